// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <Eigen/Geometry>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

/// Load cases of superelements with time factors.
namespace flexura::mbs {
namespace {

using namespace checks;
using ::testing::HasSubstr;

class LoadCases : public MechanismFileTest {
 protected:
  void SetUp() override {
    MechanismFileTest::SetUp();
    Random random(8);
    f_.resize(3, l_.x.cols());
    for (Eigen::Index k = 0; k < f_.cols(); ++k) f_.col(k) = random.vector3();
    superelement::LoadCase wind{.name = "wind", .p_se = l_.T.transpose() * f_.reshaped(), .moment = {}};
    wind.moment.setZero(3, l_.se.n());
    for (int j = 0; j < l_.se.n(); ++j)
      for (Eigen::Index k = 0; k < f_.cols(); ++k)
        wind.moment.col(j) += Vector3d(l_.T.col(j).segment<3>(3 * k)).cross(Vector3d(f_.col(k)));
    l_.se.load_cases = {wind};
    superelement::write(folder_ / "beam.se.h5", l_.se);
  }
  // Where the points stand in the world, as the motion sees them.
  Eigen::Matrix3Xd points(const Mechanism& m, const State& s) const {
    const auto scratch = m.make_scratch();
    std::vector<Pose> poses;
    m.body_poses(s, *scratch, poses);
    const int b = 2;
    Eigen::Matrix3Xd rho = l_.x;
    if (const auto& flexible = m.description().bodies[b].flexible) {
      const Eigen::Map<const VectorXd> modal(m.modal_coordinates(b, s), flexible->m());
      rho += (l_.T * (flexible->modal()->Y * modal)).reshaped(3, rho.cols());
    }
    return (poses[b].R * rho).colwise() + poses[b].p;
  }
  Matrix3d attitude(const Mechanism& m, const State& s) const {
    const auto scratch = m.make_scratch();
    std::vector<Pose> poses;
    m.body_poses(s, *scratch, poses);
    return poses[2].R;
  }

  lattice::Lattice l_ = lattice::make_lattice(4);
  Eigen::Matrix3Xd f_;
};

// The power of the forces at their points, which move as the body does, is that of the generalised forces.
TEST_F(LoadCases, HaveThePowerOfTheirForces) {
  for (const char* how :
       {"fidelity=modal", "frame=joint_fixed", "fidelity=static", "fidelity=rigid", "fidelity=ked"}) {
    SCOPED_TRACE(how);
    const std::string set = std::string("body.beam.") + how;
    const Mechanism m(read(kBlown, {set}).description),
        calm(read(kBlown, {set, "force.gale.factor=0"}).description);
    const State s = random_state(m, 4, 0.3);
    const VectorXd v_dot = Random(5).vector(m.sizes().n_v);
    const VectorXd Q = momentum(calm, s, v_dot) - momentum(m, s, v_dot);
    const auto scratch = m.make_scratch();
    const auto moved = [&](double h) {
      State at = s;
      m.retract(s.p, h * s.v, at.p);
      return points(m, at);
    };
    // Central differences of fourth order: h^4 and round-off 1e-16 / h below 1e-11.
    const double h = 1e-3;
    const Eigen::Matrix3Xd v = (8.0 * (moved(h) - moved(-h)) - (moved(2 * h) - moved(-2 * h))) / (12.0 * h);
    const double power = 2.0 * (attitude(m, s) * f_).cwiseProduct(v).sum();
    EXPECT_GT(std::abs(power), 0.1);
    EXPECT_NEAR(Q.head(m.sizes().n_v).dot(s.v), power, 1e-9 * (1.0 + Q.cwiseAbs().dot(Q.cwiseAbs())));
    power_balances(m, s, 6);
  }
}

TEST_F(LoadCases, DeformOneWayBodies) {
  const Mechanism m(read(kBlown, {"body.beam.fidelity=ked"}).description),
      calm(read(kBlown, {"body.beam.fidelity=ked", "force.gale.factor=0"}).description);
  const FlexibleBody& ked = *m.description().bodies[2].flexible;
  const Sizes n = m.sizes();
  State s = random_state(m, 4, 0.3);
  const VectorXd v_dot = Random(5).vector(n.n_v);
  const auto rates = [&](const Mechanism& of) {
    VectorXd r(n.n_v), c_rate(n.n_dyn), b(0);
    const auto scratch = of.make_scratch();
    of.momentum(s, v_dot, *scratch, r, c_rate, b);
    return c_rate;
  };
  // The elbow holds the frame, where its reaction finds no displacement: the load alone is left.
  const VectorXd change = (rates(m) - rates(calm)).tail(ked.m());
  const VectorXd own = 2.0 * ked.modal()->Y.transpose() * l_.T.transpose() * f_.reshaped();
  EXPECT_LT((change - own).norm(), 1e-11 * own.norm());
  EXPECT_GT(own.norm(), 0.1);
}

TEST_F(LoadCases, GiveResponseModesToBodiesThatFollowThem) {
  const auto n_flx = [&](const std::vector<std::string>& overrides) {
    return Mechanism(read(kBlown, overrides).description).sizes().n_flx;
  };
  // The elbow turns about its axis: five loads; the load case is one more.
  EXPECT_EQ(n_flx({"body.beam.fidelity=static"}), 5 + 1);
  EXPECT_EQ(n_flx({"body.beam.modes=2", "body.beam.attachments=used"}), 2 + 5 + 1);
}

TEST_F(LoadCases, AreRefusedWithTheReason) {
  const auto refusal_of = [&](const std::vector<std::string>& overrides) {
    return test::refusal_of([&] { read(kBlown, overrides); });
  };
  EXPECT_THAT(refusal_of({"force.gale.load=wimd"}),
              HasSubstr("body \"beam\" has no load case \"wimd\", did you mean \"wind\"?"));
  EXPECT_THAT(refusal_of({"force.gale.body=arm"}),
              HasSubstr("load cases belong to superelements: name a body made of one"));
  EXPECT_THAT(refusal_of({"force.gale.body=beem"}),
              HasSubstr("there is no body \"beem\", did you mean \"beam\"?"));
  EXPECT_THAT(refusal_of({"force.gale.factor=2*wnid"}), HasSubstr("wnid"));
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(4).se);
  EXPECT_THAT(refusal_of({}), HasSubstr("write [load.wind] into its part file and reduce it again"));
  l_.se.stiffening = lattice::any_stiffening(l_.se.n(), 5);
  superelement::write(folder_ / "beam.se.h5", l_.se);
  EXPECT_THAT(refusal_of({"body.beam.fidelity=modal-stiffened"}), HasSubstr("all of it or none"));
  l_.se.stiffening->K0p = {l_.se.stiffening->K0F[0]};
  superelement::write(folder_ / "beam.se.h5", l_.se);
  EXPECT_EQ(refusal_of({"body.beam.fidelity=modal-stiffened"}), "accepted");
}

// What the geometric stiffness adds to the force on the modes, -factor K0p s, and its power.
TEST_F(LoadCases, HaveTheStiffnessThatTheyAdd) {
  l_.se.stiffening = lattice::any_stiffening(l_.se.n(), 5);
  const MatrixXd K0p = l_.se.stiffening->K0F[3];
  const auto with = [&](const MatrixXd& terms) {
    l_.se.stiffening->K0p = {terms};
    superelement::write(folder_ / "beam.se.h5", l_.se);
    return Mechanism(read(kBlown, {"body.beam.fidelity=modal-stiffened"}).description);
  };
  const Mechanism m = with(K0p), plain = with(0.0 * K0p);
  const State s = random_state(m, 4, 0.3);
  const VectorXd v_dot = Random(5).vector(m.sizes().n_v);
  const int b = 2, n_modes = m.description().bodies[b].flexible->m();
  const Eigen::MatrixXd& Y = m.description().bodies[b].flexible->modal()->Y;
  const Eigen::Map<const VectorXd> modal(m.modal_coordinates(b, s), n_modes);
  const VectorXd added = (momentum(m, s, v_dot) - momentum(plain, s, v_dot)).head(m.sizes().n_v);
  const VectorXd wanted = 2.0 * Y.transpose() * (K0p * (Y * modal));
  EXPECT_LT((added.tail(n_modes) - wanted).norm(), 1e-9 * wanted.norm());
  EXPECT_LT(added.head(added.size() - n_modes).norm(), 1e-9 * wanted.norm());
  power_balances(m, s, 6);
}

TEST_F(LoadCases, OfFilesWithoutTheirTorqueByDisplacementAreTakenWithoutIt) {
  l_.se.load_cases[0].moment.resize(3, 0);
  superelement::write(folder_ / "beam.se.h5", l_.se);
  const MechanismDescription d = read(kBlown).description;
  EXPECT_EQ(d.bodies[2].loads[0].moment.size(), 0);
  EXPECT_GT(d.bodies[2].loads[0].modal.size(), 0);
}

}  // namespace
}  // namespace flexura::mbs
