// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "mbs/model/mechanism.hpp"
#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/assemble.hpp"
#include "mbs/solver/run.hpp"

/// Time for each evaluation and steps per second of chains and of closed loops, with the growth over their
/// size.
namespace flexura::mbs {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The best of five: other programs on the machine only add time.
double seconds_per_call(const std::function<void()>& call) {
  double best = 1e300;
  for (int sample = 0; sample < 5; ++sample) {
    const auto start = Clock::now();
    int n = 0;
    do {
      call();
      ++n;
    } while (seconds_since(start) < 0.05);
    best = std::min(best, seconds_since(start) / n);
  }
  return best;
}

RigidInertia rod(double length) {
  const double mass = 1.0, transverse = mass * length * length / 12.0;
  return RigidInertia::from_center(mass, {0.5 * length, 0.0, 0.0},
                                   Vector3d(1e-4, transverse, transverse).asDiagonal());
}

// n rods of 1 m on hinges, whose axes turn by 90 degrees from one to the next: a motion in space.
MechanismDescription chain(int n) {
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  int before = 0;
  for (int i = 0; i < n; ++i) {
    const int body = d.add_body({.name = fmt::format("rod_{}", i), .inertia = rod(1.0)});
    Pose out, in;
    if (i > 0) out.p = {1.0, 0.0, 0.0};
    if (i % 2 == 1) out.R = in.R = rotation_exp({0.5 * M_PI, 0.0, 0.0});
    d.add_joint(fmt::format("hinge_{}", i), "revolute", d.add_marker(before, fmt::format("out_{}", i), out),
                d.add_marker(body, "in", in));
    before = body;
  }
  return d;
}

// IFToMM A02's frames: n + 1 uprights on hinges, joined by n bars, all rods of 1 m; n closed loops.
MechanismDescription windows(int n) {
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  Pose end;
  end.p = {1.0, 0.0, 0.0};
  std::vector<int> top;
  for (int i = 0; i <= n; ++i) {
    const int body = d.add_body({.name = fmt::format("upright_{}", i), .inertia = rod(1.0)});
    Pose foot;
    foot.p = {static_cast<double>(i), 0.0, 0.0};
    const int j = d.add_joint(fmt::format("foot_{}", i), "revolute",
                              d.add_marker(0, fmt::format("foot_{}", i), foot), d.add_marker(body, "foot"));
    d.joints[j].initial_coordinates[0] = 0.5 * M_PI;
    d.joints[j].initial_speeds[0] = -1.0;
    top.push_back(d.add_marker(body, "top", end));
  }
  for (int i = 0; i < n; ++i) {
    const int body = d.add_body({.name = fmt::format("bar_{}", i), .inertia = rod(1.0)});
    const int j = d.add_joint(fmt::format("left_{}", i), "revolute", top[i], d.add_marker(body, "left"));
    d.joints[j].initial_coordinates[0] = -0.5 * M_PI;
    d.joints[d.add_joint(fmt::format("right_{}", i), "revolute", d.add_marker(body, "right", end),
                         top[i + 1])]
        .cut = true;
  }
  return d;
}

struct Times {
  double evaluation, acceleration, step;
};

Times measure(const std::string& name, MechanismDescription description, const std::string& method,
              double end_time) {
  Mechanism m(std::move(description));
  State s = m.initial_state();
  Eigen::VectorXd v_dot;
  assemble_positions(m, s);
  m.drop_redundant(0.0, s.p);
  s.lambda = Eigen::VectorXd::Zero(m.sizes().n_lambda);
  assemble(m, s, v_dot);
  const Sizes n = m.sizes();
  auto scratch = m.make_scratch();
  Eigen::VectorXd r(n.n_v), none(0);
  Times times{};
  times.evaluation = seconds_per_call([&] { m.momentum(s, v_dot, *scratch, r, none, none); });
  AccelerationSolver accelerations(m);
  State moving = s;
  times.acceleration = seconds_per_call([&] { accelerations.solve(moving, v_dot); });
  SolverOptions o;
  o.method = method;
  o.end_time = o.output_step = end_time;
  o.tolerance = 1e-6;
  const RunResult result = run(m, s, v_dot, o);
  times.step = result.wall_time / static_cast<double>(result.counts.steps);
  fmt::print("{}.residual = {:.4g} us\n", name, 1e6 * times.evaluation);
  fmt::print("{}.accelerations = {:.4g} us\n", name, 1e6 * times.acceleration);
  fmt::print("{}.{}.steps_per_second = {:.5g} 1/s\n", name, method, 1.0 / times.step);
  fmt::print("{}.{}.steps = {} 1\n", name, method, result.counts.steps);
  if (!result.complete) fmt::print(stderr, "{}: {}\n", name, result.stopped_because);
  return times;
}

void growth(const std::string& name, double small, double large, double factor) {
  fmt::print("{}.growth_exponent = {:.3f} 1\n", name, std::log(large / small) / std::log(factor));
}

}  // namespace
}  // namespace flexura::mbs

int main() {
  using namespace flexura::mbs;
  Times chains[3];
  const int sizes[3] = {10, 100, 1000};
  for (int k = 0; k < 3; ++k)
    chains[k] =
        measure(fmt::format("chain_{}", sizes[k]), chain(sizes[k]), "runge_kutta", k == 2 ? 0.02 : 0.2);
  growth("chain.residual", chains[0].evaluation, chains[2].evaluation, 100.0);
  growth("chain.accelerations", chains[0].acceleration, chains[2].acceleration, 100.0);
  growth("chain.step", chains[0].step, chains[2].step, 100.0);
  for (const int n : {10, 100}) measure(fmt::format("chain_{}", n), chain(n), "ida", 0.2);
  Times loops[4];
  const int numbers[4] = {2, 20, 60, 200};
  for (int k = 0; k < 4; ++k)
    loops[k] = measure(fmt::format("windows_{}", numbers[k]), windows(numbers[k]), "ida", 0.2);
  growth("windows.ida.step", loops[1].step, loops[3].step, 10.0);
  return 0;
}
