// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "mbs/app/run/recorder.hpp"
#include "mbs/base/documents/content_hash.hpp"
#include "mbs/solver/run/run_memory.hpp"

/// Checkpoints of `flexura simulate`: what a run needs to be taken up after its process was killed, so that
/// the results are those of a run that was never cut.
///
/// Beside the output lie
///
///     OUTPUT.checkpoint, OUTPUT.checkpoint.before   the last two: JSON, the run's memory (run_memory.hpp)
///     and
///                                                   how much of the rows belongs to it, with a checksum
///     OUTPUT.checkpoint.rows                        all rows so far, binary: the state, accelerations,
///     energies
///
/// A run that goes on gives the rows to everything that observes the run (results, estimates, warnings) once
/// more, and then integrates.  All three are removed when the results are whole.
namespace flexura::app {

struct CheckpointFiles {
  explicit CheckpointFiles(const std::filesystem::path& output);
  std::filesystem::path newest, before, rows;
};

/// What must be the same in the command that goes on: the content of all its files, its options.
nlohmann::json identity_of_runs(const MechanismArguments& arguments, const nlohmann::json& options);

using StoredRow =
    std::function<void(const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy)>;

/// What a process that was killed has left.
class Resumption {
 public:
  /// Reads the newer checkpoint that is whole.  Throws std::invalid_argument, one sentence, where there is
  /// none and where `identity` is another.
  Resumption(const std::filesystem::path& output, const nlohmann::json& identity);

  double interval() const { return interval_; }      ///< [s]
  const std::string& note() const { return note_; }  ///< where the newest checkpoint was damaged
  const std::string& run() const { return run_; }    ///< that was under way
  std::uint64_t size() const { return size_; }       ///< of the rows file [bytes]
  /// How a run ended that was complete by then; null for others.
  const nlohmann::json* end_of(const std::string& run) const;
  /// Gives the rows of this run, in their order.
  void replay(const std::string& run, const mbs::Mechanism& mechanism, const StoredRow& row) const;
  /// The memory of the run that was under way.
  mbs::RunMemory memory(const mbs::Mechanism& mechanism) const;

 private:
  CheckpointFiles files_;
  double interval_ = 0.0;
  std::string run_, note_;
  std::uint64_t size_ = 0;
  nlohmann::json memory_;
  std::map<std::string, nlohmann::json> ends_;
};

/// Writes them.
class Checkpoints {
 public:
  /// Every `interval` seconds.  Checkpoints of an earlier run stay until the first of this one.  With `from`
  /// the rows go on where that one ends.
  Checkpoints(const std::filesystem::path& output, double interval, nlohmann::json identity,
              const Resumption* from);
  ~Checkpoints();
  Checkpoints(const Checkpoints&) = delete;
  Checkpoints& operator=(const Checkpoints&) = delete;

  void begin_run(const std::string& run);
  void add(const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy);
  void end_run(const nlohmann::json& end);

  /// After the interval; on a slow disk after so long that they take a tenth of the time at most.
  bool due() const { return Clock::now() - last_ >= std::max(interval_, 9.0 * cost_); }
  void take(const mbs::RunMemory& memory);
  bool any() const { return any_; }  ///< one is there to go on from
  /// The results are whole.
  void remove();

 private:
  using Clock = std::chrono::steady_clock;
  struct RowsFile;
  void put(std::uint64_t kind, std::string_view content);

  CheckpointFiles files_;
  std::chrono::duration<double> interval_, cost_{0.0};
  nlohmann::json identity_;
  std::string run_;
  std::unique_ptr<RowsFile> rows_;
  Clock::time_point last_ = Clock::now();
  bool any_ = false;
};

}  // namespace flexura::app
