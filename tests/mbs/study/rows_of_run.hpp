// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"

namespace flexura::study {

/// Runs it to its end; returns its outputs, rows x quantities.  `also` is given each row.
inline Eigen::MatrixXd rows_of_run(
    const mbs::PreparedMechanism& p,
    const std::function<void(const mbs::State&, const Eigen::VectorXd& v_dot)>& also = {}) {
  const auto which = mbs::select_quantities(*p.mechanism, p.file.outputs);
  const auto scratch = p.mechanism->make_scratch();
  std::vector<Eigen::VectorXd> rows;
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    rows.emplace_back(static_cast<Eigen::Index>(which.size()));
    p.mechanism->evaluate(which, s, v_dot, *scratch, rows.back());
    if (also) also(s, v_dot);
  };
  EXPECT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
  Eigen::MatrixXd out(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(which.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) out.row(static_cast<Eigen::Index>(i)) = rows[i];
  return out;
}

}  // namespace flexura::study
