// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;
using ::testing::HasSubstr;

const char* const flexible_pendulum = R"toml(
[body.beam]
superelement = "beam.se.h5"
damping = 0.02
[body.beam.marker.tip]
on = "right"
position = [1.0, 0.2, 0.3]
[body.bob]
mass = 1
inertia = [0.1, 0.1, 0.1]
[joint.pivot]
type = "revolute"
from = "ground"
to = "beam.left"
[joint.neck]
type = "ball"
from = "beam.tip"
to = "bob"
[force.gust]
type = "force"
marker = "beam.tip"
axes = "beam.tip"
x = "sin(t)"
reaction = "bob"
)toml";

TEST_F(MechanismFileTest, SuperelementIsModalOrRigid) {
  const lattice::Lattice l = lattice::make_lattice(3);
  superelement::write(folder_ / "beam.se.h5", l.se);
  const MechanismFile file = read(flexible_pendulum);
  const Mechanism modal(file.description);
  EXPECT_EQ(modal.sizes().n_flx, l.se.n() - 6);
  EXPECT_TRUE(file.notes.empty());
  all_identities_hold(modal, 5);
  const Mechanism rigid(read(flexible_pendulum, {"body.beam.fidelity=rigid"}).description);
  EXPECT_EQ(rigid.sizes().n_flx, 0);
  all_identities_hold(rigid, 6);
  // Undeformed, both have the same pose everywhere and the same rigid mass matrix.
  const State s_m = modal.initial_state(), s_r = rigid.initial_state();
  const auto scratch_m = modal.make_scratch(), scratch_r = rigid.make_scratch();
  std::vector<Pose> poses_m, poses_r;
  modal.body_poses(s_m, *scratch_m, poses_m);
  rigid.body_poses(s_r, *scratch_r, poses_r);
  for (int b = 1; b < 3; ++b) EXPECT_LE((poses_m[b].p - poses_r[b].p).norm(), 1e-14);

  const MechanismFile truncated = read(flexible_pendulum, {"body.beam.modes=4"});
  EXPECT_EQ(Mechanism(truncated.description).sizes().n_flx, 4);
  ASSERT_EQ(truncated.notes.size(), 1u);
  EXPECT_THAT(truncated.notes[0], HasSubstr("body \"beam\" keeps 4 of 9 modes"));
  EXPECT_THAT(truncated.notes[0], HasSubstr("it is stiffer under loads"));
}

TEST_F(MechanismFileTest, BodiesArePreparedForWhatActsOnThem) {
  const lattice::Lattice l = lattice::make_lattice(12);  // 24 shapes, 18 deformations
  superelement::write(folder_ / "beam.se.h5", l.se);
  const auto modes_of = [&](const std::vector<std::string>& overrides) {
    return Mechanism(read(flexible_pendulum, overrides).description).sizes().n_flx;
  };
  // The pivot turns freely about its axis and the tip carries a ball joint and a force: 5 + 6 loads.
  EXPECT_EQ(modes_of({"body.beam.modes=4"}), 4);
  EXPECT_EQ(modes_of({"body.beam.modes=4", "body.beam.attachments=used"}), 4 + 5 + 6);
  EXPECT_EQ(modes_of({"body.beam.modes=4", "body.beam.attachments=all"}), 4 + 12);
  EXPECT_EQ(modes_of({"body.beam.fidelity=static"}), 5 + 6);
  EXPECT_EQ(modes_of({"body.beam.frame=joint_fixed"}), 18);
  EXPECT_EQ(modes_of({"body.beam.coupling=partial"}), 18);
  const MechanismFile held = read(
      flexible_pendulum, {"body.beam.frame=joint_fixed", "body.beam.modes=4", "body.beam.attachments=used"});
  EXPECT_THAT(held.notes[0],
              HasSubstr("joint \"pivot\" on interface \"left\" gives the frame and the eigenmodes'"));
  EXPECT_THAT(held.notes[1], HasSubstr("and 11 response modes up to"));
  // Response modes above the eigenmodes follow their loads: critical damping, d = 2 omega.
  const auto& data = held.description.bodies[1].flexible->data();
  EXPECT_DOUBLE_EQ(data.damping(data.damping.size() - 1),
                   2.0 * std::sqrt(data.stiffness(data.stiffness.size() - 1)));
  EXPECT_LT(data.damping(0), std::sqrt(data.stiffness(0)));

  for (const char* fidelity : {"ked", "static", "modal"}) {
    SCOPED_TRACE(fidelity);
    all_identities_hold(Mechanism(read(flexible_pendulum, {std::string("body.beam.fidelity=") + fidelity,
                                                           "body.beam.frame=joint_fixed"})
                                      .description),
                        5);
  }
  const Mechanism ked(read(flexible_pendulum, {"body.beam.fidelity=ked"}).description);
  EXPECT_EQ(ked.sizes().n_flx, 0);
  EXPECT_EQ(ked.sizes().n_dyn, 2 * 18);

  const auto refusal_of = [&](const std::vector<std::string>& overrides) -> std::string {
    try {
      read(flexible_pendulum, overrides);
    } catch (const input::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal_of({"body.beam.fidelity=modal-stiffened"}),
              HasSubstr("has no geometric stiffening terms; reduce the part again"));
  EXPECT_THAT(refusal_of({"body.beam.damping=0.1", "body.beam.rayleigh_beta=1e-4"}),
              HasSubstr("has more than one damping law"));
  EXPECT_THAT(refusal_of({"body.beam.damping_ratios=[0.1]"}), HasSubstr("make a table together"));
  EXPECT_THAT(refusal_of({"body.beam.fidelity=static", "body.beam.modes=3"}),
              HasSubstr("takes no eigenmodes"));
}

}  // namespace
}  // namespace flexura::mbs
