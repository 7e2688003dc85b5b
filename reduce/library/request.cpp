// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/request.hpp"

#include <fmt/format.h>

#include <numbers>
#include <stdexcept>

#include "mbs/base/documents/document.hpp"
#include "reduce/cms/damping.hpp"
#include "reduce/cms/shapes/shape_change.hpp"

namespace flexura::reduce {

ReductionOptions options_of(const ReductionRequest& request) {
  const ModesInput& modes = request.modes;
  ReductionOptions how;
  how.set = modes.set;
  how.n_modes = modes.up_to > 0.0 ? 0 : modes.count;
  how.omega_max = 2.0 * std::numbers::pi * modes.up_to;
  if (modes.up_to > 0.0) how.accuracy = 0.5 * modes.accuracy;
  how.effective_mass = modes.effective_mass;
  how.response_omegas = modes.response_omegas;
  how.certify = modes.certify;
  how.stiffening = request.stiffening;
  how.all_nodes = request.recovery.all_nodes;
  return how;
}

Eigen::MatrixXd strike_out(const ReductionRequest& request, Reduction& reduction,
                           std::vector<std::string>& notes, std::vector<std::string>& warnings) {
  const ModesInput& modes = request.modes;
  if (modes.struck.empty()) return {};
  StruckModes struck;
  try {
    struck = strike_modes(reduction, modes.struck);
  } catch (const std::invalid_argument& error) {
    throw input::InputError(modes.where + ".strike_modes: " + error.what());
  }
  for (std::size_t k = 0; k < struck.frequencies.size(); ++k)
    notes.push_back(fmt::format("mode {} ({:.5g} Hz) is struck out", modes.struck[k], struck.frequencies[k]));
  // Constraint modes are exact in statics; without all of them the interface is stiffer than it is.
  if (struck.interface_stiffer > 1e-6)
    warnings.push_back(
        fmt::format("striking these modes out takes part of the constraint modes: the interfaces are up to "
                    "{:.3g} % stiffer than the part is",
                    100.0 * struck.interface_stiffer));
  return std::move(struck.Y);
}

double put_damping(const ReductionRequest& request, bool brings_damping, Reduction& reduction) {
  const double ratio = brings_damping && !request.modes.damping_given ? 0.0 : request.modes.damping;
  if (!request.has_damping) return ratio;
  DampingRule rule = request.damping;
  if (rule.critical_above > 0.0 && rule.omega.empty()) rule.omega = {0.0}, rule.ratio = {ratio};
  add_damping(reduction, rule);
  return 0.0;
}

}  // namespace flexura::reduce
