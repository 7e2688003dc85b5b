// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Against Abaqus' own matrices and a reduction computed from them (data/README.md).
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "tests/reduce/parts.hpp"
#include "tests/reference.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
const std::string kData = FLEXURA_SOURCE_DIR "/tests/reduce/data/abaqus_block/";

Part block(mesh::CellType type) {
  Part part;
  part.mesh = read_abaqus(kData + (type == mesh::CellType::tet10 ? "blockC3D10.inp" : "blockC3D4.inp"), type);
  part.materials = {isotropic("steel", 2e11, 0.3, 2900.0)};
  return part;
}

Part tied_block() {
  Part part = block(mesh::CellType::tet10);
  for (const double x : {0.0, 4.0})
    part.interfaces.push_back({x == 0.0 ? "left" : "right",
                               Tie::rigid,
                               {x, 0.5, 0.5},
                               nodes_where(part.mesh, [=](const Eigen::Vector3d& p) { return p(0) == x; })});
  return part;
}

nlohmann::json reference() {
  std::ifstream file(kData + "craig_bampton_C3D10.json");
  return nlohmann::json::parse(file).at("C3D10");
}

Eigen::MatrixXd matrix_of(const nlohmann::json& rows) {
  Eigen::MatrixXd X(rows.size(), rows[0].size());
  for (Eigen::Index i = 0; i < X.rows(); ++i)
    for (Eigen::Index j = 0; j < X.cols(); ++j) X(i, j) = rows[i][j].get<double>();
  return X;
}

Eigen::VectorXd hertz(const Eigen::VectorXd& omega2) {
  return omega2.cwiseSqrt() / (2.0 * std::numbers::pi);
}

// Abaqus writes 16 digits; the tolerance asked for, 1e-10 of the largest entry, leaves room for another order
// of summation and nothing else.  A free model's interior dofs are all dofs, in the nodes' order.
void expect_same_matrices(const Part& part, const std::string& name) {
  AssemblyOptions options;
  options.may_be_free = true;
  options.shift = 1e-300;  // nothing, but a free body needs no pins
  const TiedModel model(part, options);
  const Eigen::MatrixXd K = read_coordinates(kData + name + "_STIF1.mtx.gz", model.n_i());
  const Eigen::MatrixXd M = read_coordinates(kData + name + "_MASS1.mtx.gz", model.n_i());
  ASSERT_GT(K.norm(), 0.0);
  ASSERT_GT(M.norm(), 0.0);
  EXPECT_LT((dense(model.K_ii()) - K).cwiseAbs().maxCoeff(), 1e-10 * K.cwiseAbs().maxCoeff());
  EXPECT_LT((kron3(dense(model.m())) - M).cwiseAbs().maxCoeff(), 1e-10 * M.cwiseAbs().maxCoeff());
}

TEST(AbaqusBlock, QuadraticTetrahedraHaveAbaqusStiffnessAndConsistentMass) {
  expect_same_matrices(block(mesh::CellType::tet10), "blockC3D10");
}

TEST(AbaqusBlock, LinearTetrahedraHaveAbaqusStiffnessAndLumpedMass) {
  Part part = block(mesh::CellType::tet4);
  part.mass = MassKind::lumped;
  expect_same_matrices(part, "blockC3D4");
}

// 1e-6 is the accuracy asked for; the reference matrices agree with themselves (symmetry) to 1e-8 of the
// largest entry.
TEST(AbaqusBlock, CraigBamptonMatricesAndFrequenciesAreTheReference) {
  const nlohmann::json expected = reference();
  for (const Eigensolver eigensolver : {Eigensolver::block_lanczos, Eigensolver::krylov_schur}) {
    ReductionOptions options;
    options.n_modes = 10;
    options.eigensolver = eigensolver;
    const Reduction reduction = craig_bampton(tied_block(), options);
    ASSERT_EQ(reduction.n_b, 12);
    ASSERT_EQ(reduction.n_q, 10);
    const Eigen::MatrixXd K = matrix_of(expected.at("Kbb_12x12")), M = matrix_of(expected.at("Mbb_12x12"));
    EXPECT_LT((reduction.K_se.topLeftCorner(12, 12) - K).norm(), 1e-6 * K.norm());
    EXPECT_LT((reduction.M_se.topLeftCorner(12, 12) - M).norm(), 1e-6 * M.norm());
    const Eigen::VectorXd fixed = hertz(reduction.omega2);
    const auto& modes = reduction.M_se;
    for (int k = 0; k < 10; ++k) {
      const double wanted = expected.at("fixed_interface_Hz")[k].get<double>();
      test::expect_reference(
          "fixed-interface mode " + std::to_string(k + 1) +
              (eigensolver == Eigensolver::block_lanczos ? ", block Lanczos" : ", Krylov-Schur"),
          "Hz", fixed(k), wanted, 1e-6 * wanted,
          {"block of C3D10: Abaqus' matrices, reduced by an independent program (Exudyn's data)",
           "the accuracy of the printed matrices"});
      EXPECT_LT(reduction.report.mode_residual(k), 1e-9);
    }
    EXPECT_LT((modes.bottomRightCorner(10, 10) - Eigen::MatrixXd::Identity(10, 10)).norm(), 1e-10);
    const Eigen::VectorXd omega2 = linalg::generalized_eigen(reduction.K_se, reduction.M_se).values;
    for (int k = 0; k < 10; ++k)
      EXPECT_NEAR(hertz(omega2.tail(16))(k) / expected.at("CB10_freefree_Hz")[k].get<double>(), 1.0, 1e-6);
    const Eigen::VectorXd clamped = linalg::generalized_eigen(reduction.K_se.bottomRightCorner(16, 16),
                                                              reduction.M_se.bottomRightCorner(16, 16))
                                        .values;
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(hertz(clamped)(k) / expected.at("CB10_clamped_left_Hz")[k].get<double>(), 1.0, 1e-6);
    EXPECT_NEAR(reduction.inertia.mass / expected.at("mass").get<double>(), 1.0, 1e-12);
  }
}

TEST(AbaqusBlock, FullFreeAndClampedFrequenciesAreTheReference) {
  const nlohmann::json expected = reference();
  const Part part = tied_block();
  const double scale = std::pow(2.0 * std::numbers::pi * 450.0, 2);
  const linalg::EigenPairs free = full_free_modes(part, 10, scale);
  ASSERT_EQ(free.omega2.size(), 16);
  for (int k = 0; k < 6; ++k)
    EXPECT_LT(std::abs(free.omega2(k)), 1e-8 * scale);  // round-off: see full_free_modes
  for (int k = 0; k < 10; ++k)
    EXPECT_NEAR(
        hertz(free.omega2.tail(10))(k) / expected.at("full_freefree_with_rigid_faces_Hz")[k].get<double>(),
        1.0, 1e-6);
  const linalg::EigenPairs clamped = full_clamped_modes(part, "left", 6);
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(hertz(clamped.omega2)(k) / expected.at("full_clamped_left_Hz")[k].get<double>(), 1.0, 1e-6);
}

}  // namespace
}  // namespace flexura::reduce
