// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mbs/base/terminal/command_line.hpp"
#include "mbs/solver/linear/stability.hpp"
#include "mbs/solver/linear/steady_state.hpp"
#include "mbs/solver/start/prepare.hpp"

/// What all commands on mechanism files share.
namespace flexura::app {

struct MechanismArguments {
  std::string file;
  std::vector<std::string> set{}, runs{};
  std::string state{};       ///< state set of the file to start from
  std::string from_state{};  ///< state file to start from
  std::string cache{};       ///< folder for prepared bodies; empty: none
};

void declare_mechanism(terminal::Options& options, MechanismArguments& arguments, bool needs_file = true);

/// What declare_mechanism() declares beside FILE: --set, --state, --from-state, --run, --cache.
void declare_choices(terminal::Options& options, MechanismArguments& arguments);

struct NamedRun {
  std::string name;
  mbs::PreparedMechanism prepared;
  std::vector<std::string> warnings = {};  ///< of its start, printed already
};

/// The runs that the file names and the user chose, each assembled.  Throws std::invalid_argument for a run
/// that is not there.
std::vector<NamedRun> prepare_runs(const MechanismArguments& arguments);

/// The single run of those chosen, for what makes one file: `option` names what asked for it.
NamedRun& only_run(std::vector<NamedRun>& runs, const MechanismArguments& arguments,
                   const std::string& option);

/// Moves the state into static equilibrium and judges it, with notes; those that are warnings bear their mark.
mbs::Stability move_to_equilibrium(mbs::PreparedMechanism& prepared);

/// Notes that bear the mark of warnings (not_assembled.hpp) become the run's warnings, printed on stderr.
void give_warnings(NamedRun& run);

/// Closes the notes of a command that estimates no error: what of the bodies' discretisation nothing judged, and
/// what is known of the rest (estimated_error.hpp).
void note_discretisation(mbs::PreparedMechanism& prepared);

/// The prepared state is an equilibrium or one of a steady motion.
bool lasts(const mbs::PreparedMechanism& prepared);

/// The linear system about the prepared state, with notes on what it means.  A state within the tolerance of an equilibrium
/// moves there.  Throws std::invalid_argument
/// where it means nothing (steady_state.hpp), unless `frozen` asks for it all the same.
mbs::SteadyLinearisation linearise_about(mbs::PreparedMechanism& prepared,
                                         const mbs::LineariseOptions& options, bool frozen);
/// "equilibrium", "steady motion", "frozen", or "the given state, which accelerates by 0.1 m/s^2 or rad/s^2" where none was
/// found within whose tolerance it stands.
std::string about_what(const mbs::PreparedMechanism& prepared, mbs::SteadyLinearisation::Verdict verdict);
/// What --frozen says of itself.
extern const char* const kFrozenHelp;

/// "engine, run rigid, t = 0 s"; without the run where the file names none.
std::string heading(const NamedRun& run);

/// What --json says of every run: {"run", "time_s", "notes"}; commands add their own.
nlohmann::json run_json(const NamedRun& run);

/// Prints {"kind", "name", "runs": list} of the runs' mechanism.
void print_json(const std::string& kind, const std::vector<NamedRun>& runs, const nlohmann::json& list);

/// `flexura check` of a mechanism file, as tables or as JSON.
int check_mechanism(const MechanismArguments& arguments, bool json, const terminal::Verbosity& verbosity);

}  // namespace flexura::app
