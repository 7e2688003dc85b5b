// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace flexura::reduce {

namespace {

std::vector<double> list(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

double frequency(double omega2) {
  return std::sqrt(std::max(omega2, 0.0)) / (2.0 * std::numbers::pi);
}

nlohmann::json mesh_json(const mesh::CadMesh& cad) {
  const mesh::MeshReport& m = cad.report;
  return {{"nodes", m.n_nodes},
          {"cells", m.n_cells},
          {"size", m.size},
          {"straightened_nodes", m.n_straightened},
          {"volume", m.volume},
          {"cad_volume", m.cad_volume},
          {"volume_error", m.volume_error},
          {"centroid", list(m.centroid)},
          {"cad_centroid", list(m.cad_centroid)},
          {"seconds", m.seconds}};
}

nlohmann::json reduction_json(const Reduction& reduction) {
  const ReductionReport& r = reduction.report;
  std::vector<double> frequencies;
  for (int k = 0; k < reduction.n_q; ++k) frequencies.push_back(frequency(reduction.omega2[k]));
  return {{"dofs", r.n_i + r.n_b},
          {"interface_dofs", r.n_b},
          {"modes", r.n_q},
          {"fixed_interface_frequencies_hz", frequencies},
          {"greatest_mode_residual", r.mode_residual.size() > 0 ? r.mode_residual.maxCoeff() : 0.0},
          {"constraint_residual", r.constraint_residual},
          {"rigid_strain", r.rigid_strain},
          {"smallest_pivot", r.smallest_pivot},
          {"factor_nonzeros", r.factor_nonzeros},
          {"peak_memory_bytes", r.peak_memory_bytes},
          {"seconds",
           {{"assembly", r.seconds_assembly},
            {"ordering", r.seconds_ordering + r.seconds_symbolic},
            {"factorisation", r.seconds_factor},
            {"constraint_modes", r.seconds_constraint_modes},
            {"normal_modes", r.seconds_normal_modes},
            {"projection", r.seconds_projection},
            {"estimate", r.seconds_estimate}}}};
}

}  // namespace

Report make_report(const PartInput& input, const mesh::CadMesh& cad, const Reduction& reduction,
                   const std::vector<std::string>& notes, double seconds) {
  const ReductionReport& r = reduction.report;
  const InertiaIntegrals& inertia = reduction.inertia;
  const Eigen::Vector3d centre = inertia.S_x / inertia.mass;

  Report report;
  report.json = {{"part", input.name},
                 {"mass", inertia.mass},
                 {"centre", list(centre)},
                 {"mesh", mesh_json(cad)},
                 {"reduction", reduction_json(reduction)},
                 {"notes", notes},
                 {"seconds", seconds}};

  std::string& text = report.text;
  for (const std::string& note : notes) text += "  " + note + '\n';
  text += fmt::format("  mesh: {} nodes, {} cells, volume {:+.3f} % of the CAD volume, {:.1f} s\n",
                      cad.report.n_nodes, cad.report.n_cells, 100.0 * cad.report.volume_error,
                      cad.report.seconds);
  text += fmt::format("  mass {:.6g} kg, centre ({:.5g}, {:.5g}, {:.5g}) m\n", inertia.mass, centre.x(),
                      centre.y(), centre.z());
  text += fmt::format(
      "  {} dofs -> {} interface dofs + {} modes: assembly {:.1f} s, factorisation {:.1f} s, constraint "
      "modes {:.1f} s, "
      "modes {:.1f} s, projection {:.1f} s\n",
      r.n_i + r.n_b, r.n_b, r.n_q, r.seconds_assembly,
      r.seconds_ordering + r.seconds_symbolic + r.seconds_factor, r.seconds_constraint_modes,
      r.seconds_normal_modes, r.seconds_projection);
  if (reduction.n_q > 0) {
    text += fmt::format("  fixed-interface modes {:.5g} to {:.5g} Hz, greatest residual {:.1e}\n",
                        frequency(reduction.omega2[0]), frequency(reduction.omega2[reduction.n_q - 1]),
                        r.mode_residual.maxCoeff());
  }
  text += fmt::format("  {:.1f} s in all, peak memory {:.2f} GB\n", seconds, r.peak_memory_bytes / 1e9);
  return report;
}

}  // namespace flexura::reduce
