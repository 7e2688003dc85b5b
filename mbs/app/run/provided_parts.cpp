// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/provided_parts.hpp"

#include <fmt/format.h>

#include "mbs/base/files/signals.hpp"
#include "mbs/study/ledger/estimated_error.hpp"

namespace flexura::app {

std::unique_ptr<study::PartsOnDemand> provide_parts(SimulateArguments& arguments,
                                                    const std::filesystem::path& bin,
                                                    terminal::Progress& progress,
                                                    const terminal::Verbosity& verbosity) {
  study::Telling telling;
  telling.progress = [&progress](std::string_view stage) { progress(stage, -1.0); };
  telling.note = [&progress, &verbosity](const std::string& sentence) {
    if (verbosity.quiet) return;
    progress.clear();
    terminal::say(stderr, "note: " + sentence);
  };
  telling.warning = [&progress](const std::string& sentence) {
    progress.clear();
    terminal::say(stderr, "warning: " + sentence);
  };
  auto parts = std::make_unique<study::PartsOnDemand>(arguments.file, bin, arguments.cache,
                                                      arguments.run_scripts, std::move(telling));
  const files::StopRequests signals;
  const std::vector<std::string> set = parts->provide(arguments.set, arguments.runs);
  progress.clear();
  arguments.set.insert(arguments.set.end(), set.begin(), set.end());
  return parts;
}

std::vector<std::string> finer_parts(study::PartsOnDemand& parts, const mbs::PreparedMechanism& prepared) {
  const double accuracy = prepared.file.solver.quantity("accuracy");
  if (!(accuracy > 0.0)) return {};
  std::vector<study::MeshOfBody> meshes;
  for (const study::ErrorSource& source : study::discretisation_of(prepared))
    if (source.kind == "mesh") meshes.push_back({source.name, source.error});
  return parts.refine(meshes, accuracy);
}

}  // namespace flexura::app
