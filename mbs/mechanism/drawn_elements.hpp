// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

/// Planar beams and those in modal coordinates are one body, whose pose tells nothing of how they bend: pictures have their
/// elements as bodies.
namespace flexura::mbs {

struct DrawnElement {
  std::string name;  ///< "cable.element_3"
  int body = -1;     ///< of which it is a part
  double length = 0.0;
};

/// In the order of the bodies, of each from its start.
std::vector<DrawnElement> drawn_elements(const Mechanism& mechanism);

/// In the body: where its elements start, x along the line to their ends.
std::vector<Pose> drawn_chords(const Mechanism& mechanism, int body, const State& s);

}  // namespace flexura::mbs
