// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <cstdio>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/library/builder.hpp"
#include "mbs/library/simulation.hpp"
#include "mesh/model/geometry.hpp"
#include "reduce/library/reduce.hpp"
#include "reduce/linalg/session/session.hpp"

using namespace flexura;

/// A rod of n bricks along x, 0.1 m x 0.1 m, without contraction across: its stiffness is E A / L.
reduce::Part rod(int n, double length) {
  reduce::Part part;
  part.materials = {reduce::isotropic("steel", 2.1e11, 0.0, 7850.0)};
  part.mesh.points.resize(4 * (n + 1), 3);
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k < 4; ++k)
      part.mesh.points.row(4 * i + k) << length * i / n, (k == 1 || k == 2) ? 0.1 : 0.0, k >= 2 ? 0.1 : 0.0;
  mesh::CellBlock bricks{.type = mesh::CellType::hex8, .variant = mesh::CellVariant::bubbles};
  bricks.nodes.resize(n, 8);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 4; ++k) bricks.nodes(i, k) = 4 * i + k, bricks.nodes(i, 4 + k) = 4 * (i + 1) + k;
  part.mesh.solids = {bricks};
  mesh::extract_boundary(part.mesh);
  part.interfaces = {
      {.name = "left", .point = {0.0, 0.05, 0.05}, .set = {.nodes = {0, 1, 2, 3}, .faces = {}}},
      {.name = "right",
       .point = {length, 0.05, 0.05},
       .set = {.nodes = {4 * n, 4 * n + 1, 4 * n + 2, 4 * n + 3}, .faces = {}}}};
  return part;
}

// Reduced and hung on a hinge: the runtime takes the superelement from memory.
int main() {
  const linalg::Session session;
  const superelement::Superelement se = reduce::reduce(rod(20, 2.0), "rod", {.n_modes = 6});
  const double stiffness = se.K_se(6, 6), exact = 2.1e11 * 0.01 / 2.0, mass = 7850.0 * 0.01 * 2.0;
  mbs::MechanismBuilder b("pendulum");
  b.gravity({0.0, 0.0, -9.81});
  const auto body = b.add("rod", mbs::ModalBody(se));
  mbs::Pose across;  // the hinge turns about its markers' z axis, here along -y
  across.R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  b.add<mbs::Revolute>("hinge", b.ground().marker(across), body.marker("left", across));
  mbs::Simulation s(b.build(), {.tolerance = 1e-8});
  s.advance(0.1);
  // It falls from the level with 3 g / (2 L (1 + h^2 / (4 L^2))); it swings by some 1e-5 rad about that, and the load's arm
  // shortens by 1e-3.
  const double turn = std::abs(s.output("hinge.angle")),
               falling = 0.5 * 0.01 * 1.5 * 9.81 / 2.0 / (1.0 + 0.01 / 16.0);
  std::printf(
      "stiffness %.12g N/m, exact %.12g; mass %.9g kg, exact %.9g; turned by %.6g rad, a rigid rod by %.6g\n",
      stiffness, exact, se.inertia.mass, mass, turn, falling);
  return std::abs(stiffness / exact - 1.0) < 1e-9 && std::abs(se.inertia.mass / mass - 1.0) < 1e-12 &&
                 std::abs(turn / falling - 1.0) < 3e-3
             ? 0
             : 1;
}
