// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/position/projection.hpp"
#include "mbs/solver/run/energy.hpp"

namespace flexura::study {

/// The equations of a run for its estimate, which chooses among rows that follow from each other by itself.
///
/// A run that comes to where its rows nearly depend on each other goes on by others (Runner::choose_rows_anew()), but shows states
/// with the multipliers of those it began with.  What those rows leave open of an error grows like 1 / sigma^2: of a driven
/// Bennett linkage 100 % was told where 1e-3 % was true.
class OwnRows {
 public:
  /// `mechanism` outlives it.
  OwnRows(const mbs::Mechanism& mechanism, const mbs::SolverOptions& options);

  const mbs::Equations& equations() const {
    return own_ ? *own_ : static_cast<const mbs::Equations&>(mechanism_);
  }
  /// The rows come near to depending on each other at one of these states, and were not looked at there.
  bool hold_little(const std::array<mbs::Instant, 3>& nodes);
  /// Behind it: others where they hold better there; false where there are none.
  bool choose();
  /// Multipliers of the rows that the run shows to those of equations(), and back; s keeps to its constraints.
  void take(mbs::State& s, const Eigen::VectorXd& v_dot) { translate(here_, s, v_dot); }
  void show(mbs::State& s, const Eigen::VectorXd& v_dot) { translate(there_, s, v_dot); }

 private:
  void translate(mbs::LoopCloser& to, mbs::State& s, const Eigen::VectorXd& v_dot) const;

  const mbs::Mechanism& mechanism_;
  std::unique_ptr<mbs::Equations> own_;  // null where there are no rows to choose from
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  mbs::LoopCloser here_, there_;
  mbs::State weakest_;
  double hold_ = 1.0, tried_at_ = 1.0;
  bool has_other_rows_ = false;
};

}  // namespace flexura::study
