// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/gears/involute.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace flexura::mbs {
namespace {

constexpr double pi = std::numbers::pi;

double inv(double angle) {
  return std::tan(angle) - angle;
}

// inv rises from 0 at 0 to infinity at 90 degrees.
double angle_of_inv(double value) {
  double low = 0.0, high = 0.5 * pi;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (inv(middle) < value ? low : high) = middle;
  }
  return low;
}

void need(bool holds, const std::string& rule) {
  if (!holds) throw std::invalid_argument(rule);
}

void check(const InvoluteData& d) {
  need(d.module > 0.0 && d.width > 0.0, "module and width of a mesh must be above 0");
  need(d.teeth_1 >= 5 && d.teeth_2 >= 5, "wheels of an involute mesh have five teeth at least");
  need(d.pressure_angle > 0.0 && d.pressure_angle < pi / 4.0, "the pressure angle lies between 0 and 45 deg");
  need(std::abs(d.helix_angle) < pi / 4.0, "the helix angle lies within 45 deg");
  need(d.addendum > 0.0 && d.backlash >= 0.0 && d.tooth_stiffness >= 0.0 && d.harmonics >= 0,
       "addendum, backlash, stiffness and harmonics of a mesh must not be negative");
}

// 1 / c'_th of ISO 6336-1 [mm um / N].
double flexibility(double z_n1, double z_n2, double x_1, double x_2) {
  return 0.04723 + 0.15551 / z_n1 + 0.25791 / z_n2 - 0.00635 * x_1 - 0.11654 * x_1 / z_n1 - 0.00193 * x_2 -
         0.24188 * x_2 / z_n2 + 0.00529 * x_1 * x_1 + 0.00182 * x_2 * x_2;
}

}  // namespace

Involute::Involute(const InvoluteData& d) {
  check(d);
  const double cos_beta = std::cos(d.helix_angle), m_t = d.module / cos_beta;
  transverse_angle = std::atan(std::tan(d.pressure_angle) / cos_beta);
  const double cos_alpha = std::cos(transverse_angle);
  base_1 = 0.5 * m_t * d.teeth_1 * cos_alpha;
  base_2 = 0.5 * m_t * d.teeth_2 * cos_alpha;
  pitch = pi * m_t * cos_alpha;
  tan_base_helix = std::tan(d.helix_angle) * cos_alpha;
  half_backlash_ = 0.5 * d.backlash;
  need(d.backlash < 0.5 * pitch, "the backlash of a mesh must be smaller than half a pitch");
  const double inv_working = inv(transverse_angle) + 2.0 * std::tan(d.pressure_angle) *
                                                         (d.shift_1 + d.shift_2) / (d.teeth_1 + d.teeth_2);
  need(inv_working > 0.0, "the profile shifts take the wheels so near that their base circles overlap");
  working_angle = angle_of_inv(inv_working);
  centre_distance = (base_1 + base_2) / std::cos(working_angle);
  half_thickness_1 = pi / (2.0 * d.teeth_1) + 2.0 * d.shift_1 * std::tan(d.pressure_angle) / d.teeth_1 +
                     inv(transverse_angle) - inv_working;

  reach = 0.0;
  const auto tip_path = [&](int teeth, double shift, double base) {
    const double tip = 0.5 * m_t * teeth + d.module * (d.addendum + shift);
    reach += tip;
    need(tip > base, "the tips of a wheel stand within its base circle");
    return std::sqrt(tip * tip - base * base) - base * std::tan(working_angle);  // beyond the pitch point
  };
  const double recess = tip_path(d.teeth_1, d.shift_1, base_1),
               approach = tip_path(d.teeth_2, d.shift_2, base_2);
  contact_ratio = (recess + approach) / pitch;
  need(contact_ratio >= 1.0,
       fmt::format("the contact ratio of the mesh is {:.4g}: below 1 teeth part before the next ones meet",
                   contact_ratio));
  overlap_ratio = d.width * std::abs(std::sin(d.helix_angle)) / (pi * d.module);
  middle_ = 0.5 * (recess - approach);

  // ISO's is for virtual teeth of the normal section, and given in N/(mm um).
  const double sin_base = std::sin(d.helix_angle) * std::cos(d.pressure_angle);
  const double virtual_teeth = 1.0 / ((1.0 - sin_base * sin_base) * cos_beta);
  tooth_stiffness =
      d.tooth_stiffness > 0.0
          ? d.tooth_stiffness
          : 0.8e9 * cos_beta /
                flexibility(d.teeth_1 * virtual_teeth, d.teeth_2 * virtual_teeth, d.shift_1, d.shift_2);
  mean_stiffness = tooth_stiffness * (0.75 * contact_ratio + 0.25) * d.width;
  const auto sinc = [](double x) { return x == 0.0 ? 1.0 : std::sin(pi * x) / (pi * x); };
  for (int n = 1; n <= d.harmonics; ++n)
    harmonics_.push_back(2.0 * sinc(n * contact_ratio) * sinc(n * overlap_ratio));
  for (int i = 0; i < 1000; ++i)
    need(ripple(pitch * i / 1000.0).value > 0.0,
         "so many harmonics make the stiffness of the mesh vanish somewhere");
}

Involute::Play Involute::play(double distance) const {
  const double sum = base_1 + base_2;
  if (!(distance > sum))
    throw std::runtime_error(
        fmt::format("the axes of an involute mesh are {:.6g} m apart; its base circles overlap below "
                    "{:.6g} m, its wheels mesh at {:.6g} m",
                    distance, sum, centre_distance));
  if (distance >= reach)
    throw std::runtime_error(
        fmt::format("the axes of an involute mesh are {:.6g} m apart; its tips no longer reach each other "
                    "from {:.6g} m on, its "
                    "wheels mesh at {:.6g} m: place the wheels nearer",
                    distance, reach, centre_distance));
  const double angle = std::acos(sum / distance), sine = std::sin(angle);
  // d half / da = sin(alpha), and sin(alpha)^2 = 1 - (sum / a)^2.
  return {half_backlash_ + sum * (inv(angle) - inv(working_angle)), sine,
          sum * sum / (distance * distance * distance * sine)};
}

Involute::Ripple Involute::ripple(double y) const {
  Ripple r{1.0, 0.0, 0.0};
  for (std::size_t i = 0; i < harmonics_.size(); ++i) {
    const double q = 2.0 * pi * static_cast<double>(i + 1) / pitch, angle = q * (y - middle_);
    r.value += harmonics_[i] * std::cos(angle);
    r.first -= harmonics_[i] * q * std::sin(angle);
    r.second -= harmonics_[i] * q * q * std::cos(angle);
  }
  return r;
}

}  // namespace flexura::mbs
