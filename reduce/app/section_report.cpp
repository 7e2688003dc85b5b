// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/section_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <ostream>

namespace flexura::reduce {

beam::SectionProperties without_round_off(beam::SectionProperties s) {
  const auto clear = [](double& value, double whole) {
    if (std::abs(value) < 1e-6 * whole) value = 0.0;
  };
  for (Eigen::Vector2d* p : {&s.centroid, &s.mass_centre, &s.tension_centre, &s.shear_centre})
    for (int k = 0; k < 2; ++k) clear((*p)(k), s.size);
  clear(s.I_yz, std::sqrt(s.I_y * s.I_z));
  clear(s.principal_angle, 1.0);
  return s;
}

void print_section(const beam::SectionProperties& exact, std::ostream& out) {
  const beam::SectionProperties s = without_round_off(exact);
  const auto line = [&](const char* what, double value, const char* unit) {
    out << fmt::format("  {:<34} {:>14.6g} {}\n", what, value, unit);
  };
  out << fmt::format("section {}\n", s.section.name);
  line("area", s.area, "m^2");
  line("mass per length", s.section.inertia.m, "kg/m");
  line("centroid y", s.centroid.x(), "m");
  line("centroid z", s.centroid.y(), "m");
  line("tension centre y", s.tension_centre.x(), "m");
  line("tension centre z", s.tension_centre.y(), "m");
  line("shear centre y", s.shear_centre.x(), "m");
  line("shear centre z", s.shear_centre.y(), "m");
  line("reference E", s.E_ref, "Pa");
  line("reference G", s.G_ref, "Pa");
  line("I_y about the tension centre", s.I_y, "m^4");
  line("I_z", s.I_z, "m^4");
  line("I_yz = -int y z dA", s.I_yz, "m^4");
  line("I_1, principal", s.I_1, "m^4");
  line("I_2", s.I_2, "m^4");
  line("angle from y to axis 1", s.principal_angle * 180.0 / std::numbers::pi, "deg");
  line("I_t, torsion", s.I_t, "m^4");
  line("A_sy, shear area", s.A_sy, "m^2");
  line("A_sz, shear area", s.A_sz, "m^2");
  line("I_w, warping", s.I_w, "m^6");
  line("decay length sqrt(E I_w / G I_t)", s.decay_length, "m");
  if (s.couples) out << "  stretch or bending couples with shear or twist\n";
  if (s.section.open_thin_walled)
    out << "  open and thin-walled: a beam is right only where its ends warp freely or it is long\n";
  out << "  stiffness at the origin, order N, V_y, V_z, T, M_y, M_z:\n";
  const beam::Matrix6d C = s.section.stiffness();
  for (int i = 0; i < 6; ++i) {
    out << "   ";
    for (int j = 0; j < 6; ++j) {
      const bool nothing = std::abs(C(i, j)) < 1e-6 * std::sqrt(C(i, i) * C(j, j));
      out << fmt::format(" {:>12.5g}", nothing ? 0.0 : C(i, j));
    }
    out << '\n';
  }
}

std::string section_json(const beam::SectionProperties& s) {
  const auto pair = [](const Eigen::Vector2d& p) { return nlohmann::json{p.x(), p.y()}; };
  const auto rows = [](const beam::Matrix6d& matrix) {
    nlohmann::json list = nlohmann::json::array();
    for (int i = 0; i < 6; ++i) {
      nlohmann::json row = nlohmann::json::array();
      for (int j = 0; j < 6; ++j) row.push_back(matrix(i, j));
      list.push_back(row);
    }
    return list;
  };
  const nlohmann::json json = {{"name", s.section.name},
                               {"area", s.area},
                               {"mass_per_length", s.section.inertia.m},
                               {"centroid", pair(s.centroid)},
                               {"mass_centre", pair(s.mass_centre)},
                               {"tension_centre", pair(s.tension_centre)},
                               {"shear_centre", pair(s.shear_centre)},
                               {"E_ref", s.E_ref},
                               {"G_ref", s.G_ref},
                               {"A", s.A},
                               {"I_y", s.I_y},
                               {"I_z", s.I_z},
                               {"I_yz", s.I_yz},
                               {"I_1", s.I_1},
                               {"I_2", s.I_2},
                               {"principal_angle_rad", s.principal_angle},
                               {"I_t", s.I_t},
                               {"A_sy", s.A_sy},
                               {"A_sz", s.A_sz},
                               {"I_w", s.I_w},
                               {"decay_length", s.decay_length},
                               {"couples", s.couples},
                               {"open_thin_walled", s.section.open_thin_walled},
                               {"stiffness", rows(s.section.stiffness())},
                               {"mass", rows(s.section.inertia.matrix())}};
  return json.dump(1);
}

}  // namespace flexura::reduce
