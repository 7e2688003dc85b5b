// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "beam/model/mesh.hpp"

/// Models that several beam tests share.
namespace flexura::beam::testing {

/// One straight member along x from the origin, height along z.
inline Model straight(const SectionEntry& section, double length, Theory theory = Theory::timoshenko) {
  Model model;
  model.nodes = {{"A", {0, 0, 0}}, {"B", {length, 0, 0}}};
  model.sections = {section};
  Member member;
  member.name = "AB";
  member.end[0].node = 0;
  member.end[1].node = 1;
  member.section = 0;
  member.theory = theory;
  model.members = {member};
  return model;
}

inline SectionEntry entry(const std::string& name, const Shape& shape, const Material& material,
                          std::optional<ShearFormula> formula = {}) {
  return {make_section(name, shape, material, formula), shape, formula};
}

inline Subdivision divided(int elements) {
  Subdivision rule;
  rule.elements_per_member = elements;
  return rule;
}

/// Dofs of every node that leave bending in the x-z plane only: all but w and theta_y.
inline std::vector<int> all_but_bending_z(const BeamMesh& mesh) {
  std::vector<int> fixed;
  for (int dof = 0; dof < mesh.n_dofs(); ++dof)
    if (dof % 6 != 2 && dof % 6 != 4) fixed.push_back(dof);
  return fixed;
}

}  // namespace flexura::beam::testing
