// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Beams tied to solids: half of a bar as a solid, half as a beam.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reduce/beams/beam_reduction.hpp"
#include "reduce/beams/full_modes.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "tests/beam/models.hpp"
#include "tests/beam/reduction_session.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::beam {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kSide = 0.1, kHalf = 0.5;  // a bar of 0.1 x 0.1 x 1 m

// Without lateral contraction the end faces stay as they are under stretch and bending, so that a rigid tie
// disturbs nothing: what beam theory says there is exact for the solid.
reduce::Part solid_bar(double length, int cells, double nu) {
  reduce::Part part = reduce::testing::beam({length, kSide, kSide}, {cells, 2, 2}, mesh::CellType::hex20,
                                            reduce::Tie::rigid, reduce::Tie::rigid);
  part.materials = {reduce::isotropic("steel", 2.1e11, nu, 7850.0)};
  return part;
}

reduce::AttachedSolid attached(const reduce::Part& part, int modes, const std::vector<int>& nodes) {
  reduce::ReductionOptions options;
  options.n_modes = modes;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) options.shape_nodes.push_back(node);
  reduce::AttachedSolid solid{"block", reduce::craig_bampton(part, options), nodes, {}};
  solid.picture.vertices = part.mesh.points;
  solid.picture.triangles.resize(0, 3);
  solid.picture.edges.resize(0, 2);
  return solid;
}

// Solid from x = 0 to 0.5, beam on to 1: nodes 0, 1 are the solid's interfaces.
Model half_beam(double nu) {
  const Material material = isotropic("steel", 2.1e11, nu, 7850.0);
  Model model;
  model.nodes = {{"block.left", {0, kSide / 2, kSide / 2}},
                 {"block.right", {kHalf, kSide / 2, kSide / 2}},
                 {"tip", {2 * kHalf, kSide / 2, kSide / 2}}};
  model.sections = {testing::entry("square", Rectangle{kSide, kSide}, material)};
  Member member;
  member.name = "arm";
  member.end[0].node = 1;
  member.end[1].node = 2;
  member.section = 0;
  model.members = {member};
  model.anchors = {0, 1};
  return model;
}

class MixedPart : public testing::WithSession {};

TEST_F(MixedPart, StretchAndBendingPassThroughTheTieExactly) {
  const reduce::Structure structure(BeamMesh(half_beam(0.0), testing::divided(2)),
                                    {attached(solid_bar(kHalf, 5, 0.0), 4, {0, 1})});
  reduce::ReductionOptions none;
  none.n_modes = 0;
  const auto result = reduce::reduce_beams(structure, {{"root", 0}, {"tip", 2}}, none);
  const Eigen::MatrixXd C = reduce::reduced_static_compliance(result.reduction, "root", "tip").bottomRows(6);
  const double L = 2 * kHalf, E = 2.1e11, A = kSide * kSide, I = std::pow(kSide, 4) / 12;
  // hex20 holds the quadratic displacements of pure stretch and bending; round-off of K is eps times the
  // number of cells along the bar to the fourth, 1e-12, and some digits more by the solid's own reduction.
  EXPECT_NEAR(C(0, 0) / (L / (E * A)), 1.0, 1e-9);
  EXPECT_NEAR(C(4, 4) / (L / (E * I)), 1.0, 1e-9);
  EXPECT_NEAR(C(2, 4) / (-L * L / (2 * E * I)), 1.0, 1e-9);
  EXPECT_NEAR(C(1, 5) / (L * L / (2 * E * I)), 1.0, 1e-9);
  // A tip force shears as well, and the rigid ties hold the shear warping: Timoshenko's deflection within the
  // shear's own share of it, 12 EI / (G A_s L^2) / 4 = 0.6 %.
  const double G = E / 2, tip = std::pow(L, 3) / (3 * E * I) + L / (G * A * 5 / 6);
  EXPECT_NEAR(C(2, 2) / tip, 1.0, 6e-3);
}

TEST_F(MixedPart, MassAndInertiaAreThoseOfTheWholeBar) {
  const reduce::Structure structure(BeamMesh(half_beam(0.3), testing::divided(2)),
                                    {attached(solid_bar(kHalf, 5, 0.3), 6, {0, 1})});
  reduce::ReductionOptions some;
  some.n_modes = 4;
  const auto result = reduce::reduce_beams(structure, {{"root", 0}, {"tip", 2}}, some);
  const auto& inertia = result.reduction.inertia;
  const double L = 2 * kHalf, m = 7850.0 * L * kSide * kSide;
  EXPECT_NEAR(inertia.mass, m, 1e-10 * m);
  EXPECT_NEAR(inertia.S_x.x(), m * L / 2, 1e-10 * m * L);
  EXPECT_NEAR(inertia.S_x.z(), m * kSide / 2, 1e-10 * m * L);
  EXPECT_NEAR(inertia.S_xx(0, 0), m * L * L / 3, 1e-10 * m * L * L);
  // About z at Bo: the solid's and the beam's share of int y^2 dm alike.
  EXPECT_NEAR(inertia.S_xx(1, 1), m * (kSide * kSide / 3), 1e-10 * m * L * L);
  // Rigid motions strain nothing and their kinetic energy is the mass matrix's.
  EXPECT_LT(result.reduction.report.rigid_strain, 1e-11);
  Eigen::VectorXd along = Eigen::VectorXd::Zero(result.reduction.n());
  along(0) = along(6) = 1.0;
  EXPECT_NEAR(along.dot(result.reduction.M_se * along), m, 1e-9 * m);
  // The picture moves with it: solid vertices by the solid's shapes, beam vertices by the beam's (floats).
  const Eigen::VectorXf u = result.reduction.shapes * along.cast<float>();
  for (Eigen::Index v = 0; v < structure.picture().vertices.rows(); ++v) {
    EXPECT_NEAR(u(3 * v), 1.0, 2e-6);
    EXPECT_NEAR(u(3 * v + 1), 0.0, 2e-6);
  }
}

TEST_F(MixedPart, VibratesLikeTheSolidBar) {
  const reduce::Structure structure(BeamMesh(half_beam(0.3), testing::divided(10)),
                                    {attached(solid_bar(kHalf, 10, 0.3), 30, {0, 1})});
  const Eigen::VectorXd mixed = reduce::full_beam_modes(structure, 6);
  const auto solid = reduce::full_free_modes(solid_bar(2 * kHalf, 20, 0.3), 6, mixed(6));
  for (int k = 0; k < 6; ++k) EXPECT_LT(std::abs(mixed(k)), 1e-9 * mixed(6));
  // Bending pairs, torsion and stretch of a bar of l/h = 10: beam theory and solid differ by 0.5 % there, the
  // rigid plate in the middle stiffens by about as much.
  for (int k = 6; k < 12; ++k)
    EXPECT_NEAR(std::sqrt(mixed(k) / solid.omega2(k)), 1.0, 0.01) << "mode " << k - 5;
}

TEST_F(MixedPart, FewSolidModesStiffenManyConverge) {
  const reduce::Part part = solid_bar(kHalf, 10, 0.3);
  const auto first_and_sixth = [&](int modes) {
    const reduce::Structure structure(BeamMesh(half_beam(0.3), testing::divided(10)),
                                      {attached(part, modes, {0, 1})});
    const Eigen::VectorXd omega2 = reduce::full_beam_modes(structure, 6);
    return std::pair{omega2(6), omega2(11)};
  };
  const auto none = first_and_sixth(0), some = first_and_sixth(8), many = first_and_sixth(60);
  EXPECT_GT(none.second, 1.001 * many.second);
  EXPECT_GE(none.first, many.first * (1 - 1e-9));
  // Rayleigh-Ritz from above; the share of dropped modes falls with the square of their frequency.
  EXPECT_LT(some.second - many.second, 0.2 * (none.second - many.second));
}

TEST_F(MixedPart, RefusesSolidsThatDoNotFit) {
  const reduce::AttachedSolid block = attached(solid_bar(kHalf, 2, 0.3), 0, {0, 2});
  try {
    const reduce::Structure structure(BeamMesh(half_beam(0.3), testing::divided(2)), {block});
    FAIL() << "no refusal";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("solid \"block\", interface \"right\" does not lie at node \"tip\""));
  }
}

}  // namespace
}  // namespace flexura::beam
