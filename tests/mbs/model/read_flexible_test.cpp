// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "mbs/bodies/modal_basis.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;
using ::testing::AllOf;
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

const char* const bob_on_a_rail = R"toml(
[joint.rail]
type = "prismatic"
from = "ground"
to = "bob"
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
  // Of the boundary condition only where modes are left out.
  ASSERT_EQ(truncated.notes.size(), 2u);
  EXPECT_THAT(truncated.notes[0], HasSubstr("gives the eigenmodes' boundary condition"));
  EXPECT_THAT(truncated.notes[1],
              AllOf(HasSubstr("body \"beam\" keeps 4 of 9 modes"), HasSubstr("(the next has ")));
  EXPECT_THAT(read(flexible_pendulum, {"body.beam.modes=[2, 5]"}).notes[1],
              HasSubstr("(the lowest left out has "));
  EXPECT_THAT(truncated.notes[1], HasSubstr("it is stiffer under loads"));
}

TEST_F(MechanismFileTest, BodiesArePreparedForWhatActsOnThem) {
  const lattice::Lattice l = lattice::make_lattice(12);  // 24 shapes, 18 deformations
  superelement::write(folder_ / "beam.se.h5", l.se);
  const auto modes_of = [&](const std::vector<std::string>& overrides) {
    return Mechanism(read(flexible_pendulum, overrides).description).sizes().n_flx;
  };
  // The pivot turns freely about its axis and the tip carries a ball joint and a force: 5 + 6 loads.
  EXPECT_EQ(modes_of({"body.beam.modes=4"}), 4);
  EXPECT_EQ(modes_of({"body.beam.modes=[1, 3, 7]"}), 3);
  EXPECT_EQ(modes_of({"body.beam.modes=\"1-3, 7\""}), 4);
  const int of_mass = modes_of({"body.beam.effective_mass=0.5", "body.beam.boundary=joint"});
  EXPECT_TRUE(of_mass > 0 && of_mass < 18) << of_mass;
  EXPECT_EQ(modes_of({"body.beam.max_frequency=1 mHz", "body.beam.attachments=used"}), 5 + 6);
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
  // Response modes are damped as eigenmodes are: by the ratio, of the modes that the joint leaves.
  const ModalData& data = *held.description.bodies[1].flexible->modal();
  const Eigen::MatrixXd D = data.damping_matrix();
  const Eigen::VectorXd power = D.eigenvalues().real();
  EXPECT_GT(power.minCoeff(), 0.0);
  EXPECT_LT(power.maxCoeff(), std::sqrt(data.stiffness.maxCoeff()));  // by far no critical damping, 2 omega

  // What hangs on a body whose deformation does not act back would stay where it is.
  EXPECT_THAT(test::refusal_of([&] { read(flexible_pendulum, {"body.beam.fidelity=ked"}); }),
              HasSubstr("body \"bob\" hangs on it by joint \"neck\": it would neither move"));
  const std::string held_bob = std::string(flexible_pendulum) + bob_on_a_rail;
  for (const char* fidelity : {"ked", "static", "modal"}) {
    SCOPED_TRACE(fidelity);
    all_identities_hold(
        Mechanism(read(std::string(fidelity) == "ked" ? held_bob : std::string(flexible_pendulum),
                       {std::string("body.beam.fidelity=") + fidelity, "body.beam.frame=joint_fixed"})
                      .description),
        5);
  }
  const Mechanism ked(read(held_bob, {"body.beam.fidelity=ked"}).description);
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
  // One word changes the fidelity: what the others need may stay.
  EXPECT_THAT(read(flexible_pendulum, {"body.beam.fidelity=static", "body.beam.modes=3"}).notes[0],
              HasSubstr("is static and takes no eigenmodes: modes is of no account"));
  EXPECT_THAT(refusal_of({"body.beam.damping_by_mode=[0.1, -0.1]"}),
              HasSubstr("body.beam.damping_by_mode = [0.1, -0.1]: holds -0.1"));
  EXPECT_THAT(refusal_of({"body.beam.damping_ratios=[]", "body.beam.damping_frequencies=[]"}),
              HasSubstr("is empty"));
  EXPECT_THAT(refusal_of({"body.beam.damping_ratios=[0.1, 0.2]", "body.beam.damping_frequencies=[10, 5]"}),
              HasSubstr("damping_frequencies = [10, 5]: 5 Hz does not lie above the one before it"));
  EXPECT_THAT(refusal_of({"body.beam.effective_mass=0.9", "body.beam.modes=[1, 3]"}),
              HasSubstr("`modes` says by their numbers which eigenmodes are kept"));
  EXPECT_THAT(refusal_of({"body.beam.modes=1-3,"}), HasSubstr("a text like \"1-5, 8\" is wanted"));
  EXPECT_THAT(refusal_of({"body.beam.max_frequency=1e-6"}), HasSubstr("max_frequency: superelement"));
}

// A long chain from a file: its joints stand as constraints, but for those whose coordinates a formula reads.
TEST_F(MechanismFileTest, LongChainsArePartedWhereNothingReadsTheJoints) {
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(12).se);  // 18 deformations each
  std::string chain;
  for (int k = 0; k < 8; ++k)
    chain += fmt::format(R"toml(
[body.b{0}]
superelement = "beam.se.h5"
[joint.j{0}]
type = "revolute"
from = "{1}"
to = "b{0}.left"
)toml",
                         k, k == 0 ? "ground" : fmt::format("b{}.right", k - 1));
  const auto parted = [&](const std::string& text) {
    const Mechanism m(read(text).description);
    std::string joints;
    for (const JointDescription& joint : m.description().joints)
      if (joint.splits) joints += joint.name + " ";
    return joints;
  };
  EXPECT_EQ(parted(chain), "j1 j2 j3 j4 j5 j6 j7 ");
  EXPECT_EQ(parted(chain + "[force.f]\ntype = \"joint_force\"\njoint = \"j0\"\nvalue = \"-j3.speed\"\n"),
            "j1 j2 j4 j5 j6 j7 ");
}

// Simpack's conditions on the joint that holds the eigenmodes.
TEST_F(MechanismFileTest, JointsThatGiveNoBoundaryConditionAreTold) {
  superelement::Superelement se = lattice::make_lattice(6).se;
  superelement::write(folder_ / "beam.se.h5", se);
  const std::vector<std::string> universal = {"joint.pivot.type=universal", "body.beam.frame=joint_fixed"};
  const MechanismFile file = read(flexible_pendulum, universal);
  EXPECT_THAT(file.notes[0],
              HasSubstr("what joint \"pivot\" locks does not stand still in the body as it moves: its "
                        "eigenmodes are those of the free body"));
  EXPECT_THAT(file.notes[1], HasSubstr("gives the frame"));
  all_identities_hold(Mechanism(file.description), 5);
  std::vector<std::string> asked = universal;
  asked.push_back("body.beam.boundary=joint");
  EXPECT_THAT(test::refusal_of([&] { read(flexible_pendulum, asked); }),
              HasSubstr("boundary = \"joint\": what joint \"pivot\" locks does not stand still"));
}

TEST_F(MechanismFileTest, ResponseFrequencyMustBeNoNaturalFrequency) {
  const superelement::Superelement se = lattice::make_lattice(6).se;
  superelement::write(folder_ / "beam.se.h5", se);
  BasisReport report;
  modal_data(se, {}, &report);
  const auto set = [](double hz) { return fmt::format("body.beam.response_frequency={:.17g}", hz); };
  const std::vector<std::string> all = {"body.beam.modes=2", "body.beam.attachments=used", ""};
  for (const double off : {0.0, 5e-4, 0.01}) {
    std::vector<std::string> overrides = all;
    overrides.back() = set(report.eigen_hz[1] * (1.0 + off));
    const std::string text = test::refusal_of([&] { read(flexible_pendulum, overrides); });
    if (off < 1e-3)
      EXPECT_THAT(text, HasSubstr("response_frequency: superelement \"lattice\"")) << off;
    else
      EXPECT_EQ(text, "accepted");
  }
}

const char* const carried_by_several = R"toml(
[body.beam]
superelement = "beam.se.h5"
[body.beam.marker.middle]
points = [[0.3, 0.17, 0], [0.6, 0.34, 0.1], [0.62, 0.14, 0.33], [0.3, -0.03, 0.3]]
[body.beam.marker.around]
position = [0.45, 0.2, 0.15]
within = "300 mm"
axis = [0, 1, 1]
[body.bob]
mass = 1
inertia = [0.1, 0.1, 0.1]
[joint.pivot]
type = "revolute"
from = "ground"
to = "beam.middle"
[joint.neck]
type = "ball"
from = "beam.around"
to = "bob"
[force.gust]
type = "force"
marker = "beam.middle"
axes = "beam.around"
x = "sin(t)"
y = "3"
reaction = "bob"
)toml";

TEST_F(MechanismFileTest, MarkersFollowSeveralNodes) {
  const lattice::Lattice l = lattice::make_lattice(6);
  superelement::write(folder_ / "bare.se.h5", l.se);
  superelement::write(folder_ / "beam.se.h5", lattice::with_surface(l));
  const MechanismFile file = read(carried_by_several);
  EXPECT_THAT(file.notes[0],
              HasSubstr("marker \"beam.middle\" follows 4 nodes of the surface, the farthest"));
  EXPECT_THAT(file.notes[1], HasSubstr("marker \"beam.around\" follows"));
  // Joints, forces and measures there: kinematics, powers and Lagrange's equations are those of the marker.
  all_identities_hold(Mechanism(file.description), 11);
  const auto& nodes = file.description.bodies[1].flexible->nodes();
  ASSERT_EQ(nodes.size(), 4u);
  EXPECT_EQ(nodes[2].name, "beam.middle");
  // The marker stands where it is told to, its node in the centre of those around.
  const auto place = [](const MechanismDescription& d, const std::string& name) {
    for (const MarkerDescription& m : d.markers)
      if (m.name == name)
        return m.node < 0 ? m.X_BP.p
                          : Vector3d(d.bodies[m.body].flexible->nodes()[m.node].p_BoN_B + m.X_BP.p);
    return Vector3d(Vector3d::Zero());
  };
  EXPECT_LT((place(file.description, "beam.around") - Vector3d(0.45, 0.2, 0.15)).norm(), 1e-15);
  const MechanismDescription rigid = read(carried_by_several, {"body.beam.fidelity=rigid"}).description;
  for (const char* name : {"beam.middle", "beam.around"})
    EXPECT_LT((place(file.description, name) - place(rigid, name)).norm(), 1e-15) << name;
  for (const char* how : {"fidelity=ked", "fidelity=static", "frame=joint_fixed", "attachments=used"}) {
    SCOPED_TRACE(how);
    all_identities_hold(
        Mechanism(read(std::string(carried_by_several) + bob_on_a_rail, {std::string("body.beam.") + how})
                      .description),
        12);
  }
  // Both ends in one rigid piece: six deformations fewer.
  const std::string link = std::string(carried_by_several) +
                           "[body.beam.marker.grip]\nnodes = [\"left\", "
                           "\"right\"]\nlink = \"rigid\"\n";
  const Mechanism linked(read(link).description);
  EXPECT_EQ(linked.sizes().n_flx, l.se.n() - 12);
  all_identities_hold(linked, 13);
}

TEST_F(MechanismFileTest, MarkersOnSeveralNodesAreRefusedWithTheReason) {
  const lattice::Lattice l = lattice::make_lattice(6);
  superelement::write(folder_ / "bare.se.h5", l.se);
  const auto refusal_of_marker = [&](const std::string& keys,
                                     const std::string& body = "superelement = \"bare.se.h5\"") {
    return refusal("[body.beam]\n" + body + "\n[body.beam.marker.x]\n" + keys + "\n");
  };
  EXPECT_THAT(refusal_of_marker("nodes = [\"left\", \"rihgt\"]"),
              HasSubstr("no interface \"rihgt\", did you mean \"right\"?"));
  EXPECT_THAT(refusal_of_marker("nodes = [\"left\", \"left\"]"), HasSubstr("names \"left\" twice"));
  EXPECT_THAT(refusal_of_marker("nodes = [\"left\", \"right\"]"),
              HasSubstr("determine 5 of its six motions; give at least three places"));
  EXPECT_THAT(refusal_of_marker("nodes = [\"left\"]\non = \"left\""), HasSubstr("is for a marker on one"));
  EXPECT_THAT(refusal_of_marker("nodes = [\"left\"]\nweights = [1, 2]"), HasSubstr("2 entries for 1 nodes"));
  EXPECT_THAT(refusal_of_marker("points = [[0, 0, 0]]"), HasSubstr("has no shapes on its surface"));
  EXPECT_THAT(refusal_of_marker("points = [[0, 0, 0]]\nlink = \"rigid\""),
              HasSubstr("a rigid link joins interfaces"));
  EXPECT_THAT(refusal_of_marker("within = \"1 mm\""), HasSubstr("needs a position"));
  EXPECT_THAT(refusal_of_marker("on = \"left\"\nweights = [1]"),
              HasSubstr("is for a marker on several nodes"));
  EXPECT_THAT(refusal_of_marker("nodes = [\"a\"]", "mass = 1"), HasSubstr("only superelements have nodes"));
  superelement::write(folder_ / "beam.se.h5", lattice::with_surface(l));
  const std::string body = "superelement = \"beam.se.h5\"";
  EXPECT_THAT(refusal_of_marker("points = [[0, 0.1, 0], [0, 0.11, 0], [1, 0, 0]]", body),
              HasSubstr("nearest to the same node of the surface as a point before it"));
  // The lattice's nearest corner is (0.94, 0.41, 0.24).
  EXPECT_THAT(refusal_of_marker("position = [5, 0, 0]\nwithin = \"10 mm\"", body),
              HasSubstr("the sphere holds 0 nodes of the surface, the nearest one lies 4.087 m"));
}

// All of the geometric stiffening or none: the file has none for loads on nodes of the surface.
TEST_F(MechanismFileTest, LoadsOnTheSurfaceOfAStiffenedBodyAreRefused) {
  superelement::Superelement se = lattice::with_surface(lattice::make_lattice(6));
  se.stiffening = lattice::any_stiffening(se.n(), 5);
  superelement::write(folder_ / "beam.se.h5", se);
  const std::string stiffened = "body.beam.fidelity=modal-stiffened";
  const auto refusal_of = [&](const std::vector<std::string>& overrides) {
    return test::refusal_of([&] { read(carried_by_several, overrides); });
  };
  EXPECT_THAT(refusal_of({stiffened}), HasSubstr("marker \"beam.middle\" loads nodes of the surface"));
  EXPECT_EQ(refusal_of({}), "accepted");
  // Places that are looked at only load nothing.
  const std::vector<std::string> looks_only = {stiffened, "joint.pivot.to=beam.left",
                                               "joint.neck.from=beam.right", "force.gust.marker=beam.right",
                                               "force.gust.axes=beam.right"};
  EXPECT_EQ(refusal_of(looks_only), "accepted");
}

}  // namespace
}  // namespace flexura::mbs
