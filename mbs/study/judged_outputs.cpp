// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/judged_outputs.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "mbs/input/units.hpp"

namespace flexura::study {
namespace {

// Rows beyond so many are thinned out.
constexpr double kMostRows = 800.0;
// An output counts from this part of the largest one of its unit on: below it symmetry and round-off stand,
// not motion.  What nobody asked for by name has to be larger to matter.
constexpr double kNothing = 1e-6, kNothingUnasked = 1e-3;

}  // namespace

std::vector<int> judged_outputs(const mbs::PreparedMechanism& run, const mbs::Mechanism& full,
                                std::vector<OutputEstimate>& sums) {
  const auto run_infos = run.mechanism->quantities(), infos = full.quantities();
  const bool asked = !run.file.outputs.empty();
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < infos.size(); ++i) index.emplace(infos[i].name, static_cast<int>(i));
  std::vector<int> outputs;
  for (const int i : mbs::select_quantities(*run.mechanism, run.file.outputs)) {
    const std::string& name = run_infos[static_cast<std::size_t>(i)].name;
    const auto found = index.find(name);
    if (found == index.end() || name.find(".mode_") != std::string::npos) continue;
    // Energies are stored for the balance; strain energy is not what a rigid body is judged by.
    if (!asked &&
        (name.starts_with("energy.") || name.starts_with("power.") || name.ends_with(".strain_energy")))
      continue;
    outputs.push_back(found->second);
    OutputEstimate output;
    output.name = name;
    output.unit = input::si_unit(infos[static_cast<std::size_t>(found->second)].dimension);
    sums.push_back(std::move(output));
  }
  return outputs;
}

long rows_between(const mbs::PreparedMechanism& run) {
  const mbs::SolverOptions& o = run.options;
  return std::max(1L, static_cast<long>((o.end_time - o.start_time) / o.output_step / kMostRows));
}

void find_what_counts(std::vector<OutputEstimate>& outputs, bool asked) {
  std::map<std::string, double> largest;
  for (const OutputEstimate& o : outputs) {
    double& most = largest[o.unit];
    most = std::max(most, o.size_rms);
  }
  for (OutputEstimate& o : outputs)
    o.counts = o.size_rms > (asked ? kNothing : kNothingUnasked) * largest[o.unit];
}

double OutputEstimate::relative_max() const {
  return size_max > 0.0 ? max / size_max : 0.0;
}
double OutputEstimate::relative_rms() const {
  return size_rms > 0.0 ? rms / size_rms : 0.0;
}

std::pair<double, int> worst_output(const Eigen::VectorXd& squares, double span,
                                    const std::vector<OutputEstimate>& outputs) {
  std::pair<double, int> worst{0.0, -1};
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const OutputEstimate& o = outputs[i];
    if (!o.counts || !(o.size_rms > 0.0)) continue;
    const double error = std::sqrt(squares(static_cast<Eigen::Index>(i)) / span) / o.size_rms;
    if (error > worst.first) worst = {error, static_cast<int>(i)};
  }
  return worst;
}

}  // namespace flexura::study
