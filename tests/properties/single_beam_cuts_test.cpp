// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every straight beam, mesh and choice of modes, under loads that turn with its deformation or move with it: its section
// forces against the joint that holds it, against what lies beyond the cut and against closed forms.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mbs/solver/start/prepare.hpp"
#include "mbs/superelement/file.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using mbs::chance::Chance;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;
using Vector6d = Eigen::Matrix<double, 6, 1>;

std::string list(const Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

// From Bo along R's first column, its height along the third.
struct Beam {
  Matrix3d R = Matrix3d::Identity();
  double L = 1.0, width = 0.03, height = 0.006,
         line = 0.0;  // line force along z [N/m], of the load case "line"
  int elements = 4, modes = 20;
  std::string keys;  // of the body

  double EI() const { return 210e9 * width * std::pow(height, 3) / 12.0; }
  double mass() const { return 7850.0 * width * height * L; }

  std::string part() const {
    return fmt::format(
        "stiffening = true\n[material.m]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = \"7850 "
        "kg/m^3\"\n[section.s]\ntype = \"rectangle\"\nwidth = {:.17g}\nheight = {:.17g}\n[node.a]\nposition "
        "= "
        "[0, 0, 0]\n[node.b]\nposition = {}\n[member.r]\nnodes = [\"a\", \"b\"]\ndirection = {}\nelements = "
        "{}\n[load.line]\nmember = \"r\"\nline_force = {}\n[interface.a]\n[interface.b]\n[modes]\ncount = "
        "{}\n",
        width, height, list(L * R.col(0)), list(R.col(1)), elements, list(line * R.col(2)), modes);
  }
};

Beam random_beam(Chance& chance) {
  Beam out;
  out.R.col(0) = chance.direction();
  out.R.col(1) = out.R.col(0).cross(chance.direction()).normalized();
  out.R.col(2) = out.R.col(0).cross(out.R.col(1));
  out.L = chance.between(0.5, 2.0);
  out.height = out.L * chance.between(0.005, 0.02);
  out.width = out.height * chance.between(1.5, 5.0);
  out.elements = 2 + chance.below(7);
  out.modes = chance.below(13);
  return out;
}

// Held at "a" by a joint whose axes are the member's or, "revolute", have z along `axis` of them.
struct Held {
  Beam beam;
  Vector3d gravity = Vector3d::Zero(), tip = Vector3d::Zero();  // in the member's axes
  std::string joint = "type = \"fixed\"\n", start = "quasi_static";
  Matrix3d axes = Matrix3d::Identity();  // of the joint, in the member's
  std::vector<double> shares = {0.0};
  bool in_member_axes = false;
};

struct Found {
  std::vector<Vector6d> cuts;  // N, V_y, V_z, T, M_y, M_z
  Vector6d joint;              // force and torque on "a", in the member's axes
};

Found found_of(const Held& h) {
  const test::Folder folder;
  const Beam& beam = h.beam;
  superelement::write(
      folder / "b.se.h5",
      reduce::reduce(reduce::read_beam_part(folder.write("beam.toml", beam.part()))).superelement);
  const Matrix3d J = beam.R * h.axes;
  std::string text = fmt::format(
      "gravity = {0}\n[ground.marker.o]\naxis = {1}\nx_axis = {2}\n[body.b]\nsuperelement = "
      "\"b.se.h5\"\n{3}[body.b.marker.o]\non = \"a\"\naxis = {1}\nx_axis = {2}\n[joint.j]\nfrom = "
      "\"ground.o\"\nto = \"b.o\"\n{4}",
      list(beam.R * h.gravity), list(J.col(2)), list(J.col(0)), beam.keys, h.joint);
  const Vector3d tip = beam.R * h.tip;
  text +=
      fmt::format("[force.tip]\ntype = \"force\"\nmarker = \"b.b\"\nx = {:.17g}\ny = {:.17g}\nz = {:.17g}\n",
                  tip.x(), tip.y(), tip.z());
  if (beam.line != 0.0) text += "[force.line]\ntype = \"distributed_load\"\nbody = \"b\"\nload = \"line\"\n";
  for (std::size_t k = 0; k < h.shares.size(); ++k)
    text += fmt::format("[body.b.section_point.p{}]\nmember = \"r\"\nshare = {:.17g}\n{}", k, h.shares[k],
                        h.in_member_axes ? "axes = \"member\"\n" : "");
  text += fmt::format("[solver]\nend_time = 1\ninitial_deformation = \"{}\"\n", h.start);
  SCOPED_TRACE(beam.part() + "----\n" + text);
  const mbs::PreparedMechanism p = mbs::prepare(folder.write("m.toml", text));
  const std::vector<mbs::OutputInfo> infos = p.mechanism->quantities();
  const auto scratch = p.mechanism->make_scratch();
  const auto values = [&](const std::string& of, const std::vector<std::string>& components) {
    std::vector<int> which;
    for (const std::string& component : components)
      for (std::size_t i = 0; i < infos.size(); ++i)
        if (infos[i].name == of + "." + component) which.push_back(static_cast<int>(i));
    Vector6d out;
    p.mechanism->evaluate(which, p.state, p.v_dot, *scratch, out);
    return out;
  };
  Found out;
  for (std::size_t k = 0; k < h.shares.size(); ++k)
    out.cuts.push_back(values(fmt::format("b.p{}", k), {"N", "V_y", "V_z", "T", "M_y", "M_z"}));
  const Vector6d joint = values("j", {"force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"});
  out.joint << h.axes * joint.head<3>(), h.axes * joint.tail<3>();
  return out;
}

void expect_near(const Vector6d& found, const Vector6d& right, double tolerance) {
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(found(k), right(k), tolerance) << "component " << k;
}

class SingleBeamCuts : public testing::Test {
 protected:
  template <class Body>
  void for_seeds(int first, int count, const Body& body) {
    for (int seed = first; seed < first + count && !HasFailure(); ++seed) {
      SCOPED_TRACE(fmt::format("seed {}", seed));
      Chance chance(static_cast<std::uint64_t>(seed));
      body(chance);
    }
  }
};

std::string random_modes(Chance& chance) {
  std::string keys;
  if (chance.flip(0.5)) keys += "frame = \"joint_fixed\"\n";
  if (chance.flip(0.6)) keys += fmt::format("modes = {}\n", 1 + chance.below(6));
  return keys;
}

// Columns pressed up to half of what buckles them, or pulled by three times that, pushed aside by a hundredth of their length: the
// tension's share of the bending moment is up to its whole size.  Slopes of a hundredth leave 1e-4 of it, and as much of N, which
// the shear force sees.
TEST_F(SingleBeamCuts, OfPressedAndPulledColumnsAreInBalance) {
  for_seeds(1, 120, [](Chance& chance) {
    Held h;
    h.beam = random_beam(chance);
    const double L = h.beam.L, aside = 0.01 * 3.0 * h.beam.EI() / (L * L),
                 P = chance.between(-0.5, 3.0) * std::numbers::pi * std::numbers::pi * h.beam.EI() /
                     (4.0 * L * L);
    const double share = chance.between(-1.0, 1.0);
    h.tip = {P, 0.0, share * aside};
    h.beam.line = (1.0 - std::abs(share)) * aside / L;
    h.beam.keys = "fidelity = \"modal-stiffened\"\n" + random_modes(chance);
    h.shares = {0.0, 1.0};
    const Found found = found_of(h);
    const double force = std::abs(P) + aside;
    Vector6d scale;
    scale << force, force, force, force * L, force * L, force * L;
    const Vector6d foot = found.cuts[0] + found.joint;
    EXPECT_LT(foot.head<3>().norm(), 1e-4 * force);
    EXPECT_LT(foot.tail<3>().norm(), 1e-3 * aside * L);
    // At the tip nothing turns, whatever the beam does before it.
    EXPECT_LT(found.cuts[1].tail<3>().norm(), 1e-3 * aside * L);

    // In a frame that its foot holds the member's axes stand still, and what lies beyond a cut is known.
    if (h.beam.keys.find("joint_fixed") == std::string::npos) return;
    const double at = chance.between(0.0, 1.0);
    h.shares = {at};
    h.in_member_axes = true;
    const Vector3d beyond = h.tip + Vector3d(0.0, 0.0, h.beam.line * (1.0 - at) * L);
    EXPECT_LT((found_of(h).cuts[0].head<3>() - beyond).norm(), 1e-4 * force);
  });
}

// Blades on a hub, pulled by their spin and bent by their weight along its axis.
TEST_F(SingleBeamCuts, OfSpinningBladesAreInBalance) {
  for_seeds(1001, 100, [](Chance& chance) {
    Held h;
    h.beam = random_beam(chance);
    const double L = h.beam.L, line = 0.01 * 8.0 * h.beam.EI() / std::pow(L, 3);
    h.gravity = {0.0, 0.0, -line * L / h.beam.mass()};
    const double spin = chance.between(0.5, 3.0) * std::sqrt(h.beam.EI() / (h.beam.mass() * std::pow(L, 3)));
    h.joint = fmt::format("type = \"revolute\"\ndrive = \"{:.17g} * t\"\n", spin);
    h.beam.keys = "fidelity = \"modal-stiffened\"\n" + random_modes(chance);
    h.shares = {0.0, 1.0};
    const Found found = found_of(h);
    const double pull = h.beam.mass() * spin * spin * L / 2.0;
    const Vector6d root = found.cuts[0] + found.joint;
    EXPECT_LT(root.head<3>().norm(), 2e-4 * (pull + line * L));
    EXPECT_LT(root.tail<3>().norm(), 2e-3 * line * L * L / 2.0);
    EXPECT_LT(found.cuts[1].tail<3>().norm(), 2e-3 * line * L * L / 2.0);
    EXPECT_NEAR(found.cuts[0](2), -line * L, 2e-4 * (pull + line * L));
  });
}

// A spinning rod, whatever inertia its equations of motion know: rho A w^2 (L^2 - x^2) / 2, and nothing else.
TEST_F(SingleBeamCuts, OfASpinningRodOfAnyFidelityAndCoupling) {
  for_seeds(2001, 60, [](Chance& chance) {
    Held h;
    h.beam = random_beam(chance);
    const int which = chance.below(4);
    h.beam.keys = which == 0   ? "fidelity = \"static\"\n"
                  : which == 1 ? "fidelity = \"ked\"\n" + random_modes(chance)
                  : which == 2 ? "coupling = \"constant\"\n" + random_modes(chance)
                               : "coupling = \"partial\"\n" + random_modes(chance);
    const double L = h.beam.L, spin = chance.between(0.5, 20.0);
    h.joint = fmt::format("type = \"revolute\"\ndrive = \"{:.17g} * t\"\n", spin);
    h.shares = {0.0, chance.between(0.0, 1.0), 1.0};
    const Found found = found_of(h);
    const double pull = h.beam.mass() * spin * spin * L / 2.0;
    for (std::size_t k = 0; k < 3; ++k) {
      Vector6d right = Vector6d::Zero();
      right(0) = pull * (1.0 - h.shares[k] * h.shares[k]);
      // It stretches by less than 1e-4 of its length, and turns nowhere.
      expect_near(found.cuts[k], right, 2e-4 * pull);
    }
  });
}

// A one-way body is let go undeformed: what is beyond a cut moves and weighs, and beyond the free end there is nothing.
TEST_F(SingleBeamCuts, OfOneWayBodiesEndAtTheirFreeEnd) {
  for_seeds(3001, 60, [](Chance& chance) {
    Held h;
    h.beam = random_beam(chance);
    h.beam.keys = "fidelity = \"ked\"\n" + random_modes(chance);
    h.gravity = chance.vector(10.0);
    h.start = "none";
    h.shares = {1.0};
    expect_near(found_of(h).cuts[0], Vector6d::Zero(), 1e-5 * h.beam.mass() * h.gravity.norm());
  });
}

// And it starts where its loads hold it where that is asked for: under its weight as a cantilever, w (L - x)^2 / 2.
TEST_F(SingleBeamCuts, OfAOneWayBodyThatStartsAtRest) {
  for_seeds(4001, 30, [](Chance& chance) {
    Held h;
    h.beam = random_beam(chance);
    h.beam.keys = "fidelity = \"ked\"\n" + random_modes(chance);
    const double L = h.beam.L, line = 0.001 * 8.0 * h.beam.EI() / std::pow(L, 3),
                 at = chance.between(0.0, 1.0);
    h.gravity = {0.0, 0.0, -line * L / h.beam.mass()};
    h.shares = {at};
    const Vector6d cut = found_of(h).cuts[0];
    EXPECT_NEAR(cut(2), -line * L * (1.0 - at), 1e-4 * line * L);
    EXPECT_NEAR(cut(4), line * L * L * (1.0 - at) * (1.0 - at) / 2.0, 1e-4 * line * L * L);
  });
}

// Closed form of a clamped column under the tension P and the tip force F: the foot's moment F tanh(k L) / k, k^2 = P / EI, with
// the tangent where it is pressed.
TEST_F(SingleBeamCuts, OfTheColumnsClosedForm) {
  for (const double load : {-0.5, 0.3, 2.0}) {
    Held h;
    h.beam.elements = 10;
    h.beam.modes = 20;
    h.beam.keys = "fidelity = \"modal-stiffened\"\n";
    const double L = 1.0, EI = h.beam.EI(), P = load * std::numbers::pi * std::numbers::pi * EI / 4.0,
                 k = std::sqrt(std::abs(P) / EI), F = 0.01 * 3.0 * EI;
    h.tip = {P, 0.0, F};
    const double right = F * (P < 0.0 ? std::tan(k * L) : std::tanh(k * L)) / k;
    for (const std::string modes :
         {"", "frame = \"joint_fixed\"\n", "frame = \"joint_fixed\"\nmodes = 6\n"}) {
      SCOPED_TRACE(fmt::format("{} {}", load, modes));
      Held one = h;
      one.beam.keys += modes;
      // Six modes of the clamped column, of which two or more bend it the other way, lack 12 / 11^4 or less of its deflection.
      EXPECT_NEAR(std::abs(found_of(one).cuts[0](4)), right, 3e-3 * right);
    }
  }
}

// A position beside the beam: told from a hundredth of its length on, refused beyond its length.
TEST_F(SingleBeamCuts, OfAPlaceBesideTheBeam) {
  const test::Folder folder;
  superelement::write(
      folder / "b.se.h5",
      reduce::reduce(reduce::read_beam_part(folder.write("beam.toml", Beam{}.part()))).superelement);
  const auto notes = [&](double off) {
    const auto file = folder.write(
        "m.toml",
        fmt::format(
            "[ground.marker.o]\n[body.b]\nsuperelement = \"b.se.h5\"\n[body.b.section_point.p]\nposition "
            "= [0.5, {}, 0]\n[joint.j]\ntype = \"fixed\"\nfrom = \"ground.o\"\nto = \"b.a\"\n",
            off));
    return fmt::format("{}", fmt::join(mbs::prepare(file).notes, "\n"));
  };
  EXPECT_THAT(notes(0.009), Not(HasSubstr("from member \"r\"")));
  EXPECT_THAT(notes(0.02), HasSubstr("0.02 m from member \"r\"; its section force is that at 0.5 m of it"));
  EXPECT_THAT(
      [&] { notes(3.0); },
      ThrowsMessage<std::exception>(HasSubstr("3 m from member \"r\", which is 1 m long and the nearest")));
}

}  // namespace
}  // namespace flexura::properties
