// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <functional>
#include <numbers>

#include "mbs/model/mechanism.hpp"
#include "mbs/model/modal_basis.hpp"
#include "mbs/solver/assemble.hpp"
#include "mbs/solver/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

/// Chains and loops of flexible bodies with 20 modes each: time of the set-up, of a residual and of a step,
/// and how they grow with the number of bodies.
namespace flexura::mbs {
namespace {

// Of processor time: other programs on the machine must not count.
double now() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::shared_ptr<const FlexibleBody> link_body() {
  beams::StraightBeam b;
  b.EA = 1e6;
  b.GI_t = 40.0;
  b.EI_y = b.EI_z = 50.0;
  b.rho_I_y = b.rho_I_z = 1e-5;
  b.elements = 8;
  BasisOptions options;
  options.modes = 20;
  options.damping = 0.01;
  return std::make_shared<FlexibleBody>(modal_data(beams::beam_superelement(b), options));
}

enum class Kind { chain, loop, tree };  // tree: a chain with every joint in the tree

// n links of 1 m along x, hinged about z and y in turn; of a loop the end is held where it starts.
MechanismDescription links(const std::shared_ptr<const FlexibleBody>& link, int n, Kind kind) {
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  int before = 0;
  for (int i = 0; i < n; ++i) {
    const int body = d.add_body({.name = fmt::format("link_{}", i), .flexible = link});
    Pose turn;
    if (i % 2 == 1) turn.R = rotation_exp({0.5 * std::numbers::pi, 0.0, 0.0});
    const int from = i == 0 ? d.add_marker(0, "wall", turn) : d.add_marker(before, "out", turn, 1);
    const int j =
        d.add_joint(fmt::format("hinge_{}", i), "revolute", from, d.add_marker(body, "in", turn, 0));
    d.joints[j].keep_in_tree = kind == Kind::tree;
    before = body;
  }
  if (kind == Kind::loop) {
    Pose end;
    end.p = {1.0 * n, 0.0, 0.0};
    const int j =
        d.add_joint("end", "spherical", d.add_marker(0, "end", end), d.add_marker(before, "end", {}, 1));
    d.joints[j].cut = true;
  }
  return d;
}

struct Times {
  double set_up, residual, step;
};

Times measure(const std::string& name, MechanismDescription description) {
  Times out{};
  double start = now();
  Mechanism m(std::move(description));
  State s = m.initial_state();
  Eigen::VectorXd v_dot;
  assemble_positions(m, s);
  m.drop_redundant(0.0, s.p);
  s.lambda = Eigen::VectorXd::Zero(m.sizes().n_lambda);
  assemble(m, s, v_dot);
  out.set_up = now() - start;

  const Sizes n = m.sizes();
  auto scratch = m.make_scratch();
  Eigen::VectorXd r(n.n_v), none(0), g(n.n_lambda), g_dot(n.n_lambda), f(n.n_v);
  out.residual = 1e300;
  for (int sample = 0; sample < 5; ++sample) {
    start = now();
    int calls = 0;
    do {
      m.residuals(s, v_dot, s.lambda, *scratch, r, none, none, g_dot, g, f);
      ++calls;
    } while (now() - start < 0.01);
    out.residual = std::min(out.residual, (now() - start) / calls);
  }

  SolverOptions options;
  options.method = "radau";
  options.end_time = 0.05;
  options.output_step = 0.01;
  options.tolerance = 1e-4;
  start = now();
  const RunResult result = run(m, s, v_dot, options);
  const double seconds = now() - start;
  if (!result.complete) fmt::print(stderr, "{}: {}\n", name, result.stopped_because);
  out.step = seconds / static_cast<double>(result.counts.steps);
  fmt::print("{}.set_up = {:.3g} ms\n", name, 1e3 * out.set_up);
  fmt::print("{}.residual = {:.4g} us\n", name, 1e6 * out.residual);
  fmt::print("{}.step = {:.3g} ms\n", name, 1e3 * out.step);
  fmt::print("{}.steps = {} 1\n", name, result.counts.steps);
  fmt::print("{}.run = {:.3g} s\n", name, seconds);
  return out;
}

}  // namespace
}  // namespace flexura::mbs

int main() {
  using namespace flexura::mbs;
  const auto link = link_body();
  const auto series = [&](const char* name, Kind kind) {
    const Times few = measure(fmt::format("flexible_{}_10", name), links(link, 10, kind));
    const Times many = measure(fmt::format("flexible_{}_100", name), links(link, 100, kind));
    const auto growth = [&](const char* what, double small, double large) {
      fmt::print("flexible_{}.{}.growth_exponent = {:.2f} 1\n", name, what, std::log10(large / small));
    };
    growth("residual", few.residual, many.residual);
    growth("step", few.step, many.step);
  };
  series("chain", Kind::chain);
  series("loop", Kind::loop);
  // What the constraints between the links save.
  measure("flexible_chain_10_in_tree", links(link, 10, Kind::tree));
  return 0;
}
