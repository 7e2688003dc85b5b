// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/integrator_check.hpp"

#include <fmt/format.h>

#include <algorithm>
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

bool energy_tells_more(double relative_energy_error, double estimated_error) {
  constexpr double kTells = 0.01, kBeyond = 30.0;
  return std::abs(relative_energy_error) > std::max(kTells, kBeyond * estimated_error);
}

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
      which_(judged_outputs(run, *run.mechanism, outputs_)),
      families_(*run.mechanism, length_of(run)),
      rows_(*run.mechanism, which_, rows_between(run)) {}

void IntegratorCheck::take(const mbs::State& s, const VectorXd& v_dot) {
  const std::size_t before = rows_.size();
  rows_.take(s, v_dot);
  if (rows_.size() > before) families_.take(s, v_dot);
}

IntegratorEstimate IntegratorCheck::estimate(const mbs::RunCallbacks& callbacks) {
  mbs::SolverOptions options = run_.options;
  IntegratorEstimate out;
  out.factor = factor_;
  const bool by_step = options.fixed_step > 0.0;
  out.note = fmt::format("a second run at {:g} times the {}", factor_, by_step ? "step" : "tolerance");
  (by_step ? options.fixed_step : options.tolerance) *= factor_;
  OutputRows others(*run_.mechanism, which_, rows_between(run_));
  mbs::RunCallbacks mine = callbacks;
  mine.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount&) {
    others.take(s, v_dot);
  };
  const mbs::RunResult again = mbs::run(*run_.mechanism, run_.state, run_.v_dot, options, mine);
  out.wall = again.wall_time;
  const OutputRows::Difference off = rows_.against(others, options.end_time - options.start_time);
  if (!again.complete || off.rows == 0)
    throw std::runtime_error(fmt::format(
        "the second run that tells the integrator's error ({} {:g}) stopped: {}",
        by_step ? "fixed_step" : "tolerance", by_step ? options.fixed_step : options.tolerance,
        again.stopped_because.empty() ? "it has no row in common with the first" : again.stopped_because));
  const auto count = static_cast<double>(off.rows);
  const double times = std::abs(std::pow(factor_, power_) - 1.0);  // the difference over the error
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    outputs_[i].rms = std::sqrt(off.squares(static_cast<Eigen::Index>(i)) / count) / times;
    outputs_[i].size_rms = std::sqrt(off.sizes(static_cast<Eigen::Index>(i)) / count);
  }
  families_.judge(outputs_, !run_.file.outputs.empty(), tolerance_of_noise(run_), Families::Of::run);
  const auto [error, worst] = worst_output(off.squares, count, outputs_);
  out.error = error / times;
  if (worst >= 0) out.output = outputs_[static_cast<std::size_t>(worst)].name;
  return out;
}

}  // namespace flexura::study
