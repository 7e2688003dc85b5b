// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

/// Flexible bodies in free and in large motion.
namespace flexura::mbs {
namespace {

using Eigen::VectorXd;

struct FrameMotion {
  Pose X_WB;
  Vector3d w_W, v_W;
};

FrameMotion motion_of(const Mechanism& m, int body, const State& s) {
  FrameMotion out;
  std::vector<Pose> poses;
  const auto scratch = m.make_scratch();
  m.body_poses(s, *scratch, poses);
  out.X_WB = poses[body];
  const auto infos = m.quantities();
  std::vector<int> which;
  for (const char* name : {".angular_velocity_x", ".angular_velocity_y", ".angular_velocity_z", ".velocity_x",
                           ".velocity_y", ".velocity_z"})
    for (std::size_t i = 0; i < infos.size(); ++i)
      if (infos[i].name == m.description().bodies[body].name + name) which.push_back(static_cast<int>(i));
  VectorXd values(6);
  m.evaluate(which, s, VectorXd::Zero(m.sizes().n_v), *scratch, values);
  out.w_W = values.head<3>();
  out.v_W = values.tail<3>();
  return out;
}

struct Momenta {
  Vector3d linear, angular;  // about W's origin
};

Momenta momenta(const Mechanism& m, int body, const State& s) {
  const FlexibleBody& flexible = *m.description().bodies[body].flexible;
  const FrameMotion motion = motion_of(m, body, s);
  const Matrix3d& R = motion.X_WB.R;
  const Vector3d w = R.transpose() * motion.w_W, v = R.transpose() * motion.v_W;
  const auto scratch = flexible.make_scratch();
  auto& work = *scratch;
  const int at = m.modal_position(body);
  flexible.set_position(s.p.data() + at, work);
  const VectorXd s_dot = s.v.tail(flexible.m());
  const Vector3d linear = flexible.mass() * v + w.cross(work.d) + work.C_t * s_dot;
  const Vector3d angular = work.d.cross(v) + work.J * w + work.C_r * s_dot;
  return {R * linear, motion.X_WB.p.cross(R * linear) + R * angular};
}

TEST(FreeFlexibleBody, KeepsItsMomenta) {
  beams::StraightBeam b;
  b.EA = 1e4;
  b.GI_t = 5.0;
  b.EI_y = 2.0;
  b.EI_z = 3.0;
  b.rho_I_y = b.rho_I_z = 1e-4;
  b.elements = 6;
  const superelement::Superelement se = beams::beam_superelement(b);
  for (const bool stiffened : {false, true}) {
    SCOPED_TRACE(stiffened);
    BasisOptions options;
    options.modes = 8;
    options.damping = 0.02;
    options.stiffening = stiffened;
    MechanismDescription d;
    d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
    const Mechanism m(d);
    State s = m.initial_state();
    // Tumbles, and rings in all its modes.
    for (int i = 0; i < m.sizes().n_v; ++i) s.v(i) = 0.4 * std::cos(1.3 * i) + (i < 6 ? 0.3 : 0.0);
    VectorXd v_dot;
    assemble(m, s, v_dot);
    const Momenta before = momenta(m, 1, s);
    SolverOptions solver;
    solver.end_time = solver.output_step = 2.0;
    solver.tolerance = 1e-9;
    solver.method = "radau";
    const RunResult r = run(m, s, v_dot, solver);
    ASSERT_TRUE(r.complete) << r.stopped_because;
    const Momenta after = momenta(m, 1, r.state);
    // Some thousand steps of 1e-9 each.
    EXPECT_LT((after.linear - before.linear).norm(), 1e-6 * before.linear.norm());
    EXPECT_LT((after.angular - before.angular).norm(), 1e-6 * before.angular.norm());
    EXPECT_LT(std::abs(r.energy.error()), 1e-5 * r.energy.peak);
  }
}

/// Two equal beams on hinges, let go from the horizontal under gravity; the tip of the second after
/// `end_time`.
Vector3d double_pendulum(const std::function<std::shared_ptr<const FlexibleBody>()>& beam, double end_time) {
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  const int upper = d.add_body({.name = "upper", .flexible = beam()});
  const int lower = d.add_body({.name = "lower", .flexible = beam()});
  d.add_joint("hinge", "revolute", d.add_marker(0, "hook"), d.add_marker(upper, "root", {}, 0));
  d.add_joint("knee", "revolute", d.add_marker(upper, "tip", {}, 1), d.add_marker(lower, "root", {}, 0));
  const Mechanism m(d);
  State s = m.initial_state();
  VectorXd v_dot;
  assemble(m, s, v_dot);
  SolverOptions solver;
  solver.method = "radau";
  solver.end_time = solver.output_step = end_time;
  solver.tolerance = 1e-5;
  const RunResult r = run(m, s, v_dot, solver);
  EXPECT_TRUE(r.complete) << r.stopped_because;
  std::vector<Pose> poses;
  const auto scratch = m.make_scratch();
  m.body_poses(r.state, *scratch, poses);
  const FlexibleBody& body = *d.bodies[lower].flexible;
  return (poses[lower] * body.node_pose(1, r.state.p.data() + m.modal_position(lower))).p;
}

TEST(FlexibleDoublePendulum, AncfAndModalAgreeAtSmallDeflectionAndPartAtLarge) {
  const auto difference = [](double EI) {
    BeamPart part;
    part.elements = 8;
    part.C = Vector6d(1e5, 4e4, 4e4, EI, EI, EI).asDiagonal();
    part.rho_I_y = part.rho_I_z = 1e-5;
    part.damping_time = 1e-3;
    beams::StraightBeam b;
    b.EA = 1e5;
    b.GI_t = b.EI_y = b.EI_z = EI;
    b.rho_I_y = b.rho_I_z = 1e-5;
    b.elements = 8;
    const superelement::Superelement se = beams::beam_superelement(b);
    BasisOptions options;
    options.modes = 8;
    options.fixed_interface = 0;
    options.held = interface_loads(se, 0);
    options.loads = interface_loads(se, {0, 1});
    options.damping_law.rayleigh = Eigen::Vector2d(0.0, 1e-3);
    const Vector3d modal =
        double_pendulum([&] { return std::make_shared<ModalBody>(modal_data(se, options)); }, 0.7);
    const Vector3d ancf = double_pendulum([&] { return ancf_body(part); }, 0.7);
    return (modal - ancf).norm();
  };
  // The weight bends a beam by m g L^4 / 8 EI, 1.2 mm and 0.25 m.  At the small deflection what is left is
  // the elements' constant curvature, 1 / (12 n^2) = 0.1 % of it, magnified by the fall; and the sag's
  // square.
  EXPECT_LT(difference(1000.0), 2e-4);
  EXPECT_GT(difference(5.0), 0.02);
}

}  // namespace
}  // namespace flexura::mbs
