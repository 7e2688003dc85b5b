// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/section_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <ostream>

namespace flexura::reduce {

void print_section(const beam::SectionProperties& s, std::ostream& out) {
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
      const bool nothing = std::abs(C(i, j)) < 1e-9 * std::sqrt(C(i, i) * C(j, j));
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

std::string section_svg(const beam::SectionProperties& s) {
  Eigen::RowVector2d low = s.shear_centre.transpose(), high = low;
  for (const beam::Loop& loop : s.section.outline) {
    low = low.cwiseMin(loop.colwise().minCoeff());
    high = high.cwiseMax(loop.colwise().maxCoeff());
  }
  // Principal axes reach a little over the section, the frame a little over them; the legend stands below.
  const double size = (high - low).maxCoeff(), reach = 0.6 * size, scale = 480.0 / size;
  const Eigen::Vector2d& centre = s.tension_centre;
  low = low.cwiseMin(centre.transpose().array().matrix() - Eigen::RowVector2d(reach, reach));
  high = high.cwiseMax(centre.transpose().array().matrix() + Eigen::RowVector2d(reach, reach));
  const double margin = 40.0, width = 2 * margin + scale * (high(0) - low(0));
  const double bottom = 2 * margin + scale * (high(1) - low(1));
  const auto X = [&](double y) { return margin + scale * (y - low(0)); };
  const auto Y = [&](double z) { return margin + scale * (high(1) - z); };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" font-family=\"sans-serif\" "
      "font-size=\"14\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
      "<path fill=\"#c3cfdd\" stroke=\"#2b3f57\" fill-rule=\"evenodd\" d=\"",
      width, bottom + 120.0);
  for (const beam::Loop& loop : s.section.outline) {
    for (int k = 0; k < loop.rows(); ++k)
      svg += fmt::format("{}{:.2f} {:.2f} ", k == 0 ? "M" : "L", X(loop(k, 0)), Y(loop(k, 1)));
    svg += "Z ";
  }
  svg += "\"/>\n";
  const auto arrow = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to, const char* style,
                         const char* label) {
    svg += fmt::format(
        "<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" {}/>"
        "<text x=\"{:.2f}\" y=\"{:.2f}\">{}</text>\n",
        X(from.x()), Y(from.y()), X(to.x()), Y(to.y()), style, X(to.x()) + 4, Y(to.y()) - 4, label);
  };
  for (int axis = 0; axis < 2; ++axis) {
    const double phi = s.principal_angle + 0.5 * std::numbers::pi * axis;
    const Eigen::Vector2d along(std::cos(phi), std::sin(phi));
    arrow(centre - reach * along, centre + reach * along, "stroke=\"#a33\" stroke-dasharray=\"6 4\"",
          axis == 0 ? "1" : "2");
  }
  // The section's own axes at its origin O, where members put their axis.
  const Eigen::Vector2d O = Eigen::Vector2d::Zero();
  if (low(0) <= 0 && low(1) <= 0 && high(0) >= 0 && high(1) >= 0) {
    arrow(O, Eigen::Vector2d(0.2 * size, 0), "stroke=\"#000\" stroke-width=\"1.5\"", "y");
    arrow(O, Eigen::Vector2d(0, 0.2 * size), "stroke=\"#000\" stroke-width=\"1.5\"", "z");
  }
  int row = 0;
  const auto mark = [&](const Eigen::Vector2d& p, const char* name, const char* colour) {
    svg += fmt::format(
        "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"5\" fill=\"{}\"/><circle cx=\"{:.0f}\" cy=\"{:.0f}\" "
        "r=\"5\" "
        "fill=\"{}\"/><text x=\"{:.0f}\" y=\"{:.0f}\">{} ({:.4g}, {:.4g}) mm</text>\n",
        X(p.x()), Y(p.y()), colour, margin, bottom + 22.0 * row - 5, colour, margin + 14, bottom + 22.0 * row,
        name, 1e3 * p.x(), 1e3 * p.y());
    ++row;
  };
  mark(s.tension_centre, "tension centre", "#a33");
  mark(s.shear_centre, "shear centre", "#1a7a3c");
  mark(s.mass_centre, "centre of mass", "#2255aa");
  svg += fmt::format(
      "<text x=\"{:.0f}\" y=\"{:.0f}\">principal axes: 1 at {:.2f} deg from y, I_1 = {:.5g} mm^4, I_2 = "
      "{:.5g} "
      "mm^4</text>\n",
      margin, bottom + 22.0 * row, s.principal_angle * 180.0 / std::numbers::pi, 1e12 * s.I_1, 1e12 * s.I_2);
  return svg + "</svg>\n";
}

}  // namespace flexura::reduce
