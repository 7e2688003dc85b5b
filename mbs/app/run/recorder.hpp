// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/app/run/watch/creep_watch.hpp"
#include "mbs/app/run/watch/path_watch.hpp"
#include "mbs/app/run/watch/turn_watch.hpp"
#include "mbs/mechanism/range/linear_range.hpp"
#include "mbs/results/results.hpp"
#include "mbs/solver/run/energy.hpp"
#include "mbs/solver/run/growth.hpp"

/// From a mechanism's states to a results file.
namespace flexura::app {

results::ModelHeader model_header(std::span<const NamedRun> runs, const std::filesystem::path& mechanism_file,
                                  const std::filesystem::path& results_file);

/// The same of mechanisms that are no runs.
results::ModelHeader model_header(const std::vector<const mbs::PreparedMechanism*>& runs,
                                  const std::filesystem::path& mechanism_file,
                                  const std::filesystem::path& results_file);

/// What energy.* quantities take from the run's own account; the rest follows from the states alone.
struct EnergyRow {
  double work_in = 0.0, dissipated = 0.0, balance = 0.0;
};

/// Writes one run.
class Recorder {
 public:
  /// `patterns` of wanted quantities, none for the usual ones.
  Recorder(const mbs::PreparedMechanism& prepared, results::Writer& writer,
           const std::vector<std::string>& patterns, bool store_states);
  /// What the mechanism's file wants.
  Recorder(const mbs::PreparedMechanism& prepared, results::Writer& writer)
      : Recorder(prepared, writer, prepared.file.outputs, prepared.options.store_states) {}
  void begin(const std::string& name);
  /// Who looks at every row as it is appended: time, poses X_WB and modal coordinates of all bodies.
  using Look =
      std::function<void(double, const std::vector<mbs::Pose>&, const std::vector<Eigen::VectorXd>&)>;
  void look_at_rows(Look look) { look_ = std::move(look); }
  void append(const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy);
  /// A row of a run in time, watched.
  void append(const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& energy);
  /// Judges the row just appended: throws std::runtime_error where the motion grows without bound.
  void watch(const mbs::State& s, double kinetic_energy);
  /// Whether flexible bodies stayed in the linear range in the rows so far.
  const mbs::LinearRange& range() const { return range_; }
  /// What the user should know of the rows so far.
  std::vector<std::string> notes() const { return creep_.sentences(); }

 private:
  const mbs::Mechanism& mechanism_;
  results::Writer& writer_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<int> which_;
  std::vector<results::Quantity> quantities_;
  std::vector<results::RunBody> run_bodies_;
  std::vector<mbs::Pose> poses_, poses_before_;
  double t_before_ = 0.0;
  mbs::LinearRange range_;
  mbs::GrowthWatch growth_;
  TurnWatch turns_;
  PathWatch paths_;
  CreepWatch creep_;
  Eigen::VectorXd p_start_, p_scale_;
  results::Row row_;
  bool store_states_;
  Look look_;
};

/// Names of all states in a results file: positions, velocities ("hinge.speed'"), dynamic and algebraic
/// states, multipliers ("lambda.hinge.x") and switches ("switch.floor.gap").
std::vector<std::string> state_names(const mbs::Mechanism& mechanism);
/// A row of them, and back.
Eigen::VectorXd pack(const mbs::State& s);
mbs::State unpack(const mbs::Mechanism& mechanism, double t, const Eigen::VectorXd& states);

}  // namespace flexura::app
