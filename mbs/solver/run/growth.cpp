// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/growth.hpp"

#include <fmt/format.h>

#include <cmath>

namespace flexura::mbs {

namespace {

constexpr std::size_t kDecades = 10;
constexpr long kRows = 8;
constexpr double kSlower = 1.25, kTravel = 1e3;
constexpr double kLight = 299792458.0;  // [m/s]

}  // namespace

void GrowthWatch::observe(double t, double kinetic, double travel, double speed) {
  if (!reason_.empty()) return;
  ++row_;
  if (!std::isfinite(
          kinetic)) {  // the speed of a body that turns about its centre of mass is none of a place
    reason_ = fmt::format(
        "the motion grows without bound: the kinetic energy at t = {:.6g} s is beyond all numbers; look for "
        "an "
        "unstable control, a damper of negative sign or a drive or force that has no bound",
        t);
    return;
  }
  if (speed > 0.1 * kLight) {
    reason_ = fmt::format(
        "the motion grows without bound: a body moves at {:.3g} m/s at t = {:.6g} s, beyond a tenth of the "
        "speed of "
        "light, where Newton's equations end; look for an unstable control, a damper of negative sign or a "
        "force that "
        "has no bound",
        speed, t);
    return;
  }
  if (kinetic > highest_ && highest_ > 0.0) {
    // Decades passed since the last row, where its logarithm passed them.
    const double from = std::log10(highest_), to = std::log10(kinetic);
    for (double decade = std::floor(from) + 1.0; decade <= to; decade += 1.0)
      pass(t_before_ + (t - t_before_) * (decade - from) / (to - from), std::pow(10.0, decade), travel);
  }
  if (kinetic >= highest_) {
    highest_ = kinetic;
    t_before_ = t;
  }
}

void GrowthWatch::pass(double t, double energy, double travel) {
  decades_.push_back({t, row_, travel});
  if (decades_.size() <= kDecades) return;
  if (decades_.size() > kDecades + 1) decades_.pop_front();
  const Decade &first = decades_.front(), &middle = decades_[kDecades / 2], &last = decades_.back();
  if (last.row - first.row < kRows || !(travel > kTravel) || !(travel > 1e3 * first.travel)) return;
  if (last.t - middle.t > kSlower * (middle.t - first.t)) return;
  reason_ = since(kDecades, energy);
}

std::string GrowthWatch::since(std::size_t decades, double energy) const {
  const Decade &first = decades_[decades_.size() - 1 - decades], &last = decades_.back();
  return fmt::format(
      "the motion grows without bound: since t = {:.6g} s its kinetic energy has grown tenfold every {:.3g} "
      "s, to {:.3g} "
      "J at t = {:.6g} s; look for an unstable control, a damper of negative sign or a force that has no "
      "bound",
      first.t, (last.t - first.t) / static_cast<double>(decades), energy, last.t);
}

std::string GrowthWatch::suspicion() const {
  constexpr std::size_t kFewer = 6;
  if (!reason_.empty() || decades_.size() <= kFewer) return reason_;
  const std::size_t end = decades_.size() - 1;
  const Decade &first = decades_[end - kFewer], &middle = decades_[end - kFewer / 2], &last = decades_[end];
  const bool is_exponential = last.t - middle.t <= kSlower * (middle.t - first.t);
  return last.travel > kTravel || is_exponential ? since(kFewer, highest_) : "";
}

}  // namespace flexura::mbs
