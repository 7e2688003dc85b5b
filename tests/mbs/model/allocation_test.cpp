// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

#include "mbs/bodies/modal_body.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "tests/mbs/allocations.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/sanitized.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;

TEST(Evaluation, AllocatesNothing) {
#if defined(FLEXURA_ADDRESS_SANITIZER)
  GTEST_SKIP() << "the sanitizer owns malloc";
#endif
  const lattice::Lattice l = lattice::make_lattice(10);
  MechanismDescription d;
  d.gravity = {0, 0, -9.81};
  Random random(1);
  int previous = 0;
  for (const JointType& type : joint_types()) {
    const int body = d.add_body({.name = type.name, .inertia = random.inertia()});
    d.add_joint("to_" + type.name, type.name, d.add_marker(previous, "out_" + type.name),
                d.add_marker(body, "in"));
    previous = body;
  }
  const int beam = d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(l.se))});
  const int joint = d.add_joint("hinge", "revolute", d.add_marker(previous, "hinge"),
                                d.add_marker(beam, "left", random.pose(), 0));
  d.joints[joint].drives[0] = std::make_shared<Expression>("joint.hinge.drive", "sin(3*t)^2", d.signals,
                                                           std::map<std::string, double>{});
  d.joints[d.add_joint("loop", "spherical", d.add_marker(0, "loop"), d.add_marker(beam, "right", {}, 1))]
      .cut = true;
  const Mechanism mechanism(d);
  const State s = random_state(mechanism, 2);
  const Sizes n = mechanism.sizes();
  const auto scratch = mechanism.make_scratch();
  VectorXd r(n.n_v), none(0), g(n.n_lambda), f_c(n.n_v), p_dot(n.n_p);
  VectorXd g_dot(n.n_lambda);
  MatrixXd M(n.n_v, n.n_v), G(n.n_lambda, n.n_v);
  const VectorXd v_dot = random.vector(n.n_v);
  const auto evaluate = [&] {
    mechanism.kinematic(s.p, s.v, p_dot);
    mechanism.momentum(s, v_dot, *scratch, r, none, none);
    mechanism.position_constraints(s.t, s.p, *scratch, g);
    mechanism.velocity_constraints(s.t, s.p, s.v, *scratch, g);
    mechanism.acceleration_constraints(s.t, s.p, s.v, v_dot, *scratch, g);
    mechanism.apply_GT(s.t, s.p, s.lambda, *scratch, f_c);
    mechanism.residuals(s, v_dot, s.lambda, *scratch, r, none, none, g_dot, g, f_c);
    mechanism.mass_matrix(s.p, *scratch, M);
    mechanism.constraint_matrix(s.t, s.p, *scratch, G);
    mechanism.factor_mass(s.p, *scratch);
    mechanism.solve_mass(*scratch, r);
  };
  evaluate();
  const long before = allocations;
  for (int i = 0; i < 10; ++i) evaluate();
  EXPECT_EQ(allocations - before, 0);
  EXPECT_GT(before, 0);
}

}  // namespace
}  // namespace flexura::mbs
