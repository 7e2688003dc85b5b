// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Mode vectors of another program with their reduced matrices.  The other program is played by dense algebra
// on the assembled K and M, whose own reduction the result must equal: both span one space.
#include "reduce/cms/finished_modes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <fstream>
#include <iomanip>

#include "mbs/superelement/file.hpp"
#include "reduce/app/write_reduced.hpp"
#include "reduce/assembly/input/average.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/recovery/stress.hpp"
#include "tests/app/command.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A cantilever-like block with averaging ties, its K and M on all nodes, and our own reduction of it.
struct Example {
  Part part = beam({0.3, 0.06, 0.05}, {4, 1, 1}, mesh::CellType::hex20, Tie::average, Tie::average);
  std::vector<mesh::Index> all;
  MatrixXd K, m;
  Reduction own;
  static constexpr int kModes = 9;

  Example() {
    AssemblyOptions assembly;
    assembly.may_be_free = true;
    Part free = part;
    for (InterfaceSpec& interface : free.interfaces) interface.directions.clear();
    const TiedModel model(free, assembly);  // averages without rows: no node is eliminated
    K = dense(model.K_ii());
    m = dense(model.m());
    for (mesh::Index a = 0; a < part.mesh.n_nodes(); ++a) all.push_back(a);
    ReductionOptions options;
    options.n_modes = kModes;
    options.shape_nodes = all;
    options.stress_nodes = all;
    own = craig_bampton(part, options);
  }

  // Constraint modes and fixed-interface modes by dense algebra: K bordered by the averages.
  MatrixXd vectors() const {
    const Index n = K.rows();
    MatrixXd A(12, n);
    A.setZero();
    for (int k : {0, 1}) {
      const MatrixXd map = averaging_map(part.mesh, part.interfaces[k]);
      const auto& nodes = part.interfaces[k].set.nodes;
      for (std::size_t a = 0; a < nodes.size(); ++a)
        A.block(6 * k, 3 * nodes[a], 6, 3) = map.middleCols(3 * static_cast<Index>(a), 3);
    }
    MatrixXd bordered = MatrixXd::Zero(n + 12, n + 12);
    const double scale = K.norm();
    bordered.topLeftCorner(n, n) = K / scale;
    bordered.topRightCorner(n, 12) = A.transpose();
    bordered.bottomLeftCorner(12, n) = A;
    MatrixXd right = MatrixXd::Zero(n + 12, 12);
    right.bottomRows(12).setIdentity();
    MatrixXd V(n, 12 + kModes);
    V.leftCols(12) = bordered.partialPivLu().solve(right).topRows(n);
    const MatrixXd Q = Eigen::HouseholderQR<MatrixXd>(A.transpose()).householderQ();
    const MatrixXd N = Q.rightCols(n - 12);
    V.rightCols(kModes) = N * linalg::generalized_eigen(N.transpose() * K * N, N.transpose() * kron3(m) * N)
                                  .vectors.leftCols(kModes);
    return V;
  }

  NodalMatrices nodal_mass() const {
    NodalMatrices out;
    for (int a = 0; a < m.rows(); ++a)
      for (int b = a; b < m.rows(); ++b)
        if (m(a, b) != 0.0) {
          out.pairs.push_back({a, b});
          out.K.push_back(Eigen::Matrix3d::Zero());
          out.m.push_back(m(a, b));
        }
    return out;
  }
};

const Example& example() {
  static const Example instance;
  return instance;
}

// Eigenvectors may come with either sign: each is turned to ours.
VectorXd signs(const MatrixXd& ours, const MatrixXd& theirs) {
  return ours.cwiseProduct(theirs).colwise().sum().unaryExpr([](double x) { return x < 0.0 ? -1.0 : 1.0; });
}

void expect_the_own_reduction(const Reduction& r, double tolerance) {
  const Reduction& own = example().own;
  ASSERT_EQ(r.n_b, own.n_b);
  ASSERT_EQ(r.n_q, own.n_q);
  const double size = own.K_se.topLeftCorner(12, 12).diagonal().maxCoeff();
  EXPECT_LT((r.K_se.topLeftCorner(12, 12) - own.K_se.topLeftCorner(12, 12)).cwiseAbs().maxCoeff(),
            tolerance * size);
  EXPECT_LT((r.omega2 - own.omega2).cwiseQuotient(own.omega2).cwiseAbs().maxCoeff(), tolerance);
  VectorXd turn = VectorXd::Ones(own.n());
  turn.tail(own.n_q) =
      signs(own.shapes.rightCols(own.n_q).cast<double>(), r.shapes.rightCols(own.n_q).cast<double>());
  const MatrixXd M = turn.asDiagonal() * r.M_se * turn.asDiagonal();
  EXPECT_LT((M - own.M_se).norm(), tolerance * own.M_se.norm());
  EXPECT_LT((r.inertia.S_phi * turn.asDiagonal() - own.inertia.S_phi).norm(),
            tolerance * own.inertia.S_phi.norm());
  EXPECT_LT((r.inertia.S_phiphi[3] - turn.asDiagonal() * own.inertia.S_phiphi[3] * turn.asDiagonal()).norm(),
            tolerance * own.inertia.S_phiphi[3].norm());
  const MatrixXd stress = r.stress_modes * turn.asDiagonal();
  EXPECT_LT((stress - own.stress_modes).norm(), tolerance * own.stress_modes.norm());
}

FinishedModes modes_of(const MatrixXd& V) {
  const Example& e = example();
  FinishedModes modes{
      .V = V, .K = V.transpose() * e.K * V, .M = V.transpose() * kron3(e.m) * V, .stress = {}};
  modes.stress = nodal_stress_modes(e.part, V, e.all);
  return modes;
}

ReductionOptions on_all_nodes() {
  ReductionOptions options;
  options.shape_nodes = example().all;
  options.stress_nodes = example().all;
  return options;
}

Part with_mass_only() {
  Part part = example().part;
  part.matrices = example().nodal_mass();
  return part;
}

// In any mixture: the vectors are multiplied by a full matrix of random numbers.
TEST(FinishedModes, GiveTheSuperelementOfTheSpaceTheySpan) {
  const MatrixXd V = example().vectors();
  const MatrixXd mixed = V * random_matrix(V.cols(), V.cols());
  // Round-off of dense solutions with a condition of some 1e5, magnified by that of the mixture, 1e2.
  expect_the_own_reduction(reduce_finished_modes(with_mass_only(), modes_of(mixed), on_all_nodes()), 1e-6);
}

TEST(FinishedModes, NeedNotHoldTheRigidMotions) {
  // Constraint modes of one interface less its rigid motion: the rigid motions come from the nodes.
  const MatrixXd V = example().vectors();
  MatrixXd fewer(V.rows(), 6 + Example::kModes);
  fewer << V.leftCols(6), V.rightCols(Example::kModes);
  expect_the_own_reduction(reduce_finished_modes(with_mass_only(), modes_of(fewer), on_all_nodes()), 1e-6);
}

TEST(FinishedModes, ComeFromFilesWithTheirStresses) {
  const test::Folder folder;
  const Example& e = example();
  const MatrixXd V = e.vectors();
  const FinishedModes modes = modes_of(V);
  const auto put = [&](const std::string& name, const MatrixXd& A, bool market) {
    std::ofstream out(folder / name);
    out << std::setprecision(17);
    if (market) {
      out << "%%MatrixMarket matrix array real general\n" << A.rows() << ' ' << A.cols() << '\n';
      for (const double value : A.reshaped()) out << value << '\n';
    } else {
      for (Index i = 0; i < A.rows(); ++i)
        for (Index j = 0; j < A.cols(); ++j) out << A(i, j) << (j + 1 < A.cols() ? ' ' : '\n');
    }
  };
  put("modes.txt", V, false);
  put("stress.mtx", modes.stress, true);
  put("K.mtx", modes.K, true);
  put("M.txt", modes.M, false);
  {
    std::ofstream nodes(folder / "nodes.csv"), mass(folder / "mass.mtx");
    nodes << std::setprecision(17);
    mass << std::setprecision(17);
    for (mesh::Index a = 0; a < e.part.mesh.n_nodes(); ++a)
      nodes << a + 1 << ", " << e.part.mesh.points(a, 0) << ", " << e.part.mesh.points(a, 1) << ", "
            << e.part.mesh.points(a, 2) << '\n';
    const NodalMatrices m = e.nodal_mass();
    for (std::size_t k = 0; k < m.pairs.size(); ++k)
      for (int d = 1; d <= 3; ++d)
        mass << 3 * m.pairs[k][0] + d << ' ' << 3 * m.pairs[k][1] + d << ' ' << m.m[k] << '\n';
  }
  std::string text =
      "[geometry]\nfile = \"nodes.csv\"\n[mode_vectors]\nvectors = \"modes.txt\"\n"
      "stiffness = \"K.mtx\"\nreduced_mass = \"M.txt\"\nmass = \"mass.mtx\"\n"
      "stress = \"stress.mtx\"\n[recovery]\nstress = true\nprecision = \"double\"\n";
  for (int k : {0, 1}) {
    text += "[interface." + e.part.interfaces[k].name + "]\nby = \"nodes\"\ntie = \"average\"\nnodes = [";
    for (const mesh::Index node : e.part.interfaces[k].set.nodes) text += std::to_string(node + 1) + ", ";
    text += "]\n";
  }
  const auto file = folder.write("part.toml", text);
  reduce_to_file(read_part(file), folder / "part.se.h5", {.report = {}, .quiet = true});
  const superelement::Superelement se =
      superelement::read(folder / "part.se.h5", {.surface = true, .shapes = true, .stress = true});
  // A table of nodes has no faces, so that the mean is taken over nodes and not over areas: another interface
  // of the same body.  Mass and rigid motions are those of the body; the validator has compared M_se with the
  // integrals.
  EXPECT_EQ(se.n_b, 12);
  EXPECT_EQ(se.n_q, Example::kModes);
  EXPECT_NEAR(se.inertia.mass / e.own.inertia.mass, 1.0, 1e-12);
  ASSERT_TRUE(se.stress);
  EXPECT_EQ(se.stress->S.rows(), 6 * e.part.mesh.n_nodes());
  EXPECT_EQ(se.surface.vertices.rows(), e.part.mesh.n_nodes());
  // Free vibration does not care where the interfaces are.
  const VectorXd ours = linalg::generalized_eigen(se.K_se, se.M_se).values,
                 own = linalg::generalized_eigen(e.own.K_se, e.own.M_se).values;
  for (Index k = 6; k < ours.size(); ++k) EXPECT_NEAR(ours(k) / own(k), 1.0, 1e-6) << k;
}

// Modes with the interfaces held move them not at all: rigid motions are what is left, and that is said.
TEST(FinishedModes, InterfacesThatTheVectorsDoNotMoveFollowRigidMotions) {
  const MatrixXd V = example().vectors();
  const Reduction r =
      reduce_finished_modes(with_mass_only(), modes_of(V.rightCols(Example::kModes)), on_all_nodes());
  EXPECT_EQ(r.n_b, 6);
  EXPECT_THAT(r.report.notes,
              ::testing::Contains(::testing::HasSubstr("move only 6 of the 12 interface dofs")));
}

TEST(FinishedModes, WhatContradictsIsRefused) {
  const MatrixXd V = example().vectors();
  const auto refusal = [&](const FinishedModes& modes, const Part& part) -> std::string {
    try {
      reduce_finished_modes(part, modes, on_all_nodes());
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  const Part part = with_mass_only();
  FinishedModes grounded = modes_of(V);
  grounded.K.diagonal() *= 1.5;
  EXPECT_THAT(refusal(grounded, part), ::testing::HasSubstr("contradicts the vectors"));
  FinishedModes grams = modes_of(V);
  grams.M *= 1e3;
  EXPECT_THAT(refusal(grams, part), ::testing::HasSubstr("not in one unit"));
  Part rigid = part;
  rigid.interfaces[1].tie = Tie::rigid;
  EXPECT_THAT(refusal(modes_of(V), rigid), ::testing::HasSubstr("tie it as an average"));
}

}  // namespace
}  // namespace flexura::reduce
