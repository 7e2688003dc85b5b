// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <memory>
#include <numbers>

#include "mbs/mechanism/mechanism.hpp"

namespace flexura::mbs {

struct Chain {
  int links = 9;
  bool keep_whole = false;  ///< all joints in the tree
  bool floats = false;      ///< else it hangs on a hinge
  bool closed = false;      ///< its end is held where it starts
};

/// Links of 1 m along x, hinged about z and y in turn, in gravity along -y.
inline MechanismDescription chain_of(const std::shared_ptr<const FlexibleBody>& link, const Chain& chain) {
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  int before = 0;
  for (int i = 0; i < chain.links; ++i) {
    const int body = d.add_body({.name = fmt::format("link_{}", i), .flexible = link});
    Pose turn;
    if (i % 2 == 1) turn.R = rotation_exp({0.5 * std::numbers::pi, 0.0, 0.0});
    if (i > 0 || !chain.floats) {
      const int from = i == 0 ? d.add_marker(0, "wall", turn) : d.add_marker(before, "out", turn, 1);
      const int j =
          d.add_joint(fmt::format("hinge_{}", i), "revolute", from, d.add_marker(body, "in", turn, 0));
      d.joints[j].keep_in_tree = chain.keep_whole;
    }
    before = body;
  }
  if (chain.closed) {
    Pose end;
    end.p = {1.0 * chain.links, 0.0, 0.0};
    const int j =
        d.add_joint("end", "spherical", d.add_marker(0, "end", end), d.add_marker(before, "end", {}, 1));
    d.joints[j].cut = true;
  }
  return d;
}

}  // namespace flexura::mbs
