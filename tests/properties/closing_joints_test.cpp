// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A joint's coordinate is the same thing wherever the tree runs: driven, coupled, held by a formula or pushed, a linkage moves alike
// with the joint in the tree, closing the loop, or as a connection of which the program decides.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mbs/solver/linear/linearise.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/cases/case_run.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;

// Four links between two pins of the ground, in the xy plane: two freedoms.
struct FiveBar {
  std::array<Eigen::Vector2d, 5> point;
  std::array<double, 4> mass;
  int prescribed = 0, other = 0;  ///< joints 0 to 4
  std::string law;                ///< keys of the driven joint
  std::string constraint;         ///< a table

  explicit FiveBar(Chance& chance) {
    const auto near = [&](double x, double y) {
      return Eigen::Vector2d(x + chance.between(-0.15, 0.15), y + chance.between(-0.15, 0.15));
    };
    point = {Eigen::Vector2d(0, 0), near(-0.3, 0.8), near(0.5, 1.3), near(1.3, 0.9), Eigen::Vector2d(1.2, 0)};
    for (double& m : mass) m = chance.between(0.5, 2);
    prescribed = chance.below(5);
    other = (prescribed + 1 + chance.below(4)) % 5;
  }
  double direction(int link) const {
    const Eigen::Vector2d along =
        point[static_cast<std::size_t>(link + 1)] - point[static_cast<std::size_t>(link)];
    return std::atan2(along.y(), along.x());
  }
  // Of link j against that before it, where the ground is along x at either end.
  double angle(int joint) const {
    return (joint < 4 ? direction(joint) : 0.0) - (joint > 0 ? direction(joint - 1) : 0.0);
  }
  // `kind`: "joint", "connection", or "cut" for joints of which the prescribed one closes the loop.
  std::string text(const std::string& kind) const {
    std::string out = fmt::format(
        "gravity = [0, -9.81, 0]\n[ground.marker.p0]\n[ground.marker.p4]\nposition = [{}, {}, 0]\n",
        point[4].x(), point[4].y());
    for (int i = 0; i < 4; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double length = (point[k + 1] - point[k]).norm();
      out += fmt::format(
          "[body.b{0}]\nmass = {1}\ncenter = [{2}, 0, 0]\ninertia = [0.1, 0.1, 0.1]\nposition = [{3:.17g}, "
          "{4:.17g}, "
          "0]\nrotation = [0, 0, {5:.17g}]\n[body.b{0}.marker.p{0}]\n[body.b{0}.marker.p{6}]\nposition = "
          "[{7:.17g}, 0, 0]\n",
          i, mass[k], 0.4 * length, point[k].x(), point[k].y(), direction(i), i + 1, length);
    }
    for (int j = 0; j < 5; ++j) {
      const std::string before = j == 0 ? "ground" : fmt::format("b{}", j - 1),
                        after = j == 4 ? "ground" : fmt::format("b{}", j);
      const bool is_prescribed = j == prescribed;
      out += fmt::format("[{}.j{}]\ntype = \"revolute\"\nfrom = \"{}.p{}\"\nto = \"{}.p{}\"\n",
                         kind == "connection" ? kind : "joint", j, before, j, after, j);
      if (is_prescribed && kind == "cut") out += "cut = true\n";
      if (is_prescribed) out += law;
      // Coupled angles are counted from what is given.
      if (!constraint.empty() && (j == other || (is_prescribed && kind != "cut")))
        out += fmt::format("angle = {:.17g}\n", angle(j));
    }
    return out + constraint + "[solver]\nend_time = 0.5\noutput_step = 0.1\ntolerance = 1e-9\n";
  }
};

TEST(ClosingJoints, ArePrescribedAsJointsOfTheTree) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    FiveBar bars(chance);
    const int kind = chance.below(6);
    const double from = bars.angle(bars.prescribed), size = chance.between(-0.2, 0.2),
                 w = chance.between(1, 4);
    std::string force = fmt::format("j{}.drive_force", bars.prescribed);
    // Some follow an input, some time.
    // It sets off at rest, so that no speed of the other freedom is chosen for it.
    const std::string law =
        fmt::format("{:.17g}*sin({:.17g}*t){}", size, w, kind == 1 || kind == 2 ? "" : "^2");
    const std::string given = chance.flip(0.5) ? "u" : law;
    if (kind == 0) bars.law = fmt::format("drive = \"{:.17g} + {}\"\n", from, given);
    if (kind == 1) bars.law = fmt::format("drive_speed = \"{}\"\n", given);
    if (kind == 2) bars.law = fmt::format("drive_acceleration = \"{}\"\n", given);
    if (kind >= 3) {
      const double factor = chance.either_sign(0.3, 2), at_start = from + factor * bars.angle(bars.other);
      if (kind == 3)
        bars.constraint = fmt::format(
            "[constraint.x]\ntype = \"coupler\"\njoints = [\"j{}\", \"j{}\"]\nfactors = [1, {:.17g}]\noffset "
            "= \"{:.17g} + {}\"\n",
            bars.prescribed, bars.other, factor, at_start, given);
      else if (kind == 4)
        bars.constraint = fmt::format(
            "[constraint.x]\ntype = \"expression\"\nunit = \"rad\"\nvalue = \"j{}.angle + {:.17g}*j{}.angle "
            "- {:.17g} - "
            "{}\"\n",
            bars.prescribed, factor, bars.other, at_start, given);
      else
        bars.constraint = fmt::format(
            "[constraint.x]\ntype = \"gear\"\njoint_1 = \"j{}\"\njoint_2 = \"j{}\"\nteeth_1 = 1\nteeth_2 = "
            "{:.17g}\n"
            "internal = {}\noffset = \"{:.17g} + {}\"\n",
            bars.prescribed, bars.other, std::abs(factor), factor < 0, at_start, given);
      force = kind == 4 ? "x.force" : "x.torque_1";
    }
    const std::string input = given == "u" ? fmt::format("[input.u]\nvalue = \"{}\"\n", law) : "";
    const std::vector<std::string> names{"b1.position_x",         "b1.position_y",     "b2.position_x",
                                         "b2.angular_velocity_z", "b2.acceleration_x", force};
    mbs::cases::Series runs[3];
    const char* kinds[] = {"joint", "cut", "connection"};
    for (int k = 0; k < 3; ++k) {
      const std::string text = bars.text(kinds[k]) + input;
      SCOPED_TRACE(fmt::format("seed {}\n{}", seed, text));
      const mbs::PreparedMechanism p = mbs::prepare(folder.write("bars.toml", text));
      if (k == 1) EXPECT_FALSE(p.mechanism->in_tree(bars.prescribed));
      if (k == 2) EXPECT_TRUE(p.mechanism->in_tree(bars.prescribed));
      runs[k] = mbs::cases::simulate(p, names);
      ASSERT_EQ(runs[k].t.size(), 6u);
      for (std::size_t i = 0; k > 0 && i < runs[k].t.size(); ++i) {
        // A hundred times the tolerance is left of motions over the run; accelerations and forces answer with the squared rates of
        // some 10 rad/s and the weight of the bars.
        constexpr double kAllowed[] = {2e-7, 2e-7, 2e-7, 2e-6, 2e-5, 2e-4};
        for (Eigen::Index q = 0; q < 6; ++q)
          EXPECT_NEAR(runs[k].values[i](q), runs[0].values[i](q),
                      kAllowed[q] * std::max(1.0, std::abs(runs[0].values[i](q))))
              << names[static_cast<std::size_t>(q)] << " " << runs[k].t[i];
      }
    }
    if (HasFailure()) return;
  }
}

// A force on the coordinate of a joint that closes the loop moves what it moves with the joint in the tree.
TEST(ClosingJoints, ArePushedInLinearSystemsAsJointsOfTheTree) {
  const test::Folder folder;
  for (int seed = 0; seed < 40; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const FiveBar bars(chance);
    Eigen::MatrixXcd response[2];
    for (int k = 0; k < 2; ++k) {
      std::string text = bars.text(k == 0 ? "joint" : "cut");
      text.replace(0, text.find('\n'), "gravity = [0, 0, 0]");
      // The joint is kept in the tree, or is not there.
      if (k == 0)
        text.insert(text.find('\n', text.find(fmt::format("[joint.j{}]", bars.prescribed))) + 1,
                    "cut = false\n");
      text += fmt::format(
          "[force.k]\ntype = \"joint_spring_damper\"\njoint = \"j{}\"\nstiffness = 30\ndamping = 1\nrest = "
          "{:.17g}\n",
          bars.other, bars.angle(bars.other));
      const mbs::PreparedMechanism p = mbs::prepare(folder.write("bars.toml", text), {});
      ASSERT_EQ(p.mechanism->in_tree(bars.prescribed), k == 0) << text;
      mbs::LineariseOptions options;
      auto scratch = p.mechanism->make_scratch();
      const mbs::CoordinateRef c{bars.prescribed, 0};
      if (k == 0)
        options.inputs = {p.mechanism->joint_places()[static_cast<std::size_t>(bars.prescribed)].i_v};
      else
        options.along = {{"j", p.mechanism->force_along(c, p.state, *scratch)}};
      const auto which =
          mbs::select_quantities(*p.mechanism, {"b1.position_x", "b2.position_y", "b2.acceleration_x"});
      options.outputs = [&](const mbs::State& s, const Eigen::VectorXd& v_dot) {
        Eigen::VectorXd y(3);
        p.mechanism->evaluate(which, s, v_dot, *scratch, y);
        return y;
      };
      options.output_names = {"x", "y", "a"};
      const mbs::LinearSystem system = mbs::linearise(*p.mechanism, p.state, options);
      response[k] = mbs::frequency_response(system, Eigen::VectorXd::Constant(1, 0.7))[0];
    }
    // Derivatives are exact, but for those of a closure's own coordinate: differences to some 1e-9.
    EXPECT_LT((response[1] - response[0]).norm(), 1e-7 * response[0].norm()) << seed;
  }
}

}  // namespace
}  // namespace flexura::properties
