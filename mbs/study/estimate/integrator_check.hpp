// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/judged_outputs.hpp"
#include "mbs/study/estimate/output_rows.hpp"

/// What the integrator costs a run in accuracy, from the same run once more with a tolerance ten times as
/// large (a fixed step twice as long).
///
/// Local errors are held to the tolerance, so that the global error goes with its power p: of a method whose
/// error test is of order q in h and whose global error of order r, p = r / q.  The difference of the two
/// runs is the error E 10^p of the second, E of the first left out, where both point the same way:
///
///     E = |y_2 - y_1| / (10^p - 1)
///
/// p: radau 5/6 (its test 0.1 tolerance^(2/3) goes with h^4, E with h^5), ida 5/6 (order five), runge_kutta 1
/// (order five tested with order four), generalised_alpha 2/3.  The energy balance, the usual figure, knows
/// nothing of phases and of forces.
namespace flexura::study {

struct IntegratorEstimate {
  double error = 0.0;    ///< relative rms of the worst output that counts
  std::string output;    ///< that output
  bool is_whole = true;  ///< else it is at least `error`
  std::string note;      ///< what it is from, or why it is not whole
  double factor = 1.0;   ///< of the tolerance (or fixed step) of the second run; 1 where there was none
  double wall = 0.0;     ///< [s] that it took
};

/// A balance of energy that is off by so much tells of more than a small error of the outputs: it is of their squares, and
/// numerical damping takes some of what rings.
bool energy_tells_more(double relative_energy_error, double estimated_error);

class IntegratorCheck {
 public:
  /// Null where nothing is integrated: kinematics, quasi_statics, no outputs.  `run` outlives it.
  static std::unique_ptr<IntegratorCheck> make(const mbs::PreparedMechanism& run);

  /// The next row of the run; 800 at most are compared.
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot);

  /// Runs again.  Throws std::runtime_error where that run does not come to its end.
  IntegratorEstimate estimate(const mbs::RunCallbacks& callbacks);

 private:
  IntegratorCheck(const mbs::PreparedMechanism& run, double factor, double power);
  const mbs::PreparedMechanism& run_;
  double factor_, power_;
  std::vector<OutputEstimate> outputs_;  // before which_, which fills it
  std::vector<int> which_;
  Families families_;
  OutputRows rows_;
};

}  // namespace flexura::study
