// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/solver/exact_motions.hpp"

/// The orders of all integrators on motions known in closed form: docs/verification/orders.md holds the table, and this test
/// that it is what the integrators do.  FLEXURA_WRITE_ORDERS=1 writes the page anew.
namespace flexura::mbs::test {
namespace {

using Eigen::VectorXd;
using flexura::test::Folder;

struct Motion {
  std::string name, text;                   ///< the mechanism's file
  std::function<VectorXd(double t)> exact;  ///< of its outputs
  bool has_switch = false;
};

Motion oscillator() {
  ExactMotion exact = damped_oscillator(9.0, 0.1, 1.0, 0.0);
  return {"a damped oscillator", std::move(exact.text), std::move(exact.outputs)};
}

Motion top() {
  ExactMotion exact = free_top(0.2, 0.13, {2.0, -1.0, 5.0}, {0.7, -0.4, 0.0});
  return {"a top that floats (quaternions)", std::move(exact.text), std::move(exact.outputs)};
}

// The mass's place, or the thread's tension.
Motion on_a_thread(bool tension) {
  const ExactMotion exact = sling(2.0, 1.5, 4.0);
  const std::string all = R"("j.x", "j.y", "thread.tension")";
  std::string text = exact.text;
  text.replace(text.find(all), all.size(), tension ? R"("thread.tension")" : R"("j.x", "j.y")");
  return {tension ? "its tension" : "a mass that goes round on a thread", text, [=](double t) -> VectorXd {
            const VectorXd y = exact.outputs(t);
            return tension ? VectorXd(y.tail(1)) : VectorXd(y.head(2));
          }};
}

// A cart whose place (index 3) or speed (index 2) is prescribed, x = 1/3 sin 3 t, with a mass on a spring on it, and a force on
// that mass from t_1 on: r'' + w^2 r = 3 sin 3 t + F(t).
Motion led_cart(bool by_speed, bool jumps) {
  const double w = 8.0, F = jumps ? 20.0 : 0.0, t_1 = 0.37;
  return {fmt::format("a cart led by its {}, with a mass on a spring{}", by_speed ? "speed" : "place",
                      jumps ? " and a force that jumps" : ""),
          slide() + fmt::format(R"toml({}
[body.b]
mass = 1
inertia = [1, 1, 1]
[body.b.marker.m]
[joint.r]
type = "prismatic"
from = "a.m"
to = "b.m"
[force.s]
type = "joint_spring_damper"
joint = "r"
stiffness = {}
[force.f]
type = "joint_force"
joint = "r"
value = "t < {} ? 0 : {}"
[output]
quantities = ["j.position", "r.position", "r.speed"]
)toml",
                                by_speed ? "drive_speed = \"cos(3*t)\"" : "drive = \"sin(3*t)/3\"", w * w,
                                t_1, F),
          [=](double t) -> VectorXd {
            const double A = 3.0 / (w * w - 9.0), B = -3.0 * A / w, s = t - t_1;
            double r = A * std::sin(3.0 * t) + B * std::sin(w * t),
                   v = 3.0 * A * std::cos(3.0 * t) + w * B * std::cos(w * t);
            // The force acts between cart and mass, and the cart does not mind.
            if (s > 0.0) {
              r += F / (w * w) * (1.0 - std::cos(w * s));
              v += F / w * std::sin(w * s);
            }
            return Eigen::Vector3d(std::sin(3.0 * t) / 3.0, r, v);
          }};
}

// Two springs, one on either side: arcs of w_1 for x > 0, of w_2 for x < 0.
Motion two_springs() {
  const double w_1 = 6.0, w_2 = 15.0, pi = std::acos(-1.0);
  return {"a mass between two springs (switch)",
          slide() + fmt::format(R"toml(position = 1
[force.s]
type = "joint_force"
joint = "j"
value = "j.position > 0 ? -{}*j.position : -{}*j.position"
[output]
quantities = ["j.position", "j.speed"]
)toml",
                                w_1 * w_1, w_2 * w_2),
          [=](double t) -> VectorXd {
            const double first = 0.5 * pi / w_1, period = pi / w_1 + pi / w_2;
            if (t < first) return Eigen::Vector2d(std::cos(w_1 * t), -w_1 * std::sin(w_1 * t));
            const double s = std::fmod(t - first, period);
            if (s < pi / w_2)
              return Eigen::Vector2d(-w_1 / w_2 * std::sin(w_2 * s), -w_1 * std::cos(w_2 * s));
            const double u = s - pi / w_2;
            return Eigen::Vector2d(std::sin(w_1 * u), w_1 * std::cos(w_1 * u));
          },
          true};
}

// A bar, clamped, pulled at its tip and, from t_1 on, pushed: the sum over the modes of its own matrices, f_k / w_k^2
// (1 - cos w_k t).
Motion bar(const Folder& folder, bool jumps) {
  const superelement::Superelement se = beams::beam_superelement({.length = 1.0,
                                                                  .elements = 2,
                                                                  .EA = 60.0,
                                                                  .GI_t = 1.0,
                                                                  .EI_y = 0.05,
                                                                  .EI_z = 0.05,
                                                                  .mass_per_length = 1.0,
                                                                  .rho_I_y = 0.05,
                                                                  .rho_I_z = 0.05});
  superelement::write(folder / "bar.se.h5", se);
  const double t_1 = 0.37, F = 3.0, F_1 = jumps ? -5.0 : F;
  // All but what moves the root: interfaces come first, the root's six directions at their head.
  const Eigen::Index n = se.K_se.rows() - 6;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(se.K_se.bottomRightCorner(n, n),
                                                                        se.M_se.bottomRightCorner(n, n));
  const VectorXd of_tip = modes.eigenvectors().row(0).transpose(), w2 = modes.eigenvalues();
  return {jumps ? "a bar pulled by a force that jumps (flexible)" : "a bar that is pulled (flexible)",
          fmt::format(R"toml(gravity = [0, 0, 0]
[ground.marker.m]
[body.bar]
superelement = "bar.se.h5"
[joint.clamp]
type = "fixed"
from = "ground.m"
to = "bar.root"
[force.pull]
type = "force"
marker = "bar.tip"
x = "t < {} ? {} : {}"
[measure.u]
type = "position"
from = "ground.m"
to = "bar.tip"
direction = [1, 0, 0]
[output]
quantities = ["u"]
)toml",
                      t_1, F, F_1),
          [=](double t) -> VectorXd {
            double u = 1.0;
            for (Eigen::Index k = 0; k < n; ++k) {
              const double w = std::sqrt(w2(k)), of_force = of_tip(k) * of_tip(k) / w2(k);
              u += of_force * F * (1.0 - std::cos(w * t));
              if (t > t_1) u += of_force * (F_1 - F) * (1.0 - std::cos(w * (t - t_1)));
            }
            return VectorXd::Constant(1, u);
          }};
}

/// A run: its longest step, and the largest errors of the outputs, each in parts of its largest value.
struct Run {
  double step, at_ends, in_rows;
};

Run measure(const Folder& folder, const Motion& motion, const std::string& method, double tolerance,
            double fixed_step = 0.0) {
  // Rows fall between the steps.
  const PreparedMechanism p = prepare(
      folder.write("mechanism.toml", motion.text),
      {"solver.end_time=1", "solver.output_step=0.047", "solver.method=" + method,
       fmt::format("solver.tolerance={}", tolerance), fmt::format("solver.fixed_step={}", fixed_step)});
  const auto which = select_quantities(*p.mechanism, p.file.outputs);
  const auto scratch = p.mechanism->make_scratch();
  VectorXd y(static_cast<Eigen::Index>(which.size())), in_rows = VectorXd::Zero(y.size()), at_ends = in_rows,
                                                       size = in_rows;
  Run out{};
  const auto look = [&](const State& s, const VectorXd& v_dot, VectorXd& error) {
    p.mechanism->evaluate(which, s, v_dot, *scratch, y);
    const VectorXd exact = motion.exact(s.t);
    error = error.cwiseMax((y - exact).cwiseAbs());
    size = size.cwiseMax(exact.cwiseAbs());
  };
  AccelerationSolver accelerations(*p.mechanism);
  RunCallbacks callbacks;
  callbacks.row = [&](const State& s, const VectorXd& v_dot, const EnergyAccount&) {
    look(s, v_dot, in_rows);
  };
  callbacks.step = [&](const Instant& begin, const std::array<Instant, 3>& nodes) {
    Instant end = nodes[2];
    accelerations.solve(end.state, end.v_dot);  // and multipliers
    look(end.state, end.v_dot, at_ends);
    out.step = std::max(out.step, end.state.t - begin.state.t);
  };
  const RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(run.complete) << motion.name << ": " << run.stopped_because;
  out.at_ends = at_ends.cwiseQuotient(size).maxCoeff();
  out.in_rows = in_rows.cwiseQuotient(size).maxCoeff();
  return out;
}

// Of log(error) over log(x) by least squares, without errors that are round-off.
double slope(const std::vector<double>& x, const std::vector<double>& error) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (error[i] < 1e-12) continue;
    const double a = std::log(x[i]), b = std::log(error[i]);
    n += 1.0;
    sx += a;
    sy += b;
    sxx += a * a;
    sxy += a * b;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

// Over four fixed steps, each half of the one before.
double order_of_fixed_steps(const Folder& folder, const Motion& motion, const std::string& method, double h) {
  std::vector<double> steps, errors;
  for (; steps.size() < 4; h *= 0.5) {
    // Newton's method leaves a part of the tolerance.
    steps.push_back(h);
    errors.push_back(measure(folder, motion, method, 1e-10, h).at_ends);
  }
  return slope(steps, errors);
}

/// In the order of the page's columns.
constexpr int kColumns = 7;
using Row = std::array<double, kColumns>;

Row orders_of(const Folder& folder, const Motion& motion) {
  Row row;
  row[0] = order_of_fixed_steps(folder, motion, "generalised_alpha", 1.0 / 150.0);
  row[1] = order_of_fixed_steps(folder, motion, "runge_kutta", 1.0 / 40.0);
  int column = 3;
  for (const std::string method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    std::vector<double> tolerances, steps, in_rows, at_ends;
    for (double tolerance = 1e-4; tolerance > (method == "generalised_alpha" ? 3e-8 : 3e-11);
         tolerance *= 0.1) {
      const Run run = measure(folder, motion, method, tolerance);
      tolerances.push_back(tolerance);
      steps.push_back(run.step);
      at_ends.push_back(run.at_ends);
      in_rows.push_back(run.in_rows);
    }
    if (method == "radau") row[2] = slope(steps, at_ends);
    row[column++] = slope(tolerances, in_rows);
  }
  return row;
}

constexpr const char* kPage = R"(# Orders of the integrators

Measured on motions known in closed form: how the error falls with the step, and with the tolerance. The page is written and, with every build,
checked by `tests/mbs/solver/orders.cpp`; errors are the largest of a second's motion, in parts of the largest value.

- **Steps**: over four fixed steps, each half of the one before, at the ends of steps; of `radau`, which takes no fixed ones, over seven tolerances
  against the longest step. `generalised_alpha` solves index 3 and has order 2, multipliers included; `runge_kutta` solves index 1 with projections and
  has order 5; `radau` solves the stabilised index 2 and has order 5. At a switch, whose time comes from the polynomial within the step, it has that
  one's order, 4. Even motion round a circle is better than the order by one.
- **Tolerance**: error of rows, which lie between the steps, is about C tol^p. `ida` chooses its order as it goes, 1 to 5, and has 5/6 as a method of
  order 5 held to its tolerance in each step; `runge_kutta` nearly 1; `generalised_alpha` 2/3. The rows of `radau` are those of its polynomial, of order 4 where its steps
  have 5, and its estimate is held to tol^(2/3): 2/3.
- No order is lost by constraints of position (index 3), of speed (index 2), by quaternions, by bodies that deform, or at events.

| motion | steps: `generalised_alpha` | `runge_kutta` | `radau` | tolerance: `ida` | `radau` | `generalised_alpha` | `runge_kutta` |
|---|---|---|---|---|---|---|---|
)";

TEST(Orders, AreThoseOfTheirMethodsAndOfThePage) {
  const Folder folder;
  std::string page = kPage;
  const std::string file = std::string(FLEXURA_SOURCE_DIR) + "/docs/verification/orders.md";
  const std::string written = flexura::test::read_text(file);
  EXPECT_EQ(written.substr(0, page.size()), page) << "FLEXURA_WRITE_ORDERS=1 writes it";
  for (const Motion& motion : {oscillator(), top(), on_a_thread(false), on_a_thread(true),
                               led_cart(true, false), led_cart(false, false), led_cart(true, true),
                               led_cart(false, true), two_springs(), bar(folder, false), bar(folder, true)}) {
    SCOPED_TRACE(motion.name);
    const Row row = orders_of(folder, motion);
    // A fixed step's own order; what a hundredth of it is off shows by the next term.
    EXPECT_NEAR(row[0], 2.0, 0.1);
    EXPECT_GT(row[1], 4.7);
    EXPECT_GT(row[2], motion.has_switch ? 4.0 : 4.8);
    // Powers of the tolerance: steps of every length add a hundredth or two.
    EXPECT_GT(row[3], 0.75);
    EXPECT_GT(row[4], 0.55);
    EXPECT_GT(row[5], 0.65);
    EXPECT_GT(row[6], 0.8);
    std::string line = "| " + motion.name + " |";
    for (const double x : row) line += fmt::format(" {:.2f} |", x);
    page += line + "\n";
    const std::size_t at = written.find("| " + motion.name + " |");
    if (at == std::string::npos) {
      ADD_FAILURE() << "the page lacks " << line;
      continue;
    }
    std::istringstream cells(written.substr(at + motion.name.size() + 4));
    for (int i = 0; i < kColumns; ++i) {
      double x = 0.0;
      std::string bar;
      ASSERT_TRUE(cells >> x >> bar);
      // Another compiler's round-off makes other steps; orders are those of smooth lines all the same.
      EXPECT_NEAR(x, row[static_cast<std::size_t>(i)], i == 2 ? 0.5 : 0.1) << "column " << i + 1;
    }
  }
  if (std::getenv("FLEXURA_WRITE_ORDERS")) std::ofstream(file) << page;
}

}  // namespace
}  // namespace flexura::mbs::test
