// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <functional>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/flexible/chain.hpp"
#include "tests/mbs/started.hpp"

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
  return std::make_shared<ModalBody>(modal_data(beams::beam_superelement(b), options));
}

struct Times {
  double set_up, residual, step;
};

Times measure(const std::string& name, MechanismDescription description) {
  Times out{};
  double start = now();
  const Started begin(std::move(description));
  const Mechanism& m = begin.m;
  const State& s = begin.s;
  const Eigen::VectorXd& v_dot = begin.v_dot;
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
  const auto measured = [&](const char* name, const Chain& chain) {
    return measure(fmt::format("flexible_{}_{}", name, chain.links), chain_of(link, chain));
  };
  const auto series = [&](const char* name, bool closed) {
    const Times few = measured(name, {.links = 10, .closed = closed});
    const Times many = measured(name, {.links = 100, .closed = closed});
    const auto growth = [&](const char* what, double small, double large) {
      fmt::print("flexible_{}.{}.growth_exponent = {:.2f} 1\n", name, what, std::log10(large / small));
    };
    growth("residual", few.residual, many.residual);
    growth("step", few.step, many.step);
  };
  series("chain", false);
  series("loop", true);
  // What the constraints between the links save.
  measure("flexible_chain_10_in_tree", chain_of(link, {.links = 10, .keep_whole = true}));
  return 0;
}
