// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every frame, load and fidelity: the section forces of a cut are what a joint there carries.  The judge is the same frame in two
// bodies with a fixed joint between them, whose reaction comes from the balance of bodies and knows of no section.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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
using Vector6d = Eigen::Matrix<double, 6, 1>;

std::string list(const Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

// Members one behind the other, and side branches at their nodes; the cut is inside a member of the row, at a node of its mesh.
struct Frame {
  std::vector<Vector3d> nodes;                     // of the row
  std::vector<std::pair<int, Vector3d>> branches;  // from a node of the row
  std::vector<int> elements;                       // of each member of the row
  std::vector<Vector3d> line_force;                // on each, of the load case "lines"
  std::string sections;                            // and materials
  std::vector<std::string> section_of;
  int cut = 0, at = 1;  // member, and how many of its elements lie before it
  int modes = 0;        // of each part

  double share() const { return static_cast<double>(at) / elements[static_cast<std::size_t>(cut)]; }
  Vector3d place() const {
    const auto k = static_cast<std::size_t>(cut);
    return nodes[k] + share() * (nodes[k + 1] - nodes[k]);
  }
  // Columns: x along the member, z as near to B's z as can be.
  Matrix3d axes() const {
    const auto k = static_cast<std::size_t>(cut);
    Matrix3d R;
    R.col(0) = (nodes[k + 1] - nodes[k]).normalized();
    R.col(2) = (Vector3d::UnitZ() - R(2, 0) * R.col(0)).normalized();
    R.col(1) = R.col(2).cross(R.col(0));
    return R;
  }
};

Frame random_frame(Chance& chance) {
  Frame out;
  out.sections = "[material.m]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = \"7850 kg/m^3\"\n";
  for (int k = 0; k < 2; ++k) {
    const double width = chance.between(0.03, 0.08);
    out.sections += fmt::format("[section.s{}]\nmaterial = \"m\"\n", k);
    const double height = chance.between(0.03, 0.08);
    out.sections += chance.flip(0.5)
                        ? fmt::format("type = \"rectangle\"\nwidth = {}\nheight = {}\n", width, height)
                        : fmt::format("type = \"hollow_circle\"\nouter_diameter = {}\ninner_diameter = {}\n",
                                      width, chance.between(0.5, 0.9) * width);
  }
  const int n = 1 + chance.below(3);
  out.nodes.push_back(chance.vector(0.5));
  for (int k = 0; k < n; ++k) {
    Vector3d along = chance.direction();
    while (std::abs(along.z()) > 0.9) along = chance.direction();
    out.nodes.push_back(out.nodes.back() + chance.between(0.4, 1.2) * along);
    out.elements.push_back(2 + chance.below(5));
    out.line_force.push_back(chance.vector(200.0));
    out.section_of.push_back(fmt::format("s{}", chance.below(2)));
  }
  for (int k = 0; k <= n; ++k)
    if (chance.flip(0.3))
      out.branches.emplace_back(k, out.nodes[static_cast<std::size_t>(k)] + chance.vector(0.5));
  out.cut = chance.below(n);
  out.at = 1 + chance.below(out.elements[static_cast<std::size_t>(out.cut)] - 1);
  out.modes = chance.below(12);
  return out;
}

enum class Side { whole, before, behind };

// Nodes n0 ... of the row, "cut" between; interfaces at the ends.
std::string part_text(const Frame& f, Side side, int modes) {
  std::string text = f.sections;
  const int n = static_cast<int>(f.elements.size());
  const auto node = [&](const std::string& name, const Vector3d& p) {
    text += fmt::format("[node.{}]\nposition = {}\n", name, list(p));
  };
  const auto member = [&](int k, const std::string& from, const std::string& to, int elements) {
    const auto i = static_cast<std::size_t>(k);
    text += fmt::format("[member.m{}]\nnodes = [\"{}\", \"{}\"]\nsection = \"{}\"\nelements = {}\n", k, from,
                        to, f.section_of[i], elements);
    text += fmt::format("[load.l{0}]\ncase = \"lines\"\nmember = \"m{0}\"\nline_force = {1}\n", k,
                        list(f.line_force[i]));
  };
  const int first = side == Side::behind ? f.cut + 1 : 0, last = side == Side::before ? f.cut : n;
  for (int k = first; k <= last; ++k) node(fmt::format("n{}", k), f.nodes[static_cast<std::size_t>(k)]);
  if (side != Side::whole) node("cut", f.place());
  for (int k = 0; k < n; ++k) {
    const int elements = f.elements[static_cast<std::size_t>(k)];
    if (k != f.cut || side == Side::whole) {
      if (k >= first && k < last) member(k, fmt::format("n{}", k), fmt::format("n{}", k + 1), elements);
    } else if (side == Side::before) {
      member(k, fmt::format("n{}", k), "cut", f.at);
    } else {
      member(k, "cut", fmt::format("n{}", k + 1), elements - f.at);
    }
  }
  for (std::size_t b = 0; b < f.branches.size(); ++b) {
    const auto& [from, to] = f.branches[b];
    if (from < first || from > last) continue;
    node(fmt::format("b{}", b), to);
    text +=
        fmt::format("[member.b{0}]\nnodes = [\"n{1}\", \"b{0}\"]\nsection = \"s0\"\nelements = 2\n", b, from);
    text += fmt::format("[mass.b{}]\nnode = \"b{}\"\nmass = 3\n", b, b);
  }
  if (side != Side::behind) text += "[interface.n0]\n";
  if (side != Side::before) text += fmt::format("[interface.n{}]\n", n);
  if (side != Side::whole) text += "[interface.cut]\n";
  return text + fmt::format("[modes]\ncount = {}\n", modes);
}

// How the frame stands or moves.
struct Scene {
  std::string name;
  bool spins = false;      // about an axis through its first node, at a constant rate; else it is held there
  bool both_ends = false;  // held at its last node, too
  bool starts_undeformed = false;
  Vector3d gravity = Vector3d::Zero(), axis = Vector3d::UnitZ(), tip = Vector3d::Zero();
  double rate = 0.0, lines = 0.0;
};

std::string scene_text(const Frame& f, const Scene& scene, bool split, const std::string& body_keys) {
  const int n = static_cast<int>(f.elements.size());
  const std::string last = split ? "behind" : "whole", first = split ? "before" : "whole";
  Matrix3d E;  // of the axis the frame turns about
  E.col(2) = scene.axis;
  E.col(0) = scene.axis.unitOrthogonal();
  const std::string axes = fmt::format("axis = {}\nx_axis = {}\n", list(E.col(2)), list(E.col(0)));
  std::string text =
      fmt::format("gravity = {}\n[ground.marker.o]\nposition = {}\n{}[ground.marker.end]\nposition = {}\n",
                  list(scene.gravity), list(f.nodes.front()), axes, list(f.nodes.back()));
  const std::string cut_axes =
      fmt::format("on = \"cut\"\naxis = {}\nx_axis = {}\n", list(f.axes().col(2)), list(f.axes().col(0)));
  for (const std::string& body :
       split ? std::vector<std::string>{"before", "behind"} : std::vector<std::string>{"whole"}) {
    text += fmt::format("[body.{0}]\nsuperelement = \"{0}.se.h5\"\n{1}", body, body_keys);
    if (body != "behind") text += fmt::format("[body.{}.marker.o]\non = \"n0\"\n{}", body, axes);
    if (split) text += fmt::format("[body.{}.marker.c]\n{}", body, cut_axes);
    text += fmt::format(
        "[force.lines_{0}]\ntype = \"distributed_load\"\nbody = \"{0}\"\nload = \"lines\"\nfactor = "
        "{1:.17g}\n",
        body, scene.lines);
  }
  if (!split)
    text +=
        fmt::format("[body.whole.section_point.c]\nmember = \"m{}\"\nshare = {:.17g}\n", f.cut, f.share());
  text += fmt::format("[joint.root]\ntype = \"{}\"\nfrom = \"ground.o\"\nto = \"{}.o\"\n",
                      scene.spins ? "revolute" : "fixed", first);
  if (scene.spins && scene.starts_undeformed)
    text +=
        fmt::format("drive = \"{0:.17g} * t + {1:.17g} * t^2\"\n", scene.rate, 0.5 * scene.rate * scene.rate);
  else if (scene.spins)
    text += fmt::format("drive = \"{:.17g} * t\"\n", scene.rate);
  if (scene.both_ends)
    text += fmt::format("[joint.end]\ntype = \"fixed\"\nfrom = \"ground.end\"\nto = \"{}.n{}\"\n", last, n);
  if (split) text += "[joint.cut]\ntype = \"fixed\"\nfrom = \"before.c\"\nto = \"behind.c\"\n";
  text += fmt::format(
      "[force.tip]\ntype = \"force\"\nmarker = \"{}.n{}\"\nx = {:.17g}\ny = {:.17g}\nz = {:.17g}\n", last, n,
      scene.tip.x(), scene.tip.y(), scene.tip.z());
  return text + fmt::format("[solver]\nend_time = 1\ninitial_deformation = \"{}\"\n",
                            scene.starts_undeformed ? "none" : "quasi_static");
}

Vector6d values(const mbs::PreparedMechanism& p, const std::string& of,
                const std::vector<std::string>& components) {
  const std::vector<mbs::OutputInfo> infos = p.mechanism->quantities();
  std::vector<int> which;
  for (const std::string& component : components)
    for (std::size_t i = 0; i < infos.size(); ++i)
      if (infos[i].name == of + "." + component) which.push_back(static_cast<int>(i));
  Eigen::VectorXd out(6);
  const auto scratch = p.mechanism->make_scratch();
  p.mechanism->evaluate(which, p.state, p.v_dot, *scratch, out);
  return out;
}

void expect_balance(const Frame& frame, const Scene& scene, int modes, double tolerance,
                    const std::string& body_keys = "") {
  const test::Folder folder;
  std::string parts;
  for (const auto& [name, side] :
       {std::pair{"whole", Side::whole}, {"before", Side::before}, {"behind", Side::behind}}) {
    const std::string text = part_text(frame, side, modes);
    parts += text + "----\n";
    const auto file = folder.write(fmt::format("{}.toml", name), text);
    superelement::write(folder / fmt::format("{}.se.h5", name),
                        reduce::reduce(reduce::read_beam_part(file)).superelement);
  }
  const std::string one_text = scene_text(frame, scene, false, body_keys),
                    two_text = scene_text(frame, scene, true, "");
  SCOPED_TRACE(parts + one_text + "----\n" + two_text);
  const mbs::PreparedMechanism one = mbs::prepare(folder.write("one.toml", one_text)),
                               two = mbs::prepare(folder.write("two.toml", two_text));
  const Vector6d found = values(one, "whole.c", {"N", "V_y", "V_z", "T", "M_y", "M_z"}),
                 right = -values(two, "cut",
                                 {"force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"});
  // What the undeformed frame's inertia balances is the loads, whatever little reaches the cut at that instant.
  const double size = right.norm() + (scene.starts_undeformed ? scene.tip.norm() : 0.0);
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(found(k), right(k), tolerance * size) << "component " << k;
}

class Cuts : public testing::Test {
 protected:
  // Until one fails; each prints its seed and its files.
  template <class Body>
  void for_seeds(int first, int count, const Body& body) {
    for (int seed = first; seed < first + count && !HasFailure(); ++seed) {
      SCOPED_TRACE(fmt::format("seed {}", seed));
      Chance chance(static_cast<std::uint64_t>(seed));
      body(chance);
    }
  }
};

Scene at_rest(Chance& chance) {
  Scene scene;
  scene.gravity = chance.vector(0.02);
  scene.tip = chance.vector(0.3);
  scene.lines = chance.between(-1e-3, 1e-3);
  scene.both_ends = chance.flip(0.4);
  return scene;
}

// Loads are a thousandth of what such frames bear, so that slopes, by which two bodies turn loads otherwise than one, are
// below this; of_deformation is kept in single precision.
constexpr double kTolerance = 5e-4;

// Of what the frame in one piece is made: any fidelity, with every mode that its superelement has or with few.
std::string random_keys(Chance& chance) {
  std::string keys;
  const int fidelity = chance.below(4);
  if (fidelity == 0) return "fidelity = \"static\"\n";
  if (fidelity == 1) keys = "fidelity = \"ked\"\n";
  if (chance.flip(0.3)) keys += "frame = \"joint_fixed\"\n";
  if (chance.flip(0.6)) keys += fmt::format("modes = {}\n", 1 + chance.below(4));
  return keys;
}

TEST_F(Cuts, AreInBalanceWithWeightLineAndPointLoads) {
  for_seeds(1, 120, [](Chance& chance) {
    const Frame frame = random_frame(chance);
    const Scene scene = at_rest(chance);
    // What two walls bear follows from how the frame gives way, which takes all modes, or those of its loads.
    std::string keys = random_keys(chance);
    if (scene.both_ends && keys.find("static") == std::string::npos) keys.clear();
    expect_balance(frame, scene, frame.modes, kTolerance, keys);
  });
}

TEST_F(Cuts, AreInBalanceWithCentrifugalLoads) {
  for_seeds(1001, 60, [](Chance& chance) {
    const Frame frame = random_frame(chance);
    Scene scene;
    scene.spins = true;
    scene.axis = chance.direction();
    scene.rate = chance.between(0.1, 0.5);
    expect_balance(frame, scene, frame.modes, kTolerance, random_keys(chance));
  });
}

// The first instant of a motion that takes hold of the undeformed frame: all is inertia.  With every mode.
TEST_F(Cuts, AreInBalanceWithInertia) {
  for_seeds(2001, 20, [](Chance& chance) {
    const Frame frame = random_frame(chance);
    Scene scene = at_rest(chance);
    scene.both_ends = false;
    scene.spins = scene.starts_undeformed = true;
    scene.axis = chance.direction();
    scene.rate = chance.between(0.1, 0.5);
    expect_balance(frame, scene, 1000, kTolerance);
  });
}

// Closed forms, w = rho A g: w (L - x), w (L - x)^2 / 2 of a cantilever, w (L - x) of a mast.  The default mesh and modes.
TEST_F(Cuts, OfACantileverAndAMastUnderTheirWeight) {
  constexpr double L = 2.0, w = 7850.0 * 0.05 * 0.05 * 9.81;
  const auto forces = [&](const Vector3d& gravity, int modes, const std::string& keys, double share) {
    const test::Folder folder;
    const auto file = folder.write(
        "beam.toml",
        fmt::format(
            "[material.m]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = \"7850 kg/m^3\"\n[section.s]\n"
            "type = \"rectangle\"\nwidth = 0.05\nheight = 0.05\n[node.root]\nposition = [0, 0, "
            "0]\n[node.tip]\nposition = [2, 0, 0]\n[member.arm]\nnodes = [\"root\", "
            "\"tip\"]\n[interface.root]\n[interface.tip]\n[modes]\ncount = {}\n",
            modes));
    superelement::write(folder / "beam.se.h5", reduce::reduce(reduce::read_beam_part(file)).superelement);
    const mbs::PreparedMechanism p = mbs::prepare(folder.write(
        "arm.toml",
        fmt::format(
            "gravity = {}\n[ground.marker.wall]\n[body.arm]\nsuperelement = "
            "\"beam.se.h5\"\n{}[body.arm.section_point.c]\nposition = [{:.17g}, 0, 0]\n[joint.clamp]\ntype = "
            "\"fixed\"\nfrom = \"ground.wall\"\nto = \"arm.root\"\n[solver]\nend_time = "
            "1\ninitial_deformation = "
            "\"quasi_static\"\n",
            list(gravity), keys, share * L)));
    return values(p, "arm.c", {"N", "V_y", "V_z", "T", "M_y", "M_z"});
  };
  for (const int modes : {0, 20})
    for (const std::string keys : {"", "modes = 1\n"})
      for (const double share : {0.0, 0.5, 0.3137}) {  // the last between the places that are kept
        SCOPED_TRACE(fmt::format("{} modes, {}at {}", modes, keys, share));
        const double rest = L * (1.0 - share);
        const Vector6d lying = forces({0.0, 0.0, -9.81}, modes, keys, share),
                       hanging = forces({9.81, 0.0, 0.0}, modes, keys, share);
        // It sags by 0.07 % of its length: that much turns loads.
        EXPECT_NEAR(std::abs(lying(2)), w * rest, 1e-3 * w * L);
        EXPECT_NEAR(std::abs(lying(4)), 0.5 * w * rest * rest, 1e-3 * w * L);
        EXPECT_NEAR(lying(0), 0.0, 2e-3 * w * L);
        EXPECT_NEAR(hanging(0), w * rest, 1e-6 * w * L);
      }
}

}  // namespace
}  // namespace flexura::properties
