// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every superelement, all of whose modes are kept: a mechanism's eigenvalues are those of the quadratic problem of its K_se,
// D_se, M_se with the joint's conditions, whatever the joint, the frame and the boundary condition.
#include "tests/properties/quadratic_problem.hpp"

namespace flexura::properties {
namespace {

// The six rigid motions of the interfaces' dofs.
MatrixXd rigid(const Superelement& se) {
  MatrixXd R = MatrixXd::Zero(se.n(), 6);
  for (const superelement::Interface& i : se.interfaces)
    for (std::size_t k = 0; k < i.directions.size(); ++k) {
      const int row = i.first_dof + static_cast<int>(k), d = static_cast<int>(i.directions[k]);
      R(row, d) = 1.0;
      if (d < 3)
        for (int a = 0; a < 3; ++a) R(row, 3 + a) = Vector3d::Unit(a).cross(i.p_BoN_B)(d);
    }
  return R;
}

// Dampers between motions of the body that strain it.
MatrixXd random_damping(Chance& chance, const Superelement& se) {
  const MatrixXd R = rigid(se), MR = se.M_se * R;
  const MatrixXd P =
      MatrixXd::Identity(se.n(), se.n()) - R * (R.transpose() * MR).ldlt().solve(MR.transpose());
  const VectorXd size = se.M_se.diagonal().cwiseSqrt();
  const int n_dampers = 1 + chance.below(4);
  MatrixXd C(n_dampers, se.n());
  for (int i = 0; i < n_dampers; ++i) {
    const double strength = std::pow(10.0, chance.between(-1.0, 1.0));  // [sqrt(1/s)]
    for (int j = 0; j < se.n(); ++j) C(i, j) = strength * chance.between(-1.0, 1.0) * size(j);
  }
  C = (C * P).eval();
  return C.transpose() * C;
}

const char* const kFrames[] = {"",
                               "frame = \"mean_axis\"\n",
                               "frame = \"joint_fixed\"\n",
                               "boundary = \"joint\"\n",
                               "frame = \"joint_fixed\"\nboundary = \"free\"\n",
                               "frame = \"joints\"\n"};

template <class Judge>
void for_random_parts(int cases, const Judge& judge) {
  const test::Folder folder;
  int judged = 0;
  for (int seed = 1; judged < cases && seed < 4 * cases; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    const Kind kind = chance.one_of(kKinds);
    RandomPart part = random_part(chance, kind == Kind::flexdata ? Kind::beams : kind, folder,
                                  {.all_directions = true, .fewest_modes = 1});
    if (!part.refused.empty()) continue;
    ++judged;
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, part.text));
    judge(chance, folder, std::move(part.superelement));
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(judged, cases);
}

TEST(Damping, OfAMatrixIsThatOfTheQuadraticProblem) {
  for_random_parts(200, [](Chance& chance, const test::Folder& folder, Superelement se) {
    se.D_se = random_damping(chance, se);
    const JointCase& joint = chance.one_of(kJoints);
    std::string frame = chance.one_of(kFrames);
    if (joint.locked.empty() && frame.find("\"joints\"") != std::string::npos) frame.clear();
    Case c = make_case(chance, folder, std::move(se), frame, joint);
    SCOPED_TRACE(c.text);
    expect_same(c.found, c.se, [&](const Superelement& se) { return right(se, se.D_se, c.G); });
  });
}

// A ratio belongs to the modes that the joint leaves.
TEST(Damping, OfARatioIsThatOfTheModesThatTheJointLeaves) {
  for_random_parts(200, [](Chance& chance, const test::Folder& folder, Superelement se) {
    const JointCase& joint = chance.one_of(kJoints);
    const double ratio = chance.between(0.001, 0.1);
    const char* const kHeld[] = {"frame = \"joint_fixed\"\n", "boundary = \"joint\"\n"};
    Case c = make_case(chance, folder, std::move(se),
                       chance.one_of(kHeld) + fmt::format("damping = {:.17g}\n", ratio), joint);
    SCOPED_TRACE(c.text);
    expect_same(c.found, c.se, [&](const Superelement& se) {
      const Values undamped = right(se, MatrixXd::Zero(se.n(), se.n()), c.G);
      double largest = 0.0;
      for (const auto& s : undamped) largest = std::max(largest, std::abs(s));
      Values damped;
      for (const auto& s : undamped)
        // What does not vibrate is rigid motion.
        if (std::abs(s) >= 1e-6 * largest)
          damped.push_back(std::abs(s) * std::complex<double>(-ratio, std::sqrt(1.0 - ratio * ratio)));
      return damped;
    });
  });
}

// A body of few modes on a joint of any type: Ritz's method with the rigid motions and the lowest modes of the body as that joint
// holds it, or free where what it locks moves in the body.
TEST(Damping, FewModesAreThoseOfTheBodyAsItsJointHoldsIt) {
  struct Kind {
    JointCase joint;
    bool holds_from, holds_to;  // as the first or the second of its bodies
  };
  // What a universal or homokinetic joint locks turns with one shaft; a line or plane moves past the point that is led on it.
  const Kind kinds[] = {{{"fixed", {0, 1, 2, 3, 4, 5}}, true, true},
                        {{"revolute", {0, 1, 2, 3, 4}}, true, true},
                        {{"prismatic", {0, 1, 3, 4, 5}}, true, true},
                        {{"cylindrical", {0, 1, 3, 4}}, true, true},
                        {{"spherical", {0, 1, 2}}, true, true},
                        {{"planar", {2, 3, 4}}, true, true},
                        {{"orientation", {3, 4, 5}}, true, true},
                        {{"parallel", {3, 4}}, true, true},
                        {{"six_dof", {}}, true, true},
                        {{"universal", {0, 1, 2, 5}}, false, false},
                        {{"constant_velocity", {0, 1, 2, 5}}, false, false},
                        {{"point_on_line", {0, 1}}, false, false},
                        {{"point_on_plane", {2}}, false, false}};
  for_random_parts(220, [&](Chance& chance, const test::Folder& folder, Superelement se) {
    Kind kind = chance.one_of(kinds);
    if (chance.flip(0.3))
      kind = {
          {"screw", {0, 1, 3, 4}, chance.either_sign(1.0, 1.0) * std::pow(10.0, chance.between(-3.0, 1.0))},
          true,
          true};
    const double ratio = chance.between(0.001, 0.1);
    const bool to_ground = chance.flip(0.5);
    const int modes = 1 + chance.below(std::max(1, se.n() - 7));
    const char* const frame = chance.flip(0.5) ? "" : "frame = \"joint_fixed\"\n";
    const Case c = make_case(chance, folder, std::move(se),
                             fmt::format("{}modes = {}\ndamping = {:.17g}\n", frame, modes, ratio),
                             kind.joint, to_ground);
    SCOPED_TRACE(c.text);
    const bool holds = to_ground ? kind.holds_from : kind.holds_to;
    expect_same(c.found, c.se, [&](const Superelement& se) {
      const MatrixXd R = rigid(se), boundary = holds ? c.G : MatrixXd(0, se.n());
      const MatrixXd N =
          boundary.rows() > 0 ? MatrixXd(boundary.fullPivLu().kernel()) : MatrixXd::Identity(se.n(), se.n());
      const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> held(N.transpose() * se.K_se * N,
                                                                    N.transpose() * se.M_se * N);
      // The rigid motions that the boundary leaves come first.
      const Index n_rigid = boundary.rows() > 0 ? 6 - Eigen::FullPivLU<MatrixXd>(boundary * R).rank() : 6;
      const Index n = std::min<Index>(modes, N.cols() - n_rigid);
      MatrixXd V(se.n(), 6 + n), D = MatrixXd::Zero(6 + n, 6 + n);
      V << R, N * held.eigenvectors().middleCols(n_rigid, n);
      for (Index k = 0; k < n; ++k)
        D(6 + k, 6 + k) = 2.0 * ratio * std::sqrt(held.eigenvalues()(n_rigid + k));
      MatrixXd K = V.transpose() * se.K_se * V;
      K.topRows(6).setZero();
      K.leftCols(6).setZero();
      return eigenvalues(K, D, V.transpose() * se.M_se * V, c.G * V);
    });
  });
}

}  // namespace
}  // namespace flexura::properties
