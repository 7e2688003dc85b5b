// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/started.hpp"

/// Time for each evaluation and steps per second of chains and of closed loops, with the growth over their
/// size.
namespace flexura::mbs {
namespace {

// Of processor time: other programs on the machine must not count.
double now() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
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
  double evaluation = 1e300, acceleration = 1e300, step = 1e300;
};

// A mechanism at its assembled start, measured again and again: the best of all samples, taken in turn with
// those of the other sizes, is what the machine can do while others use it.
class Subject {
 public:
  Subject(std::string name, MechanismDescription description, std::string method, double end_time)
      : name_(std::move(name)), start_(std::move(description)) {
    options_.method = std::move(method);
    options_.end_time = options_.output_step = end_time;
    options_.tolerance = 1e-6;
  }

  void sample() {
    const Mechanism& m = start_.m;
    const Sizes n = m.sizes();
    auto scratch = m.make_scratch();
    Eigen::VectorXd r(n.n_v), none(0), v_dot;
    const auto take = [](double& best, double seconds) { best = std::min(best, seconds); };
    take(best_.evaluation,
         seconds_per_call([&] { m.momentum(start_.s, start_.v_dot, *scratch, r, none, none); }));
    AccelerationSolver accelerations(m);
    State moving = start_.s;
    take(best_.acceleration, seconds_per_call([&] { accelerations.solve(moving, v_dot); }));
    const double start = now();
    const RunResult result = run(m, start_.s, start_.v_dot, options_);
    const double seconds = now() - start;
    if (!result.complete) fmt::print(stderr, "{}: {}\n", name_, result.stopped_because);
    steps_ = result.counts.steps;
    take(best_.step, seconds / static_cast<double>(steps_));
  }

  Times report() const {
    fmt::print("{}.residual = {:.4g} us\n", name_, 1e6 * best_.evaluation);
    fmt::print("{}.accelerations = {:.4g} us\n", name_, 1e6 * best_.acceleration);
    fmt::print("{}.{}.steps_per_second = {:.5g} 1/s\n", name_, options_.method, 1.0 / best_.step);
    fmt::print("{}.{}.steps = {} 1\n", name_, options_.method, steps_);
    return best_;
  }

 private:
  static double seconds_per_call(const std::function<void()>& call) {
    call();
    const double start = now();
    int n = 0;
    do {
      call();
      ++n;
    } while (now() - start < 0.01);
    return (now() - start) / n;
  }

  std::string name_;
  Started start_;
  SolverOptions options_;
  Times best_;
  long steps_ = 0;
};

std::vector<Times> measure(std::vector<std::unique_ptr<Subject>> subjects, int samples) {
  for (int sample = 0; sample < samples; ++sample)
    for (auto& subject : subjects) subject->sample();
  std::vector<Times> times;
  for (auto& subject : subjects) times.push_back(subject->report());
  return times;
}

void growth(const std::string& name, double small, double large, double factor) {
  fmt::print("{}.growth_exponent = {:.3f} 1\n", name, std::log(large / small) / std::log(factor));
}

}  // namespace
}  // namespace flexura::mbs

int main() {
  using namespace flexura::mbs;
  std::vector<std::unique_ptr<Subject>> subjects;
  for (const int n : {10, 100, 1000})
    subjects.push_back(std::make_unique<Subject>(fmt::format("chain_{}", n), chain(n), "runge_kutta", 0.2));
  const auto chains = measure(std::move(subjects), 10);
  growth("chain.residual", chains[0].evaluation, chains[2].evaluation, 100.0);
  growth("chain.accelerations", chains[0].acceleration, chains[2].acceleration, 100.0);
  growth("chain.step", chains[0].step, chains[2].step, 100.0);
  subjects.clear();
  for (const int n : {10, 100})
    subjects.push_back(std::make_unique<Subject>(fmt::format("chain_{}", n), chain(n), "ida", 0.2));
  measure(std::move(subjects), 2);
  subjects.clear();
  for (const int n : {2, 20, 60, 200})
    subjects.push_back(std::make_unique<Subject>(fmt::format("windows_{}", n), windows(n), "ida", 0.2));
  const auto loops = measure(std::move(subjects), 2);
  growth("windows.ida.step", loops[1].step, loops[3].step, 10.0);
  return 0;
}
