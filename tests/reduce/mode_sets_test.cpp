// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Sets of modes beside Craig and Bampton's, what is struck out of them, and what is added.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "reduce/cms/damping.hpp"
#include "reduce/cms/errors/mode_choice.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

Part rod(Tie right = Tie::rigid) {
  return beam({0.5, 0.03, 0.05}, {8, 1, 2}, mesh::CellType::tet10, Tie::rigid, right);
}

Reduction reduced(const Part& part, ModeSet set, int n_modes) {
  ReductionOptions options;
  options.set = set;
  options.n_modes = n_modes;
  return craig_bampton(part, options);
}

MatrixXd rigid_motions(const Reduction& se) {
  MatrixXd R = MatrixXd::Zero(se.n(), 6);
  for (const ReducedInterface& interface : se.interfaces)
    for (int d = 0; d < 6; ++d) {
      R(interface.first_dof + d, d) = 1.0;
      for (int a = 0; a < 3 && d < 3; ++a)
        R(interface.first_dof + d, 3 + a) = Eigen::Vector3d::Unit(a).cross(interface.point)(d);
    }
  return R;
}

// Free modes are in Craig and Chang's basis, so its free frequencies are the full model's; attachment modes
// make statics exact as constraint modes do.  Either tie.
TEST(CraigChang, HasTheFullModelsFreeFrequenciesAndStatics) {
  for (const Tie tie : {Tie::rigid, Tie::average}) {
    const Part part = rod(tie);
    const Reduction se = reduced(part, ModeSet::craig_chang, 8);
    EXPECT_EQ(se.n_b, 12);
    EXPECT_EQ(se.n_q, 8 + 6) << "free modes and what inertia relief adds to the attachment modes";
    const VectorXd omega2 = reduced_free_modes(se);
    const linalg::EigenPairs full = full_free_modes(part, 8, omega2(6));
    for (int k = 0; k < 8; ++k)  // the residual of the free modes, 1e-9, squared or not
      EXPECT_NEAR(omega2(6 + k) / full.omega2(6 + k), 1.0, 1e-8) << k;
    const MatrixXd exact = full_static_compliance(part, "left", "right"),
                   ours = reduced_static_compliance(se, "left", "right");
    for (int d = 0; d < 6; ++d) EXPECT_NEAR(ours(6 + d, d) / exact(6 + d, d), 1.0, 1e-7) << d;
  }
}

// K_se R = 0, R^T M_se R is the body's, and the modes stand apart in K_se: the form that the runtime wants.
// 6 rigid, 5 free and 12 attachment modes are 23 shapes: no load on the interfaces alone is one of inertia,
// so none depends.
TEST(CraigChang, StandsInTheSameFormAsCraigBampton) {
  const Part part = rod();
  const Reduction chang = reduced(part, ModeSet::craig_chang, 5),
                  bampton = reduced(part, ModeSet::craig_bampton, 5);
  const MatrixXd R = rigid_motions(chang), R_bampton = rigid_motions(bampton);
  ASSERT_EQ(chang.n_q, 11);
  EXPECT_LT((chang.K_se * R).norm(), 1e-9 * chang.K_se.norm() * R.norm());
  EXPECT_EQ(chang.K_se.topRightCorner(12, 11).norm(), 0.0);
  const MatrixXd ours = R.transpose() * chang.M_se * R,
                 theirs = R_bampton.transpose() * bampton.M_se * R_bampton;
  EXPECT_LT((ours - theirs).norm(), 1e-8 * theirs.norm());
  EXPECT_TRUE(chang.report.notes.empty());
}

// Static condensation: frequencies from above, statics exact.
TEST(Guyan, IsExactInStaticsAndBoundsFrequenciesFromAbove) {
  const Part part = rod();
  const Reduction se = reduced(part, ModeSet::guyan, 0);
  EXPECT_EQ(se.n_q, 0);
  const MatrixXd exact = full_static_compliance(part, "left", "right"),
                 ours = reduced_static_compliance(se, "left", "right");
  for (int d = 0; d < 6; ++d) EXPECT_NEAR(ours(6 + d, d) / exact(6 + d, d), 1.0, 1e-8);
  const VectorXd omega2 = reduced_free_modes(se);
  const linalg::EigenPairs full = full_free_modes(part, 3, omega2(6));
  for (int k = 0; k < 3; ++k) EXPECT_GT(omega2(6 + k), full.omega2(6 + k));
}

// At its frequency the interface's dynamic stiffness is the full model's: the boundary motion under a unit
// load, from the superelement, against many modes.
TEST(ResponseModes, MakeTheDynamicStiffnessExactAtTheirFrequency) {
  const Part part = rod();
  const Reduction reference = reduced(part, ModeSet::craig_bampton, 120);
  ReductionOptions options;
  options.n_modes = 4;
  const Reduction plain = craig_bampton(part, options);
  const double omega = 0.5 * std::sqrt(plain.omega2(0));
  options.response_omegas = {omega};
  const Reduction se = craig_bampton(part, options);
  EXPECT_GT(se.report.n_extra, 6);
  const auto stiffness = [&](const Reduction& r) -> MatrixXd {
    const MatrixXd Z = r.K_se - omega * omega * r.M_se;
    const MatrixXd Z_qb = Z.bottomLeftCorner(r.n_q, 12);
    return Z.topLeftCorner(12, 12) - Z_qb.transpose() * Z.bottomRightCorner(r.n_q, r.n_q).ldlt().solve(Z_qb);
  };
  const MatrixXd exact = stiffness(reference);
  const double error = (stiffness(se) - exact).norm(), without = (stiffness(plain) - exact).norm();
  // 120 modes still leave (omega / omega_120)^4, below 1e-6, of the inertia; four leave more by powers of
  // ten.
  EXPECT_LT(error, 2e-2 * without);
}

TEST(ResponseModes, BeyondTheModesAreRefused) {
  ReductionOptions options;
  options.n_modes = 4;
  const Reduction plain = craig_bampton(rod(), options);
  options.response_omegas = {std::sqrt(plain.omega2_dropped)};
  try {
    craig_bampton(rod(), options);
    FAIL();
  } catch (const std::invalid_argument& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("keep more modes or choose a lower frequency"));
  }
}

// Its kept round-off differed by twice itself from the full model, and the part was refused.
TEST(ResponseModes, OfAllModesAreNone) {
  ReductionOptions options;
  options.n_modes = 100000;
  const Reduction plain = craig_bampton(rod(), options);
  options.response_omegas = {0.0, 0.5 * std::sqrt(plain.omega2(0))};
  const Reduction se = craig_bampton(rod(), options);
  EXPECT_EQ(se.report.n_extra, 0);
  EXPECT_EQ(se.n_q, plain.n_q);
}

TEST(LoadCases, TorqueByDisplacementIsThatOfTheForcesWhereTheyAct) {
  const Part part = rod();
  ReductionOptions options;
  options.n_modes = 3;
  LoadField push{.name = "push", .forces = {}, .acceleration = {}};
  push.forces = Eigen::MatrixX3d::Zero(part.mesh.n_nodes(), 3);
  options.shape_nodes = {5, 17, 23};
  for (std::size_t i = 0; i < options.shape_nodes.size(); ++i)
    push.forces.row(options.shape_nodes[i]) << 3.0 + static_cast<double>(i), -1.0,
        2.0 * static_cast<double>(i);
  options.loads = {push};
  const Reduction se = craig_bampton(part, options);
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(3, se.shapes.cols());
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index k = 0; k < se.shapes.cols(); ++k)
      expected.col(k) +=
          Eigen::Vector3d(se.shapes.col(k).segment<3>(3 * i).cast<double>())
              .cross(push.forces.row(options.shape_nodes[static_cast<std::size_t>(i)]).transpose());
  // Shapes are given in single precision.
  EXPECT_LT((se.loads[0].moment - expected).norm(), 1e-6 * expected.norm());
  EXPECT_GT(expected.norm(), 0.0);
}

// Gravity as a load case is M_se times unit acceleration, and its shape makes the sagging middle exact.
TEST(LoadCases, GravityIsTheMassMatrixTimesRigidMotion) {
  const Part part = rod();
  ReductionOptions options;
  options.n_modes = 3;
  LoadField gravity{.name = "gravity", .forces = {}, .acceleration = {}};
  gravity.acceleration = Eigen::RowVector3d(0, 0, -9.81).replicate(part.mesh.n_nodes(), 1);
  options.loads = {gravity};
  const Reduction se = craig_bampton(part, options);
  ASSERT_EQ(se.loads.size(), 1u);
  const VectorXd expected = se.M_se * rigid_motions(se).col(2) * -9.81;
  EXPECT_LT((se.loads[0].p_se - expected).norm(), 1e-9 * expected.norm());
  // Its torque by displacement: the mass that moves, times the acceleration.
  for (int k = 0; k < se.n_b + se.n_q; ++k) {
    const Eigen::Vector3d moved = se.inertia.S_phi.col(k);
    EXPECT_LT((se.loads[0].moment.col(k) - moved.cross(Eigen::Vector3d(0, 0, -9.81))).norm(),
              1e-9 * 9.81 * se.inertia.S_phi.norm())
        << k;
  }
  options.loads[0].keep_shape = true;
  const Reduction exact = craig_bampton(part, options);
  EXPECT_EQ(exact.n_q, 4);
  // Work of the load with both interfaces held, p^T K_ii^-1 p: only with its own shape is it all there.
  const auto work = [](const Reduction& r) {
    const VectorXd p = r.loads[0].p_se.tail(r.n_q);
    return p.dot(p.cwiseQuotient(r.omega2));
  };
  const double all = work(exact);
  options.loads[0].keep_shape = false;
  options.n_modes = 150;
  const double nearly_all = work(craig_bampton(part, options));
  EXPECT_GT(all, nearly_all);
  EXPECT_NEAR(all / nearly_all, 1.0, 1e-3);
}

TEST(StruckModes, LeaveTheOtherFrequenciesAsTheyAre) {
  const Part part = rod();
  Reduction se = reduced(part, ModeSet::craig_bampton, 6);
  const VectorXd before = reduced_free_modes(se);
  const StruckModes struck = strike_modes(se, {18, 9});
  EXPECT_EQ(se.n_q, 4);
  const VectorXd after = reduced_free_modes(se);
  std::vector<double> expected(before.begin(), before.end());
  expected.erase(expected.begin() + 17);
  expected.erase(expected.begin() + 8);
  for (std::size_t k = 6; k < expected.size(); ++k)
    EXPECT_NEAR(after(static_cast<Eigen::Index>(k)) / expected[k], 1.0, 1e-8) << k;
  EXPECT_NEAR(struck.frequencies[1], std::sqrt(before(8)) / (2.0 * std::numbers::pi),
              1e-6 * struck.frequencies[1]);
  // What goes takes part of the constraint modes along: the interface gets stiffer, never softer.
  EXPECT_GT(struck.interface_stiffer, 1e-6);
  const MatrixXd R = rigid_motions(se);
  EXPECT_LT((se.K_se * R).norm(), 1e-9 * se.K_se.norm() * R.norm());
}

TEST(StruckModes, RigidAndMissingModesAreRefused) {
  Reduction se = reduced(rod(), ModeSet::craig_bampton, 2);
  const auto refusal = [&](std::vector<int> numbers) -> std::string {
    try {
      strike_modes(se, numbers);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal({3}), HasSubstr("mode 3 is a rigid one"));
  EXPECT_THAT(refusal({15}), HasSubstr("there is no mode 15 to strike out; the superelement has 14"));
  EXPECT_THAT(refusal({7, 8, 9}), HasSubstr("interface dofs independently; keep more"));
}

TEST(ModeChoice, AnAccuracyOutOfReachIsRefusedWithWhatWasReached) {
  ReductionOptions options;
  options.accuracy = 1e-14;
  options.omega_max = 2.0 * std::sqrt(reduced(rod(), ModeSet::craig_bampton, 1).omega2(0));
  try {
    craig_bampton(rod(), options);
    FAIL();
  } catch (const std::invalid_argument& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("is out of reach"));
    EXPECT_THAT(refused.what(), HasSubstr("the estimate is"));
  }
}

TEST(ModeChoice, EffectiveMassIsReachedWithAsFewModesAsItTakes) {
  const Part part = rod();
  ReductionOptions options;
  options.effective_mass = 0.8;
  const Reduction se = craig_bampton(part, options);
  // The interior's mass and what of it the modes hold, by another road: p = M_qb R_b.
  const MatrixXd P = se.M_se.bottomLeftCorner(se.n_q, 12) * rigid_motions(se).topRows(12);
  const double all = se.inertia.mass;
  for (int a = 0; a < 3; ++a) {
    const double held = P.col(a).squaredNorm();
    EXPECT_LT(held, all);
    EXPECT_GT(held, 0.8 * 0.8 * all) << "the interfaces carry less than a fifth of the mass";
  }
}

// A damping table gives each free mode its ratio, and rigid motion none.
TEST(Damping, TableGivesEveryModeItsRatio) {
  Reduction se = reduced(rod(), ModeSet::craig_bampton, 5);
  const linalg::DenseEigen modes = linalg::generalized_eigen(se.K_se, se.M_se);
  const auto omega = [&](int k) { return std::sqrt(modes.values(k)); };
  DampingRule rule;
  rule.omega = {omega(6), omega(10)};
  rule.ratio = {0.01, 0.03};
  rule.critical_above = omega(14) * 0.999;
  add_damping(se, rule);
  for (int k = 6; k < se.n(); ++k) {
    const VectorXd y = modes.vectors.col(k);
    const double ratio = y.dot(se.D_se * y) / (2.0 * omega(k));
    const double expected = k >= 14   ? 1.0
                            : k >= 10 ? 0.03
                                      : 0.01 + 0.02 * (omega(k) - omega(6)) / (omega(10) - omega(6));
    EXPECT_NEAR(ratio, expected, 1e-9) << k;
  }
  const MatrixXd R = rigid_motions(se);
  EXPECT_LT((se.D_se * R).norm(), 1e-9 * se.D_se.norm() * R.norm());
}

// A hinge within the part: round-off stands for the stiffness of its mode, below zero as well.
TEST(Damping, HingesWithinThePartAreNotDamped) {
  Reduction se = reduced(rod(), ModeSet::craig_bampton, 3);
  const linalg::DenseEigen modes = linalg::generalized_eigen(se.K_se, se.M_se);
  const VectorXd hinge = modes.vectors.col(6), next = modes.vectors.col(7), M_y = se.M_se * hinge;
  const double round_off = 1e-9 * modes.values(6);
  se.K_se -= modes.values(6) * M_y * M_y.transpose() + round_off * se.M_se;  // of rigid motion, too
  DampingRule rule;
  rule.omega = {0.0};
  rule.ratio = {0.02};
  add_damping(se, rule);
  const double rate = next.dot(se.D_se * next);
  EXPECT_NEAR(rate / (2.0 * 0.02 * std::sqrt(modes.values(7))), 1.0, 1e-9);
  EXPECT_NEAR(hinge.dot(se.D_se * hinge) / rate, 0.0, 1e-9);
}

// Of any superelement with hinges: alpha M without rigid motion's share, however the eigensolver mixes zero eigenvalues.
TEST(Damping, RigidMotionIsTakenOutBesideHinges) {
  mbs::chance::Chance chance(7);
  for (int k = 0; k < 200; ++k) {
    Reduction se;
    se.n_b = 12, se.n_q = 2 + chance.below(6);
    const Eigen::Vector3d away = std::pow(10.0, chance.between(-1.0, 1.0)) * chance.direction();  // of Bo
    for (const int i : {0, 1})
      se.interfaces.push_back({.name = "",
                               .point = away + chance.vector(1.0),
                               .directions = {0, 1, 2, 3, 4, 5},
                               .first_dof = 6 * i});
    const auto random = [&](Eigen::Index rows, Eigen::Index columns) {
      MatrixXd A(rows, columns);
      for (double& a : A.reshaped()) a = chance.between(-1.0, 1.0);
      return A;
    };
    const MatrixXd R = rigid_motions(se), A = random(se.n(), se.n());
    se.M_se = A * A.transpose() + MatrixXd::Identity(se.n(), se.n());
    const MatrixXd P = MatrixXd::Identity(se.n(), se.n()) -
                       R * (R.transpose() * se.M_se * R).ldlt().solve(R.transpose() * se.M_se);
    const int n_hinges = 1 + chance.below(3);
    const MatrixXd B = random(se.n() - 6 - n_hinges, se.n()) * P;
    se.K_se = 1e6 * B.transpose() * B;
    DampingRule rule;
    rule.alpha = chance.between(0.1, 10.0);
    rule.beta = chance.between(0.0, 1e-4);
    const MatrixXd right = rule.alpha * P.transpose() * se.M_se * P + rule.beta * se.K_se;
    add_damping(se, rule);
    // P loses the squared distance of Bo over the size, 1e2, and the condition of M, 1e3, of 1e-16.
    EXPECT_LT((se.D_se - right).norm(), 1e-9 * right.norm()) << k;
  }
}

TEST(Damping, RayleighIsTheSumOfMassAndStiffnessOnElasticModes) {
  Reduction se = reduced(rod(), ModeSet::craig_bampton, 3);
  DampingRule rule;
  rule.alpha = 12.0;
  rule.beta = 1e-6;
  add_damping(se, rule);
  const linalg::DenseEigen modes = linalg::generalized_eigen(se.K_se, se.M_se);
  for (int k = 6; k < se.n(); ++k)
    EXPECT_NEAR(modes.vectors.col(k).dot(se.D_se * modes.vectors.col(k)) / (12.0 + 1e-6 * modes.values(k)),
                1.0, 1e-9);
}

}  // namespace
}  // namespace flexura::reduce
