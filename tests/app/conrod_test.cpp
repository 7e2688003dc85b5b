// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The steam engine's connecting rod from its STEP file, coarsely meshed: the superelement against the full
// model on the same mesh with the same ties.
#include <gtest/gtest.h>

#include <cmath>

#include "mesh/gmsh/cad.hpp"
#include "mesh/model/select.hpp"
#include "reduce/cms/verification.hpp"

namespace flexura::test {
namespace {

constexpr double kDensity = 7850.0;

/// Meshed and reduced once for all tests of this file.
struct Conrod {
  mesh::CadMesh cad;
  reduce::Part part;
  reduce::Reduction reduction;
};

const Conrod& conrod() {
  static const Conrod instance = [] {
    Conrod c;
    c.cad = mesh::mesh_cad({.path = std::string(FLEXURA_SOURCE_DIR) + "/cases/steam_engine/conrod.step",
                            .size = 0.012,
                            .elements_per_circle = 10,
                            .worker = std::string(FLEXURA_BIN_DIR) + "/flexura-mesh"});
    c.part.mesh = c.cad.mesh;
    c.part.materials = {reduce::isotropic("steel", 210e9, 0.3, kDensity)};
    const auto add = [&c](const char* name, double x, double radius) {
      const mesh::Selection chosen = mesh::select_nodes(
          c.cad.mesh, c.cad.cad.faces, mesh::CylinderRule{.point = {x, 0.0, 0.0}, .radius = radius});
      c.part.interfaces.push_back({.name = name, .point = chosen.reference, .set = chosen.set});
    };
    add("big_end", 0.0, 0.025);
    add("small_end", 0.3, 0.015);
    reduce::ReductionOptions options;
    options.n_modes = 20;
    c.reduction = reduce::craig_bampton(c.part, options);
    return c;
  }();
  return instance;
}

// The tolerance: 0.5 % of the CAD kernel's volume; the centre to 0.5 % of the part's half length.
TEST(ConrodFromStep, MassAndCentreAreThoseOfTheCadPart) {
  const Conrod& c = conrod();
  const mesh::CadSolid& solid = c.cad.cad.solids.at(0);
  EXPECT_NEAR(c.reduction.inertia.mass / (kDensity * solid.volume), 1.0, 0.005);
  const Eigen::Vector3d centre = c.reduction.inertia.S_x / c.reduction.inertia.mass;
  EXPECT_LT((centre - solid.centroid).norm(), 0.005 * 0.15);
}

TEST(ConrodFromStep, InterfaceNodesLieOnTheBoresAxes) {
  const std::vector<reduce::ReducedInterface>& interfaces = conrod().reduction.interfaces;
  for (int k = 0; k < 2; ++k) {
    // Across the axis: STEP prints 15 digits and axes are fitted to 1e-12 m. Along it the node lies at the
    // centroid of the meshed bore, which is symmetric only as far as the mesh is: 1e-4 of the bore's length.
    const Eigen::Vector3d off = interfaces.at(k).point - Eigen::Vector3d(0.3 * k, 0.0, 0.0);
    EXPECT_LT(off.head<2>().norm(), 1e-9);
    EXPECT_LT(std::abs(off.z()), 1e-4 * 0.036);
  }
}

// Craig-Bampton is exact in statics: what is left is round-off of two solves with a stiffness matrix of
// condition number 1e6 to 1e8 (element stiffness over bending stiffness), hence 1e-8 of sqrt(u_ii u_jj).
TEST(ConrodFromStep, UnitLoadsOnOneBoreBendItLikeTheFullModel) {
  const Conrod& c = conrod();
  const Eigen::MatrixXd full =
      reduce::full_static_compliance(c.part, "big_end", "small_end").middleRows(6, 6);
  const Eigen::MatrixXd reduced =
      reduce::reduced_static_compliance(c.reduction, "big_end", "small_end").middleRows(6, 6);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      EXPECT_NEAR(reduced(i, j), full(i, j), 1e-8 * std::sqrt(full(i, i) * full(j, j))) << i << ", " << j;
    }
  }
}

// With 20 modes the cut-off lies far above the first five elastic modes; the tolerances are the issue's.
TEST(ConrodFromStep, FreeFrequenciesAreThoseOfTheFullModel) {
  const Conrod& c = conrod();
  const Eigen::VectorXd reduced = reduce::reduced_free_modes(c.reduction);
  const linalg::EigenPairs full = reduce::full_free_modes(c.part, 20, reduced[6]);
  // Exactly six rigid motions, zero to round-off: 1e-9 of the first elastic eigenvalue (see full_free_modes).
  EXPECT_LT(std::abs(reduced[5]), 1e-6 * reduced[6]);
  EXPECT_LT(std::abs(full.omega2[5]), 1e-6 * full.omega2[6]);
  EXPECT_GT(full.omega2[6], 1e4);
  for (int k = 0; k < 5; ++k) {
    const double f_full = std::sqrt(full.omega2[6 + k]), f_reduced = std::sqrt(reduced[6 + k]);
    EXPECT_NEAR(f_reduced / f_full, 1.0, k < 3 ? 1e-3 : 5e-3) << "elastic mode " << k + 1;
    EXPECT_GE(f_reduced, f_full * (1.0 - 1e-8)) << "Ritz values are upper bounds";
  }
}

}  // namespace
}  // namespace flexura::test
