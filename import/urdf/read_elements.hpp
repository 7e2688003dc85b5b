// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "import/urdf/robot.hpp"

/// One link, one joint: what stands in them alone.
namespace flexura::import::urdf {

class Element;

using Colors = std::map<std::string, std::string>;  ///< "#rrggbb" of materials by name

/// A <material> with a name and a colour becomes known.  A colour is worth no refusal.
void note_color(const Element& material, Colors& colors, Findings& findings);

/// The link but for its name; what cannot be drawn is left out.
Link read_link(const Element& e, Colors& colors, Findings& findings);

/// The joint but for its name, its links and what it mimics.
Joint read_joint(const Element& e, const std::string& name, Findings& findings);

/// What <gazebo reference="LINK"> says of its surface.
void read_touch(const Element& gazebo, Touch& touch);

}  // namespace flexura::import::urdf
