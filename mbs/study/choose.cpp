// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "mbs/study/percent.hpp"
#include "mbs/terminal/terminal.hpp"

namespace flexura::study {
namespace {

using terminal::number;

constexpr double kShareOfModes = 0.5;
constexpr int kMostAttempts = 6;

// What a body is to be; modes 0 is rigid.
struct BodyChoice {
  int modes = 0, available = 0;
  std::string reason;
};
using Choices = std::map<std::string, BodyChoice>;

std::vector<std::string> as_overrides(const std::vector<std::string>& given, const Choices& choices,
                                      double tolerance) {
  std::vector<std::string> out = given;
  out.push_back(fmt::format("solver.tolerance={:.3g}", tolerance));
  for (const auto& [body, choice] : choices) {
    out.push_back(fmt::format("body.{}.fidelity={}", body, choice.modes > 0 ? "modal" : "rigid"));
    // The bound of a key that cannot be taken away; a rigid body takes no modes.
    if (choice.modes > 0) out.push_back(fmt::format("body.{}.modes={}", body, choice.modes));
  }
  return out;
}

std::string describe(const std::string& body, const BodyChoice& choice) {
  if (choice.modes == 0) return fmt::format("{}: rigid: {}", body, choice.reason);
  return fmt::format("{}: modal, {} of {} modes: {}", body, choice.modes, choice.available, choice.reason);
}

ChosenRun attempt(const std::filesystem::path& file, std::vector<std::string> overrides, bool with_ladder,
                  const mbs::RunCallbacks& callbacks) {
  ChosenRun out{mbs::prepare(file, overrides), {}, {}, {}, false, {}, {}, 0.0};
  const auto shadows = Shadows::make(out.prepared, file, overrides, with_ladder);
  mbs::RunCallbacks mine = callbacks;
  mine.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& energy) {
    out.rows.push_back({s, v_dot, energy});
    if (shadows) shadows->take(s, v_dot);
  };
  out.result =
      mbs::run(*out.prepared.mechanism, out.prepared.state, out.prepared.v_dot, out.prepared.options, mine);
  out.has_estimate = shadows != nullptr;
  if (shadows) out.estimate = shadows->estimate();
  out.overrides = std::move(overrides);
  return out;
}

// The fewest modes whose loss stays within the share; all of them when no rung does.
BodyChoice choose(const SourceEstimate& source, double share) {
  BodyChoice choice;
  choice.available = source.available;
  if (source.error <= share) {
    choice.reason = fmt::format("its deformation changes outputs by {} at most", percent(source.error));
    return choice;
  }
  const std::string rigid = fmt::format("rigid, {} would be off by {}", source.output, percent(source.error));
  for (const ModesNeeded& rung : source.ladder)
    if (rung.error <= share) {
      choice.modes = rung.modes;
      choice.reason = fmt::format("{}; what lies above {} Hz changes outputs by {} at most", rigid,
                                  number(rung.highest_hz, 3), percent(rung.error));
      return choice;
    }
  choice.modes = source.available;
  choice.reason = fmt::format("{}; no smaller number keeps outputs within {}", rigid, percent(share));
  return choice;
}

}  // namespace

ChosenRun run_within(double accuracy, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides, const mbs::RunCallbacks& callbacks) {
  if (!(accuracy > 0.0 && accuracy <= 1.0))
    throw std::invalid_argument(
        fmt::format("accuracy = {:.6g}: must be above 0 and at most 100 %", accuracy));
  const double tolerance = std::clamp(0.01 * accuracy * accuracy, 1e-9, 1e-4);
  Choices choices;
  {
    const mbs::MechanismFile given = mbs::read_mechanism(file, mbs::solver_schema(), overrides);
    for (const mbs::BodyDescription& body : given.description.bodies)
      if (!body.superelement.empty()) choices[body.name] = {};
  }
  ChosenRun run = attempt(file, as_overrides(overrides, choices, tolerance), true, callbacks);
  double screening = 0.0;
  std::vector<std::string> later;
  if (run.has_estimate && run.result.complete) {
    const double share = kShareOfModes * accuracy / static_cast<double>(choices.size());
    bool all_rigid = true;
    for (const SourceEstimate& source : run.estimate.by_body) {
      BodyChoice& choice = choices[source.body];
      choice = choose(source, share);
      all_rigid = all_rigid && choice.modes == 0;
    }
    for (int k = 0; !all_rigid && k < kMostAttempts; ++k) {
      screening += run.result.wall_time;
      run = attempt(file, as_overrides(overrides, choices, tolerance), false, callbacks);
      if (!run.result.complete || !run.has_estimate || run.estimate.error <= accuracy) break;
      const SourceEstimate& worst = run.estimate.by_body.front();
      BodyChoice& choice = choices[worst.body];
      const int more = std::min(choice.available, std::max(2 * choice.modes, 1));
      if (more == choice.modes) break;
      later.push_back(fmt::format("run again: with {} modes of {} the run estimated {} in {}", choice.modes,
                                  worst.body, percent(run.estimate.error), worst.output));
      choice.modes = more;
    }
  }
  run.screening_wall = screening;
  for (const auto& [body, choice] : choices) run.reasons.push_back(describe(body, choice));
  run.reasons.insert(run.reasons.end(), later.begin(), later.end());
  run.reasons.push_back(
      fmt::format("tolerance {:.1e}: for {} in forces and deflections", tolerance, percent(accuracy)));
  return run;
}

}  // namespace flexura::study
