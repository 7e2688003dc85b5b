// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <optional>

#include "mbs/base/documents/document.hpp"
#include "reduce/library/attempt.hpp"
#include "reduce/library/bar_sections.hpp"
#include "reduce/library/comparison.hpp"
#include "reduce/library/plausibility.hpp"
#include "reduce/library/reduce.hpp"
#include "reduce/library/reduce_modal_matrices.hpp"
#include "reduce/library/request.hpp"
#include "reduce/library/section_forces.hpp"
#include "reduce/linalg/session/session.hpp"
#include "reduce/superelement/mesh_hints.hpp"
#include "reduce/superelement/mesh_report.hpp"
#include "reduce/superelement/report.hpp"
#include "reduce/superelement/to_superelement.hpp"

namespace flexura::reduce {

namespace {

ReductionOptions options_of(const PartInput& input, const ReduceOptions& options) {
  ReductionOptions how = options_of(static_cast<const ReductionRequest&>(input));
  how.interface_modes = input.modes.interface_modes;
  how.estimate_mesh = true;
  how.team = options.team;
  how.storage.place =
      options.factor_in_file ? linalg::FactorStorage::Place::file : linalg::FactorStorage::Place::automatic;
  if (!std::getenv("TMPDIR") && !options.output.empty())
    how.storage.folder = std::filesystem::absolute(options.output).parent_path();
  how.progress = options.progress;
  return how;
}

std::vector<linalg::UserOption> petsc_of(const PartInput& input, const ReduceOptions& options) {
  std::vector<linalg::UserOption> petsc = input.petsc;
  petsc.insert(petsc.end(), options.petsc.begin(), options.petsc.end());
  return petsc;
}

void add_comparison(const PartInput& input, const Part& part, const Reduction& reduction,
                    const ReduceOptions& options, ReportData& data) {
  if (options.compare <= 0) return;
  data.comparison = compare(part, reduction, options.compare, input.modes.struck, options.progress);
  if (data.comparison.full_hz.empty())
    data.warnings.push_back(
        "--compare has nothing to compare: the superelement has no elastic frequency of the free body");
  if (data.comparison.static_error < 0.0)
    data.notes.push_back(
        "--compare: statics not compared, which needs two interfaces with all six directions and no other");
}

// What the mesh and the materials give to say.
void add_hints(const PartInput& input, const Attempt& done, ReportData& data) {
  const Part& part = done.modelled.part;
  if (const std::string coarse = too_coarse(data.mesh_error); !coarse.empty())
    data.warnings.push_back(coarse);
  const bool one_size = input.format == PartFormat::cad && !done.graded;
  const MeshHints hints = mesh_hints(part, one_size ? done.mesh.size : 0.0, data.mesh_error);
  data.warnings.insert(data.warnings.end(), hints.warnings.begin(), hints.warnings.end());
  data.notes.insert(data.notes.end(), hints.notes.begin(), hints.notes.end());
  data.warnings.insert(data.warnings.end(), done.modelled.warnings.begin(), done.modelled.warnings.end());
  for (const Material& material : part.materials) {
    const bool own =
        std::ranges::any_of(input.materials, [&](const Material& m) { return m.name == material.name; });
    if (const std::string odd = odd_material(material, !own); !odd.empty()) data.warnings.push_back(odd);
  }
  const bool has_unit = input.format == PartFormat::cad || !input.cad.unit.empty();
  for (const std::string& odd :
       {has_unit ? std::string() : odd_size(part.mesh), odd_thickness(part.mesh), odd_joint(part.mesh)})
    if (!odd.empty()) data.warnings.push_back(odd);
}

// Damping of the whole part by its own materials or matrices; dampers between places stand beside the modes' own.
bool brings_damping(const PartInput& input, const Part& part) {
  return !input.finished.damping.empty() || !input.damping_matrix.empty() ||
         std::ranges::any_of(part.materials, [](const Material& m) { return m.damping.any(); });
}

}  // namespace

Reduced reduce(const PartInput& input, const ReduceOptions& options) {
  if (is_reduced_body(input)) return reduce_reduced_body(input);
  const auto start = std::chrono::steady_clock::now();
  const linalg::Session session;
  const linalg::UserOptions user(petsc_of(input, options), options.team);
  const bool finished = !input.finished.vectors.empty();
  if (options.compare > 0 && finished)
    throw input::InputError(
        "--compare solves the full model, which finished modes do not bring along; leave it out");
  std::vector<std::string> warnings;
  Attempt done = reach(input, options.output, options_of(input, options), options.say, warnings);
  const Part& part = done.modelled.part;
  Reduction& reduction = done.reduction;

  ReportData data{.mesh = done.mesh, .notes = done.modelled.notes};
  data.warnings = warnings;
  if (!done.missed.empty()) data.warnings.push_back(done.missed);
  if (reduction.dropped.size() > 0) data.errors = mode_errors(reduction);
  strike_out(input, reduction, data.notes, data.warnings);
  add_comparison(input, part, reduction, options, data);
  data.mesh_error = reduction.mesh;
  for (const Material& material : part.materials)
    data.bulk_over_shear = std::max(data.bulk_over_shear, bulk_over_shear(material));
  add_hints(input, done, data);
  const bool damps_itself = brings_damping(input, part);
  const double ratio = put_damping(input, damps_itself, reduction);
  if (damps_itself && !input.modes.damping_given)
    data.notes.push_back(
        "the part brings its damping along: no ratio of [modes] is added to it (damping = \"1 %\" does)");
  if (part.bars.size() > most_members)
    data.notes.push_back(
        fmt::format("section forces for run time are kept of up to {} beams and rods, not of these {}",
                    most_members, part.bars.size()));
  data.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  Report report = make_report(input, reduction, data);

  Reduced out;
  out.too_coarse = too_coarse(data.mesh_error);
  out.missed = std::move(done.missed);
  std::vector<mesh::Index> stress_nodes;
  for (const std::int32_t vertex : done.vertices)
    stress_nodes.push_back(done.picture.nodes[static_cast<std::size_t>(vertex)]);
  std::optional<superelement::MeshError> mesh_error;
  if (reduction.mesh) mesh_error = to_mesh_error(*reduction.mesh, part, done.picture.nodes);
  std::optional<superelement::SectionForces> sections;
  if (part.bars.size() <= most_members) sections = bar_sections(part, reduction, done.modelled.loads);
  std::optional<superelement::NodalMotions> nodes;
  if (reduction.nodes) nodes = to_nodal_motions(*reduction.nodes, part.mesh, input.recovery.double_precision);
  superelement::Superelement& se = out.superelement;
  se = to_superelement(input, std::move(reduction), std::move(done.picture.surface), report.json.dump(1),
                       std::move(done.vertices));
  se.mesh_error = std::move(mesh_error);
  se.nodes = std::move(nodes);
  se.sections = std::move(sections);
  se.modal_damping = ratio;
  if (se.stress && !finished) add_compliance(part, stress_nodes, *se.stress);
  if (user.has_log() && options.say) options.say("where time went, by PETSc:");
  user.print_log();
  for (const std::string& name : user.unused())
    data.warnings.push_back(fmt::format(
        "PETSc option {}: nothing in this reduction has given such a report; is it misspelt?", name));
  out.text = std::move(report.text);
  out.json = std::move(report.json);
  out.warnings = std::move(data.warnings);
  out.mesh = std::move(done.modelled.part.mesh);
  out.materials = std::move(done.modelled.part.materials);
  return out;
}

superelement::Superelement reduce(const Part& part, const std::string& name, ReductionOptions options) {
  const linalg::Session session;
  std::vector<std::vector<mesh::Index>> nodes;
  for (const InterfaceSpec& interface : part.interfaces) nodes.push_back(interface.set.nodes);
  SurfacePicture picture = make_surface(part.mesh, nodes);
  options.shape_nodes = picture.nodes;
  Reduction reduction = craig_bampton(part, options);
  std::optional<superelement::MeshError> mesh_error;
  if (reduction.mesh) mesh_error = to_mesh_error(*reduction.mesh, part, picture.nodes);
  PartInput named;  // what the superelement takes of a part's input
  named.name = name;
  superelement::Superelement se =
      to_superelement(named, std::move(reduction), std::move(picture.surface), "{}");
  se.mesh_error = std::move(mesh_error);
  return se;
}

}  // namespace flexura::reduce
