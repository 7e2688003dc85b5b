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

}  // namespace
}  // namespace flexura::properties
