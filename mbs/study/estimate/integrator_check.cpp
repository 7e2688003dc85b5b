// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/integrator_check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <stdexcept>

#include "mbs/solver/accuracy/integrator_kind.hpp"

namespace flexura::study {
namespace {

using Eigen::VectorXd;

constexpr double kFactor = 10.0, kLargestTolerance = 0.1;

// The global error goes with the tolerance to this power, with a fixed step to the method's order.
std::optional<double> power_of(const mbs::SolverOptions& options) {
  const mbs::IntegratorKind& kind = mbs::kind_of(options);
  const double power = options.fixed_step > 0.0 ? kind.power_of_step : kind.power_of_tolerance;
  return power > 0.0 ? std::optional(power) : std::nullopt;
}

}  // namespace

std::unique_ptr<IntegratorCheck> IntegratorCheck::make(const mbs::PreparedMechanism& run) {
  const std::optional<double> power = power_of(run.options);
  if (!power) return nullptr;
  // Where no looser tolerance is allowed a tighter one serves as well: E = |y_2 - y_1| / (1 - factor^p).
  double factor = kFactor;
  if (run.options.fixed_step > 0.0)
    factor = 2.0;
  else if (factor * run.options.tolerance > kLargestTolerance)
    factor = 1.0 / kFactor;
  std::unique_ptr<IntegratorCheck> check(new IntegratorCheck(run, factor, *power));
  return check->which_.empty() ? nullptr : std::move(check);
}

IntegratorCheck::IntegratorCheck(const mbs::PreparedMechanism& run, double factor, double power)
    : run_(run),
      factor_(factor),
      power_(power),
      scratch_(run.mechanism->make_scratch()),
      which_(judged_outputs(run, *run.mechanism, outputs_)),
      families_(*run.mechanism, length_of(run)),
      every_(rows_between(run)) {}

void IntegratorCheck::evaluate(const mbs::State& s, const VectorXd& v_dot, VectorXd& y) {
  y.resize(static_cast<Eigen::Index>(which_.size()));
  run_.mechanism->evaluate(which_, s, v_dot, *scratch_, y);
}

void IntegratorCheck::take(const mbs::State& s, const VectorXd& v_dot) {
  if (!is_wanted()) return;
  times_.push_back(s.t);
  evaluate(s, v_dot, values_.emplace_back());
  families_.take(s, v_dot);
}

IntegratorEstimate IntegratorCheck::estimate(const mbs::RunCallbacks& callbacks) {
  mbs::SolverOptions options = run_.options;
  IntegratorEstimate out;
  out.factor = factor_;
  const bool by_step = options.fixed_step > 0.0;
  out.note = fmt::format("a second run at {:g} times the {}", factor_, by_step ? "step" : "tolerance");
  (by_step ? options.fixed_step : options.tolerance) *= factor_;
  const auto n = static_cast<Eigen::Index>(which_.size());
  VectorXd squares = VectorXd::Zero(n), sizes = VectorXd::Zero(n), y;
  std::size_t row = 0;
  rows_ = 0;
  mbs::RunCallbacks mine = callbacks;
  mine.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount&) {
    if (!is_wanted() || row >= times_.size()) return;
    // Rows stand at the same times, the last where the run ended.
    if (std::abs(s.t - times_[row]) > 1e-9 * std::abs(options.end_time - options.start_time)) return;
    evaluate(s, v_dot, y);
    squares += (y - values_[row]).cwiseAbs2();
    sizes += values_[row].cwiseAbs2();
    ++row;
  };
  const mbs::RunResult again = mbs::run(*run_.mechanism, run_.state, run_.v_dot, options, mine);
  out.wall = again.wall_time;
  if (!again.complete || row == 0)
    throw std::runtime_error(fmt::format(
        "the second run that tells the integrator's error ({} {:g}) stopped: {}",
        by_step ? "fixed_step" : "tolerance", by_step ? options.fixed_step : options.tolerance,
        again.stopped_because.empty() ? "it has no row in common with the first" : again.stopped_because));
  const auto count = static_cast<double>(row);
  for (Eigen::Index i = 0; i < n; ++i)
    outputs_[static_cast<std::size_t>(i)].size_rms = std::sqrt(sizes(i) / count);
  families_.judge(outputs_, !run_.file.outputs.empty(), run_.options.tolerance);
  const auto [error, worst] = worst_output(squares, count, outputs_);
  out.error = error / std::abs(std::pow(factor_, power_) - 1.0);
  if (worst >= 0) out.output = outputs_[static_cast<std::size_t>(worst)].name;
  return out;
}

}  // namespace flexura::study
