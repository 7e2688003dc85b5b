// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/algebra/history.hpp"

/// What is read back from a history comes from a file: every length is that of the mechanism's own, every
/// count lies where its reader can use it, before anything is done with it.
namespace flexura::mbs {

[[noreturn]] inline void refuse_history() {
  throw std::invalid_argument(
      "the integrator's history does not fit this mechanism: it was saved by another one, or was changed; "
      "start "
      "from the states alone (--from-state)");
}

inline void require_size(long size, long wanted) {
  if (size != wanted) refuse_history();
}
inline void require_sizes(const State& s, const Sizes& n) {
  require_size(s.p.size(), n.n_p);
  require_size(s.v.size(), n.n_v);
  require_size(s.c.size(), n.n_dyn);
  require_size(s.lambda.size(), n.n_lambda);
  require_size(s.a.size(), n.n_alg);
  require_size(static_cast<long>(s.root.size()), n.n_root);
  if (s.hysteresis.size() > 0) require_size(s.hysteresis.size(), n.n_root);
}
inline void require_between(long value, long least, long most) {
  if (value < least || value > most) refuse_history();
}

/// A vector of n entries.
inline void remember(History& history, Eigen::VectorXd& x, long n) {
  history(x);
  if (history.reads()) require_size(x.size(), n);
}
/// A state of the mechanism's sizes.
inline void remember(History& history, State& s, const Sizes& n) {
  history(s);
  if (history.reads()) require_sizes(s, n);
}

}  // namespace flexura::mbs
