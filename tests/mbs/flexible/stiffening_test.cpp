// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/modal_body.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;
using lattice::Lattice;
using lattice::make_lattice;

MatrixXd random_symmetric(Random& random, int n, double size) {
  MatrixXd A(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) A(i, j) = A(j, i) = size * random();
  return A;
}

/// Any symmetric matrices will do: the identities hold for every second-order displacement.
superelement::Superelement with_random_stiffening(superelement::Superelement se, unsigned seed) {
  Random random(seed);
  superelement::StiffeningTerms& terms = se.stiffening.emplace();
  for (MatrixXd& K : terms.K0t) K = random_symmetric(random, se.n(), 0.002);
  for (MatrixXd& K : terms.K0r) K = random_symmetric(random, se.n(), 0.002);
  for (MatrixXd& K : terms.K0omega) K = random_symmetric(random, se.n(), 0.002);
  for (int k = 0; k < se.n_b; ++k) terms.K0F.push_back(random_symmetric(random, se.n(), k < 3 ? 0.0 : 0.005));
  return se;
}

std::shared_ptr<const FlexibleBody> body(const Lattice& l, Coupling coupling, bool stiffened, bool damped,
                                         int fixed_interface = -1) {
  BasisOptions options;
  options.coupling = coupling;
  options.stiffening = stiffened;
  options.fixed_interface = fixed_interface;
  options.modes = 8;
  options.loads = interface_loads(l.se, 1);
  if (!damped) options.damping = 0.0;
  return std::make_shared<ModalBody>(modal_data(stiffened ? with_random_stiffening(l.se, 4) : l.se, options));
}

MechanismDescription chain(Coupling coupling, bool stiffened, bool damped, int fixed_interface = -1) {
  static const Lattice a = make_lattice(2), b = make_lattice(1, 250.0);
  return chain_of(body(a, coupling, stiffened, damped, fixed_interface),
                  body(b, coupling, stiffened, damped, fixed_interface), "revolute");
}

TEST(GeometricStiffening, SatisfiesLagrangesEquations) {
  const Mechanism mechanism(chain(Coupling::full, true, false));
  lagrange_equations_hold(mechanism, random_state(mechanism, 3, 0.2), 4);
}

TEST(GeometricStiffening, SatisfiesAllIdentities) {
  all_identities_hold(Mechanism(chain(Coupling::full, true, true)), 6);
  all_identities_hold(Mechanism(chain(Coupling::full, true, true, 0)), 7);
}

TEST(GeometricStiffening, OfClosuresBetweenDeformingMarkersSatisfiesAllIdentities) {
  for (const char* type : {"spherical", "fixed", "cylindrical"}) {
    SCOPED_TRACE(type);
    MechanismDescription d = chain(Coupling::full, true, true);
    Random random(8);
    const int F = d.add_marker(chain_second, "loop", random.pose(0.2), 0),
              M = d.add_marker(chain_first, "loop", random.pose(0.2), 1);
    const int joint = d.add_joint("loop", type, F, M);
    d.joints[joint].cut = true;
    all_identities_hold(Mechanism(d), 9);
  }
}

TEST(Coupling, ConstantAndPartialSatisfyLagrangesEquations) {
  for (const Coupling coupling : {Coupling::constant, Coupling::partial}) {
    const Mechanism mechanism(chain(coupling, false, false));
    lagrange_equations_hold(mechanism, random_state(mechanism, 3, 0.2), 4);
    all_identities_hold(mechanism, 6);
    const Mechanism fixed_frame(chain(coupling, false, false, 0));
    lagrange_equations_hold(fixed_frame, random_state(fixed_frame, 3, 0.2), 4);
  }
}

TEST(GeometricStiffening, IsThatOfItsLoads) {
  // What stiffening adds to the modal forces at rest in a moving frame is K_G s, K_G the sum of K0t a, K0r
  // alpha and K0omega of the spin's products.
  const Lattice l = make_lattice(2);
  const superelement::Superelement se = with_random_stiffening(l.se, 4);
  BasisOptions options;
  options.stiffening = true;
  const ModalBody flexible(modal_data(se, options));
  const MatrixXd& Y = flexible.data().Y;
  const int m = flexible.m();
  Random random(2);
  const Spatial V{random.vector3(), {}}, A{random.vector3(), random.vector3()};
  const auto modal_force = [&](const VectorXd& s) {
    const auto scratch = flexible.make_scratch();
    auto& work = *scratch;
    flexible.set_position(s.data(), work);
    VectorXd zero = VectorXd::Zero(m), out(m);
    flexible.inverse_dynamics(s.data(), zero.data(), zero.data(), V, A, work, out.data());
    return out;
  };
  BasisOptions linear;
  const ModalBody without(modal_data(se, linear));
  const auto modal_force_without = [&](const VectorXd& s) {
    const auto scratch = without.make_scratch();
    auto& work = *scratch;
    without.set_position(s.data(), work);
    VectorXd zero = VectorXd::Zero(m), out(m);
    without.inverse_dynamics(s.data(), zero.data(), zero.data(), V, A, work, out.data());
    return out;
  };
  const superelement::StiffeningTerms& K0 = *se.stiffening;
  MatrixXd K_G = MatrixXd::Zero(se.n(), se.n());
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    K_G += A.linear(a) * K0.K0t[a] + A.angular(a) * K0.K0r[a] + V.angular(a) * V.angular(a) * K0.K0omega[a] +
           V.angular(a) * V.angular(b) * K0.K0omega[3 + a];
  }
  const VectorXd s = random.vector(m, 0.1);
  // Both are linear in s: exact but for round-off.
  const VectorXd difference = modal_force(s) - modal_force_without(s),
                 expected = Y.transpose() * (K_G * (Y * s));
  EXPECT_LE((difference - expected).cwiseAbs().maxCoeff(),
            1e-12 * (1.0 + modal_force(s).cwiseAbs().maxCoeff()));
}

}  // namespace
}  // namespace flexura::mbs
