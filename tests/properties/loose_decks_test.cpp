// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Decks of which something is loose: trusses in a plane, pieces.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "reduce/library/reduce.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/properties/world_decks.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using mbs::chance::Chance;
using mbs::test::refusal_of;
using ::testing::Contains;
using ::testing::HasSubstr;
using LooseDecks = WorldDecks;

// Rods in a plane, each node held by two of those before it: nothing holds them across the plane, which a program that
// knows AUTOSPC does at the ground.  In the plane the stiffness at three nodes is that of the rods.
TEST_F(LooseDecks, PlaneTrussesInSpace) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(seed);
    const int n = 4 + chance.below(5);
    const double E = 2e11;
    std::vector<Vector3d> x = {{0, 0, 0}, {1, 0, 0}};
    std::vector<std::array<int, 2>> rods = {{0, 1}};
    for (int k = 2; k < n; ++k) {
      x.emplace_back(0.5 * k + chance.between(-0.2, 0.2), k % 2 == 0 ? 1.0 : 0.0, 0.0);
      rods.push_back({k - 2, k}), rods.push_back({k - 1, k});
    }
    const Matrix3d R = chance.rotation();
    std::string deck = "BEGIN BULK\nMAT1,1,2.+11,,.3,7800.\n";
    for (int k = 0; k < n; ++k) {
      const Vector3d at = R * x[static_cast<std::size_t>(k)];
      deck += fmt::format("GRID,{},,{:.16e},{:.16e},{:.16e}\n", k + 1, at.x(), at.y(), at.z());
    }
    MatrixXd K = MatrixXd::Zero(3 * n, 3 * n);
    for (std::size_t r = 0; r < rods.size(); ++r) {
      const double A = chance.between(1e-4, 1e-3);
      const auto [a, b] = rods[r];
      deck += fmt::format("CONROD,{},{},{},1,{:.16e}\n", r + 1, a + 1, b + 1, A);
      const Vector3d d = R * (x[static_cast<std::size_t>(b)] - x[static_cast<std::size_t>(a)]),
                     e = d.normalized();
      const Matrix3d k = E * A / d.norm() * e * e.transpose();
      K.block<3, 3>(3 * a, 3 * a) += k, K.block<3, 3>(3 * b, 3 * b) += k;
      K.block<3, 3>(3 * a, 3 * b) -= k, K.block<3, 3>(3 * b, 3 * a) -= k;
    }
    // Kept: the first two nodes and the last above; the others by their equilibrium in the plane alone.
    const std::vector<int> kept = {0, 1, (n - 1) / 2 * 2};
    MatrixXd T = MatrixXd::Zero(3 * n, 9 + 2 * (n - 3));
    for (int k = 0; k < 3; ++k) T.block<3, 3>(3 * kept[static_cast<std::size_t>(k)], 3 * k).setIdentity();
    for (int k = 2, column = 9; k < n; ++k) {
      if (k == kept[2]) continue;
      T.block<3, 2>(3 * k, column) = R.leftCols<2>();
      column += 2;
    }
    const MatrixXd S = T.transpose() * K * T;
    MatrixXd wanted = S.topLeftCorner(9, 9);
    if (n > 3) {
      const Eigen::Index m = S.rows() - 9;
      wanted -= S.topRightCorner(9, m) * S.bottomRightCorner(m, m).ldlt().solve(S.bottomLeftCorner(m, 9));
    }
    PartInput input = part(file(deck + "ENDDATA\n", "truss.bdf"));
    for (const int k : kept) input.interfaces.push_back(interface_at(k + 1));
    input.modes.count = 1;
    const Reduced reduced = reduce(input);
    const MatrixXd K_se = reduced.superelement.K_se.topLeftCorner(9, 9);
    EXPECT_LE((K_se - wanted).norm(),
              1e-9 * wanted.norm());  // round-off times the condition of slender triangles
    if (n > 3) EXPECT_THAT(reduced.warnings, Contains(HasSubstr("AUTOSPC")));
  }
}

// Two bricks that nothing joins: both bodies in one superelement, or the larger alone, or refused.
TEST_F(LooseDecks, PiecesThatNothingJoins) {
  std::string deck = kBrick;
  deck += "*NODE\n";
  for (int k = 0; k < 8; ++k)
    deck += fmt::format("{},{},{},{}\n", 11 + k, (k % 4 == 1 || k % 4 == 2) ? 6.0 : 4.0,
                        k % 4 > 1 ? 1.0 : 0.0, k / 4);
  deck +=
      "*NODE\n21,7,0,0\n22,7,1,0\n23,7,1,1\n24,7,0,1\n"
      "*ELEMENT,TYPE=C3D8,ELSET=E\n2,11,12,13,14,15,16,17,18\n3,12,21,22,13,16,24,23,17\n"
      "*MATERIAL,NAME=M\n*ELASTIC\n2e11,0.3\n*DENSITY\n7800\n*SOLID SECTION,ELSET=E,MATERIAL=M\n";
  PartInput input = part(file(deck, "two.inp"));
  input.modes.count = 2;
  const Reduced both = reduce(input);
  EXPECT_NEAR(both.superelement.inertia.mass, 4 * 7800.0, 1e-8);
  EXPECT_THAT(both.warnings, Contains(HasSubstr("falls into 2 pieces that nothing joins, of 8 to 12 nodes")));
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(both.superelement.K_se).eigenvalues();
  EXPECT_LT(std::abs(values(11)), 1e-6 * values(values.size() - 1));  // twelve rigid motions
  EXPECT_GT(values(12), 1e-6 * values(values.size() - 1));
  input.keep_largest = true;
  EXPECT_NEAR(reduce(input).superelement.inertia.mass, 3 * 7800.0, 1e-8);
  input.keep_largest = false, input.strict = true;
  EXPECT_THAT(refusal_of([&] { reduce(input); }), HasSubstr("falls into 2 pieces that nothing joins"));
}

}  // namespace
}  // namespace flexura::reduce
