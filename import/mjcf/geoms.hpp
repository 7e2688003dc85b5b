// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "import/mjcf/model.hpp"
#include "import/tree/inertia.hpp"

namespace flexura::import::mjcf {

/// A <geom> as solid and mass; `open` says why its mass is not known, where it is not.
struct Geom {
  std::string kind;
  std::optional<tree::Solid>
      solid;  ///< in the frame that the geom stands in; none for planes, height fields ...
  tree::Inertial inertial;
  std::string open;
};

/// `geom` with its defaults.
Geom read_geom(const Node& geom, const Model& model, Findings& findings);

/// Of <inertial>.
tree::Inertial read_inertial(const Node& inertial, const Compiler& compiler, Findings& findings);

/// The rules that the compiler has for every body that moves: balanceinertia, boundmass, boundinertia.
void bound(tree::Inertial& inertial, const Compiler& compiler);

}  // namespace flexura::import::mjcf
