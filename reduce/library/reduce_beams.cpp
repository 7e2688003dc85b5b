// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/base/documents/document.hpp"
#include "reduce/beams/full_modes.hpp"
#include "reduce/library/beam_stresses.hpp"
#include "reduce/library/reduce.hpp"
#include "reduce/library/request.hpp"
#include "reduce/library/section_forces.hpp"
#include "reduce/linalg/session/session.hpp"
#include "reduce/superelement/report.hpp"
#include "reduce/superelement/to_superelement.hpp"

namespace flexura::reduce {
namespace {

superelement::Surface surface_of(const Picture& from) {
  superelement::Surface surface;
  surface.vertices = from.vertices;
  surface.triangles = from.triangles;
  surface.edges = from.edges;
  surface.triangle_interface.assign(from.triangles.rows(), -1);
  return surface;
}

// The nodes of the model come first, those within members after them.  Nodes that only show a direction are left out.
superelement::NodalMotions nodal_motions(const Structure& structure, const Eigen::MatrixXd& T,
                                         bool double_precision) {
  const std::vector<Eigen::Vector3d>& points = structure.mesh().points();
  superelement::NodalMotions out{.double_precision = double_precision};
  std::vector<int> nodes;
  for (int node = 0; node < static_cast<int>(points.size()); ++node)
    if (structure.used()[static_cast<std::size_t>(6 * node)]) nodes.push_back(node);
  const auto n_k = static_cast<Eigen::Index>(nodes.size());
  out.positions.resize(n_k, 3);
  out.T.resize(6 * n_k, T.cols());
  out.rotations.assign(nodes.size(), superelement::NodalMotions::Rotation::own);
  for (Eigen::Index k = 0; k < n_k; ++k) {
    const int node = nodes[static_cast<std::size_t>(k)];
    out.numbers.push_back(node + 1);
    out.positions.row(k) = points[static_cast<std::size_t>(node)].transpose();
    out.T.middleRows<6>(6 * k) = T.middleRows<6>(6 * node);
  }
  return out;
}

// A solid whose own modes end below the structure's makes those too stiff.
std::vector<std::string> short_solids(const BeamPartInput& input, double highest_hz) {
  std::vector<std::string> texts;
  for (const AttachedSolid& solid : input.solids) {
    const double reach = solid.reduction.n_q > 0 ? frequency_hz(solid.reduction.omega2.maxCoeff()) : 0.0;
    if (reach < 1.5 * highest_hz)
      texts.push_back(
          fmt::format("solid \"{}\" has {} modes, up to {:.4g} Hz; modes of the structure above {:.4g} Hz "
                      "lack some of its "
                      "vibration: raise `modes` of [solid.{}]",
                      solid.name, solid.reduction.n_q, reach, reach / 1.5, solid.name));
  }
  return texts;
}

// An accuracy of frequencies up to some is shared by the elements and the modes; static compliance is exact whatever they are.
void set_goal(BeamPartInput& input, const ReduceOptions& options, std::vector<std::string>& notes) {
  ModesInput& modes = input.modes;
  if (!(modes.accuracy > 0.0)) return;
  if (!(modes.up_to > 0.0)) {
    constexpr int kFrequencies = 6;  // as of solids
    const Structure structure(beam::BeamMesh(input.model, input.subdivision), input.solids, input.links);
    const Eigen::VectorXd free = full_beam_modes(structure, kFrequencies, true, options.progress);
    if (free.size() <= 6) return;
    modes.up_to = 1.001 * frequency_hz(free(std::min<Eigen::Index>(free.size() - 1, 5 + kFrequencies)));
  }
  beam::Subdivision& mesh = input.subdivision;
  mesh.max_frequency_hz = std::max(mesh.max_frequency_hz, modes.up_to);
  mesh.frequency_error = std::min(mesh.frequency_error, 0.5 * modes.accuracy);
  notes.push_back(fmt::format("elements and modes for an accuracy of {:.3g} % up to {:.5g} Hz",
                              100.0 * modes.accuracy, modes.up_to));
}

}  // namespace

Reduced reduce(const BeamPartInput& given, const ReduceOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const linalg::Session session;
  BeamPartInput input = given;
  std::vector<std::string> notes;
  set_goal(input, options, notes);
  const beam::BeamMesh mesh(input.model, input.subdivision);
  std::vector<int> held;
  for (const BeamInterface& interface : input.interfaces) held.push_back(interface.node);
  for (const std::string& text : beam::warnings(input.model, held)) notes.push_back("warning: " + text);
  for (const std::string& text : beam::accuracy_warnings(mesh)) notes.push_back("warning: " + text);

  ReductionOptions how = options_of(input);
  how.progress = options.progress;
  const Structure structure(mesh, input.solids, input.links, input.recovery.stress);
  std::vector<BeamInterface> interfaces = input.interfaces;
  if (const auto body = body_interface(structure, interfaces)) {
    notes.push_back(
        fmt::format("the interfaces leave rigid motions free; interface \"{}\", node \"{}\", takes them",
                    body->name, input.model.nodes[body->node].name));
    interfaces.push_back(*body);
  }
  BeamReduction beams = reduce_beams(structure, interfaces, how, input.cases);
  Reduction& reduction = beams.reduction;
  notes.insert(notes.end(), reduction.report.notes.begin(), reduction.report.notes.end());
  std::vector<std::string> warnings;
  if (const Eigen::MatrixXd Y = strike_out(input, reduction, notes, warnings); Y.size() > 0)
    beams.T = (beams.T * Y).eval();
  for (const std::string& text : warnings) notes.push_back("warning: " + text);
  const double ratio = put_damping(input, false, reduction);
  for (const NodeLink& link : input.links)
    notes.push_back(fmt::format("link {}: stiffness {:.5g} N/m, damping {:.5g} N s/m", link.name,
                                link.stiffness, link.damping));
  const ReductionReport& r = reduction.report;

  std::optional<superelement::StressModes> stress;
  if (input.recovery.stress) {
    stress = beam_stresses(structure, beams, input.cases, input.recovery.double_precision, notes);
    if (!stress)
      throw input::InputError(
          input.recovery.where +
          ".stress: no member has a section whose stresses are known; take a standard section or one that "
          "`flexura section` has solved");
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Eigen::Vector3d centre = reduction.inertia.S_x / reduction.inertia.mass;
  std::vector<double> frequencies;
  for (int k = 0; k < reduction.n_q; ++k) frequencies.push_back(frequency_hz(reduction.omega2[k]));
  if (reduction.n_q > 0)
    for (const std::string& text : short_solids(input, frequencies.back()))
      notes.push_back("warning: " + text);
  if (input.model.members.size() > most_members)
    notes.push_back(
        fmt::format("section forces for run time are kept of up to {} members, not of these", most_members));
  const nlohmann::json json = {{"part", input.name},
                               {"mass", reduction.inertia.mass},
                               {"centre", {centre.x(), centre.y(), centre.z()}},
                               {"mesh",
                                {{"nodes", r.n_nodes},
                                 {"elements", r.n_cells},
                                 {"members", input.model.members.size()},
                                 {"solids", input.solids.size()}}},
                               {"reduction", reduction_json(reduction)},
                               {"certificate", certificate_json(r)},
                               {"notes", notes},
                               {"seconds", seconds}};
  std::string text;
  for (const std::string& note : notes) text += "  " + note + '\n';
  for (const AttachedSolid& solid : input.solids)
    text += fmt::format("  solid {}: {:.6g} kg, {} interfaces, {} modes\n", solid.name,
                        solid.reduction.inertia.mass, solid.reduction.interfaces.size(), solid.reduction.n_q);
  text +=
      fmt::format("  {} members, {} elements, {} nodes; mass {:.6g} kg, centre ({:.5g}, {:.5g}, {:.5g}) m\n",
                  input.model.members.size(), r.n_cells, r.n_nodes, reduction.inertia.mass, centre.x(),
                  centre.y(), centre.z());
  text += fmt::format("  {} dofs -> {} interface dofs + {} modes, {:.1f} s, peak memory {:.2f} GB\n",
                      r.n_i + r.n_b, r.n_b, r.n_q, seconds, r.peak_memory_bytes / 1e9);
  if (reduction.n_q > 0)
    text +=
        fmt::format("  fixed-interface modes {:.5g} to {:.5g} Hz", frequencies.front(), frequencies.back()) +
        (r.mode_residual.size() > 0 ? fmt::format(", greatest residual {:.1e}", r.mode_residual.maxCoeff())
                                    : std::string()) +
        (r.certified_modes >= 0 ? fmt::format("; none missed: {} below {:.5g} Hz by Sylvester's law\n",
                                              r.certified_modes, frequency_hz(r.certified_omega2))
                                : std::string("\n"));

  std::vector<superelement::LoadCase> cases;
  for (const LoadCase& load : input.cases)
    cases.push_back({.name = load.name,
                     .p_se = beams.T.transpose() * load_vector(structure, load),
                     .is_preload = !load.preloads.empty() && load.nodal.empty() && load.members.empty()});
  superelement::Superelement se =
      to_superelement(input, std::move(reduction), surface_of(structure.picture()), json.dump(1));
  se.load_cases = std::move(cases);
  se.stress = std::move(stress);
  if (input.recovery.all_nodes) se.nodes = nodal_motions(structure, beams.T, input.recovery.double_precision);
  se.modal_damping = ratio;
  if (input.model.members.size() <= most_members) {
    std::optional<UnitTensions> tensions;
    if (input.stiffening) tensions.emplace(structure, interfaces, input.cases);
    // What inertia adds takes nine columns for each shape, tension one for each unit load: about 30 MB in all.
    const Eigen::Index columns = beams.T.cols() * (9 + (tensions ? tensions->loads() : 0));
    const auto most_places = static_cast<int>(1'350'000 / std::max<Eigen::Index>(1, columns));
    se.sections = section_forces(structure, beams, input.cases, most_places, tensions ? &*tensions : nullptr);
  }
  return {.superelement = std::move(se), .text = std::move(text), .json = json};
}

}  // namespace flexura::reduce
