// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/element/section_link.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace flexura::beam::ancf {

namespace {

// Stretch and bending of a section free to shear and twist: (EA, EI_y, EI_z) with their couplings;
// shear-rigid sections have a flexibility for these too.
Eigen::Matrix3d stretch_and_bending(const Section& section) {
  const int kept[] = {N, M_y, M_z};
  Eigen::Matrix3d f;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) f(i, j) = section.f(kept[i], kept[j]);
  return f.inverse();
}

// Couplings below this part of the geometric mean of the two stiffnesses are round-off of a symmetric
// section.
constexpr double kCoupling = 1e-9;

void refuse_coupling(const Section& section, const Eigen::Matrix3d& C, int i, int j) {
  if (std::abs(C(i, j)) > kCoupling * std::sqrt(C(i, i) * C(j, j)))
    throw std::invalid_argument(fmt::format(
        "section '{}' couples stretch and bending, which an elastic line cannot carry; use the ANCF beam.",
        section.name));
}

LineSection line(const Section& section, double EA, double EI, double damping_time) {
  return {.EA = EA,
          .EI = EI,
          .mass_per_length = section.inertia.m,
          .damping_time_axial = damping_time,
          .damping_time_bending = damping_time};
}

}  // namespace

BeamSection beam_section(const Section& section, double damping_time) {
  BeamSection out;
  out.C = section.stiffness();
  const SectionInertia& mass = section.inertia;
  out.m = mass.m;
  out.m_y = mass.m_y;
  out.m_z = mass.m_z;
  out.m_yy = mass.m_yy;
  out.m_zz = mass.m_zz;
  out.m_yz = mass.m_yz;
  out.damping_time = damping_time;
  return out;
}

LineSection planar_line_section(const Section& section, double damping_time) {
  const Eigen::Matrix3d C = stretch_and_bending(section);
  refuse_coupling(section, C, 0, 2);
  refuse_coupling(section, C, 1, 2);
  return line(section, C(0, 0), C(2, 2), damping_time);
}

LineSection spatial_line_section(const Section& section, double damping_time) {
  const Eigen::Matrix3d C = stretch_and_bending(section);
  refuse_coupling(section, C, 0, 1);
  refuse_coupling(section, C, 0, 2);
  if (std::abs(C(1, 1) - C(2, 2)) > 0.01 * C(1, 1) || std::abs(C(1, 2)) > 0.01 * C(1, 1))
    throw std::invalid_argument(fmt::format(
        "section '{}' has E I_y = {:g} and E I_z = {:g} N m^2, but a spatial line bends alike in all "
        "directions; use the ANCF beam.",
        section.name, C(1, 1), C(2, 2)));
  return line(section, C(0, 0), 0.5 * (C(1, 1) + C(2, 2)), damping_time);
}

}  // namespace flexura::beam::ancf
