// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/beside_switches.hpp"

#include <fmt/format.h>

#include <set>
#include <stdexcept>

namespace flexura::mbs {
namespace {

using Eigen::VectorXd;

// Of a typical size: statics comes to 1e-10 of it.
constexpr double kBeside = 1e-9;

// Whether neither its states nor its output follow its signals: asked with two sets of them, as good as any.
bool keeps_its_value(const Control& control, int n_signals) {
  if (control.n_switches() == 0 || control.reads().empty() || control.is_algebraic()) return false;
  VectorXd c = VectorXd::Zero(control.n_states()), rate[2] = {c, c};
  double output[2] = {};
  try {
    control.start(c.data());
    for (int i = 0; i < 2; ++i) {
      const VectorXd signals = VectorXd::Constant(n_signals, 0.3 + 0.4 * i);
      control.rates(signals.data(), c.data(), rate[i].data());
      output[i] = control.output(signals.data(), c.data());
    }
  } catch (const std::runtime_error&) {  // a formula without a value there: it is asked, so it follows
    return false;
  }
  return rate[0] == rate[1] && output[0] == output[1];
}

}  // namespace

std::vector<std::string> notes_on_switches(const Mechanism& mechanism, const State& s) {
  std::vector<std::string> out;
  const Sizes n = mechanism.sizes();
  if (n.n_root > 0) {
    const auto scratch = mechanism.make_scratch();
    VectorXd here(n.n_root), there(n.n_root);
    mechanism.roots(s, *scratch, here);
    std::set<int> beside;
    for (int i = 0; i < n.n_v; ++i)
      for (const double sign : {1.0, -1.0}) {
        const VectorXd d = sign * kBeside * mechanism.velocity_scale(i) * VectorXd::Unit(n.n_v, i);
        State moved = s;
        mechanism.retract(s.p, d, moved.p);
        moved.v += d;
        mechanism.roots(moved, *scratch, there);
        for (int k = 0; k < n.n_root; ++k)
          if (there(k) < 0.0 && there(k) < here(k)) beside.insert(k);
      }
    for (const int k : beside)
      out.push_back(fmt::format(
          "the state stands where {} switches: the linear system is that of one side, and stability "
          "is not told from it; take a state beside it",
          mechanism.describe_root(k)));
  }
  for (const auto& control : mechanism.description().controls)
    if (keeps_its_value(*control, mechanism.description().signals.size()))
      out.push_back(fmt::format(
          "control \"{}\" keeps its value between its switches: a loop that it closes is open in the "
          "linear system",
          control->name()));
  return out;
}

}  // namespace flexura::mbs
