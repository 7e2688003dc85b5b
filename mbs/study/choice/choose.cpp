// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/choose.hpp"

#include <algorithm>

#include "mbs/study/choice/chooser.hpp"

namespace flexura::study {

double accuracy_of(const mbs::PreparedMechanism& run) {
  return run.file.solver.quantity("accuracy");
}

bool is_open(const mbs::PreparedMechanism& run, const mbs::BodyDescription& body) {
  if (!body.is_reduced() || body.name.find('.') != std::string::npos)
    return false;  // a subsystem's own file says
  const auto given = run.file.leaves_fidelity_open.find(body.name);
  return given == run.file.leaves_fidelity_open.end() ? accuracy_of(run) > 0.0 : given->second;
}

bool is_to_be_chosen(const mbs::PreparedMechanism& run) {
  return accuracy_of(run) > 0.0 || std::ranges::any_of(run.mechanism->description().bodies,
                                                       [&](const auto& body) { return is_open(run, body); });
}

ChosenRun run_within(const mbs::PreparedMechanism& given, const mbs::RunCallbacks& callbacks,
                     bool integrator) {
  return Chooser(given, callbacks, integrator).run();
}

}  // namespace flexura::study
