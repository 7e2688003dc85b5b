// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_beam_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

namespace flexura::mesh::abaqus {
namespace {

using Words = std::set<std::string>;

bool is_of_calculix(const Keyword& k) {
  static const Words solvers = {
      "SPOOLES", "PASTIX", "PARDISO", "PROFILE", "TAUCS", "ITERATIVE SCALING", "ITERATIVE CHOLESKY"};
  static const Words types = {"B31R", "B32R", "U1", "T3D3R", "DCOUP3D"};
  if (k.name == "BEAM SECTION")
    return k.has("OFFSET1") || k.has("OFFSET2") ||
           (upper(k.get("SECTION")) == "CIRC" && numbers_of(k, 0).size() > 1);
  if (k.name == "ELEMENT") return types.contains(upper(k.get("TYPE")));
  if (k.name == "NODE FILE" || k.name == "EL FILE" || k.name == "NODE OUTPUT" || k.name == "ELEMENT OUTPUT") {
    const std::string output = upper(k.get("OUTPUT"));
    return output == "2D" || output == "3D";
  }
  return solvers.contains(upper(k.get("SOLVER"))) || (k.name == "FREQUENCY" && k.has("STORAGE"));
}

bool is_of_abaqus(const Keyword& k) {
  static const Words names = {"PART", "ASSEMBLY", "INSTANCE", "PREPRINT", "BEAM GENERAL SECTION"};
  static const Words types = {"B33", "B33H", "B31H", "B32H", "B31OS", "B32OS", "ROTARYI"};
  static const Words sections = {"I", "L", "TRAPEZOID", "HEX", "ARBITRARY"};
  if (k.name == "ELEMENT") return types.contains(upper(k.get("TYPE")));
  if (k.name == "BEAM SECTION") return sections.contains(upper(k.get("SECTION")));
  return names.contains(k.name) || (k.name == "OUTPUT" && (k.has("FIELD") || k.has("HISTORY")));
}

double extent(const BarSection& s, Eigen::Index axis) {
  const auto [low, high] = std::ranges::minmax_element(
      s.outline, {}, [axis](const Eigen::Vector2d& point) { return point[axis]; });
  return (*high)[axis] - (*low)[axis];
}

double fraction(const Keyword& k, const char* key) {
  return k.has(key) ? to_real(k.get(key), k.where) : 0.0;
}

std::size_t dimensions_of(const std::string& type) {
  static const std::map<std::string, std::size_t> kNumber = {{"CIRC", 1}, {"PIPE", 2}, {"RECT", 2},
                                                             {"BOX", 6},  {"I", 7},    {"L", 4}};
  const auto found = kNumber.find(type);
  return found == kNumber.end() ? 0 : found->second;
}

BarSection section_of_shape(const std::string& type, const std::vector<double>& d) {
  const std::size_t number = dimensions_of(type);
  require(
      number > 0,
      fmt::format("SECTION={} is not known; CIRC, PIPE, RECT, BOX, I and L are, or give its constants (*BEAM "
                  "GENERAL SECTION)",
                  type));
  require(d.size() >= number, fmt::format("SECTION={} has {} dimensions, not {}", type, number, d.size()));
  const auto may_be_zero = [&](std::size_t k) {  // of I: where the node is; a flange that is not there (a T)
    return type == "I" && (k == 0 || (k > 1 && k < 6 && d[2 + k % 2] == 0 && d[4 + k % 2] == 0));
  };
  for (std::size_t k = 0; k < number; ++k)
    require(d[k] > 0 || may_be_zero(k), fmt::format("a dimension of SECTION={} is {:g}", type, d[k]));
  if (type == "CIRC") return circle(d[0]);
  if (type == "PIPE") {
    require(d[0] >= d[1], "SECTION=PIPE: the wall is thicker than the radius");
    return tube(d[0], d[0] - d[1]);
  }
  if (type == "RECT") return rectangle(d[0], d[1]);
  if (type == "BOX") {  // a, b, t1 to t4 around
    require(d[0] > d[2] + d[4] && d[1] > d[3] + d[5], "SECTION=BOX: the walls leave no hole");
    return box(d[0], d[1], (d[2] + d[4]) / 2, (d[3] + d[5]) / 2);
  }
  if (type ==
      "I") {  // l, h, b1, b2, t1, t2, t3: lower and upper flange, web; the node is l above the lower edge
    require(d[2] + d[3] > 0, "SECTION=I: both flanges have the width 0; take SECTION=RECT");
    require(d[1] > d[4] + d[5], "SECTION=I: the flanges are thicker than the section is high");
    const double web = d[1] - d[4] - d[5];
    const double shear = d[4] / 2 + flange_centre(d[4], d[2], d[5], d[3]) * (d[1] - (d[4] + d[5]) / 2);
    BarSection s = open_section(
        {{0, d[4] / 2, d[2], d[4]}, {0, d[4] + web / 2, d[6], web}, {0, d[1] - d[5] / 2, d[3], d[5]}}, 0,
        shear);
    s.node_z = d[0] - (shear - s.shear_z);
    return s;
  }
  require(d[0] > d[3] && d[1] > d[2], "SECTION=L: the legs are thicker than the section");
  return open_section(
      {{d[0] / 2, d[2] / 2, d[0], d[2]}, {d[3] / 2, d[2] + (d[1] - d[2]) / 2, d[3], d[1] - d[2]}}, d[3] / 2,
      d[2] / 2);
}

}  // namespace

DeckProgram written_for(const std::vector<Keyword>& keywords) {
  const bool calculix = std::ranges::any_of(keywords, is_of_calculix),
             abaqus = std::ranges::any_of(keywords, is_of_abaqus);
  return calculix == abaqus ? DeckProgram::unknown : calculix ? DeckProgram::calculix : DeckProgram::abaqus;
}

BarSection shaped_section(const Keyword& k, DeckProgram program, Unused& otherwise) {
  const std::string type = upper(k.get("SECTION"));
  const std::vector<double> dim = numbers_of(k, 0);
  const bool has_offset = k.has("OFFSET1") || k.has("OFFSET2");
  const std::size_t known = type == "CIRC" && program != DeckProgram::abaqus ? 2 : dimensions_of(type);
  if (const std::size_t given = static_cast<std::size_t>(
          std::ranges::find_if(dim.rbegin(), dim.rend(), [](double d) { return d != 0.0; }).base() -
          dim.begin());
      known > 0 && given > known)
    otherwise.add(
        fmt::format("*BEAM SECTION, SECTION={} has {} numbers; its dimensions are the first {}, the rest is "
                    "not used",
                    type, given, known),
        k.where);
  if (program == DeckProgram::abaqus) {
    if (has_offset)
      otherwise.add("*BEAM SECTION's OFFSET1 and OFFSET2, which Abaqus does not know, are not used", k.where);
    return section_of_shape(type, dim);
  }
  BarSection s;
  if (type == "CIRC" && !dim.empty()) {
    const double t_1 = dim[0], t_2 = dim.size() > 1 && dim[1] != 0.0 ? dim[1] : t_1;
    if (!(t_1 > 0.0 && t_2 > 0.0))
      throw std::invalid_argument(
          fmt::format("SECTION=CIRC has the thicknesses {:g} and {:g}; they must be above zero", t_1, t_2));
    s = ellipse(t_1 / 2, t_2 / 2);
    if (program == DeckProgram::unknown && dim.size() < 2 && !has_offset)
      otherwise.add(
          fmt::format("*BEAM SECTION, SECTION=CIRC: {:g} is taken for the diameter, as CalculiX does; Abaqus "
                      "takes it for the radius, and nothing in the deck tells which is meant: say it by "
                      "geometry.program",
                      t_1),
          k.where);
  } else if (type == "RECT" && dim.size() == 1) {  // CalculiX: the second thickness is that of the first
    s = section_of_shape(type, {dim[0], dim[0]});
  } else {
    s = section_of_shape(type, dim);
  }
  if (has_offset) {
    s.node_y += fraction(k, "OFFSET1") * extent(s, 0);
    s.node_z += fraction(k, "OFFSET2") * extent(s, 1);
  }
  return s;
}

}  // namespace flexura::mesh::abaqus
