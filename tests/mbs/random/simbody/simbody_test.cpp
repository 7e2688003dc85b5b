// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tests/mbs/random/random_scene.hpp"
#include "tests/mbs/random/scene/scene_run.hpp"
#include "tests/mbs/random/simbody/simbody_scene.hpp"

/// Random mechanisms move as Simbody says.  FLEXURA_SEED=17 compares that one, FLEXURA_SEED=100:200 those from 100 to 199, with a
/// line for each.
namespace flexura::mbs::chance {
namespace {

constexpr double kTolerance = 1e-9;

struct Difference {
  double place = 0.0, speed = 0.0, acceleration = 0.0;
};

// Of two motions, lengths over `size`; speeds and accelerations over the largest.  Accelerations are sums of such terms as w^2 and
// of weights and reactions, some rad/s^2 here, which may cancel: in a mechanism that stands still all that is left is round-off.
Difference compare(const std::vector<BodyMotion>& a, const std::vector<BodyMotion>& b, double size) {
  Difference out;
  double speed = 0.0, acceleration = 0.0;
  const auto norm = [&](const Spatial& V) { return std::max(V.angular.norm(), V.linear.norm() / size); };
  for (std::size_t i = 1; i < a.size(); ++i) {
    speed = std::max(speed, norm(a[i].V));
    acceleration = std::max(acceleration, norm(a[i].A));
    out.speed = std::max(out.speed, norm(a[i].V - b[i].V));
    out.acceleration = std::max(out.acceleration, norm(a[i].A - b[i].A));
  }
  out.place = difference(a, b, size);
  out.speed /= std::max(speed, 1e-3);
  out.acceleration /= std::max(acceleration + speed * speed, 1.0);
  return out;
}

class Comparison {
 public:
  Comparison(std::uint64_t seed, const std::string& file) : scene_(random_scene(seed)), file_(file) {}

  void run() {
    skipped = SimbodyScene::lacks(scene_);
    if (!skipped.empty()) return;
    Writing how;
    how.solver = fmt::format("tolerance = {:.17g}\n", kTolerance);
    const Ran ran = simulate(scene_, how, file_);
    if (ran.rows.empty()) {
      skipped = "refused by the program";  // the other judge asks whether it may
      return;
    }
    const ScenePhysics physics(scene_);
    size_ = physics.size();
    SimbodyScene other(scene_);
    int kept = -1;
    bool keeps_rank = true;
    for (std::size_t k = 0; k < ran.rows.size(); ++k) {
      const RanRow& row = ran.rows[k];
      other.place(row.t, row.motion);
      if (kept < 0) kept = other.rows().kept;
      const bool is_clear = other.rows().is_clear();
      keeps_rank = keeps_rank && is_clear && other.rows().kept == kept;
      if (is_clear && k % 5 == 0 && !physics.stands_at_switch(row.motion, row.t)) look_at_row(row, other);
    }
    if (rows == 0) skipped = "rows near rank loss";
    const bool has_jump =
        std::ranges::any_of(scene_.forces, [](const SceneForce& f) { return f.type == "joint_force"; });
    if (keeps_rank && !has_jump && ran.end == Ran::End::complete) look_at_end(ran, other);
  }

  std::string skipped;     ///< why nothing was compared
  int rows = 0;            ///< whose accelerations were compared
  int sharp = 0;           ///< of these, to 2e-9 or better
  bool has_moved = false;  ///< the motion was compared
  Difference largest;
  double moved = 0.0;  ///< difference at the end
  std::string complaints;
  const std::string& what() const { return scene_.what; }

 private:
  // What rounded markers leave open; it turns the tangents by so much, too.
  double misfit() const { return scene_.digits < 17 ? 3.0 * std::pow(10.0, 1 - scene_.digits) : 0.0; }

  void look_at_row(const RanRow& row, SimbodyScene& other) {
    const Difference d = compare(row.motion, other.motion(), size_);
    ++rows;
    largest.place = std::max(largest.place, d.place);
    largest.speed = std::max(largest.speed, d.speed);
    largest.acceleration = std::max(largest.acceleration, d.acceleration);
    // Mobilizers take places that close the tree, so that what the program or rounded markers leave open is all in the
    // constraints: rows that fit to e give accelerations right to e / sigma^2 (near_rank_loss() of dead_point.hpp).
    const SimbodyScene::Rows there = other.rows();
    // How far they may be open is for the other judge.
    double allowed = 1e-9 + 10.0 * (std::min(there.open, 1e-8) + misfit()) / there.least_pivot;
    // Round-off over the condition of G M^-1 G^T.
    allowed += 1e-15 / (there.least_pivot * there.least_pivot);
    // Here an actuator's force is exact, there the integrator's: as in look_at_end().
    const bool has_actuator =
        std::ranges::any_of(scene_.forces, [](const SceneForce& f) { return f.type == "actuator"; });
    if (has_actuator && row.t > 0.0) allowed += 300.0 * kTolerance;
    sharp += allowed < 2e-9 ? 1 : 0;
    for (const auto& [name, value] :
         {std::pair{"places", d.place}, {"speeds", d.speed}, {"accelerations", d.acceleration}})
      if (!(value <= allowed))
        complaints +=
            fmt::format("{} at t = {:.6g} differ by {:.2e}, {:.1e} allowed\n", name, row.t, value, allowed);
  }

  void look_at_end(const Ran& ran, SimbodyScene& other) {
    const RanRow &first = ran.rows.front(), &last = ran.rows.back();
    const auto run_there = [&](double disturbance, long& steps) {
      other.place(first.t, first.motion);
      steps = other.run(last.t, kTolerance, disturbance);
      return other.motion();
    };
    long steps = 0, ignored = 0;
    const std::vector<BodyMotion> there = run_there(0.0, steps);
    has_moved = true;
    moved = difference(last.motion, there, size_);
    // Each step of either may err by the tolerance, at worst all of them one way.
    double allowed = kTolerance * static_cast<double>(std::max({300L, ran.steps, steps})) + misfit();
    if (moved <= allowed) return;
    // An error grows as a disturbance of the speeds does.
    constexpr double kDisturbance = 1e-6;
    allowed *= std::max(1.0, difference(there, run_there(kDisturbance, ignored), size_) / kDisturbance);
    if (!(moved <= allowed))
      complaints +=
          fmt::format("the motion differs by {:.2e} at t = {:.6g}, {:.1e} allowed\n", moved, last.t, allowed);
  }

  const Scene scene_;
  const std::string file_;
  double size_ = 1.0;
};

TEST(RandomMechanisms, MoveAsSimbodySays) {
  std::uint64_t seed = 1, end = std::numeric_limits<std::uint64_t>::max();
  int wanted = 1000;
  const char* const given = std::getenv("FLEXURA_SEED");
  if (given) {
    char* rest = nullptr;
    seed = std::strtoull(given, &rest, 10);
    end = *rest == ':' ? std::strtoull(rest + 1, nullptr, 10) : seed + 1;
    wanted = std::numeric_limits<int>::max();
  }
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("flexura_simbody_{}", ::getpid());
  std::filesystem::create_directories(folder);
  std::map<std::string, int> skipped;
  int compared = 0, rows = 0, sharp = 0, moved = 0;
  Difference largest;
  double farthest = 0.0;
  for (; seed < end && compared < wanted; ++seed) {
    Comparison c(seed, (folder / fmt::format("seed_{}", seed)).string());
    try {
      c.run();
    } catch (const std::exception& e) {
      c.complaints += fmt::format("{}\n", e.what());
    }
    if (given)
      fmt::print("seed {} ({}): {} places {:.1e}, speeds {:.1e}, accelerations {:.1e} of {} rows; {}\n", seed,
                 c.what(), c.skipped, c.largest.place, c.largest.speed, c.largest.acceleration, c.rows,
                 c.has_moved ? fmt::format("motion {:.1e}", c.moved) : "motion not compared");
    if (!c.complaints.empty())
      ADD_FAILURE() << "seed " << seed << " (" << c.what() << "), file "
                    << (folder / fmt::format("seed_{}.toml", seed)) << "\n"
                    << c.complaints << "again: FLEXURA_SEED=" << seed << " with this test";
    else
      std::filesystem::remove(folder / fmt::format("seed_{}.toml", seed));
    if (!c.skipped.empty()) ++skipped[c.skipped];
    compared += c.skipped.empty() ? 1 : 0;
    moved += c.has_moved ? 1 : 0;
    rows += c.rows;
    sharp += c.sharp;
    largest.acceleration = std::max(largest.acceleration, c.largest.acceleration);
    farthest = std::max(farthest, c.moved);
  }
  std::error_code not_empty;
  std::filesystem::remove(folder, not_empty);
  fmt::print(
      "{} mechanisms of {} seeds: accelerations of {} rows ({} to 2e-9) differ by up to {:.1e}, {} motions "
      "by up to "
      "{:.1e}\n",
      compared, seed - 1, rows, sharp, largest.acceleration, moved, farthest);
  for (const auto& [why, n] : skipped) fmt::print("  {} skipped: {}\n", n, why);
  if (given) return;
  // Enough was compared, and that sharply.
  EXPECT_GE(moved, wanted / 2);
  EXPECT_GE(sharp, rows / 2);
}

}  // namespace
}  // namespace flexura::mbs::chance
