// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <string>

/// Planar linkages as text of mechanism files.
namespace flexura::mbs::test {

/// A link along its x axis: its first hinge at its origin, its second at the marker `t` [m, kg, kg m^2].
struct PlanarLink {
  std::string name;
  double length, mass, center, inertia;
};

inline std::string text_of(const PlanarLink& link) {
  return fmt::format(
      "[body.{0}]\nmass = {1}\ncenter = [{2}, 0, 0]\ninertia = [{3}, {3}, "
      "{3}]\n[body.{0}.marker.t]\nposition = "
      "[{4}, 0, 0]\n",
      link.name, link.mass, link.center, link.inertia, link.length);
}

/// A hinge about z, with `keys` in lines of their own.
inline std::string hinge(const std::string& name, const std::string& from, const std::string& to,
                         const std::string& keys = "") {
  return fmt::format("[joint.{}]\ntype = \"revolute\"\nfrom = \"{}\"\nto = \"{}\"\n{}\n", name, from, to,
                     keys);
}

}  // namespace flexura::mbs::test
