// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/geometry.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/cms/shapes/sturm.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using mesh::CellType;

// A bent, tapered beam with curved cells: nothing about it is symmetric or aligned.
Part banana(Tie left, Tie right) {
  Part part = beam({0.6, 0.06, 0.04}, {10, 2, 2}, CellType::tet10, left, right);
  const auto bend = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    const double taper = 1.0 - 0.5 * x(0);
    return {x(0) + 0.1 * x(1), taper * x(1) + 0.3 * x(0) * x(0),
            taper * x(2) - 0.1 * x(0) * x(0) + 0.05 * x(0)};
  };
  deform(part.mesh, bend);
  for (InterfaceSpec& interface : part.interfaces)
    interface.point = bend(interface.point) + Eigen::Vector3d(0, 0.01, 0);
  return part;
}

class ReducedBanana : public ::testing::TestWithParam<std::pair<Tie, Tie>> {
 protected:
  Part part() const { return banana(GetParam().first, GetParam().second); }
};

Reduction reduce_with(const Part& part, int n_modes, std::vector<mesh::Index> nodes = {}) {
  ReductionOptions options;
  options.n_modes = n_modes;
  options.shape_nodes = std::move(nodes);
  return craig_bampton(part, options);
}

TEST_P(ReducedBanana, SuperelementHasTheMassCentreAndInertiaOfTheMesh) {
  const Part p = part();
  const Reduction se = reduce_with(p, 5);
  const mesh::Volumes volumes = mesh::measure_volume(p.mesh);
  const double rho = p.materials[0].density, mass = rho * volumes.volume;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(se.n(), 6);
  for (const ReducedInterface& interface : se.interfaces)
    R.middleRows(interface.first_dof, 6) = node_motion_at(interface.point);
  const Eigen::Matrix<double, 6, 6> M = R.transpose() * se.M_se * R;
  const Eigen::Vector3d c = volumes.centroid;
  Eigen::Matrix3d cross;
  cross << 0, -c(2), c(1), c(2), 0, -c(0), -c(1), c(0), 0;
  Eigen::Matrix<double, 6, 6> expected = mass * Eigen::Matrix<double, 6, 6>::Identity();
  expected.topRightCorner<3, 3>() = -mass * cross;
  expected.bottomLeftCorner<3, 3>() = mass * cross;
  expected.bottomRightCorner<3, 3>() = rho * volumes.inertia - mass * cross * cross;
  EXPECT_LT((M - expected).cwiseAbs().maxCoeff(), 1e-10 * mass);
  EXPECT_NEAR(se.inertia.mass / mass, 1.0, 1e-10);
  EXPECT_LT((se.inertia.S_x - mass * c).norm(), 1e-10 * mass);
  EXPECT_LT(se.report.rigid_strain, 1e-12);
  EXPECT_LT(se.report.constraint_residual, 1e-12);
}

// Craig-Bampton is exact in statics.
TEST_P(ReducedBanana, StaticCompliancesAreThoseOfTheFullModel) {
  const Part p = part();
  const Reduction se = reduce_with(p, 3);
  for (const auto& [clamped, loaded] : {std::pair{"left", "right"}, std::pair{"right", "left"}}) {
    const Eigen::MatrixXd full = full_static_compliance(p, clamped, loaded);
    const Eigen::MatrixXd reduced = reduced_static_compliance(se, clamped, loaded);
    const int first = std::string(loaded) == "left" ? 0 : 6;
    const Eigen::MatrixXd own = full.middleRows(first, 6);
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        EXPECT_NEAR(reduced(first + i, j), own(i, j), 1e-8 * std::sqrt(own(i, i) * own(j, j)))
            << i << "," << j;
    EXPECT_LT(full.middleRows(6 - first, 6).norm(), 1e-12 * full.norm());
  }
}

TEST_P(ReducedBanana, FreeFrequenciesAreThoseOfTheFullModelAndSixAreZero) {
  const Part p = part();
  const Reduction se = reduce_with(p, 20);
  const Eigen::VectorXd reduced = reduced_free_modes(se);
  const linalg::EigenPairs full = full_free_modes(p, 5, reduced(6));
  // Round-off of a dense generalised problem: 1e-16 of the largest eigenvalue, here about 1e9 times the
  // first.
  EXPECT_LT(reduced.head(6).cwiseAbs().maxCoeff(), 1e-15 * reduced.maxCoeff() * 100);
  EXPECT_LT(reduced.head(6).cwiseAbs().maxCoeff(), 1e-3 * reduced(6));
  EXPECT_LT(full.omega2.head(6).cwiseAbs().maxCoeff(), 1e-8 * full.omega2(6));
  for (int k = 0; k < 5; ++k) {
    const double error = std::sqrt(reduced(6 + k) / full.omega2(6 + k)) - 1.0;
    EXPECT_GT(error, -1e-9) << "a Ritz value lies above";
    EXPECT_LT(error, k < 3 ? 1e-3 : 5e-3) << "elastic mode " << k;
  }
}

// The integrals against quadrature over the cells of the field that the shapes describe, weighted by random
// numbers.
TEST_P(ReducedBanana, InertiaIntegralsAreThoseOfTheDisplacementField) {
  const Part p = part();
  std::vector<mesh::Index> all(p.mesh.n_nodes());
  for (mesh::Index a = 0; a < p.mesh.n_nodes(); ++a) all[a] = a;
  const Reduction se = reduce_with(p, 4, all);
  const Eigen::VectorXd q = random_matrix(se.n(), 1), r = random_matrix(se.n(), 1, 2);
  // The nodal fields come from the shapes as they are stored, in single precision: 1e-7 is all one can ask.
  const Eigen::VectorXd U = se.shapes.cast<double>() * q, V = se.shapes.cast<double>() * r;
  Eigen::Vector3d S_u = Eigen::Vector3d::Zero();
  Eigen::Matrix3d S_xu = Eigen::Matrix3d::Zero(), S_uv = Eigen::Matrix3d::Zero();
  for (const mesh::CellBlock& block : p.mesh.solids) {
    const mesh::Quadrature& rule = mesh::volume_quadrature(block.type);
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
      for (Eigen::Index k = 0; k < rule.weights.size(); ++k) {
        const mesh::ShapeValues shape = mesh::evaluate_shape(block.type, rule.points.row(k));
        Eigen::Vector3d x = Eigen::Vector3d::Zero(), u = x, v = x;
        Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
        for (Eigen::Index a = 0; a < shape.N.size(); ++a) {
          const mesh::Index node = block.nodes(cell, a);
          x += shape.N(a) * p.mesh.points.row(node).transpose();
          u += shape.N(a) * U.segment<3>(3 * node);
          v += shape.N(a) * V.segment<3>(3 * node);
          J += p.mesh.points.row(node).transpose() * shape.dN.row(a);
        }
        const double dm = p.materials[0].density * rule.weights(k) * J.determinant();
        S_u += dm * u;
        S_xu += dm * x * u.transpose();
        S_uv += dm * u * v.transpose();
      }
  }
  const double mass = se.inertia.mass, size = U.cwiseAbs().maxCoeff();
  EXPECT_LT((se.inertia.S_phi * q - S_u).norm(), 1e-6 * mass * size);
  Eigen::Matrix3d S_xphi;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) S_xphi(a, b) = se.inertia.S_xphi.row(3 * a + b) * q;
  EXPECT_LT((S_xphi - S_xu).norm(), 1e-6 * mass * size);
  constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (int k = 0; k < 6; ++k) {
    const auto& block = se.inertia.S_phiphi[k];
    EXPECT_NEAR(q.dot(block * r), S_uv(kPairs[k][0], kPairs[k][1]),
                1e-6 * mass * size * V.cwiseAbs().maxCoeff());
  }
}

// Neither eigensolver has missed a mode: Sylvester's law counts them without iterating.
TEST_P(ReducedBanana, NoModeIsMissed) {
  const Part p = part();
  const Reduction se = reduce_with(p, 24);
  for (int k : {0, 1, 7, se.n_q - 1}) {
    EXPECT_EQ(count_modes_below(TiedModel(p), se.omega2(k) * (1.0 + 1e-6)), k + 1) << "above mode " << k;
    EXPECT_EQ(count_modes_below(TiedModel(p), se.omega2(k) * (1.0 - 1e-6)), k) << "below mode " << k;
  }
}

INSTANTIATE_TEST_SUITE_P(AllTies, ReducedBanana,
                         ::testing::Values(std::pair{Tie::rigid, Tie::rigid},
                                           std::pair{Tie::rigid, Tie::average},
                                           std::pair{Tie::average, Tie::average}),
                         [](const auto& info) {
                           return std::string(reduce::name_of(info.param.first)) + "_" +
                                  reduce::name_of(info.param.second);
                         });

// An averaged face is softer than a rigid one.
TEST(Reduction, AveragingTiesAreSofterThanRigidOnes) {
  const auto tip = [](Tie tie) -> Eigen::MatrixXd {
    return full_static_compliance(banana(Tie::rigid, tie), "left", "right").bottomRows(6);
  };
  const Eigen::MatrixXd rigid = tip(Tie::rigid), average = tip(Tie::average);
  for (int d = 0; d < 6; ++d) EXPECT_GT(average(d, d), rigid(d, d));
}

// A body held at one end, like a tuning fork: its interface moves without strain, and all stiffness is that
// of the modes.
TEST(Reduction, OneInterfaceLeavesAllStiffnessToTheModes) {
  Part part = banana(Tie::rigid, Tie::rigid);
  part.interfaces.pop_back();
  const Reduction se = reduce_with(part, 20);
  ASSERT_EQ(se.n_b, 6);
  EXPECT_EQ(se.K_se.topLeftCorner(6, 6).norm(), 0.0);
  const linalg::DenseEigen reduced = linalg::generalized_eigen(se.K_se, se.M_se);
  const linalg::EigenPairs full = full_free_modes(part, 2, se.omega2(0));
  for (int k = 6; k < 8; ++k) {
    // From above (Rayleigh), by what twenty modes leave of a beam's first bending: the share of the dropped
    // ones' inertia, well below a percent.
    EXPECT_GT(reduced.values(k) / full.omega2(k), 1.0 - 1e-9);
    EXPECT_LT(reduced.values(k) / full.omega2(k), 1.01);
  }
}

// Three single nodes hold a body as well; their nine directions are boundary dofs of the mesh itself.
TEST(Reduction, SingleNodesAreInterfaces) {
  Part p = banana(Tie::rigid, Tie::rigid);
  p.interfaces.clear();
  for (const auto& corner :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.6, 0, 0), Eigen::Vector3d(0, 0.06, 0.04)}) {
    Part straight = beam({0.6, 0.06, 0.04}, {10, 2, 2}, CellType::tet10, Tie::rigid, Tie::rigid);
    p.interfaces.push_back(
        {"node" + std::to_string(p.interfaces.size()),
         Tie::node,
         {},
         nodes_where(straight.mesh, [&](const Eigen::Vector3d& x) { return (x - corner).norm() < 1e-9; }),
         {0, 1, 2}});
  }
  const Reduction se = reduce_with(p, 20);
  EXPECT_EQ(se.n_b, 9);
  EXPECT_LT(se.report.rigid_strain, 1e-11);
  const Eigen::VectorXd reduced = reduced_free_modes(se);
  const linalg::EigenPairs full = full_free_modes(p, 3, reduced(6));
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::sqrt(reduced(6 + k) / full.omega2(6 + k)), 1.0, 2e-2);
}

// A slender solid of small cells: rounding alone leaves a residual of 1e-8 (eigen_problem.hpp), its
// frequencies are right all the same, by a dense solver and by beam theory.
TEST(Reduction, FrequenciesOfSlenderSolidsAreRightWhateverTheirResidual) {
  const Part p = beam({0.9, 0.06, 0.025}, {14, 2, 1}, CellType::tet10, Tie::rigid, Tie::average);
  const Reduction se = reduce_with(p, 10);
  const linalg::EigenPairs full = full_free_modes(p, 6, reduced_free_modes(se)(6));
  Part tied = p;
  for (InterfaceSpec& interface : tied.interfaces) interface.directions.clear();
  AssemblyOptions assembly;
  assembly.may_be_free = true;
  const TiedModel model(tied, assembly);
  const Eigen::MatrixXd K = dense(model.K_ii());
  Eigen::MatrixXd M;
  model.matrices().multiply_M_ii(Eigen::MatrixXd::Identity(K.rows(), K.rows()), M);
  // Round-off of the dense solver is 1e-16 of the largest eigenvalue, some 1e9 times the first elastic one.
  const Eigen::VectorXd exact = linalg::generalized_eigen(K, 0.5 * (M + M.transpose())).values;
  for (int k = 6; k < 12; ++k) EXPECT_NEAR(full.omega2(k) / exact(k), 1.0, 1e-6) << k;
  // Euler and Bernoulli's free beam in its softer plane, 22.373 sqrt(EI / rho A) / L^2; shear and rotary
  // inertia take (t / L)^2 times some ten from it, stiff ends and straight cells add as much.
  const double beam_omega = 22.373 * std::sqrt(2.1e11 / 7850.0 / 12.0) * 0.025 / (0.9 * 0.9);
  EXPECT_NEAR(std::sqrt(full.omega2(6)) / beam_omega, 1.0, 0.03);
}

TEST(Reduction, ModesUpToAFrequencyAreAllOfThem) {
  const Part p = banana(Tie::rigid, Tie::rigid);
  const Reduction many = reduce_with(p, 30);
  ReductionOptions options;
  options.n_modes = 0;
  options.omega_max = std::sqrt(0.5 * (many.omega2(11) + many.omega2(12)));
  const Reduction upto = craig_bampton(p, options);
  ASSERT_EQ(upto.n_q, 12);
  EXPECT_LT((upto.omega2 - many.omega2.head(12)).norm(), 1e-10 * many.omega2(11));
}

}  // namespace
}  // namespace flexura::reduce
