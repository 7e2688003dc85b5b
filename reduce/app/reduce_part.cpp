// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/reduce_part.hpp"

#include <fmt/format.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/superelement/file.hpp"
#include "mbs/terminal/terminal.hpp"
#include "mesh/gmsh/cad.hpp"
#include "reduce/app/report.hpp"
#include "reduce/app/surface.hpp"
#include "reduce/app/to_superelement.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/linalg/session.hpp"

namespace flexura::reduce {

namespace {

/// Finds the faces of every interface and ties them to their node.
Part make_part(const PartInput& input, const mesh::CadMesh& cad, std::vector<std::string>& notes) {
  Part part;
  part.mesh = cad.mesh;
  part.materials = input.materials;
  part.mass = input.mass;
  for (const InterfaceInput& wanted : input.interfaces) {
    mesh::Selection chosen;
    try {
      chosen = mesh::select_nodes(cad.mesh, cad.cad.faces, wanted.rule);
    } catch (const std::invalid_argument& error) {
      throw input::InputError(wanted.where + ": " + error.what());
    }
    InterfaceSpec spec{
        .name = wanted.name, .tie = wanted.tie, .point = wanted.reference.value_or(chosen.reference)};
    notes.push_back(fmt::format("interface {}: {}, {} nodes, {}", wanted.name, chosen.description,
                                chosen.set.nodes.size(), name_of(wanted.tie)));
    spec.set = std::move(chosen.set);
    part.interfaces.push_back(std::move(spec));
  }
  return part;
}

/// The surface vertices at which stress modes are wanted.
std::vector<std::int32_t> stress_vertices(const RecoveryInput& wanted, const mesh::Mesh& mesh,
                                          const std::vector<mesh::Index>& surface_nodes) {
  std::vector<std::int32_t> vertices;
  if (!wanted.stress) return vertices;
  std::vector<char> inside(mesh.n_nodes(), wanted.groups.empty());
  for (const std::string& name : wanted.groups) {
    const auto set = mesh.sets.find(name);
    if (set == mesh.sets.end()) {
      std::vector<std::string> names;
      for (const auto& [known, nodes] : mesh.sets) names.push_back(known);
      throw input::InputError(fmt::format("{}: the mesh has no set \"{}\"{}", wanted.where, name,
                                          input::suggestion(name, names)));
    }
    for (const mesh::Index node : set->second.nodes) inside[node] = 1;
  }
  for (std::size_t v = 0; v < surface_nodes.size(); ++v)
    if (inside[surface_nodes[v]]) vertices.push_back(static_cast<std::int32_t>(v));
  if (vertices.empty())
    throw input::InputError(wanted.where +
                            ": none of the sets' nodes lies on the part's surface, where "
                            "stresses are kept");
  return vertices;
}

}  // namespace

void reduce_part(const PartInput& input, const std::filesystem::path& output, const OutputOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  terminal::Progress line(stderr, options.quiet);
  const auto progress = [&line](std::string_view stage, double fraction) { line(stage, fraction); };

  const mesh::CadMesh cad = mesh::mesh_cad(input.cad, progress);
  std::vector<std::string> notes = cad.report.messages;
  const Part part = make_part(input, cad, notes);
  std::vector<std::vector<mesh::Index>> interface_nodes;
  for (const InterfaceSpec& spec : part.interfaces) interface_nodes.push_back(spec.set.nodes);
  SurfacePicture picture = make_surface(part.mesh, interface_nodes);

  const linalg::Session session;
  ReductionOptions how;
  how.n_modes = input.modes.up_to > 0.0 ? 0 : input.modes.count;
  how.omega_max = 2.0 * std::numbers::pi * input.modes.up_to;
  how.shape_nodes = picture.nodes;
  how.stiffening = input.stiffening;
  how.progress = progress;
  std::vector<std::int32_t> vertices = stress_vertices(input.recovery, part.mesh, picture.nodes);
  for (const std::int32_t vertex : vertices) how.stress_nodes.push_back(picture.nodes[vertex]);
  Reduction reduction = craig_bampton(part, how);

  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Report report = make_report(input, cad, reduction, notes, seconds);
  line("write", 0.0);
  const superelement::Superelement se = to_superelement(
      input, std::move(reduction), std::move(picture.surface), report.json.dump(1), std::move(vertices));
  superelement::write(output, se);
  if (!options.report.empty()) {
    std::ofstream(options.report) << report.json.dump(2) << '\n';
  }
  line.finish();
  if (!options.quiet) fmt::print("{}wrote {}\n", report.text, output.string());
}

}  // namespace flexura::reduce
