// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Kinematics bends an arm that is swung as its own inertia has it: the load rho A phi'' x of a cantilever deflects its tip by
// 11 q_0 l^4 / (120 E I) with q_0 = rho A l phi'' (J. M. Gere, Mechanics of Materials, table of deflections), a mass there by m phi'' l^4 / (3 E I).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/superelement/file.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

TEST(KinetoElastostatics, OfSwungArmsIsTheClosedForm) {
  const test::Folder folder;
  for (int seed = 1; seed <= 40 && !::testing::Test::HasFailure(); ++seed) {
    mbs::chance::Chance chance(static_cast<std::uint64_t>(seed));
    const double l = chance.between(0.3, 2.0), b = chance.between(0.01, 0.03), h = chance.between(0.01, 0.03),
                 amplitude = chance.between(0.05, 0.5), omega = chance.between(0.5, 3.0),
                 mass = chance.flip(0.5) ? chance.between(0.1, 2.0) : 0.0;
    SCOPED_TRACE(fmt::format("seed {}: l = {}, b = {}, h = {}, amplitude {}, omega {}, mass {}", seed, l, b,
                             h, amplitude, omega, mass));
    constexpr double E = 210e9, rho = 7850.0;
    const std::string arm = fmt::format(
        "[material.m]\nyoung = {}\npoisson = 0.3\ndensity = {}\n[section.s]\ntype = \"rectangle\"\nwidth = "
        "{}\nheight = "
        "{}\n[node.a]\nposition = [0, 0, 0]\n[node.b]\nposition = [{}, 0, 0]\n[member.m]\nnodes = [\"a\", "
        "\"b\"]\n"
        "elements = 4\n[interface.a]\n[interface.b]\n[modes]\ncount = 8\n",
        E, rho, b, h, l);
    const bool is_part = chance.flip(0.8);
    std::string scene = "gravity = [0, 0, 0]\n[body.arm]\n";
    if (is_part) {
      superelement::write(
          folder / "arm.se.h5",
          reduce::reduce(reduce::read_beam_part(folder.write("arm.toml", arm), {})).superelement);
      scene += "superelement = \"arm.se.h5\"\n";
    } else {
      scene += fmt::format(
          "fidelity = \"beam\"\n[body.arm.beam]\nto = [{}, 0, 0]\nelements = 4\nyoung = {}\npoisson = "
          "0.3\ndensity = {}\n"
          "width = {}\nheight = {}\n[body.arm.marker.a]\non = \"root\"\n[body.arm.marker.b]\non = \"tip\"\n",
          l, E, rho, b, h);
    }
    scene += fmt::format(
        "[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"arm.a\"\ndrive = \"{}*sin({}*t)\"\n"
        "[body.turned]\nmass = 1\ninertia = [1, 1, 1]\n[joint.k]\ntype = \"revolute\"\nfrom = \"ground\"\nto "
        "= \"turned\"\n"
        "drive = \"{}*sin({}*t)\"\n"
        "[measure.w]\ntype = \"position\"\nfrom = \"turned\"\nto = \"arm.b\"\ndirection = [0, 1, 0]\n"
        "[solver]\nmethod = \"kinematics\"\nend_time = {}\noutput_step = {}\n",
        amplitude, omega, amplitude, omega, 3.0 / omega, 0.5 / omega);
    if (mass > 0.0)
      scene += fmt::format(
          "[body.mass]\nmass = {}\n[joint.m]\ntype = \"fixed\"\nfrom = \"arm.b\"\nto = \"mass\"\n", mass);
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("m.toml", scene));
    const auto which = mbs::select_quantities(*p.mechanism, {"w"});
    const auto scratch = p.mechanism->make_scratch();
    const double A = b * h, I = h * b * b * b / 12.0;  // width along y
    const double per_acceleration =
        (11.0 * rho * A * std::pow(l, 5) / 120.0 + mass * std::pow(l, 4) / 3.0) / (E * I);
    const double greatest = per_acceleration * amplitude * omega * omega;
    mbs::RunCallbacks callbacks;
    int rows = 0;
    callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
      Eigen::VectorXd w(1);
      p.mechanism->evaluate(which, s, v_dot, *scratch, w);
      // phi'' = -a omega^2 sin. Shear adds E I / (G A_s l^2) and centrifugal loads phi'^2 by the frequency's square: below 1 % here.
      EXPECT_NEAR(w(0), per_acceleration * amplitude * omega * omega * std::sin(omega * s.t), 0.01 * greatest)
          << s.t;
      ++rows;
    };
    EXPECT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
    EXPECT_EQ(rows, 7);
  }
}

}  // namespace
}  // namespace flexura::properties
