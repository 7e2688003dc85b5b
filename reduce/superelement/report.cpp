// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/superelement/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "reduce/superelement/mesh_report.hpp"

namespace flexura::reduce {

namespace {

std::vector<double> list(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

nlohmann::json mesh_json(const mesh::MeshReport& m) {
  return {{"nodes", m.n_nodes},
          {"cells", m.n_cells},
          {"size", m.size},
          {"straightened_nodes", m.n_straightened},
          {"volume", m.volume},
          {"cad_volume", m.cad_volume},
          {"volume_error", m.volume_error},
          {"inverted_cells", m.quality.n_inverted},
          {"poor_cells", m.quality.n_below},
          {"least_scaled_jacobian", m.quality.min_scaled_jacobian},
          {"centroid", list(m.centroid)},
          {"cad_centroid", list(m.cad_centroid)},
          {"seconds", m.seconds}};
}

/// Greatest over least stiffness of the interface, of displacements: how much a solver loses in it.
double interface_condition(const Reduction& reduction) {
  double least = std::numeric_limits<double>::infinity(), greatest = 0.0;
  for (const ReducedInterface& interface : reduction.interfaces)
    for (std::size_t d = 0; d < interface.directions.size(); ++d) {
      if (interface.directions[d] > 2) continue;
      const Eigen::Index b = interface.first_dof + static_cast<Eigen::Index>(d);
      least = std::min(least, reduction.K_se(b, b));
      greatest = std::max(greatest, reduction.K_se(b, b));
    }
  return greatest > 0.0 ? greatest / least : 1.0;
}

struct AcceptanceCheck {
  std::string check, value, bound;
  bool passed = true;
};

/// What a superelement must pass to be trusted.
std::vector<AcceptanceCheck> acceptance_checks(const Reduction& reduction, const ReportData& data) {
  const ReductionReport& r = reduction.report;
  std::vector<AcceptanceCheck> out;
  // One solve with K_ii leaves 1e-16 times its condition.  Rigid motions are made exact afterwards; their errors
  // tell those of all static shapes.
  out.push_back({"static solutions by rigid motion", fmt::format("{:.1e}", r.rigid_error), "1e-5",
                 r.rigid_error < 1e-5});
  out.push_back({"constraint modes are static solutions", fmt::format("{:.1e}", r.constraint_residual),
                 "1e-8", r.constraint_residual < 1e-8});
  if (r.factor.smallest_pivot > 0.0)  // a team's factorisation does not say
    out.push_back({"least pivot of the stiffness matrix", fmt::format("{:.1e}", r.factor.smallest_pivot),
                   "1e-12", r.factor.smallest_pivot >= 1e-12});
  if (r.mode_residual.size() > 0) {
    // Of nearly incompressible materials K phi is what remains of terms as large as the bulk modulus: round-off of 1e-16 times
    // its ratio to the shear modulus, and times some 1e4 for the spread of the mesh's own stiffnesses.
    // Low modes of thin parts are likewise small differences of large terms: the eigensolvers leave up to four times the
    // bound of round-off (is_accurate), of which the frequencies feel the square.
    double bound = std::max(1e-7, 1e-12 * data.bulk_over_shear);
    if (r.mode_round_off.size() == r.mode_residual.size())
      bound = std::max(bound, std::min(4.0 * r.mode_round_off.maxCoeff(), 1e-4));
    const double greatest = r.mode_residual.maxCoeff();
    out.push_back({"greatest residual of a mode", fmt::format("{:.1e}", greatest),
                   bound > 1e-7 ? fmt::format("{:.1e}", bound) : "1e-7", greatest <= bound});
  }
  if (r.certified_modes >= 0)
    out.push_back({"no mode missed (Sylvester)",
                   fmt::format("{} below {:.5g} Hz", r.certified_modes, frequency_hz(r.certified_omega2)),
                   "equal", true});
  // Interface modes kept for vibration leave static loads on the interface short; as much as the estimate of
  // the first frequency may.
  if (r.interface_stiffness_error >= 0.0)
    out.push_back({"static stiffness between elastic interfaces",
                   fmt::format("{:.2g} %", 100.0 * r.interface_stiffness_error), "5 %",
                   r.interface_stiffness_error < 0.05});
  // Straight cells lose 0.4 % on curved parts of ordinary fineness; one per cent is another part.
  if (data.mesh.cad_volume > 0.0)
    out.push_back({"mass of the mesh against CAD", fmt::format("{:+.3f} %", 100.0 * data.mesh.volume_error),
                   "1 %", std::abs(data.mesh.volume_error) < 0.01});
  if (data.mesh.n_cells > 0)
    out.push_back({"badly shaped cells",
                   fmt::format("{} of {}", data.mesh.quality.n_below, data.mesh.n_cells), "1 %",
                   data.mesh.quality.n_below <= data.mesh.n_cells / 100});
  if (!data.errors.empty())
    out.push_back({"first free frequency, safe estimate of its error",
                   std::isfinite(data.errors.front().safe_estimate)
                       ? fmt::format("{:.2g} %", 50.0 * data.errors.front().safe_estimate)
                       : std::string("unknown (too few modes to tell)"),
                   "5 %", data.errors.front().safe_estimate < 0.1});
  for (const std::string& warning : data.warnings) out.push_back({warning, "", "", false});
  return out;
}

nlohmann::json errors_json(const std::vector<ModeError>& errors) {
  nlohmann::json rows = nlohmann::json::array();
  for (const ModeError& e : errors) {
    if (!std::isfinite(e.safe_estimate)) break;
    rows.push_back({{"frequency_hz", frequency_hz(e.omega2)},
                    {"frequency_error", 0.5 * e.estimate},
                    {"safe_frequency_error", 0.5 * e.safe_estimate},
                    {"isolated", e.isolated}});
  }
  return rows;
}

/// The frequency to which the reduced frequencies are within `bound`, by the safe estimate of the dropped modes and the
/// mesh's share.
double good_to(const std::vector<ModeError>& errors, const MeshShare& mesh, double bound) {
  double last = 0.0;
  for (std::size_t k = 0; k < std::min(errors.size(), mesh.modes.size()); ++k) {
    if (!(0.5 * errors[k].safe_estimate + kMeshMargin * mesh.modes[k].error <= bound)) break;
    last = frequency_hz(errors[k].omega2);
  }
  return last;
}

/// What can be promised of a superelement that passed its checks: frequencies within the accuracy asked for, or one per
/// cent.
std::string verdict_of(const ReportData& data, double accuracy, bool stresses) {
  if (!data.mesh_error || data.mesh_error->modes.empty())
    return "checks passed; the mesh's error is unknown, so no accuracy is promised";
  const MeshShare& mesh = *data.mesh_error;
  double statics = 0.0;
  for (const MeshShare::Interface& interface : mesh.interfaces) statics = std::max(statics, interface.error);
  const double first = mesh.modes.front().error;
  if (std::max(first, statics) > 0.05)
    return fmt::format(
        "mesh too coarse: {} off in {} by its estimate; choose a smaller mesh size or elements of order 2",
        percent_or_more(std::max(first, statics)),
        first > statics ? "the first frequency" : "static compliance");
  const std::string compliance = promised_statics(mesh, stresses);
  if (mesh.rough)
    return fmt::format(
        "checks passed; the mesh's error is known only roughly, from recovered stresses (to a factor of "
        "five): {} in "
        "the first frequency{}; compare with a finer mesh",
        percent_or_more(first), compliance);
  if (data.errors.empty())
    return fmt::format(
        "to be trusted: mesh within {} in the first frequency; what dropped modes cost is unknown{}",
        percent_or_more(kMeshMargin * first), compliance);
  const double bound = accuracy > 0.0 ? accuracy : 0.01, good = good_to(data.errors, mesh, bound);
  if (good > 0.0)
    return fmt::format("to be trusted: frequencies within {} up to {:.5g} Hz, mesh and modes{}",
                       percent_or_more(bound), good, compliance);
  const double modes = 0.5 * data.errors.front().safe_estimate;
  return fmt::format("first frequency not within {}: mesh {}, dropped modes {}{}", percent_or_more(bound),
                     percent_or_more(first), percent_or_more(modes), compliance);
}

}  // namespace

nlohmann::json certificate_json(const ReductionReport& r) {
  if (r.certified_modes < 0) return nullptr;
  return {{"modes", r.certified_modes}, {"below_hz", frequency_hz(r.certified_omega2)}};
}

nlohmann::json reduction_json(const Reduction& reduction) {
  const ReductionReport& r = reduction.report;
  std::vector<double> frequencies;
  for (int k = 0; k < reduction.n_q; ++k) frequencies.push_back(frequency_hz(reduction.omega2[k]));
  return {{"dofs", r.n_i + r.n_b},
          {"interface_dofs", r.n_b},
          {"modes", r.n_q},
          {"interface_modes", r.n_interface_modes},
          {"interface_stiffness_error",
           r.interface_stiffness_error >= 0.0 ? nlohmann::json(r.interface_stiffness_error) : nullptr},
          {"fixed_interface_frequencies_hz", frequencies},
          {"greatest_mode_residual", r.mode_residual.size() > 0 ? r.mode_residual.maxCoeff() : 0.0},
          {"constraint_residual", r.constraint_residual},
          {"rigid_error", r.rigid_error},
          {"rigid_strain", r.rigid_strain},
          {"smallest_pivot", r.factor.smallest_pivot},
          {"factor_nonzeros", r.factor.nonzeros},
          {"factor_bytes", r.factor.bytes},
          {"factor_in_file", r.factor.in_file},
          {"peak_memory_bytes", r.peak_memory_bytes},
          {"processor_seconds",
           {{"factorisation", r.factor.processor_seconds}, {"mesh_error", r.processor_seconds_mesh_error}}},
          {"seconds",
           {{"assembly", r.seconds_assembly},
            {"ordering", r.factor.seconds_ordering + r.factor.seconds_symbolic},
            {"factorisation", r.factor.seconds_numeric},
            {"constraint_modes", r.seconds_constraint_modes},
            {"normal_modes", r.seconds_normal_modes},
            {"interface_modes", r.seconds_interface_modes},
            {"projection", r.seconds_projection},
            {"certificate", r.seconds_certificate},
            {"estimate", r.seconds_estimate},
            {"mesh_error", r.seconds_mesh_error},
            {"stiffening", r.seconds_stiffening},
            {"stress", r.seconds_stress}}}};
}

Report make_report(const PartInput& input, const Reduction& reduction, ReportData& data) {
  const ReductionReport& r = reduction.report;
  const InertiaIntegrals& inertia = reduction.inertia;
  const Eigen::Vector3d centre = inertia.S_x / inertia.mass;
  const Eigen::Matrix3d S_cc = inertia.S_xx - inertia.S_x * centre.transpose();
  const Eigen::Matrix3d J = S_cc.trace() * Eigen::Matrix3d::Identity() - S_cc;
  data.notes.insert(data.notes.end(), r.notes.begin(), r.notes.end());
  const std::vector<AcceptanceCheck> checks = acceptance_checks(reduction, data);
  const auto failed =
      std::find_if(checks.begin(), checks.end(), [](const AcceptanceCheck& c) { return !c.passed; });
  const char* const sets[] = {"craig_bampton", "craig_chang", "guyan"};

  std::string verdict;
  if (failed == checks.end()) {
    verdict = verdict_of(data, input.modes.accuracy, reduction.stress_modes.size() > 0);
  } else {
    verdict = "with care: " + failed->check;
    if (!failed->value.empty()) verdict += fmt::format(": {}, bound {}", failed->value, failed->bound);
  }

  Report report;
  report.json = {{"part", input.name},
                 {"mass", inertia.mass},
                 {"centre", list(centre)},
                 {"inertia", {J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(1, 2), J(2, 0)}},
                 {"mesh", mesh_json(data.mesh)},
                 {"mode_set", sets[static_cast<int>(input.modes.set)]},
                 {"reduction", reduction_json(reduction)},
                 {"interface_condition", interface_condition(reduction)},
                 {"estimate", errors_json(data.errors)},
                 {"mesh_error", mesh_error_json(data.mesh_error)},
                 {"certificate", certificate_json(r)},
                 {"notes", data.notes},
                 {"seconds", data.seconds}};
  nlohmann::json& acceptance = report.json["acceptance"];
  acceptance["verdict"] = verdict;
  for (const AcceptanceCheck& c : checks)
    acceptance["checks"].push_back(
        {{"check", c.check}, {"value", c.value}, {"bound", c.bound}, {"passed", c.passed}});
  if (data.mesh.cad_volume > 0.0 && input.materials.size() == 1)
    report.json["cad_mass"] = input.materials[0].density * data.mesh.cad_volume;
  if (r.band_frequency_error >= 0.0)
    report.json["band"] = {{"up_to_hz", input.modes.up_to},
                           {"frequency_error", r.band_frequency_error},
                           {"interface_error", r.band_interface_error}};
  if (!data.comparison.full_hz.empty())
    report.json["comparison"] = {{"full_hz", data.comparison.full_hz},
                                 {"reduced_hz", data.comparison.reduced_hz},
                                 {"static_error", data.comparison.static_error}};

  std::string& text = report.text;
  for (const std::string& note : data.notes) text += "  " + note + '\n';
  text += fmt::format("  mesh: {} nodes, {} cells, ", data.mesh.n_nodes, data.mesh.n_cells);
  if (data.mesh.cad_volume > 0.0)
    text += fmt::format("volume {:+.3f} % of the CAD volume, ", 100.0 * data.mesh.volume_error);
  text += fmt::format("{:.1f} s\n", data.mesh.seconds);
  text += fmt::format("  mass {:.6g} kg, centre ({:.5g}, {:.5g}, {:.5g}) m\n", inertia.mass, centre.x(),
                      centre.y(), centre.z());
  text += fmt::format(
      "  {} dofs -> {} interface dofs + {} modes: assembly {:.1f} s, factorisation {:.1f} s, constraint "
      "modes {:.1f} s, modes {:.1f} s, projection {:.1f} s\n",
      r.n_i + r.n_b, r.n_b, r.n_q, r.seconds_assembly,
      r.factor.seconds_ordering + r.factor.seconds_symbolic + r.factor.seconds_numeric,
      r.seconds_constraint_modes, r.seconds_normal_modes, r.seconds_projection);
  if (reduction.n_q > 0 && input.modes.set == ModeSet::craig_bampton) {
    text += fmt::format("  fixed-interface modes {:.5g} to {:.5g} Hz",
                        frequency_hz(reduction.omega2.minCoeff()), frequency_hz(reduction.omega2.maxCoeff()));
    if (r.mode_residual.size() > 0)
      text += fmt::format(", greatest residual {:.1e}", r.mode_residual.maxCoeff());
    if (r.certified_modes >= 0)
      text += fmt::format("; none missed: {} below {:.5g} Hz by Sylvester's law", r.certified_modes,
                          frequency_hz(r.certified_omega2));
    text += '\n';
  }
  text += mesh_error_text(data.mesh_error, reduction.stress_modes.size() > 0);
  if (r.band_frequency_error >= 0.0)
    text += fmt::format(
        "  up to {:.5g} Hz, safe estimate: frequencies within {:.2g} %, dynamic stiffness of the interface "
        "within {:.2g} %\n",
        input.modes.up_to, 100.0 * r.band_frequency_error, 100.0 * r.band_interface_error);
  for (std::size_t k = 0; k < data.comparison.full_hz.size(); ++k) {
    const double full = data.comparison.full_hz[k], reduced = data.comparison.reduced_hz[k];
    text += fmt::format("  free mode {:2}: full model {:10.6g} Hz, superelement {:10.6g} Hz, {:+.2e}\n",
                        k + 1, full, reduced, reduced / full - 1.0);
  }
  if (data.comparison.static_error >= 0.0)
    text += fmt::format("  static compliance against the full model: {:.1e}\n", data.comparison.static_error);
  if (r.factor.in_file)
    text += fmt::format("  the factor ({:.2f} GB) was kept in a temporary file\n", r.factor.bytes / 1e9);
  text += fmt::format("  {:.1f} s in all, peak memory {:.2f} GB", data.seconds, r.peak_memory_bytes / 1e9);
  if (r.peak_memory_of_others_bytes > 0.0)
    text += fmt::format(" (the other processes up to {:.2f} GB)", r.peak_memory_of_others_bytes / 1e9);
  text += '\n';
  text += "  " + verdict + '\n';
  return report;
}

}  // namespace flexura::reduce
