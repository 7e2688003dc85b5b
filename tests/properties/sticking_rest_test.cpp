// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Blocks on inclines, held by friction that sticks and by springs: where they rest is an equilibrium within the limits of the friction,
// it lasts, and there is none where the weight is more than those hold.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;
using ::testing::HasSubstr;

struct Block {
  double mass, limit, stick_stiffness;  // limit 0: no friction
  double spring;                        // to the next block, of the last one to the ground; 0: none
};

struct Chain {
  double along = 0.0;  // of gravity
  std::vector<Block> blocks;
  std::string text;
  double pull(std::size_t i) const { return along * blocks[i].mass; }
};

// One behind the other down the incline, 1 m apart, springs without tension.
Chain random_chain(Chance& chance) {
  Chain out;
  const double slope = chance.between(0.05, 1.4), g = 9.81;
  out.along = g * std::sin(slope);
  out.blocks.resize(static_cast<std::size_t>(1 + chance.below(3)));
  const std::string axis = fmt::format("[{:.17g}, 0, {:.17g}]", std::cos(slope), -std::sin(slope));
  double all = 0.0;
  for (Block& b : out.blocks) all += out.along * (b.mass = std::pow(10.0, chance.between(-1.0, 2.0)));
  for (std::size_t i = 0; i < out.blocks.size(); ++i) {
    Block& b = out.blocks[i];
    const double weight = out.pull(i);
    b.limit = chance.flip(0.85) ? weight * std::pow(10.0, chance.between(-0.5, 0.7)) : 0.0;
    b.stick_stiffness = weight * std::pow(10.0, chance.between(3.0, 7.0));
    const bool is_last = i + 1 == out.blocks.size();
    // None gives way by as much as it is long.
    b.spring = b.limit == 0.0 || chance.flip(0.6) ? all * std::pow(10.0, chance.between(0.7, 3.0)) : 0.0;
    const double place = static_cast<double>(i);
    out.text += fmt::format(R"(
[ground.marker.o{0}]
position = [{1:.17g}, 0, {2:.17g}]
axis = {3}
[body.b{0}]
mass = {4:.17g}
inertia = [1, 1, 1]
[body.b{0}.marker.m]
axis = {3}
[joint.j{0}]
type = "prismatic"
from = "ground.o{0}"
to = "b{0}.m"
)",
                            i, place * std::cos(slope), -place * std::sin(slope), axis, b.mass);
    if (b.limit > 0.0) {
      const double coulomb = b.limit * (chance.flip(0.5) ? 1.0 : chance.between(0.6, 1.0));
      out.text += fmt::format(
          "[force.f{0}]\ntype = \"stick_slip\"\njoint = \"j{0}\"\ncoulomb = {1:.17g}\nstatic = {2:.17g}\n"
          "stick_stiffness = {3:.17g}\nstick_damping = {4:.17g}\n",
          i, coulomb, b.limit, b.stick_stiffness, 2.0 * std::sqrt(b.stick_stiffness * b.mass));
    }
    if (b.spring > 0.0)
      out.text += fmt::format(
          "[force.s{0}]\ntype = \"spring_damper\"\nfrom = \"b{0}.m\"\nto = \"{1}\"\nstiffness = {2:.17g}\n"
          "damping = {3:.17g}\nfree_length = 1\n",
          i, is_last ? "ground.end" : fmt::format("b{}.m", i + 1), b.spring,
          2.0 * std::sqrt(b.spring * b.mass));
  }
  const auto n = static_cast<double>(out.blocks.size());
  out.text = fmt::format("gravity = [0, 0, -9.81]\n[ground.marker.end]\nposition = [{:.17g}, 0, {:.17g}]\n",
                         n * std::cos(slope), -n * std::sin(slope)) +
             out.text;
  return out;
}

// Of each block down its incline; the order of states is the program's.
Eigen::VectorXd places(const mbs::Mechanism& mechanism, const mbs::State& s) {
  Eigen::VectorXd x(s.p.size());
  for (int i = 0; i < static_cast<int>(x.size()); ++i) x(mechanism.name_of_position(i).at(1) - '0') = s.p(i);
  return x;
}

// What the friction of each block has to hold with the blocks at x.
std::vector<double> to_be_held(const Chain& chain, const Eigen::VectorXd& x) {
  std::vector<double> out;
  for (std::size_t i = 0; i < chain.blocks.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    double force = chain.pull(i);
    const double after = i + 1 < chain.blocks.size() ? x(k + 1) : 0.0;
    force += chain.blocks[i].spring * (after - x(k));
    if (i > 0) force -= chain.blocks[i - 1].spring * (x(k) - x(k - 1));
    out.push_back(force);
  }
  return out;
}

// By how much the weight of blocks that hang together, and on nothing else, is more than their friction holds, in parts of it; below 0
// where all hold.
double excess(const Chain& chain) {
  double worst = -1.0, weight = 0.0, holds = 0.0;
  for (std::size_t i = 0; i < chain.blocks.size(); ++i) {
    weight += chain.pull(i);
    holds += chain.blocks[i].limit;
    if (chain.blocks[i].spring > 0.0) continue;  // of the last one: the ground holds
    worst = std::max(worst, weight / holds - 1.0);
    weight = holds = 0.0;
  }
  return worst;
}

// Of positions at which it rests the span, at least: what friction leaves free, or the stretch of its springs.
double span(const Chain& chain, std::size_t i) {
  const Block& b = chain.blocks[i];
  const double k = b.stick_stiffness + b.spring + (i > 0 ? chain.blocks[i - 1].spring : 0.0);
  return b.limit > 0.0 ? 2.0 * b.limit / k : chain.pull(i) / k;
}

// Whether a run from the file's own start, with dampers, stays stuck: it ends at x then.
bool comes_to_rest_at(const Eigen::VectorXd& x, const Chain& chain, const std::string& file) {
  mbs::PreparedMechanism p = mbs::prepare(file);
  p.options.end_time = 20.0;
  bool sticks = true;
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd&, const mbs::EnergyAccount&) {
    for (const int root : s.root) sticks = sticks && root == 0;
  };
  const mbs::RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(run.complete) << run.stopped_because;
  if (!sticks || !run.events.empty()) return false;
  // The tolerance of the run, 1e-6 of the positions' own scale.
  const Eigen::VectorXd end = places(*p.mechanism, run.state);
  for (Eigen::Index i = 0; i < x.size(); ++i)
    EXPECT_NEAR(end(i), x(i), 1e-6 * span(chain, static_cast<std::size_t>(i)) + 1e-9);
  return true;
}

TEST(Sticking, BlocksRestWhereFrictionHoldsThem) {
  const test::Folder folder;
  int resting = 0, sliding = 0, refused = 0, came_to_rest = 0;
  for (int seed = 0; seed < 220; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const Chain chain = random_chain(chance);
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, chain.text));
    // Just at the limit either answer is right.
    if (std::abs(excess(chain)) < 0.02) continue;
    mbs::PreparedMechanism p = mbs::prepare(folder.write("blocks.toml", chain.text));
    if (excess(chain) > 0.0) {
      ++refused;
      try {
        mbs::find_equilibrium(*p.mechanism, p.state);
        ADD_FAILURE() << "rests";
      } catch (const std::runtime_error& refusal) {
        EXPECT_THAT(refusal.what(), HasSubstr("for more pulls there than friction holds"));
      }
      continue;
    }
    ASSERT_NO_THROW(mbs::find_equilibrium(*p.mechanism, p.state));
    const Eigen::VectorXd x = places(*p.mechanism, p.state);
    const std::vector<double> held = to_be_held(chain, x);
    bool all_stuck = true;
    for (std::size_t i = 0; i < held.size(); ++i) {
      const Block& b = chain.blocks[i];
      // Newton's last step is a part of 1e-10 of a metre, quadratic in the one before; springs along a line are exact to
      // round-off of the metre between the blocks.
      const double round_off =
          1e-14 * (b.spring + b.stick_stiffness + (i > 0 ? chain.blocks[i - 1].spring : 0.0));
      EXPECT_LT(std::abs(held[i]), b.limit * (1.0 + 1e-9) + round_off + 1e-9 * chain.pull(i));
      const auto k = static_cast<Eigen::Index>(i);
      if (b.limit > 0.0 && std::abs(x(k)) > b.limit / b.stick_stiffness * (1.0 + 1e-9)) all_stuck = false;
    }
    ++(all_stuck ? resting : sliding);
    if (all_stuck) came_to_rest += comes_to_rest_at(x, chain, folder / "blocks.toml");
    // It lasts.
    p.options.end_time = 0.5;
    mbs::AccelerationSolver(*p.mechanism).solve(p.state, p.v_dot);
    const mbs::RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, {});
    ASSERT_TRUE(run.complete) << run.stopped_because;
    const Eigen::VectorXd later = places(*p.mechanism, run.state);
    for (std::size_t i = 0; i < held.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      EXPECT_LT(std::abs(later(k) - x(k)), 1e-6 * span(chain, i) + 1e-13);
    }
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(resting, 40);
  EXPECT_GT(sliding, 20);
  EXPECT_GT(refused, 20);
  EXPECT_GT(came_to_rest, 10);
}

// Bristles by a control's state, c' = v - |v| sigma c / F (C. Canudas de Wit et al., IEEE Trans. Automat. Control 40 (1995) 419-425,
// as slow as it may be): pushed from rest to x they hold F (1 - exp(-sigma x / F)), and no more than F.
TEST(Sticking, BristlesRestWhereTheyYieldTo) {
  const test::Folder folder;
  int refused = 0;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double limit = std::pow(10.0, chance.between(-1.0, 3.0)),
                 sigma = limit * std::pow(10.0, chance.between(2.0, 6.0)),
                 push = limit * chance.either_sign(0.05, 2.0),
                 spring = chance.flip(0.6) ? limit * std::pow(10.0, chance.between(0.5, 4.0)) : 0.0;
    const double share = std::abs(push) / limit;
    if (spring == 0.0 && share > 0.98 && share < 1.02) continue;  // at the limit either answer is right
    std::string text = fmt::format(R"(gravity = [0, 0, 0]
[body.a]
mass = {}
inertia = [1, 1, 1]
[joint.j]
type = "prismatic"
from = "ground"
to = "a"
[control.z]
type = "state"
rate = "j.speed - {:.17g}*abs(j.speed)*z"
[force.f]
type = "joint_force"
joint = "j"
value = "{:.17g} - {:.17g}*z"
)",
                                   chance.between(0.1, 10.0), sigma / limit, push, sigma);
    if (spring > 0.0)
      text += fmt::format("[force.k]\ntype = \"joint_spring_damper\"\njoint = \"j\"\nstiffness = {:.17g}\n",
                          spring);
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, text));
    mbs::PreparedMechanism p = mbs::prepare(folder.write("bristles.toml", text));
    if (spring == 0.0 && share > 1.0) {
      ++refused;
      EXPECT_THROW(mbs::find_equilibrium(*p.mechanism, p.state), std::runtime_error);
      continue;
    }
    ASSERT_NO_THROW(mbs::find_equilibrium(*p.mechanism, p.state));
    // |push| = F (1 - exp(-sigma x / F)) + k x, by halving.
    double from = 0.0, to = spring > 0.0 ? std::abs(push) / spring : 100.0 * limit / sigma;
    for (int k = 0; k < 200; ++k) {
      const double x = 0.5 * (from + to);
      (limit * -std::expm1(-sigma * x / limit) + spring * x < std::abs(push) ? from : to) = x;
    }
    // The last step is a part of 1e-10 of a metre; bristles that have yielded to a few parts of a thousand pass on the round-off of
    // their rates, of differences of 1e-3, a hundredfold.
    EXPECT_NEAR(p.state.p(0), std::copysign(from, push), 1e-9 + 1e-9 * from);
    EXPECT_LE(sigma * std::abs(p.state.c(0)), limit * (1.0 + 1e-9));
  }
  EXPECT_GT(refused, 20);
}

// What a file of the equilibrium holds a run and the frequencies begin with: sqrt(k / m).
TEST(Sticking, GoesOnFromAFile) {
  const test::Folder folder;
  const std::string file = folder.write("block.toml", R"(gravity = [-3, 0, -9]
[ground.marker.x]
axis = [1, 0, 0]
[body.a]
mass = 2
inertia = [1, 1, 1]
[body.a.marker.x]
axis = [1, 0, 0]
[joint.j]
type = "prismatic"
from = "ground.x"
to = "a.x"
[force.f]
type = "stick_slip"
joint = "j"
coulomb = 10
stick_stiffness = 1e6
stick_damping = 0
[solver]
end_time = 0.1
)");
  const auto ask = [&](std::vector<std::string> words) {
    const test::Outcome outcome = test::run("flexura", std::move(words));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out + outcome.err;
  };
  const std::string state = folder / "block.json";
  EXPECT_THAT(ask({"statics", file, "--save-state", state}),
              testing::AllOf(HasSubstr("-6e-06"), HasSubstr("one of a range of equilibria: \"f\" holds it")));
  EXPECT_THAT(ask({"statics", file, "--from-state", state}), HasSubstr("-6e-06"));
  const std::string hz = fmt::format("{:.6g}", std::sqrt(1e6 / 2.0) / (2.0 * M_PI));
  EXPECT_THAT(ask({"eigen", file}), HasSubstr(hz));
  EXPECT_THAT(ask({"eigen", file, "--from-state", state}), HasSubstr(hz));
  mbs::PreparedMechanism p = mbs::prepare(file, {}, state);
  EXPECT_NEAR(p.state.p(0), -6e-6, 1e-15);
  const mbs::RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, {});
  EXPECT_NEAR(run.state.p(0), -6e-6, 1e-12);
}

}  // namespace
}  // namespace flexura::properties
