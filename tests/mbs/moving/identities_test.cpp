// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "mbs/bodies/modal_body.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/examples.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"
#include "tests/mbs/solver/derivatives.hpp"

/// What holds of every element at any state, consistent or not, of all that travels along a path: on rigid bodies and on
/// one that deforms under the path.
namespace flexura::mbs {
namespace {

class PathIdentities : public MechanismFileTest {
 protected:
  /// Every second marker of the path, and the one that travels, on a node of a body that deforms.
  MechanismDescription of(const std::string& element, bool flexible) const {
    MechanismDescription d = read(kThreeBodies + element + on_rail("")).description;
    if (!flexible) return d;
    BasisOptions options;
    options.modes = 3;
    const auto body = std::make_shared<ModalBody>(modal_data(lattice::make_lattice(4, 40.0).se, options));
    for (std::size_t b = 0; b < d.bodies.size(); ++b) {
      if (d.bodies[b].name != "a" && d.bodies[b].name != "b") continue;
      d.bodies[b].inertia = {};
      d.bodies[b].flexible = body;
    }
    for (MarkerDescription& marker : d.markers) {
      if (marker.name == "a.rail_2") marker.node = 0;
      if (marker.name == "a.out" || marker.name == "a.rail_4" || marker.name == "b.in") marker.node = 1;
    }
    return d;
  }
};

TEST_F(PathIdentities, HoldForConstraints) {
  for (const char* keys : {"orientation = \"free\"", "orientation = \"along\"", "orientation = \"fixed\"",
                           "place = \"1 + 0.3*t\"", "orientation = \"fixed\"\nplace = \"1 + sin(t)\""})
    for (const bool flexible : {false, true}) {
      SCOPED_TRACE(std::string(keys) + (flexible ? " on flexible bodies" : ""));
      const Mechanism mechanism(
          of(std::string("[constraint.x]\ntype = \"point_on_path\"\nto = \"b.in\"\n") + keys, flexible));
      checks::derivatives_agree(mechanism);
      // A line that is deformed by its own length has several feet: which it is depends on where it was.
      if (flexible && mechanism.sizes().n_alg > 0) continue;
      for (const unsigned seed : {3u, 4u}) checks::all_identities_hold(mechanism, seed);
    }
}

TEST_F(PathIdentities, HoldForMovingLoads) {
  for (const bool flexible : {false, true}) {
    SCOPED_TRACE(flexible);
    const Mechanism mechanism(
        of("[force.x]\ntype = \"moving_load\"\naxes = \"b.in\"\nplace = \"1 + 0.5*sin(third.position)\"\nx = "
           "\"3*third.position^2 + t\"\nz = \"sin(third.speed)\"",
           flexible));
    for (const unsigned seed : {3u, 4u}) checks::all_identities_hold(mechanism, seed);
    checks::derivatives_agree(mechanism);
  }
}

}  // namespace
}  // namespace flexura::mbs
