// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/tolerance_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {
namespace {

constexpr double kLoose = 0.03, kLoosest = 1e-3, kFinest = 1e-9;
constexpr double kSafe = 1e-3, kLoosestSafe = 1e-4;
// Of the accuracy: what the integrator may take, whatever the modes do (its estimate was 0.39 of the truth at least on
// the scenes of cases/trade); what it may take in any case; and both together.
constexpr double kShare = 0.35, kSure = 0.25, kBoth = 0.75;
// The error of what rings went with the tolerance to this power, from 1e-3 to 1e-6 with Radau IIA (pendulum, four-bar).
constexpr double kPower = 0.6;
constexpr double kLeastAtOnce = 0.3, kNearSafe = 2.0;

// Nothing switches but kinks, and what an estimate of this run does not see does not act.
bool is_smooth(const mbs::PreparedMechanism& run) {
  if (run.options.fixed_step > 0.0 || !mbs::kind_of(run.options).integrates) return false;
  const mbs::Mechanism& m = *run.mechanism;
  for (int i = 0; i < m.sizes().n_root; ++i)
    if (!(m.is_condition(i) && m.is_kink(i))) return false;
  for (const mbs::BlindSpot& spot : run.file.blind_spots)
    if (spot.kind == "elements" || spot.kind == "user_element") return false;
  return true;
}

}  // namespace

ToleranceChoice::ToleranceChoice(double accuracy, const mbs::PreparedMechanism& run)
    : accuracy_(accuracy),
      safe_(std::clamp(kSafe * accuracy, kFinest, kLoosestSafe)),
      is_safe_(!is_smooth(run)) {
  value_ = !is_safe_ ? std::clamp(kLoose * accuracy, kFinest, kLoosest) : safe_;
}

bool ToleranceChoice::is_too_much(double spent) const {
  return is_watched() && spent > kShare * accuracy_;
}

void ToleranceChoice::give_up(double spent, double fraction) {
  // As if the rest lost as much as what has been.
  refine(spent / std::sqrt(std::clamp(fraction, 1e-3, 1.0)));
}

void ToleranceChoice::refine(double error) {
  // Estimates that hardly fall with the tolerance are of more than it: no second guess.
  const double next =
      value_ * std::min(kLeastAtOnce, std::pow(0.5 * kShare * accuracy_ / error, 1.0 / kPower));
  if (has_guessed_ || next < kNearSafe * safe_) return take_safe_one();
  value_ = std::stod(fmt::format("{:.2g}", next));
  has_guessed_ = true;
}

void ToleranceChoice::take_safe_one() {
  value_ = std::min(value_, safe_);
  is_safe_ = true;
}

bool ToleranceChoice::has_to_be_finer(const IntegratorEstimate* estimate, double energy_error,
                                      double truncation) {
  if (!is_watched()) return false;
  const double before = value_;
  if (!estimate || !estimate->is_whole || energy_tells_more(energy_error, estimate->error)) {
    take_safe_one();
    return value_ < before;
  }
  const double error = estimate->error;
  if (error <= kShare * accuracy_ && (error <= kSure * accuracy_ || error + truncation <= kBoth * accuracy_))
    return false;
  refine(error);
  return value_ < before;
}

std::string ToleranceChoice::text() const {
  if (value_ == safe_)
    return fmt::format("tolerance {:.1e}: a thousandth of the wanted {}", value_, percent(accuracy_));
  return fmt::format("tolerance {:.1e}: what it costs of the wanted {} is estimated as the run goes", value_,
                     percent(accuracy_));
}

}  // namespace flexura::study
