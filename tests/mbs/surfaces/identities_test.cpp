// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"
#include "tests/mbs/solver/derivatives.hpp"

/// What holds of a surface in contact at any state: powers against energies, derivatives against differences.
namespace flexura::mbs {
namespace {

class SurfaceContactIdentities : public MechanismFileTest {
 protected:
  void SetUp() override {
    MechanismFileTest::SetUp();
    const lattice::Lattice l = lattice::make_lattice(4, 40.0);
    superelement::Superelement se = lattice::with_surface(l);
    // Facets between any three points: areas of all sizes.
    const auto n = static_cast<int>(l.x.cols());
    se.surface.triangles.resize(n - 4, 3);
    for (int t = 0; t < n - 4; ++t) se.surface.triangles.row(t) << t, t + 1, t + 4;
    superelement::write(folder_ / "beam.se.h5", se);
  }
  // All of the surface lies in what it touches, whichever way the bodies stand.
  void check(const std::string& keys) const {
    for (const char* how : {"fidelity=modal", "frame=joint_fixed", "fidelity=rigid"}) {
      SCOPED_TRACE(how);
      const Mechanism mechanism(read(std::string(R"toml(
gravity = [0, 0, 0]
[body.arm]
mass = 1
inertia = [0.1, 0.2, 0.3]
[body.arm.marker.end]
position = [0.3, 0.2, 0.1]
[body.arm.marker.wall]
position = [0.1, 0.4, 3]
rotation = [0.3, -0.2, 0.4]
[body.arm.marker.side]
position = [20, 0.4, 0.1]
rotation = [0.3, -0.2, 0.4]
[body.beam]
superelement = "beam.se.h5"
[joint.shoulder]
type = "spherical"
from = "ground"
to = "arm"
[joint.elbow]
type = "spherical"
from = "arm.end"
to = "beam.left"
[force.x]
type = "surface_contact"
body = "beam"
)toml") + keys,
                                     {std::string("body.beam.") + how})
                                    .description);
      checks::derivatives_agree(mechanism);
      for (const unsigned seed : {3u, 4u}) {
        const State s = checks::random_state(mechanism, seed);
        checks::power_balances(mechanism, s, seed);
        checks::all_identities_hold(mechanism, seed);
      }
    }
  }
};

TEST_F(SurfaceContactIdentities, HoldOnAPlane) {
  check("from = \"arm.wall\"\nstiffness = 2\n");
  check(
      "from = \"arm.wall\"\nstiffness = 0.5\nexponent = 1.5\ndamping = 0.1\nfriction = 0.4\ntransition_speed "
      "= 0.8\n");
  check("from = \"ground\"\nstiffness = 2\ndamping = 0.2\n");
}

TEST_F(SurfaceContactIdentities, HoldOnAndInRoundThings) {
  // The damping is small enough for no node of the random motion to leave so fast that its pressure is cut off at 0.
  for (const char* surface : {"sphere", "cylinder"})
    check(std::string(
              "from = \"arm.side\"\nstiffness = 0.3\ndamping = 0.01\nfriction = 0.3\ntransition_speed = "
              "0.5\nsurface_radius = 40\nsurface = \"") +
          surface + "\"\n");
  check(
      "from = \"arm.side\"\nstiffness = 0.3\ndamping = 0.01\nfriction = 0.3\ntransition_speed = 0.5\nsurface "
      "= "
      "\"cylinder\"\nsurface_radius = 0.2\ninside = true\n");
}

/// A beam over the facets of another one: 5 x 5 vertices, far enough apart for all of the beam to lie over the middle of them, each
/// moved by some point of that beam.
class BodiesInContact : public MechanismFileTest {
 protected:
  void check(const std::string& keys, double spacing, const Vector3d& middle) const {
    const lattice::Lattice l = lattice::make_lattice(4, 40.0);
    superelement::Superelement se = lattice::with_surface(l), other = se;
    const auto n = static_cast<int>(l.x.cols());
    se.surface.triangles.resize(n - 4, 3);
    for (int t = 0; t < n - 4; ++t) se.surface.triangles.row(t) << t, t + 1, t + 4;
    constexpr int k = 5;
    other.surface.vertices.resize(k * k, 3);
    other.shapes.resize(3 * k * k, se.shapes.cols());
    other.surface.triangles.resize(2 * (k - 1) * (k - 1), 3);
    for (int i = 0, t = 0; i < k; ++i)
      for (int j = 0; j < k; ++j) {
        const double x = spacing * (i - 2), y = spacing * (j - 2);
        const int v = i * k + j;
        other.surface.vertices.row(v) =
            (middle + Vector3d(x, y, (0.05 * x * x - 0.03 * x * y) / spacing)).transpose();
        other.shapes.middleRows(3 * v, 3) = se.shapes.middleRows(3 * ((7 * v) % n), 3);
        if (i + 1 == k || j + 1 == k) continue;
        other.surface.triangles.row(t++) << v, v + k, v + 1;
        other.surface.triangles.row(t++) << v + 1, v + k, v + k + 1;
      }
    other.surface.triangle_interface.assign(static_cast<std::size_t>(other.surface.triangles.rows()), -1);
    superelement::write(folder_ / "beam.se.h5", se);
    superelement::write(folder_ / "other.se.h5", other);
    for (const char* how : {"modal modal", "rigid modal", "modal rigid", "ked modal"}) {
      SCOPED_TRACE(how);
      const std::string both = how, one = both.substr(0, both.find(' ')),
                        two = both.substr(both.find(' ') + 1);
      const Mechanism mechanism(read(std::string(R"toml(
gravity = [0, 0, 0]
[body.beam]
superelement = "beam.se.h5"
[body.other]
superelement = "other.se.h5"
[joint.shoulder]
type = "spherical"
from = "ground"
to = "other.left"
[joint.elbow]
type = "spherical"
from = "other.right"
to = "beam.left"
[force.x]
type = "surface_contact"
body = "beam"
from_body = "other"
)toml") + keys,
                                     {"body.beam.fidelity=" + one, "body.other.fidelity=" + two})
                                    .description);
      // Weights have two derivatives: differences of fourth order err where a facet comes within reach.
      checks::derivatives_agree(mechanism, 1e-9);
      for (const unsigned seed : {3u, 4u}) {
        const State s = checks::random_state(mechanism, seed);
        checks::power_balances(mechanism, s, seed);
        checks::all_identities_hold(mechanism, seed);
      }
    }
  }
};

TEST_F(BodiesInContact, HoldTheirIdentities) {
  const Vector3d above(0.0, 0.0, 4.0);
  check("stiffness = 2\n", 10.0, above);
  check("stiffness = 0.5\nexponent = 1.5\ndamping = 0.01\nfriction = 0.4\ntransition_speed = 0.8\n", 10.0,
        above);
}

// The beam hangs over the end of the facets.
TEST_F(BodiesInContact, HoldTheirIdentitiesAtTheEnd) {
  check("stiffness = 2\ndamping = 0.01\nfriction = 0.4\ntransition_speed = 0.8\n", 10.0, {26.0, 0.0, 4.0});
}

}  // namespace
}  // namespace flexura::mbs
