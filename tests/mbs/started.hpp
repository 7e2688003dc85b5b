// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/position/assemble.hpp"

namespace flexura::mbs {

/// A mechanism with closed loops, without redundant rows, in a consistent state.
struct Started {
  Mechanism m;
  State s;
  Eigen::VectorXd v_dot;

  explicit Started(MechanismDescription description) : m(std::move(description)), s(m.initial_state()) {
    assemble_positions(m, s);
    m.drop_redundant(0.0, s.p);
    s.lambda = Eigen::VectorXd::Zero(m.sizes().n_lambda);
    assemble(m, s, v_dot);
  }
};

}  // namespace flexura::mbs
