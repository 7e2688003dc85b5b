// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "mbs/results/results.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/app/extremes_scenes.hpp"

/// A range that is stated is a range that is held: mechanisms of many kinds, at random places within it, with every method and in two unit
/// systems.  FLEXURA_SEED=17 draws that one, FLEXURA_SEED=100:200 those from 100 to 199.
namespace flexura::extremes {
namespace {

using std::numbers::pi;

using Methods = std::vector<std::string>;
const Methods kMethods = {"ida", "radau", "generalised_alpha", "runge_kutta"};

std::string text(double x) {
  char out[32];
  std::snprintf(out, sizeof out, "%.17g", x);
  return out;
}

// Seeds of this test: `count` of them, or those that the environment names.
std::vector<std::uint64_t> seeds(int count) {
  std::uint64_t from = 1, to = 1 + static_cast<std::uint64_t>(count);
  if (const char* const given = std::getenv("FLEXURA_SEED")) {
    char* end = nullptr;
    from = std::strtoull(given, &end, 10);
    to = *end == ':' ? std::strtoull(end + 1, nullptr, 10) : from + 1;
  }
  std::vector<std::uint64_t> all;
  for (std::uint64_t s = from; s < to; ++s) all.push_back(s);
  return all;
}

struct Place {
  Scales scales;                 ///< in m, kg and s
  std::vector<std::string> set;  ///< keys of the run
  std::string said;              ///< where on the axis, for a failure
  double end_factor = 1.0;       ///< times the scene's two periods
};

// Worst error of each mechanism with each method, as one table.
class Range {
 public:
  Range(const std::string& title, const std::string& doc, double bound, Methods methods = kMethods)
      : bound_(bound), methods_(std::move(methods)) {
    std::string head = "| mechanism |", line = "|---|";
    for (const std::string& m : methods_) {
      head += " " + m + " |";
      line += "---|";
    }
    std::printf("\n## %s\n%s Worst error, relative to the amplitude; the bound is %.0e.\n\n%s\n%s\n",
                title.c_str(), doc.c_str(), bound, head.c_str(), line.c_str());
  }

  void hold(const std::vector<Mechanism>& mechanisms, int draws,
            const std::function<Place(Chance&, const std::string& method)>& place) {
    for (const Mechanism& mechanism : mechanisms) {
      std::string line = std::string("| ") + mechanism.name + " |";
      for (const std::string& method : methods_) {
        double worst = 0.0;
        for (const std::uint64_t seed : seeds(draws))
          for (const bool mm : {false, true})
            worst = std::max(worst, error(mechanism, method, seed, mm, place));
        char cell[32];
        std::snprintf(cell, sizeof cell, " %.1e |", worst);
        line += cell;
      }
      std::printf("%s\n", line.c_str());
      std::fflush(stdout);
    }
  }

 private:
  double error(const Mechanism& mechanism, const std::string& method, std::uint64_t seed, bool mm,
               const std::function<Place(Chance&, const std::string& method)>& place) {
    Chance chance(seed);
    Place p = place(chance, method);
    if (mm) {
      p.scales.mass *= 1e-3;
      p.scales.length *= 1e3;
    }
    const Scene scene = mechanism.make(p.scales, chance);
    if (scene.bar) superelement::write(folder_ / "bar.se.h5", mbs::beams::beam_superelement(*scene.bar));
    const double end = scene.end_time * p.end_factor;
    const auto file = folder_.write("scene.toml", scene.text + "[output]\nquantities = [\"" + scene.output +
                                                      "\"]\n[solver]\nmethod = \"" + method +
                                                      "\"\nend_time = " + text(end) +
                                                      "\noutput_step = " + text(end / 40.0) + "\n");
    std::vector<std::string> arguments = {"simulate", "-q", file.string(), "-o",
                                          (folder_ / "out.h5").string()};
    for (const std::string& s : p.set) arguments.insert(arguments.end(), {"--set", s});
    const test::Outcome outcome = test::run("flexura", arguments);
    const std::string where = std::string(mechanism.name) + ", " + method + (mm ? ", mm-t-s" : ", m-kg-s") +
                              ", " + p.said + ", again: FLEXURA_SEED=" + std::to_string(seed) +
                              " with this test";
    if (outcome.exit_code != 0) {
      ADD_FAILURE() << where << "\n" << outcome.err;
      if (std::getenv("FLEXURA_SEED")) std::printf("%s\n", test::read_text(file).c_str());
      return INFINITY;
    }
    const results::Results results = results::read(folder_ / "out.h5");
    const results::Run& run = results.runs.front();
    double worst = 0.0;
    for (Eigen::Index i = 0; i < run.time.size(); ++i)
      worst = std::max(worst, std::abs(run.values(i, 0) - scene.exact(run.time(i))) / scene.scale);
    EXPECT_LT(worst, bound_) << where;
    if (worst >= bound_ && std::getenv("FLEXURA_SEED")) std::printf("%s\n", test::read_text(file).c_str());
    return worst;
  }

  double bound_;
  Methods methods_;
  test::Folder folder_;
};

std::vector<Mechanism> all_mechanisms() {
  std::vector<Mechanism> all = linear_mechanisms();
  all.insert(all.end(), other_mechanisms().begin(), other_mechanisms().end());
  return all;
}

std::string said(const char* what, double x) {
  char out[64];
  std::snprintf(out, sizeof out, "%s %.3g", what, x);
  return out;
}

// 1e-6 a step over some hundred steps; order 2 loses most.
constexpr double kSomeSteps = 5e-3;
constexpr int kDraws = 2;

TEST(RangesHeld, Mass) {
  Range range("Mass, random from 1e-15 to 1e+15 kg", "Two periods of mechanisms of 1 m and 1 s.", kSomeSteps);
  range.hold(all_mechanisms(), kDraws, [](Chance& c, const std::string&) {
    const double m = c.decades(1e-15, 1e15);
    return Place{{.mass = m}, {}, said("mass", m)};
  });
}

TEST(RangesHeld, Stiffness) {
  Range range("Stiffness, random from 1e-12 to 1e+15 N/m", "Two periods of mechanisms of 1 kg and 1 m.",
              kSomeSteps);
  range.hold(all_mechanisms(), kDraws, [](Chance& c, const std::string&) {
    const double k = c.decades(1e-12, 1e15);
    // Smaller where a stone of 1 m (1000 mm) would tumble faster than a tenth of the speed of light, where runs stop.
    return Place{{.length = 1.0 / std::max(1.0, std::sqrt(k) / 3e3), .time = 1.0 / std::sqrt(k)},
                 {},
                 said("stiffness", k)};
  });
}

TEST(RangesHeld, Size) {
  Range range("Size, random from 1e-12 to 1e+3 m", "Two periods of mechanisms of 1 kg and 1 s.", kSomeSteps);
  range.hold(all_mechanisms(), kDraws, [](Chance& c, const std::string&) {
    const double l = c.decades(1e-12, 1e3);
    return Place{{.length = l}, {}, said("length", l)};
  });
}

TEST(RangesHeld, MassSizeAndTimeTogether) {
  Range range("Mass, size and time together, random from 1e-9 to 1e+9 kg, 1e-9 to 1e+3 m and 1e-4 to 1e+6 s",
              "Two periods.", kSomeSteps);
  range.hold(all_mechanisms(), kDraws, [](Chance& c, const std::string&) {
    const double m = c.decades(1e-9, 1e9), l = c.decades(1e-9, 1e3),
                 t = std::max(c.decades(1e-4, 1e6),
                              1e-3 * l);  // below a tenth of the speed of light, also as mm/s
    return Place{
        {.mass = m, .length = l, .time = t}, {}, said("mass", m) + said(", length", l) + said(", time", t)};
  });
}

TEST(RangesHeld, MassRatio) {
  Range range("Mass ratio, random from 1e-9 to 1e+9",
              "Two periods of mechanisms of 1 kg, 1 m and 1 s: the coupler of the parallelogram, the second "
              "pendulum and the slider to the others "
              "(of these two the lighter, 1e-9 to 1).",
              kSomeSteps);
  range.hold({linear_mechanisms()[4], other_mechanisms()[1], other_mechanisms()[2]}, 2 * kDraws,
             [](Chance& c, const std::string&) {
               const double ratio = c.decades(1e-9, 1e9);
               return Place{{.ratio = ratio}, {}, said("ratio", ratio)};
             });
}

TEST(RangesHeld, Damping) {
  Range range("Damping ratio, random from 1e-6 to 1e+6 (runge_kutta: 1e+3)",
              "Two periods of linear mechanisms of 1 kg, 1 m and 1 s.", kSomeSteps);
  range.hold(linear_mechanisms(), 2 * kDraws, [](Chance& c, const std::string& method) {
    // The explicit method pays for each over-critical decay.
    const double zeta = c.decades(1e-6, method == "runge_kutta" ? 1e3 : 1e6);
    return Place{{.damping = zeta}, {}, said("damping ratio", zeta)};
  });
}

TEST(RangesHeld, Speed) {
  Range range("Speed, random from 1e-9 to 1e+9 rad/s",
              "A turn of driven mechanisms, and a stone that tumbles as fast, of 1 kg and 1 m (beyond 1e+6 "
              "rad/s smaller: a tenth of the speed of light is a bound).",
              kSomeSteps);
  std::vector<Mechanism> all = driven_mechanisms();
  all.push_back(other_mechanisms()[3]);
  range.hold(all, kDraws, [](Chance& c, const std::string&) {
    const double w = c.decades(1e-9, 1e9);
    return Place{{.length = std::min(1.0, 3e3 / w), .time = 1.0 / w}, {}, said("speed", w)};
  });
}

TEST(RangesHeld, NearlySingularGeometry) {
  Range range("Gap of nearly singular geometry, random from 1e-2 to 10",
              "A turn of driven mechanisms of 1 kg, 1 m and 1 s.", 1e-3);
  range.hold(driven_mechanisms(), 2 * kDraws, [](Chance& c, const std::string&) {
    const double gap = c.decades(1e-2, 10.0);
    return Place{{.gap = gap}, {}, said("gap", gap)};
  });
}

TEST(RangesHeld, FixedStep) {
  // (omega h)^2 / 12 of phase in each radian, 4 pi of them, as much again by numerical damping (rho_inf 0.8), and of nonlinear ones with
  // rates up to three times as fast.
  Range range("Fixed step times the frequency, random from 0.003 to 0.03",
              "Two periods of mechanisms of 1 kg, 1 m and 1 s.", 5e-2, {"generalised_alpha", "runge_kutta"});
  std::vector<Mechanism> all = linear_mechanisms();
  all.insert(all.end(), other_mechanisms().begin(),
             other_mechanisms().end() - 1);  // explicit steps do not follow a bar's stretching
  range.hold(all, kDraws, [](Chance& c, const std::string&) {
    const double h = c.decades(0.003, 0.03);
    return Place{{}, {"solver.fixed_step=" + text(h)}, said("step", h)};
  });
}

TEST(RangesHeld, Length) {
  // 1e-6 a step, to one side: the energy of some hundred steps a period.
  Range range("Length of a run, random from 2 to 40 periods",
              "Linear mechanisms of 1 kg, 1 m and 1 s at a tolerance of 1e-8.", kSomeSteps);
  range.hold(linear_mechanisms(), kDraws, [](Chance& c, const std::string& method) {
    const double periods = c.decades(2.0, method == "generalised_alpha" ? 10.0 : 40.0);
    return Place{{}, {"solver.tolerance=1e-8"}, said("periods", periods), 0.5 * periods};
  });
}

TEST(RangesHeld, Tolerance) {
  std::vector<Mechanism> all = all_mechanisms();
  all.pop_back();  // a cantilever of so many elements
  for (const double tolerance : {1e-3, 1e-5, 1e-7, 1e-9}) {
    // A step's error times the steps, which grow as tolerance^(-1/6) to ^(-1/3), and what of it adds up.  Of order 2 the steps are too many
    // below 1e-7.
    Methods methods = kMethods;
    if (tolerance < 1e-7) std::erase(methods, "generalised_alpha");
    Range range(said("Tolerance", tolerance), "Two periods of mechanisms of 1 kg, 1 m and 1 s.",
                std::min(0.1, 2000.0 * tolerance), methods);
    range.hold(all, 1, [&](Chance&, const std::string&) {
      return Place{{}, {"solver.tolerance=" + text(tolerance)}, said("tolerance", tolerance)};
    });
  }
}

}  // namespace
}  // namespace flexura::extremes
