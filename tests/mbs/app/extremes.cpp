// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "mbs/results/results.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/app/damped_vibration.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

/// The program as its user sees it, along each axis from sensible to absurd: how wrong it is, where it warns
/// and where it refuses.  Prints Markdown tables that tests/run extremes gathers into a page.
namespace flexura::test {
namespace {

using std::numbers::pi;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string text(double x) {
  char out[32];
  std::snprintf(out, sizeof out, "%g", x);
  return out;
}

// A mass m on a spring k with a damper c, pulled out by a: x(0) = a, v(0) = 0.
std::string oscillator(double m, double k, double c, double a) {
  return "gravity = [0, 0, 0]\n[ground.marker.rail]\naxis = [1, 0, 0]\n[body.mass]\nmass = " + text(m) +
         "\ninertia = [" + text(m) + ", " + text(m) + ", " + text(m) +
         "]\n[body.mass.marker.pin]\naxis = [1, 0, 0]\n[joint.slide]\ntype = \"prismatic\"\nfrom = "
         "\"ground.rail\"\nto = \"mass.pin\"\nposition = " +
         text(a) +
         "\n[force.spring]\ntype = \"joint_spring_damper\"\njoint = \"slide\"\nstiffness = " + text(k) +
         "\ndamping = " + text(c) + "\n[output]\nquantities = [\"slide.position\"]\n";
}

// Its exact motion, damping ratio zeta = c / (2 sqrt(k m)).
double exact(double m, double k, double c, double a, double t) {
  return flexura::extremes::damped_vibration(std::sqrt(k / m), c / (2.0 * std::sqrt(k * m)), a, t);
}

struct Answer {
  Outcome outcome;
  Eigen::VectorXd time, values;  // of the first stored quantity
  bool ran() const { return outcome.exit_code == 0; }
  /// What the program said beside its figures: a refusal, a warning or a note, shortened; "" for nothing.
  std::string said() const {
    const std::string& err = outcome.err;
    for (const char* const word : {"error: ", "warning: ", "note: "})
      if (const auto at = err.find(word); at != std::string::npos) {
        std::string line = err.substr(at, err.find('\n', at) - at);
        if (const auto path = line.find(".toml:"); path != std::string::npos)
          line = word + line.substr(line.find(' ', path) + 1);
        for (char& c : line)
          if (c == '|') c = '/';
        return line.substr(0, 160);
      }
    return "";
  }
};

class Axis {
 public:
  Axis(const std::string& title, const std::string& doc, const std::string& value,
       const std::string& measured) {
    std::printf("\n## %s\n%s\n\n| %s | %s | steps | the program says |\n|---|---|---|---|\n", title.c_str(),
                doc.c_str(), value.c_str(), measured.c_str());
  }

  Answer simulate(const std::string& mechanism, const std::vector<std::string>& set) {
    const auto file = folder_.write("scene.toml", mechanism);
    std::vector<std::string> arguments = {"simulate", file.string(), "-o", (folder_ / "out.h5").string()};
    for (const std::string& s : set) arguments.insert(arguments.end(), {"--set", s});
    Answer out{run("flexura", arguments), {}, {}};
    // A refusal says why in one sentence; nothing ends by a signal.
    EXPECT_TRUE(out.outcome.exit_code == 0 || out.outcome.exit_code == 1 || out.outcome.exit_code == 2)
        << out.outcome.exit_code << out.outcome.err;
    if (!out.ran()) {
      EXPECT_NE(out.outcome.err.find("error: "), std::string::npos) << out.outcome.err;
      return out;
    }
    const results::Results results = results::read(folder_ / "out.h5");
    out.time = results.runs.front().time;
    out.values = results.runs.front().values.col(0);
    steps_ = results.runs.front().summary_json;
    return out;
  }

  void row(const std::string& value, double error, const Answer& answer) {
    std::string steps = "-";
    if (const auto at = steps_.find("\"steps\":"); answer.ran() && at != std::string::npos)
      steps = std::to_string(std::stol(steps_.substr(at + 8)));
    std::printf("| %s | %s | %s | %s |\n", value.c_str(), std::isnan(error) ? "-" : text_of(error).c_str(),
                steps.c_str(), answer.said().c_str());
  }
  const Folder& folder() const { return folder_; }

 private:
  static std::string text_of(double error) {
    char out[32];
    std::snprintf(out, sizeof out, "%.1e", error);
    return out;
  }
  Folder folder_;
  std::string steps_;
};

// Two periods of the oscillator, error of the position against the exact one, relative to the amplitude.
double two_periods(Axis& axis, double m, double k, double c, double a, std::vector<std::string> set,
                   Answer& answer) {
  const double period = 2.0 * pi * std::sqrt(std::abs(m) / k);
  set.push_back("solver.end_time=" + text(2.0 * period));
  set.push_back("solver.output_step=" + text(period / 20.0));
  answer = axis.simulate(oscillator(m, k, c, a), set);
  if (!answer.ran()) return kNone;
  double worst = 0.0;
  for (Eigen::Index i = 0; i < answer.time.size(); ++i)
    worst = std::max(worst, std::abs(answer.values(i) - exact(m, k, c, a, answer.time(i))) / a);
  return worst;
}

// A tolerance of 1e-6 a step over some hundred steps; BDF loses phase to one side.
constexpr double kTwoPeriods = 1e-3;

TEST(ProgramAtTheExtremes, Mass) {
  Axis axis("Mass", "Two periods of a mass on a spring whose stiffness is a hundred times the mass.",
            "mass [kg]", "error, relative to the amplitude");
  for (const double m : {-1.0, 0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12, 1e15}) {
    Answer answer;
    const double error = m > 0.0 ? two_periods(axis, m, 100.0 * m, 0.0, 0.1, {}, answer) : kNone;
    if (m <= 0.0) {
      answer = axis.simulate(oscillator(m, 1.0, 0.0, 0.1), {});
      EXPECT_EQ(answer.outcome.exit_code, 2) << "a mass of " << m << " is refused";
    } else if (m >= 1e-9 && m <= 1e9) {
      EXPECT_LT(error, kTwoPeriods) << m;
    }
    axis.row(text(m), error, answer);
  }
}

TEST(ProgramAtTheExtremes, Stiffness) {
  Axis axis("Stiffness", "Two periods of 1 kg on a spring.", "stiffness [N/m]",
            "error, relative to the amplitude");
  for (const double k : {1e-12, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12, 1e15}) {
    Answer answer;
    const double error = two_periods(axis, 1.0, k, 0.0, 0.1, {}, answer);
    if (k >= 1e-3 && k <= 1e9) {
      EXPECT_LT(error, kTwoPeriods) << k;
    }
    axis.row(text(k), error, answer);
  }
}

TEST(ProgramAtTheExtremes, Damping) {
  Axis axis("Damping", "Two periods of a mass on a spring with a damper, from none to over-critical.",
            "damping ratio", "error, relative to the amplitude");
  for (const double zeta : {-0.1, 0.0, 1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 10.0, 1e3, 1e6}) {
    Answer answer;
    const double error = two_periods(axis, 1.0, 100.0, 20.0 * zeta, 0.1, {}, answer);
    if (zeta >= 0.0) {
      EXPECT_LT(error, kTwoPeriods) << zeta;
    }
    axis.row(text(zeta), error, answer);
  }
}

TEST(ProgramAtTheExtremes, SizeAndUnits) {
  Axis axis("Size and units", "The amplitude of a mass on a spring, as if in other units.", "amplitude [m]",
            "error, relative to the amplitude");
  for (const double a : {1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9}) {
    Answer answer;
    const double error = two_periods(axis, 1.0, 100.0, 0.0, a, {}, answer);
    // The absolute tolerance is 1e-8 m a step unless absolute_factor says otherwise.
    if (a >= 1e-3 && a <= 1e6) {
      EXPECT_LT(error, kTwoPeriods) << a;
    }
    axis.row(text(a), error, answer);
  }
}

TEST(ProgramAtTheExtremes, Tolerance) {
  Axis axis("Tolerance", "Two periods of 1 kg on 100 N/m.", "tolerance", "error, relative to the amplitude");
  double last = 1.0;
  for (const char* const tolerance : {"1", "1e-1", "1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8",
                                      "1e-9", "1e-10", "1e-11", "1e-12", "1e-13", "1e-14"}) {
    Answer answer;
    const double error =
        two_periods(axis, 1.0, 100.0, 0.0, 1.0, {std::string("solver.tolerance=") + tolerance}, answer);
    const double tol = std::stod(tolerance);
    if (tol > 0.1 || tol < 1e-13) {
      EXPECT_EQ(answer.outcome.exit_code, 2);
    } else {
      // Error follows tolerance: over four decades it falls by two at least, down to round-off.
      if (tol <= 1e-2 && tol >= 1e-11) {
        EXPECT_LT(error, std::max(100.0 * tol, 2.0 * last)) << tolerance;
      }
      last = error;
    }
    axis.row(tolerance, error, answer);
  }
}

TEST(ProgramAtTheExtremes, Step) {
  for (const char* const method : {"generalised_alpha", "runge_kutta"}) {
    Axis axis(std::string("Step of ") + method, "Two periods of 1 kg on 1 N/m with a fixed step.",
              "step times frequency", "error, relative to the amplitude");
    for (const double h : {-0.1, 1e-3, 1e-2, 0.1, 0.3, 1.0, 2.0, 5.0, 12.0}) {
      Answer answer;
      const double error =
          two_periods(axis, 1.0, 1.0, 0.0, 1.0,
                      {std::string("solver.method=") + method, "solver.fixed_step=" + text(h)}, answer);
      if (h < 0.0) {
        EXPECT_EQ(answer.outcome.exit_code, 2);
      }
      // (omega h)^2 / 12 of phase in each radian, 4 pi of them, and as much again by numerical damping.
      if (h > 0.0 && h <= 0.1) {
        EXPECT_LT(error, 4.0 * pi * h * h) << method << h;
      }
      axis.row(text(h), error, answer);
    }
  }
}

// A wheel that turns freely: ten revolutions.
TEST(ProgramAtTheExtremes, Speed) {
  Axis axis("Speed", "Ten revolutions of a wheel with an eccentric mass, free of gravity.", "speed [rad/s]",
            "error of the angle, relative");
  for (const double w : {1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9}) {
    const Answer answer = axis.simulate(
        "gravity = [0, 0, 0]\n[ground.marker.axle]\naxis = [0, 0, 1]\n[body.wheel]\nmass = 1\ncenter = [0.1, "
        "0, "
        "0]\ninertia = [1, 1, 1]\n[body.wheel.marker.hub]\naxis = [0, 0, 1]\n[joint.axle]\ntype = "
        "\"revolute\"\nfrom = \"ground.axle\"\nto = \"wheel.hub\"\nspeed = " +
            text(w) + "\n[output]\nquantities = [\"axle.angle\"]\n",
        {"solver.end_time=" + text(20.0 * pi / w), "solver.output_step=" + text(20.0 * pi / w)});
    double error = kNone;
    if (answer.ran()) {
      error = std::abs(answer.values(answer.values.size() - 1) / (20.0 * pi) - 1.0);
      // The motion is linear in time; the end time is printed with six digits.
      if (w >= 1e-3) {
        EXPECT_LT(error, 1e-5) << w;
      }
    }
    axis.row(text(w), error, answer);
  }
}

// A crank and a rod nearly as long as it: at the dead points the loop comes close to being singular.
TEST(ProgramAtTheExtremes, NearlySingularGeometry) {
  Axis axis("Nearly singular geometry",
            "One turn of a slider-crank whose rod is longer than its driven crank by this part; the slider's "
            "position against r cos a + sqrt(l^2 - r^2 sin^2 a).",
            "rod over crank, less 1", "error, relative to the crank");
  for (const double gap : {-0.1, 0.0, 1e-9, 1e-6, 1e-4, 1e-2, 0.1, 1.0, 10.0}) {
    const double r = 0.1, l = r * (1.0 + gap);
    char length[32];
    std::snprintf(length, sizeof length, "%.17g", l);
    const Answer answer = axis.simulate(
        "gravity = [0, 0, 0]\n[ground.marker.axle]\naxis = [0, 0, 1]\n[ground.marker.rail]\naxis = [1, 0, "
        "0]\n[body.crank]\nmass = 1\ninertia = [1e-2, 1e-2, 1e-2]\n[body.crank.marker.axle]\naxis = [0, 0, "
        "1]\n[body.crank.marker.pin]\nposition = [0.1, 0, 0]\naxis = [0, 0, 1]\n[body.rod]\nmass = "
        "1\nposition = "
        "[0.1, 0, 0]\ninertia = [1e-2, 1e-2, 1e-2]\n[body.rod.marker.big]\naxis = [0, 0, "
        "1]\n[body.rod.marker.small]\nposition = [" +
            std::string(length) + ", 0, 0]\naxis = [0, 0, 1]\n[body.slider]\nmass = 1\nposition = [" +
            text(r + l) +
            ", 0, 0]\ninertia = [1e-2, 1e-2, 1e-2]\n[body.slider.marker.pin]\naxis = [0, 0, "
            "1]\n[body.slider.marker.rail]\naxis = [1, 0, 0]\n[joint.axle]\ntype = \"revolute\"\nfrom = "
            "\"ground.axle\"\nto = \"crank.axle\"\ndrive = \"0.3 + 6.2831853071795865 * "
            "t\"\n[joint.slide]\ntype = \"prismatic\"\nfrom = \"ground.rail\"\nto = "
            "\"slider.rail\"\n[joint.big]\ntype "
            "= \"revolute\"\nfrom = \"crank.pin\"\nto = \"rod.big\"\n[joint.small]\ntype = "
            "\"revolute\"\nfrom = "
            "\"rod.small\"\nto = \"slider.pin\"\n[output]\nquantities = [\"slide.position\"]\n",
        {"solver.end_time=1", "solver.output_step=0.05"});
    double error = kNone;
    if (answer.ran()) {
      error = 0.0;
      for (Eigen::Index i = 0; i < answer.time.size(); ++i) {
        const double a = 0.3 + 2.0 * pi * answer.time(i), s = r * std::sin(a);
        error = std::max(error, std::abs(answer.values(i) - r * std::cos(a) - std::sqrt(l * l - s * s)) / r);
      }
      if (gap >= 1e-2) {
        EXPECT_LT(error, 1e-4) << gap;
      }
    }
    axis.row(text(gap), error, answer);
  }
}

// Three cranks on one axis carry a coupler, the third one's pin displaced along it: where that is round-off the mechanism is that
// of two cranks; beyond, its rows contradict each other.
TEST(ProgramAtTheExtremes, MisfitOfARedundantCrank) {
  const auto cranks = [](int n, double misfit) {
    char place[32];
    std::snprintf(place, sizeof place, "%.17g", 1.0 + misfit);
    std::string scene =
        "[body.coupler]\nmass = 2\ncenter = [1, 0, 0]\ninertia = [1, 1, 1]\nposition = [0, 0.8, -0.6]\n";
    for (int i = 0; i < n; ++i) {
      const std::string k = std::to_string(i),
                        x = i == 0   ? "0"
                            : i == 1 ? "2"
                                     : place,
                        nominal = i == 2 ? "1" : x;
      scene += "[ground.marker.foot" + k + "]\nposition = [" + nominal +
               ", 0, 0]\naxis = [1, 0, 0]\n[body.crank" + k + "]\nmass = " + text(3.0 / n) +
               "\ncenter = [0, 0.4, -0.3]\ninertia = [" + text(0.3 / n) + ", 1, 1]\nposition = [" + nominal +
               ", 0, 0]\n[body.crank" + k + ".marker.foot]\naxis = [1, 0, 0]\n[body.crank" + k +
               ".marker.head]\nposition = [0, 0.8, -0.6]\naxis = [1, 0, 0]\n[body.coupler.marker.pin" + k +
               "]\nposition = [" + x + ", 0, 0]\naxis = [1, 0, 0]\n[joint.foot" + k +
               "]\ntype = \"revolute\"\nfrom = \"ground.foot" + k + "\"\nto = \"crank" + k +
               ".foot\"\n[joint.head" + k + "]\ntype = \"revolute\"\nfrom = \"crank" + k +
               ".head\"\nto = \"coupler.pin" + k + "\"\n";
    }
    return scene + "[output]\nquantities = [\"foot0.angle\"]\n";
  };
  for (const char* const method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    Axis axis(std::string("Misfit of a redundant crank, ") + method,
              "Three cranks of 1 m under a coupler swing for two seconds, the third one's pin displaced "
              "along the pins' axes by "
              "this; against two cranks.",
              "misfit [m]", "error of the angle [rad]");
    const std::vector<std::string> set = {std::string("solver.method=") + method, "solver.end_time=2"};
    const Answer two = axis.simulate(cranks(2, 0.0), set);
    ASSERT_TRUE(two.ran()) << two.outcome.err;
    for (const double misfit : {0.0, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3}) {
      const Answer answer = axis.simulate(cranks(3, misfit), set);
      double error = kNone;
      if (answer.ran()) {
        const Eigen::Index end = two.values.size() - 1;
        error = std::abs(answer.values(answer.values.size() - 1) - two.values(end));
        // 1e-6 a step in some hundred steps, of either run.
        EXPECT_LT(error, 2e-4) << method << misfit;
      }
      EXPECT_TRUE(answer.ran() || misfit > 1e-14) << method << misfit << answer.outcome.err;
      axis.row(text(misfit), error, answer);
    }
  }
}

// A hanging chain of links, let go from the horizontal.
TEST(ProgramAtTheExtremes, NumberOfBodies) {
  Axis axis("Number of bodies", "A chain of links of 0.1 m swings for half a second from 0.3 rad each.",
            "links", "error of the energy, relative to what was moved");
  for (const int n : {1, 3, 10, 30, 100}) {
    std::string scene = "[ground.marker.end]\naxis = [0, 1, 0]\n";
    for (int i = 1; i <= n; ++i) {
      const std::string name = "link" + std::to_string(i), before = "link" + std::to_string(i - 1);
      scene += "[body." + name +
               "]\nmass = 0.1\ncenter = [0.05, 0, 0]\ninertia = [1e-5, 1e-4, 1e-4]\n[body." + name +
               ".marker.start]\naxis = [0, 1, 0]\n[body." + name +
               ".marker.end]\nposition = [0.1, 0, 0]\naxis = [0, 1, 0]\n[joint.j" + std::to_string(i) +
               "]\ntype = \"revolute\"\nfrom = \"" + (i == 1 ? "ground" : before) + ".end\"\nto = \"" + name +
               ".start\"\nangle = 0.3\n";
    }
    const Answer answer =
        axis.simulate(scene, {"solver.end_time=0.5", "output.quantities=[\"energy.total\"]"});
    double error = kNone;
    if (answer.ran()) {
      // What was moved: the potential energy of the drop, about m g L / 10 of the whole chain.
      const double scale = 0.1 * n * 9.81 * 0.1 * n / 10.0;
      error = (answer.values.array() - answer.values(0)).abs().maxCoeff() / scale;
      EXPECT_LT(error, 1e-3) << n;
    }
    axis.row(std::to_string(n), error, answer);
  }
}

// A clamped bar under a slow tip load: how much of the static deflection is left with few modes.
TEST(ProgramAtTheExtremes, NumberOfModes) {
  const char* const scene =
      "gravity = [0, 0, 0]\n[ground.marker.wall]\nposition = [0.3, -0.2, 0.1]\n[body.beam]\nsuperelement = "
      "\"beam.se.h5\"\n[joint.wall]\ntype = \"fixed\"\nfrom = \"ground.wall\"\nto = "
      "\"beam.left\"\n[force.tip]\ntype "
      "= \"force\"\nmarker = \"beam.right\"\ny = \"100 * (1 - cos(5 * t))\"\n[measure.sway]\ntype = "
      "\"position\"\nfrom = \"ground.wall\"\nto = \"beam.right\"\ndirection = [0, 1, "
      "0]\n[output]\nquantities = "
      "[\"sway\"]\n[solver]\nend_time = 1\n";
  for (const char* const attachments : {"none", "used"}) {
    Axis axis(std::string("Number of modes, response modes: ") + attachments,
              "A clamped bar under a slow tip load, against the run with all modes.", "modes",
              "error of the deflection, relative");
    superelement::write(axis.folder() / "beam.se.h5", superelement::testing::make_box_beam());
    const Eigen::VectorXd all = axis.simulate(scene, {}).values;
    for (const int modes : {0, 1, 2, 3, 4, 6, 1000}) {
      const Answer answer = axis.simulate(scene, {"body.beam.modes=" + std::to_string(modes),
                                                  std::string("body.beam.attachments=") + attachments});
      double error = kNone;
      if (answer.ran()) error = (answer.values - all).norm() / all.norm();
      if (modes == 0) {
        EXPECT_EQ(answer.outcome.exit_code, 2);
      }
      // Response modes carry the static deflection, whatever was dropped.
      if (modes >= 1 && std::string(attachments) == "used") {
        EXPECT_LT(error, 1e-2) << modes;
      }
      axis.row(std::to_string(modes), error, answer);
    }
  }
}

TEST(ProgramAtTheExtremes, NumberOfSteps) {
  Axis axis("Number of steps", "1 kg on 100 N/m, longer and longer runs at the usual tolerance.", "periods",
            "error of the energy, relative");
  for (const double periods : {1.0, 10.0, 100.0, 1000.0}) {
    const double period = 2.0 * pi / 10.0;
    const Answer answer =
        axis.simulate(oscillator(1.0, 100.0, 0.0, 0.1), {"solver.end_time=" + text(periods * period),
                                                         "solver.output_step=" + text(0.1 * periods * period),
                                                         "output.quantities=[\"energy.total\"]"});
    double error = kNone;
    if (answer.ran()) error = (answer.values.array() - answer.values(0)).abs().maxCoeff() / answer.values(0);
    // 1e-6 a step, some hundred steps in a period, all to one side.
    if (periods <= 100.0) {
      EXPECT_LT(error, 1e-3 * periods) << periods;
    }
    axis.row(text(periods), error, answer);
  }
}

}  // namespace
}  // namespace flexura::test
