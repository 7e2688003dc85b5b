// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Beams through Craig-Bampton reduction.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <numbers>

#include "reduce/beams/beam_reduction.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "tests/beam/common.hpp"
#include "tests/beam/exact/timoshenko.hpp"
#include "tests/beam/models.hpp"
#include "tests/beam/reduction_session.hpp"
#include "tests/sanitized.hpp"

namespace flexura::beam {
namespace {

using std::numbers::pi;
using testing::divided;
using testing::entry;
using ::testing::HasSubstr;
using testing::kSteel;
using testing::straight;

class BeamReduction : public testing::WithSession {};

reduce::ReductionOptions modes(int n) {
  reduce::ReductionOptions options;
  options.n_modes = n;
  return options;
}

TEST_F(BeamReduction, ShaftHasTheFrequenciesOfItsMesh) {
  const Model model = straight(entry("shaft", Circle{0.25}, kSteel), 2.0);
  const BeamMesh mesh(model, divided(60));
  const auto beams = reduce::reduce_beams(mesh, {{"left", 0}, {"right", 1}}, modes(200));
  const Eigen::VectorXd omega2 = reduce::reduced_free_modes(beams.reduction);
  // Six rigid modes at round-off of the highest kept eigenvalue.
  for (int k = 0; k < 6; ++k) EXPECT_LT(std::abs(omega2(k)), 1e-9 * omega2(6));
  // The shaft of the source, l = 2 m, Timoshenko with rotary inertia, 60 elements: 276.65 and 715.32 Hz,
  // twice each.  200 of 354 fixed-interface modes leave less than half a unit of the last digit.
  EXPECT_NEAR(std::sqrt(omega2(6)) / (2 * pi), 276.65, 0.006);
  EXPECT_NEAR(std::sqrt(omega2(7)) / (2 * pi), 276.65, 0.006);
  EXPECT_NEAR(std::sqrt(omega2(8)) / (2 * pi), 715.32, 0.01);
  EXPECT_LT(beams.reduction.report.rigid_strain, 1e-11);
  EXPECT_LT(beams.reduction.report.constraint_residual, 1e-12);
}

TEST_F(BeamReduction, InertiaIntegralsAreThoseOfTheRigidBody) {
  Model model = straight(entry("r", Rectangle{0.1, 0.3}, kSteel), 2.0);
  model.nodes[0].p_BoN_B = {0.5, -0.2, 0.1};
  model.nodes[1].p_BoN_B = {1.7, 0.9, 0.8};
  const reduce::Structure structure(BeamMesh(model, divided(10)));
  const auto beams = reduce::reduce_beams(structure, {{"a", 0}, {"b", 1}}, modes(6));
  const reduce::Reduction& r = beams.reduction;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(r.n(), 6);
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector3d& p = model.nodes[k].p_BoN_B;
    R.block<6, 6>(6 * k, 0).setIdentity();
    R.block<3, 3>(6 * k, 3) << 0, p.z(), -p.y(), -p.z(), 0, p.x(), p.y(), -p.x(), 0;
  }
  const Eigen::MatrixXd rigid = R.transpose() * r.M_se * R;
  const double mass = kSteel.rho * 0.03 * (model.nodes[1].p_BoN_B - model.nodes[0].p_BoN_B).norm();
  EXPECT_NEAR(r.inertia.mass, mass, 1e-12 * mass);
  EXPECT_NEAR(rigid(0, 0), mass, 1e-9 * mass);
  const Eigen::Matrix3d J = r.inertia.S_xx.trace() * Eigen::Matrix3d::Identity() - r.inertia.S_xx;
  EXPECT_LT((rigid.bottomRightCorner<3, 3>() - J).norm(), 1e-9 * J.norm());
  EXPECT_LT((r.inertia.S_phi * R.leftCols<3>() - mass * Eigen::Matrix3d::Identity()).norm(), 1e-9 * mass);
  // Vertices of the extruded surface follow a rigid rotation about Bo's z (float: 6e-8 of some metres).
  const Eigen::VectorXf u = r.shapes * R.col(5).cast<float>();
  for (int v = 0; v < structure.picture().vertices.rows(); v += 7) {
    EXPECT_NEAR(u(3 * v), -structure.picture().vertices(v, 1), 2e-6);
    EXPECT_NEAR(u(3 * v + 1), structure.picture().vertices(v, 0), 2e-6);
  }
}

TEST_F(BeamReduction, RefusesWhatIsNotHeld) {
  const BeamMesh mesh(straight(entry("r", Rectangle{0.1, 0.3}, kSteel), 2.0), divided(4));
  const auto text = [&](const std::vector<reduce::BeamInterface>& interfaces) {
    try {
      reduce::reduce_beams(mesh, interfaces, modes(2));
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  EXPECT_THAT(text({}), HasSubstr("no interface"));
  EXPECT_THAT(text({{"a", 0, {0, 1, 2}}, {"b", 1, {0, 1, 2}}}),
              HasSubstr("the interfaces do not hold the beam part"));
  EXPECT_THAT(text({{"a", 0}, {"b", 0}}), HasSubstr("node \"A\" is an interface already"));
  EXPECT_THAT(text({{"a", 5}}), HasSubstr("no node number 5"));
}

// A building frame: joints 4 m apart, tubular members of seven elements each.
void reduce_frame(const std::array<int, 3>& joints, int least_dofs) {
  Model model;
  model.sections = {entry("tube", HollowCircle{0.3, 0.28}, kSteel)};
  const auto number = [&](int i, int j, int k) { return (k * joints[1] + j) * joints[0] + i; };
  for (int k = 0; k < joints[2]; ++k)
    for (int j = 0; j < joints[1]; ++j)
      for (int i = 0; i < joints[0]; ++i)
        model.nodes.push_back({"n" + std::to_string(number(i, j, k)), {4.0 * i, 4.0 * j, 4.0 * k}});
  const auto add = [&](int a, int b) {
    Member member;
    member.name = "m" + std::to_string(model.members.size());
    member.end[0].node = a;
    member.end[1].node = b;
    member.section = 0;
    model.members.push_back(member);
  };
  for (int k = 0; k < joints[2]; ++k)
    for (int j = 0; j < joints[1]; ++j)
      for (int i = 0; i < joints[0]; ++i) {
        if (i + 1 < joints[0]) add(number(i, j, k), number(i + 1, j, k));
        if (j + 1 < joints[1]) add(number(i, j, k), number(i, j + 1, k));
        if (k + 1 < joints[2]) add(number(i, j, k), number(i, j, k + 1));
      }
  const BeamMesh mesh(model, divided(7));
  ASSERT_GE(mesh.n_dofs(), least_dofs);
  const std::vector<reduce::BeamInterface> interfaces = {
      {"foot", number(0, 0, 0)},
      {"foot 2", number(joints[0] - 1, joints[1] - 1, 0)},
      {"foot 3", number(0, joints[1] - 1, 0)},
      {"top", number(joints[0] / 2 - 1, joints[1] / 2, joints[2] - 1)}};
  const auto start = std::chrono::steady_clock::now();
  const auto beams = reduce::reduce_beams(mesh, interfaces, modes(10));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::printf("%d dofs: %.1f s, peak %.0f MB (assembly %.1f, factor %.1f, modes %.1f, projection %.1f)\n",
              mesh.n_dofs(), seconds, beams.reduction.report.peak_memory_bytes / 1e6,
              beams.reduction.report.seconds_assembly, beams.reduction.report.factor.seconds_numeric,
              beams.reduction.report.seconds_normal_modes, beams.reduction.report.seconds_projection);
#ifndef FLEXURA_ADDRESS_SANITIZER  // which keeps what is freed
  // 24 kB for each dof; the process itself has 100 MB.
  EXPECT_LT(beams.reduction.report.peak_memory_bytes, 1e8 + 24e3 * mesh.n_dofs());
#endif
  EXPECT_LT(beams.reduction.report.mode_residual.maxCoeff(), 1e-8);
}

TEST_F(BeamReduction, FrameReducesInProportionateMemory) {
  reduce_frame({8, 7, 6}, 30000);
}
TEST_F(BeamReduction, DISABLED_LongFrameOfAHundredThousandDofsReducesInProportionateMemory) {
  reduce_frame({12, 11, 8}, 100000);
}

}  // namespace
}  // namespace flexura::beam
