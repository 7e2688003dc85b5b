// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/app/run/recorder.hpp"
#include "mbs/app/run/results_summary.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/results/csv_name.hpp"
#include "mbs/solver/algebra/accelerations.hpp"

/// outputs: quantities computed afterwards from the states that a run has stored.
namespace flexura::app {
namespace {

struct Arguments : MechanismArguments {
  std::string results, output;
  std::vector<std::string> quantities;
  bool csv = false, json = false;
};

double stored(const results::Run& run, Eigen::Index row, const char* name) {
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name == name) return run.values(row, static_cast<Eigen::Index>(i));
  return 0.0;
}

void require_states_of(const mbs::Mechanism& mechanism, const results::Run& run, const std::string& file) {
  if (run.states.size() == 0)
    throw std::invalid_argument(fmt::format(
        "{}: run \"{}\" has no states stored; simulate with --set solver.store_states=true", file, run.name));
  const std::vector<std::string> wanted = state_names(mechanism);
  for (std::size_t i = 0; i < std::max(wanted.size(), run.state_names.size()); ++i) {
    const std::string here = i < wanted.size() ? wanted[i] : "none",
                      there = i < run.state_names.size() ? run.state_names[i] : "none";
    if (here != there)
      throw std::invalid_argument(
          fmt::format("{}: run \"{}\" is of another mechanism: its state {} is \"{}\", the mechanism's is "
                      "\"{}\"; give the file that made it",
                      file, run.name, i + 1, there, here));
  }
}

int compute(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  std::filesystem::path path = arguments.output;
  if (path.empty()) {
    path = arguments.results;
    path.replace_filename(path.stem().string() + "_outputs.h5");
  }
  files::Claims claims;
  claims.add(path);
  const results::Results in = results::read(arguments.results);
  const std::vector<NamedRun> runs = prepare_runs(arguments);
  if (arguments.csv)
    for (const NamedRun& run : runs) claims.add(results::csv_name(path, run.name));
  // All checked before anything is written.
  std::vector<const results::Run*> sources;
  for (const NamedRun& run : runs) {
    const auto found =
        std::ranges::find_if(in.runs, [&](const results::Run& r) { return r.name == run.name; });
    if (found == in.runs.end()) {
      std::vector<std::string> known;
      for (const results::Run& r : in.runs) known.push_back(r.name);
      throw std::invalid_argument(fmt::format("{}: there is no run \"{}\"{}", arguments.results, run.name,
                                              input::suggestion(run.name, known)));
    }
    require_states_of(*run.prepared.mechanism, *found, arguments.results);
    sources.push_back(&*found);
  }
  results::Writer writer(path, model_header(runs, arguments.file, path));
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const mbs::PreparedMechanism& p = runs[k].prepared;
    const results::Run& source = *sources[k];
    Recorder recorder(p, writer, arguments.quantities.empty() ? p.file.outputs : arguments.quantities, false);
    recorder.begin(runs[k].name);
    mbs::AccelerationSolver accelerations(*p.mechanism);
    for (Eigen::Index row = 0; row < source.time.size(); ++row) {
      mbs::State s = unpack(*p.mechanism, source.time(row), source.states.row(row));
      Eigen::VectorXd v_dot;
      accelerations.solve(s, v_dot);
      recorder.append(s, v_dot,
                      EnergyRow{stored(source, row, "energy.input"), stored(source, row, "energy.dissipated"),
                                stored(source, row, "energy.balance")});
    }
    writer.end_run(source.complete, source.stopped_because, source.summary_json);
  }
  writer.close();
  std::vector<std::string> files = {path.string()};
  if (arguments.csv)
    for (const auto& table : results::write_csv(results::read(path), path)) files.push_back(table.string());
  if (arguments.json) {
    nlohmann::json told = summary_json("outputs", results::read(path));
    told["files"] = files;
    fmt::print("{}\n", told.dump(1));
  } else if (!verbosity.quiet) {
    for (std::size_t i = 1; i < files.size(); ++i) fmt::print("table   {}\n", files[i]);
    fmt::print("results {}\n", files[0]);
  }
  return 0;
}

}  // namespace

terminal::Command outputs_command() {
  return {"outputs", "compute quantities afterwards from stored states",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto a = std::make_shared<Arguments>();
            declare_mechanism(options, *a);
            options.argument("RESULTS", a->results, "results with states (solver.store_states = true)")
                .option("--quantity", a->quantities, "NAME",
                        "what to compute, * and ? are wildcards; default: what the mechanism file says")
                .option("-o,--output", a->output, "FILE", "results file (default: RESULTS_outputs.h5)")
                .flag("--csv", a->csv, "write a table of each run beside it")
                .flag("--json", a->json,
                      "print names, units and ranges of what was computed, and the files, as JSON")
                .example("flexura outputs engine.toml engine.h5 --quantity \"pin.force_*\" --csv",
                         "reactions that the run did not store");
            return [a, &verbosity] { return compute(*a, verbosity); };
          }};
}

}  // namespace flexura::app
