// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "mbs/bodies/beams/ancf_part.hpp"
#include "mbs/bodies/modal_body.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"
#include "tests/mbs/solver/derivatives.hpp"

/// Derivatives of every kind of flexible body.
namespace flexura::mbs {
namespace {

using checks::derivatives_agree;
using checks::Random;
using Eigen::MatrixXd;

// Two bodies of one kind on a chain, held at nodes on either side of a joint, loaded there by a closure.
void derivatives_agree_on(std::shared_ptr<const FlexibleBody> body, double own_error = 0.0) {
  MechanismDescription d = checks::chain_of(body, body, "universal");
  Random random(21);
  const int last = d.add_marker(checks::chain_second, "last", random.pose(0.2), 0);
  d.joints[d.add_joint("closure", "spherical", d.add_marker(0, "end", random.pose()), last)].cut = true;
  derivatives_agree(Mechanism(std::move(d)), own_error);
}

TEST(FlexibleDerivatives, OfEveryLevelOfCoupling) {
  BasisOptions options;
  options.modes = 4;
  ModalData data = modal_data(lattice::make_lattice(4, 40.0).se, options);
  data.damping.setConstant(0.3);
  for (const Coupling coupling : {Coupling::constant, Coupling::partial, Coupling::full}) {
    SCOPED_TRACE(static_cast<int>(coupling));
    data.coupling = coupling;
    derivatives_agree_on(std::make_shared<ModalBody>(data));
  }
}

// A joint, a closure and what they carry at a marker that follows three places of the surface.
TEST(FlexibleDerivatives, AtAnInterpolatedNode) {
  const superelement::Superelement se = lattice::with_surface(lattice::make_lattice(4, 40.0));
  BasisOptions options;
  options.modes = 4;
  options.nodes = {interpolated_node(se, "a", {{}, {7, 10, 14}, {}}),
                   interpolated_node(se, "b", {{1}, {16, 20, 23}, {1, 2, 3, 4}})};
  ModalData data = modal_data(se, options);
  data.nodes.erase(data.nodes.begin(), data.nodes.begin() + 2);  // the chain sits on the first two
  derivatives_agree_on(std::make_shared<ModalBody>(data));
}

using FlexibleDerivativesOfAFile = MechanismFileTest;

// One-way: its deformation answers to the motion, to accelerations and reactions, and to the states of
// others.
TEST_F(FlexibleDerivativesOfAFile, OfAOneWayBody) {
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(4, 40.0).se);
  derivatives_agree(Mechanism(read(R"toml(
[ground.marker.far]
position = [1, 0.2, 0.3]
[body.beam]
superelement = "beam.se.h5"
fidelity = "ked"
modes = 4
[body.bob]
mass = 1
inertia = [0.1, 0.1, 0.1]
[body.bob.marker.end]
position = [0.3, -0.2, 0.1]
[joint.pivot]
type = "universal"
from = "ground"
to = "beam.left"
[joint.neck]
type = "revolute"
from = "beam.right"
to = "bob"
[joint.closure]
type = "spherical"
from = "ground.far"
to = "bob.end"
cut = true
[control.lag]
type = "state"
rate = "-2*lag + neck.speed"
[control.root]
type = "algebraic"
equation = "root + 0.3*root^3 - neck.angle"
[force.gust]
type = "force"
marker = "beam.right"
x = "3*lag"
y = "2*root"
)toml")
                                  .description),
                    checks::kByDifferences);
}

// Loads that are spread over the body, with a factor that depends on the motion.
TEST_F(FlexibleDerivativesOfAFile, OfALoadCase) {
  const lattice::Lattice l = lattice::make_lattice(4, 40.0);
  superelement::Superelement se = l.se;
  Random random(12);
  se.load_cases = {{"wind", random.vector(se.n()), MatrixXd::Zero(3, se.n())}};
  for (auto column : se.load_cases[0].moment.colwise()) column = random.vector3();
  superelement::write(folder_ / "beam.se.h5", se);
  superelement::StiffeningTerms& terms = se.stiffening.emplace(lattice::any_stiffening(se.n(), 5));
  terms.K0p = {terms.K0F[2]};
  // So small that a hundredth of a unit of deformation is no large second-order displacement.
  const auto scale = [](auto& matrices) {
    for (MatrixXd& K0 : matrices) K0 *= 0.02;
  };
  scale(terms.K0t);
  scale(terms.K0r);
  scale(terms.K0omega);
  scale(terms.K0F);
  superelement::write(folder_ / "beam.se.h5", se);
  for (const char* fidelity : {"modal", "modal-stiffened", "ked", "rigid"}) {
    SCOPED_TRACE(fidelity);
    derivatives_agree(Mechanism(read(kBlown, {std::string("body.beam.fidelity=") + fidelity,
                                              "force.gale.factor=1 + elbow.angle^2 + 0.3*elbow.speed"})
                                    .description),
                      checks::kByDifferences);
  }
}

// Any symmetric second-order displacement will do.
TEST(FlexibleDerivatives, OfAStiffenedBody) {
  BasisOptions options;
  options.modes = 4;
  ModalData data = modal_data(lattice::make_lattice(4, 40.0).se, options);
  Random random(31);
  const auto blocks = [&](int n) {
    MatrixXd x(4 * n, 4);
    for (int k = 0; k < n; ++k) {
      MatrixXd block(4, 4);
      for (int j = 0; j < 4; ++j) block.col(j) = random.vector(4, 0.2);
      x.middleRows(4 * k, 4) = block + block.transpose();
    }
    return x;
  };
  data.second = SecondOrderIntegrals{blocks(3), blocks(9)};
  for (FlexibleNode& node : data.nodes) node.second = blocks(6);
  derivatives_agree_on(std::make_shared<ModalBody>(data));
}

TEST(FlexibleDerivatives, OfAnAncfBeam) {
  for (const int elements : {1, 3}) {
    SCOPED_TRACE(elements);
    derivatives_agree_on(straight_ancf_part(beam::ancf::uncoupled_section(50, 20, 20, 3, 4, 5, 1, 0.05, 0.05),
                                            {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, elements),
                         checks::kByDifferences);
    checks::Random random(4);
    const Pose X = random.pose();
    derivatives_agree_on(planar_ancf_part({.EA = 50, .EI = 4, .mass_per_length = 1}, X.p, X.R, 1.0, elements),
                         checks::kByDifferences);
  }
}

}  // namespace
}  // namespace flexura::mbs
