// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Interface reduction against the interface whose every node is a boundary node.
#include "reduce/cms/shapes/interface_modes.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/shapes/constraint_modes.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A stocky block, so that its faces matter; bent, so that nothing is symmetric.
Part bent_block(Tie left, Tie right, const std::array<int, 3>& n = {3, 2, 2},
                mesh::CellType type = mesh::CellType::hex20) {
  Part part = beam({0.2, 0.1, 0.08}, n, type, left, right);
  const auto bend = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    return {x(0) + 0.1 * x(1), x(1) + 0.8 * x(0) * x(0), x(2) * (1.0 - x(0)) - 0.1 * x(1)};
  };
  deform(part.mesh, bend);
  for (InterfaceSpec& interface : part.interfaces) interface.point = bend(interface.point);
  return part;
}

// The left interface rigid, every node of the right one a boundary node of its own.
Part all_nodes_kept(Part part = bent_block(Tie::rigid, Tie::rigid)) {
  const std::vector<mesh::Index> face = part.interfaces[1].set.nodes;
  part.interfaces.pop_back();
  for (const mesh::Index node : face)
    part.interfaces.push_back({"node" + std::to_string(node), Tie::node, {}, {{node}, {}}, {0, 1, 2}});
  return part;
}

Reduction with_interface_modes(const Part& part, int interface_modes, int n_modes = 12,
                               double accuracy = 0.0) {
  ReductionOptions options;
  options.n_modes = n_modes;
  options.interface_modes = {.count = interface_modes, .accuracy = accuracy};
  for (mesh::Index node : part.interfaces.back().set.nodes) options.shape_nodes.push_back(node);
  return craig_bampton(part, options);
}

// The mean motion of the right face, 6 x 3 n_S, and a basis of the motions without one.
MatrixXd mean_of_face(const Part& part) {
  return averaging_map(part.mesh, part.interfaces[1]);
}
MatrixXd without_mean(const MatrixXd& A) {
  const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(A.transpose()).householderQ();
  return Q.rightCols(A.cols() - 6);
}

// Greatest relative excess of stiffness, rigid motions held alike.
double stiffer(const MatrixXd& K, const MatrixXd& than, const MatrixXd& R) {
  const MatrixXd hold = than.norm() / R.squaredNorm() * R * R.transpose();
  return linalg::generalized_eigen(K + hold, than + hold).values.maxCoeff() - 1.0;
}

// A face of 21 nodes, which is treated as a whole, and one of 156, where Lanczos works.
class CondensedBoundary : public ::testing::TestWithParam<std::pair<std::array<int, 3>, mesh::CellType>> {};

TEST_P(CondensedBoundary, HasTheInterfaceModesForEigenvectors) {
  const auto& [n, type] = GetParam();
  const Part whole = bent_block(Tie::rigid, Tie::elastic, n, type), part = with_rigid_faces(whole);
  const TiedModel soft_model(whole), stiff_model(part);
  const TiedSolver soft(soft_model), stiff(stiff_model);
  const ConstraintModes constraint = constraint_modes(stiff_model, stiff);
  const InterfaceModes modes =
      interface_modes(soft, stiff, constraint.Psi, constraint.K_bb, {.count = 10}, {});

  ReductionOptions guyan;
  guyan.set = ModeSet::guyan;
  const Reduction kept = craig_bampton(all_nodes_kept(part), guyan);
  const Eigen::Index n_w = kept.n_b - 6;
  EXPECT_EQ(modes.n_face, n_w);
  const MatrixXd N = without_mean(mean_of_face(whole));
  const VectorXd omega2 = linalg::generalized_eigen(N.transpose() * kept.K_se.bottomRightCorner(n_w, n_w) * N,
                                                    N.transpose() * kept.M_se.bottomRightCorner(n_w, n_w) * N)
                              .values;
  // Ritz values carry the square of the residual, 1e-16; the dense problem its round-off, 1e-16 of the
  // largest eigenvalue, some 1e5 times the first.
  ASSERT_GE(modes.omega2.size(), 10);
  for (int k = 0; k < 10; ++k) EXPECT_NEAR(modes.omega2(k) / omega2(k), 1.0, 1e-9) << k;
}

INSTANTIATE_TEST_SUITE_P(Faces, CondensedBoundary,
                         ::testing::Values(std::pair{std::array{3, 2, 2}, mesh::CellType::hex20},
                                           std::pair{std::array{2, 12, 11}, mesh::CellType::hex8}));

TEST(InterfaceModes, AllOfThemAreTheUnreducedInterface) {
  const Part whole = bent_block(Tie::rigid, Tie::elastic);
  const int all = 3 * static_cast<int>(whole.interfaces[1].set.nodes.size()) - 6;
  const Reduction reduced = with_interface_modes(whole, all);
  EXPECT_EQ(reduced.report.n_interface_modes, all);
  EXPECT_EQ(reduced.n_b, 12);
  ReductionOptions options;
  options.n_modes = 12;
  const VectorXd ours = reduced_free_modes(reduced),
                 kept = reduced_free_modes(craig_bampton(all_nodes_kept(), options));
  ASSERT_EQ(ours.size(), kept.size());
  // Two bases of one space: round-off of the dense problem, 1e-16 of the largest eigenvalue.
  const double round_off = 1e-13 * kept.maxCoeff();
  for (int k = 6; k < 40; ++k) EXPECT_NEAR(ours(k), kept(k), round_off + 1e-9 * kept(k)) << k;
  EXPECT_LT(ours.head(6).cwiseAbs().maxCoeff(), round_off);
  // Loads on the interface node are spread as the averaging tie spreads them.
  const MatrixXd exact = full_static_compliance(whole, "left", "right").bottomRows(6);
  const MatrixXd own = reduced_static_compliance(reduced, "left", "right").bottomRows(6);
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(own(i, j), exact(i, j), 1e-8 * std::sqrt(exact(i, i) * exact(j, j))) << i << "," << j;
}

// Whatever is kept: a rigid motion of the face costs the energy of the rigid tie, exactly.
TEST(InterfaceModes, LeaveRigidMotionOfTheFaceExactInStatics) {
  const Part whole = bent_block(Tie::rigid, Tie::elastic);
  const Reduction reduced = with_interface_modes(whole, 7),
                  rigid = with_interface_modes(bent_block(Tie::rigid, Tie::rigid), 0);
  const std::vector<mesh::Index>& face = whole.interfaces[1].set.nodes;
  MatrixXd D(3 * static_cast<Eigen::Index>(face.size()), 6);
  for (std::size_t a = 0; a < face.size(); ++a)
    D.middleRows<3>(3 * static_cast<Eigen::Index>(a)) =
        motion_at(whole.mesh.points.row(face[a]).transpose() - whole.interfaces[1].point);
  // Coordinates with the left interface at rest for which the face moves rigidly (modes with the face at rest
  // among them do not matter: the least energy is asked for).
  const MatrixXd S = reduced.shapes.cast<double>();
  const Eigen::Index n_q = reduced.n_q;
  const MatrixXd S_q = S.rightCols(n_q);
  const MatrixXd rest = D - S.middleCols(6, 6);  // to be made up by the modes
  Eigen::ColPivHouseholderQR<MatrixXd> qr(S_q);
  qr.setThreshold(1e-5);  // shapes are stored in single precision
  EXPECT_EQ(qr.rank(), reduced.report.n_interface_modes) << "the others leave the face at rest";
  const MatrixXd eta = qr.solve(rest);
  EXPECT_LT((S_q * eta - rest).norm(), 1e-6 * D.norm());
  // Least energy: eta + N z, N the modes with the face at rest.
  const MatrixXd N = [&] {
    Eigen::ColPivHouseholderQR<MatrixXd> of(S_q.transpose());
    of.setThreshold(1e-5);
    const MatrixXd Q = of.householderQ();
    return MatrixXd(Q.rightCols(n_q - of.rank()));
  }();
  const MatrixXd K_q = reduced.omega2.asDiagonal();
  const MatrixXd z = (N.transpose() * K_q * N).ldlt().solve(N.transpose() * K_q * eta);
  const MatrixXd least = eta - N * z;
  const MatrixXd energy = reduced.K_se.block(6, 6, 6, 6) + least.transpose() * K_q * least;
  const MatrixXd expected = rigid.K_se.block(6, 6, 6, 6);
  // Single precision of the shapes, 1e-7, magnified by the stiffness of the highest mode against the
  // interface's, some 1e2.
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(energy(i, j), expected(i, j), 1e-4 * std::sqrt(expected(i, i) * expected(j, j)))
          << i << "," << j;
}

// The unreduced interface is the one with all of its 114 modes.
TEST(InterfaceModes, ConvergeFromTheRigidTieToTheUnreducedInterface) {
  const Part whole = bent_block(Tie::elastic, Tie::elastic);
  ReductionOptions options;
  options.n_modes = 12;
  const Reduction average = craig_bampton(bent_block(Tie::average, Tie::average), options),
                  unreduced = with_interface_modes(whole, 114);
  EXPECT_EQ(unreduced.report.n_interface_modes, 114);
  EXPECT_LT(std::abs(unreduced.report.interface_stiffness_error), 1e-8);
  const VectorXd limit = reduced_free_modes(unreduced).segment(6, 4);
  const linalg::EigenPairs full = full_free_modes(whole, 4, limit(0));
  MatrixXd R(12, 6);
  for (int k : {0, 1}) R.middleRows<6>(6 * k) = node_motion_at(average.interfaces[k].point);
  std::vector<double> excess, above;  // of static stiffness, of the worst of four frequencies
  VectorXd last = VectorXd::Constant(4, 1e99);
  for (const int count : {0, 6, 20, 60, 100}) {
    const Reduction reduced = with_interface_modes(whole, count);
    excess.push_back(stiffer(reduced.K_se.topLeftCorner(12, 12), average.K_se.topLeftCorner(12, 12), R));
    EXPECT_NEAR(reduced.report.interface_stiffness_error, excess.back(), 1e-6) << count;
    EXPECT_GT(excess.back(), -1e-8) << count << ": never softer than the averaging tie";
    const VectorXd omega2 = reduced_free_modes(reduced).segment(6, 4);
    for (int k = 0; k < 4; ++k) {
      EXPECT_LE(omega2(k), last(k) * (1.0 + 1e-9)) << "a larger space gives lower Ritz values";
      EXPECT_GE(omega2(k), limit(k) * (1.0 - 1e-9));
      EXPECT_GE(omega2(k), full.omega2(6 + k) * (1.0 - 1e-7));
    }
    above.push_back(omega2.cwiseQuotient(limit).cwiseSqrt().maxCoeff() - 1.0);
    last = omega2;
  }
  for (std::size_t k = 1; k < excess.size(); ++k) {
    EXPECT_LT(excess[k], excess[k - 1]) << k;
    EXPECT_LT(above[k], above[k - 1]) << k;
  }
  // With half of the modes no more than a tenth of the rigid tie's errors is left.
  EXPECT_LT(excess[3], 0.1 * excess[0]) << excess[0] << ", " << excess[3];
  EXPECT_LT(above[3], 0.1 * above[0]) << above[0] << ", " << above[3];
}

TEST(InterfaceModes, AreKeptToTheAccuracyAskedFor) {
  const Part whole = bent_block(Tie::rigid, Tie::elastic);
  const Reduction reduced = with_interface_modes(whole, 0, 12, 0.05);
  EXPECT_LE(reduced.report.interface_stiffness_error, 0.05);
  EXPECT_GT(reduced.report.n_interface_modes, 0);
  const Reduction fewer = with_interface_modes(whole, reduced.report.n_interface_modes - 1, 12);
  EXPECT_GT(fewer.report.interface_stiffness_error, 0.05) << "no more than it takes";
  Part one = whole;
  one.interfaces.erase(one.interfaces.begin());
  EXPECT_THROW(with_interface_modes(one, 0, 12, 0.05), std::invalid_argument);
  EXPECT_EQ(with_interface_modes(one, 5).report.n_interface_modes, 5);
}

}  // namespace
}  // namespace flexura::reduce
