// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Section forces of beams and rods of decks beside the balance of what lies beyond the cut, for random frames.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mbs/results/results.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using mbs::chance::Chance;

constexpr double kRho = 7850.0;

// A member of a chain: A, its moments of area and its axes as the Quick Reference Guide has them (v in the x-y plane).
struct Bar {
  Vector3d a, b;
  Matrix3d R;
  double A, I_yy, I_zz, nsm;
  double mass() const { return (kRho * A + nsm) * (b - a).norm(); }
  // Integrals of dm, x dm, x x^T dm.
  double m = mass();
  Vector3d mx() const { return mass() * 0.5 * (a + b); }
  Matrix3d mxx() const {
    const Vector3d c = 0.5 * (a + b), d = b - a;
    return mass() * (c * c.transpose() + d * d.transpose() / 12.0) +
           kRho * d.norm() *
               (I_zz * R.col(1) * R.col(1).transpose() + I_yy * R.col(2) * R.col(2).transpose());
  }
};

struct Chain {
  std::vector<Bar> bars;
  std::string deck;
};

Chain random_chain(Chance& chance) {
  Chain chain;
  chain.deck = "BEGIN BULK\nMAT1,1,2.1+11,,0.3,7850.\n";
  Vector3d at = chance.vector(1.0);
  const int n = 2 + chance.below(4);
  const auto grid = [&](int id, const Vector3d& x) {
    chain.deck += fmt::format("GRID,{},,{:.9f},{:.9f},{:.9f}\n", id, x.x(), x.y(), x.z());
  };
  const auto rounded = [](Vector3d x) { return Vector3d((x * 1e9).array().round() / 1e9); };
  at = rounded(at);
  grid(1, at);
  for (int k = 0; k < n; ++k) {
    const Vector3d next = rounded(at + chance.between(0.3, 1.0) * chance.rotation().col(0));
    const double w = chance.between(0.01, 0.03), h = chance.between(0.01, 0.03),
                 nsm = chance.flip(0.5) ? chance.between(0.0, 2.0) : 0.0;
    const Vector3d x = (next - at).normalized();
    Vector3d v = rounded(chance.rotation().col(0));
    while (v.cross(x).norm() < 0.3) v = rounded(chance.rotation().col(0));
    Bar bar{.a = at, .b = next, .R = {}, .A = w * h, .I_yy = 0, .I_zz = 0, .nsm = nsm};
    bar.R.col(0) = x;
    bar.R.col(2) = x.cross(v).normalized();
    bar.R.col(1) = bar.R.col(2).cross(x);
    // BAR: DIM1 along z of the element, DIM2 along y.
    bar.I_zz = w * h * h * h / 12, bar.I_yy = h * w * w * w / 12;
    grid(k + 2, next);
    const char* element = chance.flip(0.5) ? "CBAR" : "CBEAM";
    chain.deck += fmt::format("PBARL,{0},1,,BAR\n,{1:.9g},{2:.9g},{3:.9g}\n", k + 1, w, h, nsm);
    if (std::string(element) == "CBEAM")
      chain.deck = test::replaced(chain.deck, fmt::format("PBARL,{},1,,BAR", k + 1),
                                  fmt::format("PBEAML,{},1,,BAR", k + 1));
    chain.deck += fmt::format("{},{},{},{},{},{:.9f},{:.9f},{:.9f}\n", element, 100 + k, k + 1, k + 1, k + 2,
                              v.x(), v.y(), v.z());
    chain.bars.push_back(bar);
    at = next;
  }
  chain.deck += "ENDDATA\n";
  return chain;
}

superelement::Superelement reduced(const test::Folder& folder, const Chain& chain, int modes,
                                   const std::string& more = "") {
  folder.write("chain.bdf", chain.deck);
  const auto part = folder.write(
      "chain.toml", fmt::format("[geometry]\nfile = \"chain.bdf\"\nunit = \"m\"\n[interface.a]\nby = "
                                "\"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = [{}]\n"
                                "[modes]\ncount = {}\n{}",
                                chain.bars.size() + 1, modes, more));
  return reduce::reduce(reduce::read_part(part)).superelement;
}

// A chain that is held at one end and pulled at the other while it is accelerated by a0 + G x: each cut bears the pull and the
// inertia of what lies beyond it, whatever the elasticity.
TEST(DeckBars, BearWhatLiesBeyondTheCut) {
  const test::Folder folder;
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const Chain chain = random_chain(chance);
    const superelement::Superelement se = reduced(folder, chain, chance.below(4));
    ASSERT_TRUE(se.sections);
    const superelement::SectionForces& sections = *se.sections;
    ASSERT_EQ(sections.members.size(), chain.bars.size());
    ASSERT_GT(sections.of_acceleration.size(), 0);
    const Vector3d F = 100.0 * chance.vector(1.0), M = 100.0 * chance.vector(1.0), a0 = chance.vector(20.0);
    const Matrix3d G = 20.0 * Matrix3d::NullaryExpr([&] { return chance.between(-1.0, 1.0); });
    VectorXd c(12);
    c.head<3>() = a0;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) c(3 + 3 * a + b) = G(b, a);
    VectorXd p = -se.inertia.S_phi.transpose() * a0 - se.inertia.S_xphi.transpose() * c.tail<9>();
    const int first_a = se.interfaces[0].first_dof, first_b = se.interfaces[1].first_dof;
    p.segment<3>(first_b) += F, p.segment<3>(first_b + 3) += M;
    MatrixXd K = se.K_se;
    for (int k = 0; k < 6; ++k) {  // held at the first end
      K.row(first_a + k).setZero(), K.col(first_a + k).setZero();
      K(first_a + k, first_a + k) = 1.0, p(first_a + k) = 0.0;
    }
    const VectorXd u = K.ldlt().solve(p), s = sections.S * u + sections.of_acceleration * c;
    const double size = F.norm() + M.norm() + 20.0 * 3.0 * se.inertia.mass;
    for (std::size_t k = 0; k < chain.bars.size(); ++k) {
      const auto found = std::ranges::find(sections.members, fmt::format("{}", 100 + k));
      ASSERT_NE(found, sections.members.end());
      const Index first = 4 * (found - sections.members.begin());
      for (const bool second : {false, true}) {
        const Bar& bar = chain.bars[k];
        const Vector3d x = second ? bar.b : bar.a;
        Vector3d force = F, moment = M + (chain.bars.back().b - x).cross(F);
        for (std::size_t j = k + (second ? 1 : 0); j < chain.bars.size(); ++j) {
          const Bar& beyond = chain.bars[j];
          const Vector3d mx = beyond.mx() - beyond.m * x;
          // -int (y - x) x (a0 + G y) dm, y the place of dm.
          const Matrix3d myy = beyond.mxx() - x * beyond.mx().transpose();
          Vector3d turn = mx.cross(a0);
          for (int d = 0; d < 3; ++d)
            for (int e = 0; e < 3; ++e) turn += myy(d, e) * Vector3d::Unit(d).cross(G.col(e));
          force -= beyond.m * a0 + G * beyond.mx();
          moment -= turn;
        }
        const Index row = 6 * (first + (second ? 3 : 0));
        EXPECT_LT((sections.positions.row(row / 6).transpose() - x).norm(), 1e-12);
        // Statics of a chain of six slender bars: condition 1e7.
        EXPECT_LT((bar.R * s.segment<3>(row) - force).norm(), 1e-7 * size) << k << second;
        EXPECT_LT((bar.R * s.segment<3>(row + 3) - moment).norm(), 1e-7 * size) << k << second;
      }
      // Between the ends: linear forces, and moments whose slope is the shear force, of loads that are linear along the bar to
      // the digits that a cubic leaves: a twelfth of q l^2 at most, here of the difference of q along the bar.
      const Index row = 6 * first;
      const double l = (chain.bars[k].b - chain.bars[k].a).norm();
      const auto slope = [&](int component) {  // of the cubic through four places, at the first
        const double h = l / 3;
        return (-11 * s(row + component) + 18 * s(row + 6 + component) - 9 * s(row + 12 + component) +
                2 * s(row + 18 + component)) /
               (6 * h);
      };
      EXPECT_NEAR(slope(4), s(row + 2), 1e-6 * size / l);
      EXPECT_NEAR(slope(5), -s(row + 1), 1e-6 * size / l);
    }
    if (testing::Test::HasFailure()) return;
  }
}

// Load cases: the weight as a load case is that of the acceleration upwards.
TEST(DeckBars, KnowLoadCases) {
  const test::Folder folder;
  for (int seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const Chain chain = random_chain(chance);
    const superelement::Superelement se =
        reduced(folder, chain, chance.below(3), "[load.w]\ntype = \"gravity\"\nacceleration = [1, 2, 3]\n");
    ASSERT_TRUE(se.sections);
    const VectorXd weight = -se.sections->of_acceleration.leftCols<3>() * Vector3d(1, 2, 3);
    // Round-off of the factor's solution.
    EXPECT_LT((se.sections->of_loads.col(0) - weight).norm(), 1e-7 * weight.norm());
    if (testing::Test::HasFailure()) return;
  }
}

constexpr const char* kRotor = R"(*NODE
1, 0, 0, 0
2, 0.5, 0, 0
3, 1, 0, 0
*ELEMENT, TYPE=B31, ELSET=E
7, 1, 2
8, 2, 3
*BEAM SECTION, ELSET=E, MATERIAL=M, SECTION=RECT
0.02, 0.03
0, 1, 0
*MATERIAL, NAME=M
*ELASTIC
2.1e11, 0.3
*DENSITY
7850
)";

// A bar that turns at 10 rad/s about its end bears m omega^2 (l^2 - x^2) / 2 per length, in a run and stored by name.
TEST(DeckBars, OfATurningDeckBearItsCentrifugalForce) {
  const test::Folder folder;
  folder.write("rotor.inp", kRotor);
  const auto part =
      folder.write("rotor.toml",
                   "[geometry]\nfile = \"rotor.inp\"\nunit = \"m\"\n[interface.a]\nby = \"nodes\"\nnodes = "
                   "[1]\n[interface.b]\nby = \"nodes\"\nnodes = [3]\n[modes]\ncount = 2\n");
  const test::Outcome made =
      test::run("flexura-reduce", {part.string(), "-q", "-o", (folder / "rotor.se.h5").string()});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto scene = folder.write(
      "m.toml",
      "gravity = [0, 0, 0]\n[ground.marker.o]\n[body.r]\nsuperelement = \"rotor.se.h5\"\n[body.r.marker.c]\n"
      "on = \"a\"\n[body.r.section_point.root]\nmember = \"7\"\nshare = 0\n[body.r.section_point.half]\n"
      "member = \"8\"\nshare = 0\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground.o\"\nto = \"r.c\"\ndrive = "
      "\"10 * t\"\n[solver]\nend_time = 0.1\noutput_step = 0.1\ninitial_deformation = \"quasi_static\"\n");
  const test::Outcome ran =
      test::run("flexura", {"simulate", scene.string(), "-q", "-o", (folder / "m.h5").string()});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const results::Results results = results::read(folder / "m.h5");
  const results::Run& run = results.runs.at(0);
  const double per_length = 7850.0 * 0.02 * 0.03;
  int found = 0;
  for (std::size_t q = 0; q < run.quantities.size(); ++q) {
    const bool root = run.quantities[q].name == "r.root.N", half = run.quantities[q].name == "r.half.N";
    if (!root && !half) continue;
    ++found;
    const double exact = per_length * 100.0 * (root ? 1.0 : 0.75) / 2;
    // The stretch makes the bar 1e-9 longer; modes of two bars ring with what quasi-statics leaves of their start.
    for (Index row = 0; row < run.values.rows(); ++row)
      EXPECT_NEAR(run.values(row, static_cast<Index>(q)), exact, 1e-3 * exact) << run.quantities[q].name;
  }
  EXPECT_EQ(found, 2);
}

}  // namespace
}  // namespace flexura::properties
