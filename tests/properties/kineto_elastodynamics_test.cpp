// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Driven mechanisms whose bodies vibrate about the motion of the undeformed ones: beside modal superposition and beside the
// nonlinear run of stiff bodies.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <filesystem>
#include <vector>

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

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows of a run: times, then the quantities.
std::vector<VectorXd> rows_of(const mbs::PreparedMechanism& p, const std::vector<std::string>& names) {
  const auto which = mbs::select_quantities(*p.mechanism, names);
  const auto scratch = p.mechanism->make_scratch();
  std::vector<VectorXd> out;
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount&) {
    VectorXd values(static_cast<Eigen::Index>(which.size())), row(1 + values.size());
    p.mechanism->evaluate(which, s, v_dot, *scratch, values);
    row << s.t, values;
    out.push_back(row);
  };
  const mbs::RunResult result = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(result.complete) << result.stopped_because;
  return out;
}

// An arm that is swung by a sin(w t) from rest without deformation: its modes, held at the root, answer the load -M r phi'' of the
// rotation r by q = p a w^2 / (W^2 - w^2) (sin w t - w / W sin W t), p = mode . M r.
TEST(KinetoElastodynamics, OfSwungArmsIsModalSuperposition) {
  const test::Folder folder;
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    mbs::chance::Chance chance(static_cast<std::uint64_t>(seed));
    const double l = chance.between(0.3, 1.0), b = chance.between(0.005, 0.02),
                 h = chance.between(0.02, 0.04);
    const std::string arm = fmt::format(
        "[material.m]\nyoung = 210e9\npoisson = 0.3\ndensity = 7850\n[section.s]\ntype = "
        "\"rectangle\"\nwidth "
        "= {}\nheight = {}\n[node.a]\nposition = [0, 0, 0]\n[node.b]\nposition = [{}, 0, "
        "0]\n[member.m]\nnodes = [\"a\", \"b\"]\nelements = 3\n[interface.a]\n[interface.b]\n[modes]\ncount "
        "= "
        "{}\ndamping = 0.0\n",
        b, h, l, chance.below(3));
    const superelement::Superelement se =
        reduce::reduce(reduce::read_beam_part(folder.write("arm.toml", arm), {})).superelement;
    superelement::write(folder / "arm.se.h5", se);
    // Held at a: the coordinates after its six.
    const Eigen::Index n = se.n() - 6;
    const MatrixXd R = superelement::rigid_motions(se);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(se.K_se.bottomRightCorner(n, n),
                                                                   se.M_se.bottomRightCorner(n, n));
    const VectorXd p = modes.eigenvectors().transpose() * (se.M_se.bottomRows(n) * R.col(5)),
                   W = modes.eigenvalues().cwiseSqrt();
    const Eigen::Index tip = se.interfaces[1].first_dof + 1 - 6;  // u_y of b
    Eigen::Index lowest = 0;
    for (Eigen::Index k = 0; k < n; ++k)
      if (std::abs(p(k)) > 1e-6 * p.cwiseAbs().maxCoeff()) {
        lowest = k;
        break;
      }
    const double w = chance.between(0.1, 0.6) * W(lowest),
                 end = chance.between(1.0, 3.0) * 2.0 * M_PI / W(lowest),
                 amplitude = 1e-3;  // centrifugal loads a^2 beside W^2
    const std::string scene = fmt::format(
        "gravity = [0, 0, 0]\n[body.arm]\nsuperelement = \"arm.se.h5\"\n"
        "[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = "
        "\"arm.a\"\ndrive = \"{0:.17g}*sin({1:.17g}*t)\"\n[body.turned]\nmass = 1\ninertia = [1, 1, "
        "1]\n[joint.k]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"turned\"\ndrive = "
        "\"{0:.17g}*sin({1:.17g}*t)\"\n[measure.w]\ntype = \"position\"\nfrom = \"turned\"\nto = "
        "\"arm.b\"\ndirection = [0, 1, 0]\n[solver]\nmethod = \"ked\"\ntolerance = 1e-5\nend_time = "
        "{2:.17g}\noutput_step = {3:.17g}\n",
        amplitude, w, end, end / 20);
    const auto rows = rows_of(mbs::prepare(folder.write("m.toml", scene)), {"w"});
    ASSERT_GE(rows.size(), 20U);
    double worst = 0.0, size = 0.0;
    for (const VectorXd& row : rows) {
      const double t = row(0);
      double exact = 0.0;
      for (Eigen::Index k = 0; k < n; ++k)
        exact += modes.eigenvectors()(tip, k) * p(k) * amplitude * w * w / (W(k) * W(k) - w * w) *
                 (std::sin(w * t) - w / W(k) * std::sin(W(k) * t));
      worst = std::max(worst, std::abs(row(1) - exact));
      size = std::max(size, std::abs(exact));
    }
    // 1e-5 of the deflection in each of some 300 steps.
    EXPECT_LT(worst, 0.01 * size);
    if (::testing::Test::HasFailure()) return;
  }
}

// The tutorial's four-bar at random speeds with a coupler of random stiffness: what its deformation makes of the rocker's angle and of
// the drive's torque is that of the nonlinear run, but for what is of second order in it.
TEST(KinetoElastodynamics, OfAStiffCouplerIsTheNonlinearRun) {
  const test::Folder folder;
  const std::filesystem::path tutorial = FLEXURA_SOURCE_DIR "/docs/tutorials/four_bar";
  std::filesystem::copy(tutorial / "flexible.toml", folder / "flexible.toml");
  for (int seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    mbs::chance::Chance chance(static_cast<std::uint64_t>(seed));
    superelement::write(folder / "link.se.h5",
                        reduce::reduce(reduce::read_beam_part(tutorial / "link.toml",
                                                              {fmt::format("material.steel.young={} GPa",
                                                                           210 * chance.between(0.5, 2.0))}))
                            .superelement);
    const double speed = chance.between(8.0, 25.0);
    const auto run = [&](std::vector<std::string> set) {
      for (const std::string& key : {fmt::format("parameters.speed={:.6g} rad/s", speed),
                                     fmt::format("solver.end_time={:.6g}", 4.0 / speed),
                                     fmt::format("solver.output_step={:.6g}", 0.05 / speed),
                                     std::string("solver.initial_deformation=quasi_static")})
        set.push_back(key);
      return rows_of(mbs::prepare(folder / "flexible.toml", set), {"d.angle", "motor.drive_force"});
    };
    const auto ked = run({"solver.method=ked", "solver.tolerance=1e-5"}),
               whole = run({"solver.method=radau", "solver.tolerance=1e-8"}),
               rigid = run({"body.coupler.fidelity=rigid", "solver.tolerance=1e-9"});
    ASSERT_EQ(ked.size(), whole.size());
    ASSERT_EQ(rigid.size(), whole.size());
    double off = 0.0, by_deformation = 0.0, torque_off = 0.0, torque = 0.0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      off = std::max(off, std::abs(ked[i](1) - whole[i](1)));
      by_deformation = std::max(by_deformation, std::abs(whole[i](1) - rigid[i](1)));
      torque_off = std::max(torque_off, std::abs(ked[i](2) - whole[i](2)));
      torque = std::max(torque, std::abs(whole[i](2)));
    }
    EXPECT_GT(by_deformation, 1e-9);
    EXPECT_LT(off, 0.03 * by_deformation);
    EXPECT_LT(torque_off, 0.01 * torque);
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(KinetoElastodynamics, IsRefusedWhereAFreedomIsLeft) {
  const test::Folder folder;
  const std::filesystem::path tutorial = FLEXURA_SOURCE_DIR "/docs/tutorials/four_bar";
  std::filesystem::copy(tutorial / "flexible.toml", folder / "flexible.toml");
  superelement::write(folder / "link.se.h5",
                      reduce::reduce(reduce::read_beam_part(tutorial / "link.toml", {})).superelement);
  std::string text = test::read_text(folder / "flexible.toml");
  folder.write("free.toml", test::replaced(text, "drive = \"speed * t\"", ""));
  const mbs::PreparedMechanism p =
      mbs::prepare(folder / "free.toml", {"solver.method=ked", "output.quantities=[\"d.angle\"]"});
  try {
    mbs::run(*p.mechanism, p.state, p.v_dot, p.options, {});
    FAIL();
  } catch (const std::exception& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("ked needs every freedom driven, and 1 of them is not"));
  }
}

}  // namespace
}  // namespace flexura::properties
