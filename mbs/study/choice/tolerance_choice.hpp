// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/integrator_check.hpp"

namespace flexura::study {

/// The integrator's tolerance for a wanted accuracy.
///
/// How large the error is that a tolerance makes depends on what rings, by a factor of a thousand between the scenes of
/// cases/trade: of a tenth of a per cent that was asked for, two controlled links need 1e-3 and a pendulum's hinge 1e-6.  So a
/// run begins with a loose one, tol = 0.03 accuracy within [1e-9, 1e-3], and its integrator's share is estimated as it goes
/// (global_error.hpp).  Where that exceeds 0.35 of the accuracy the run is given up and begun anew with a finer one, once as the
/// estimate says and then with the safe one, tol = accuracy / 1000 within [1e-9, 1e-4], which on the scenes of cases/trade leaves
/// the integrator a tenth of the error or less.
///
/// An estimate that is linear about the run tells nothing of what switches: there the safe one is taken from the beginning, and
/// likewise where the estimate turns out to be unknown.
class ToleranceChoice {
 public:
  ToleranceChoice(double accuracy, const mbs::PreparedMechanism& run);

  double value() const { return value_; }
  /// The run's integrator is to be watched and may be asked for more.
  bool is_watched() const { return !is_safe_; }
  /// A run that has come to `spent` (GlobalError::spent) has lost too much.
  bool is_too_much(double spent) const;
  /// A run that was given up at this fraction of its time: a finer one for the next.
  void give_up(double spent, double fraction);
  /// True where the whole run has to be made anew with a finer one, which value() then is; `estimate` null where there is none.
  bool has_to_be_finer(const IntegratorEstimate* estimate, double energy_error, double truncation);
  /// For what goes on without being judged as a whole.
  void take_safe_one();

  /// "tolerance 3.0e-04: what it costs of the wanted 1 % is estimated as the run goes".
  std::string text() const;

 private:
  void refine(double error);

  double accuracy_, safe_, value_;
  bool is_safe_, has_guessed_ = false;
};

}  // namespace flexura::study
