// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/reduce_part.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/text_file.hpp"
#include "reduce/app/make_part.hpp"
#include "reduce/app/mesh_hints.hpp"
#include "reduce/app/mesh_report.hpp"
#include "reduce/app/reach_accuracy.hpp"
#include "reduce/app/read_matrices.hpp"
#include "reduce/app/report.hpp"
#include "reduce/app/stage_lines.hpp"
#include "reduce/app/surface.hpp"
#include "reduce/app/to_superelement.hpp"
#include "reduce/app/write_mesh.hpp"
#include "reduce/cms/finished_modes.hpp"
#include "reduce/cms/shape_change.hpp"
#include "reduce/cms/verification.hpp"
#include "reduce/linalg/session.hpp"
#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {

namespace {

/// The surface vertices at which stress modes are wanted.
std::vector<std::int32_t> stress_vertices(const RecoveryInput& wanted, const mesh::Mesh& mesh,
                                          const std::vector<mesh::Index>& surface_nodes,
                                          const Part& part) {
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
  for (const Follower& follower : part.followers)  // the skins of shells
    if (follower.from.size() == 1 && inside[follower.from.front().first]) inside[follower.point] = 1;
  // What is seen of beams has no stress modes.
  const auto of_cells = part.frames.empty() ? std::vector<std::pair<int, int>>(surface_nodes.size(), {0, 1})
                                            : nodal_materials(part, surface_nodes);
  for (std::size_t v = 0; v < surface_nodes.size(); ++v)
    if (inside[surface_nodes[v]] && of_cells[v].first >= 0) vertices.push_back(static_cast<std::int32_t>(v));
  if (vertices.empty())
    throw input::InputError(wanted.where +
                            ": none of the sets' nodes lies on the part's surface, where "
                            "stresses are kept; name other sets");
  return vertices;
}

/// The vectors and matrices of the part file in SI: V has no unit or that of the file's lengths, in which
/// V^T K V and V^T M V were computed, so that forces per length and masses count as those of the file.
FinishedModes load_finished_modes(const PartInput& input) {
  FinishedModes modes{.V = read_dense(input.finished.vectors), .K = read_dense(input.finished.stiffness)};
  modes.K *= input.unit_mass;
  if (!input.finished.reduced_mass.empty())
    modes.M = input.unit_mass * read_dense(input.finished.reduced_mass);
  // Stress per displacement: (M L^-1 T^-2) / L.
  if (!input.finished.stress.empty())
    modes.stress =
        input.unit_mass / (input.unit_length * input.unit_length) * read_dense(input.finished.stress);
  return modes;
}

/// Frequencies of the free body and static compliance between the first and the last interface, nothing
/// reduced, against the superelement as it is written: full modes of the `struck` numbers (counted from 1,
/// rigid ones included) have no partner in it.
Comparison compare(const Part& part, const Reduction& reduction, int count, const std::vector<int>& struck,
                   const linalg::Progress& progress) {
  Comparison out;
  const Eigen::VectorXd reduced = reduced_free_modes(reduction);
  count = std::min<int>(count, static_cast<int>(reduced.size()) - 6);
  if (count < 1) return out;
  const auto n_struck = static_cast<int>(std::set<int>(struck.begin(), struck.end()).size());
  const linalg::EigenPairs full = full_free_modes(part, count + n_struck, reduced(6), progress);
  int k = 6;
  for (int number = 7; number <= 6 + count + n_struck && k < 6 + count; ++number) {
    if (std::find(struck.begin(), struck.end(), number) != struck.end()) continue;
    out.full_hz.push_back(std::sqrt(full.omega2(number - 1)) / (2.0 * std::numbers::pi));
    out.reduced_hz.push_back(std::sqrt(reduced(k++)) / (2.0 * std::numbers::pi));
  }
  std::vector<const ReducedInterface*> six;
  for (const ReducedInterface& interface : reduction.interfaces)
    if (interface.directions.size() == 6) six.push_back(&interface);
  if (six.size() == reduction.interfaces.size() && six.size() > 1) {
    const std::string &held = six.front()->name, &loaded = six.back()->name;
    const Eigen::MatrixXd exact = full_static_compliance(part, held, loaded, progress);
    const Eigen::MatrixXd ours = reduced_static_compliance(reduction, held, loaded);
    // Each direction of load by the work it does.
    const Eigen::Index at = six.back()->first_dof;
    double worst = 0.0;
    for (int d = 0; d < 6; ++d) worst = std::max(worst, std::abs(ours(at + d, d) / exact(at + d, d) - 1.0));
    out.static_error = worst;
  }
  return out;
}

}  // namespace

namespace {

/// Whether a superelement is there whose mesh resolves its part.
bool is_better(const std::filesystem::path& output) {
  std::error_code error;
  if (!std::filesystem::exists(output, error)) return false;
  // What is going to be written is not read as an input: a copy is.
  const std::filesystem::path copy =
      std::filesystem::temp_directory_path() / fmt::format("flexura-{}-{}", getpid(), output.filename().string());
  const auto remove = [](const std::filesystem::path* file) {
    std::error_code ignored;
    std::filesystem::remove(*file, ignored);
  };
  const std::unique_ptr<const std::filesystem::path, decltype(remove)> removed(&copy, remove);
  try {
    std::filesystem::copy_file(output, copy);
    const auto mesh = superelement::read(copy, {.matrices = false, .inertia = false, .mesh_error = true}).mesh_error;
    return mesh && !mesh->modes.empty() && mesh->modes.front().error >= 0.0 && mesh->modes.front().error < 0.2;
  } catch (const std::exception&) {
    return false;  // no superelement, or one without an estimate
  }
}

/// What no solid material has: most often a value without its unit.
std::string odd_material(const Material& material) {
  constexpr double kSoftest = 1e3, kStiffest = 2e12;  // [Pa]: gels, diamond
  constexpr double kLightest = 1.0, kHeaviest = 25e3;  // [kg/m^3]: aerogels, osmium
  // In shear: what does not depend on how compressible the material is.
  const double stiffness = 3.0 * material.D(3, 3);
  if (!(stiffness > kSoftest && stiffness < kStiffest))
    return fmt::format("material \"{}\" has a stiffness of about {:.3g} Pa, as no material has; is the unit of its Young's "
                       "modulus missing (young = \"210 GPa\")?",
                       material.name, stiffness);
  if (!(material.density > kLightest && material.density < kHeaviest))
    return fmt::format("material \"{}\" has a density of {:.3g} kg/m^3, as no material has; is its unit missing "
                       "(density = \"7850 kg/m^3\")?",
                       material.name, material.density);
  return "";
}

/// A shell that is thicker than a third of all shells are long: most often a thickness in another unit.  Empty where
/// none is.
std::string odd_thickness(const mesh::Mesh& mesh) {
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(HUGE_VAL), high = -low;
  double thickest = 0.0;
  for (const mesh::CellBlock& block : mesh.shells) {
    for (const mesh::Index node : block.nodes.reshaped()) {
      low = low.cwiseMin(mesh.points.row(node));
      high = high.cwiseMax(mesh.points.row(node));
    }
    for (const double thickness : block.thickness) thickest = std::max(thickest, thickness);
  }
  const double length = (high - low).norm();
  if (mesh.shells.empty() || !(thickest > length / 3.0)) return "";
  return fmt::format("a shell is {:.3g} m thick where all shells together are {:.3g} m long; is its thickness in the "
                     "deck's unit of length?",
                     thickest, length);
}

/// One mesh and its reduction.
struct Attempt {
  ModelledPart modelled;
  mesh::MeshReport mesh;
  SurfacePicture picture;
  std::vector<std::int32_t> vertices;
  Reduction reduction;
};

ReductionOptions options_of(const PartInput& input, const std::filesystem::path& output,
                            const OutputOptions& options, const linalg::Progress& progress) {
  ReductionOptions how;
  how.set = input.modes.set;
  how.n_modes = input.modes.up_to > 0.0 ? 0 : input.modes.count;
  how.omega_max = 2.0 * std::numbers::pi * input.modes.up_to;
  if (input.modes.up_to > 0.0) how.accuracy = 0.5 * input.modes.accuracy;
  how.effective_mass = input.modes.effective_mass;
  how.interface_modes = input.modes.interface_modes;
  how.response_omegas = input.modes.response_omegas;
  how.certify = input.modes.certify;
  how.estimate_mesh = true;
  how.stiffening = input.stiffening;
  how.team = options.team;
  how.storage.place =
      options.factor_in_file ? linalg::FactorStorage::Place::file : linalg::FactorStorage::Place::automatic;
  if (!std::getenv("TMPDIR")) how.storage.folder = std::filesystem::absolute(output).parent_path();
  how.progress = progress;
  return how;
}

Attempt attempt(const PartInput& input, const std::filesystem::path& output, ReductionOptions how) {
  PartMesh from = load_part_mesh(input, how.progress);
  Attempt out;
  out.mesh = from.report;
  out.modelled = make_part(input, std::move(from));
  const Part& part = out.modelled.part;
  std::vector<std::vector<mesh::Index>> interface_nodes;
  for (int k = 0; k < out.modelled.n_interfaces; ++k) interface_nodes.push_back(part.interfaces[k].set.nodes);
  for (std::vector<mesh::Index>& nodes : interface_nodes) {  // and the skins of shells at them
    const auto n = static_cast<std::ptrdiff_t>(nodes.size());
    for (const Follower& follower : part.followers)
      if (follower.from.size() == 1 && std::binary_search(nodes.begin(), nodes.begin() + n, follower.from.front().first))
        nodes.push_back(follower.point);
  }
  out.picture = make_surface(part.mesh, interface_nodes);
  if (!input.finished.vectors.empty() && part.mesh.boundary.empty()) {
    // A table of nodes has no surface: all nodes are kept, as points.
    for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) out.picture.nodes.push_back(node);
    out.picture.surface.vertices = part.mesh.points;
  }
  // Shapes of the surface at four bytes a number, which shrink to a half or so: a tenth is the least.
  const double n_shapes = 6.0 * out.modelled.n_interfaces + std::max(0, input.modes.count);
  files::expect_size(output, 0.1 * 4.0 * 3.0 * static_cast<double>(out.picture.nodes.size()) * n_shapes);
  how.loads = out.modelled.loads;
  how.shape_nodes = out.picture.nodes;
  out.vertices = stress_vertices(input.recovery, part.mesh, out.picture.nodes, part);
  for (const std::int32_t vertex : out.vertices) how.stress_nodes.push_back(out.picture.nodes[vertex]);
  out.reduction = input.finished.vectors.empty() ? craig_bampton(part, how)
                                                 : reduce_finished_modes(part, load_finished_modes(input), how);
  return out;
}

std::string why_unjudged(const Part& part) {
  if (part.matrices) return "its matrices come from another program, without elements";
  if (!part.mesh.shells.empty() || !part.frames.empty()) return "it has shells or beams, of which no estimate is known";
  if (is_nearly_incompressible(part)) return "a material is nearly incompressible, where its elements lock and no estimate sees it";
  if (!part.dependent.empty()) return "constraints (*EQUATION, MPC, *TIE between nodes) bind its mesh, whose error is not known";
  if (part.mesh.solids.empty()) return "it has no solid elements";
  return "the part has no elastic mode";
}

/// Meshes and reduces until both are within what is asked; without a goal once.  Modes are chosen on the first mesh, where
/// they cost least.  `say` gets a line for each reduction.
/// std::runtime_error where the goal is out of reach.
Attempt reach(PartInput input, const std::filesystem::path& output, ReductionOptions how,
              const std::function<void(const std::string&)>& say, std::vector<std::string>& warnings) {
  constexpr int kMostMeshes = 7, kMostModes = 200;
  AccuracyGoal goal(input.modes);
  const bool own_mesh = input.format != PartFormat::cad;
  for (int cycle = 1;;) {
    linalg::Stopwatch watch;
    Attempt out = attempt(input, output, how);
    if (!goal.asked()) return out;
    Judgement judged = goal.judge(out.reduction);
    const int dofs = out.reduction.report.n_i + out.reduction.report.n_b;
    if (!judged.known)
      throw std::runtime_error(fmt::format(
          "an accuracy of {:.3g} % is asked, but the mesh cannot be judged: {}; leave the accuracy out and choose the modes "
          "by modes.count, then nothing is promised of the mesh",
          100.0 * input.modes.accuracy, why_unjudged(out.modelled.part)));
    if (out.reduction.mesh->rough && warnings.empty())
      warnings.push_back(fmt::format(
          "the accuracy of {:.3g} % asked for is judged only roughly, from recovered stresses (to a factor of five): compare "
          "with a finer mesh",
          100.0 * input.modes.accuracy));
    say(fmt::format("mesh {}: {} dofs, {} modes; estimated error of the mesh: frequencies {:.2g} %, static compliance "
                    "{:.2g} %; of the modes left out {:.2g} %; {:.1f} s",
                    cycle, dofs, out.reduction.n_q, 100.0 * judged.frequencies, 100.0 * judged.compliance,
                    100.0 * judged.modes, watch.lap()));
    const bool more_modes = !goal.modes_reached(judged) && how.accuracy == 0.0 && how.n_modes < kMostModes;
    if (more_modes) how.n_modes = std::min(kMostModes, how.n_modes + std::max(8, how.n_modes / 2));
    const bool mesh_done = goal.mesh_reached(judged) || own_mesh;
    if (mesh_done && !more_modes) {
      if (!goal.mesh_reached(judged))
        warnings.push_back("the mesh comes with the part and cannot be made finer here; " + goal.describe(judged));
      else if (!goal.modes_reached(judged) && how.accuracy == 0.0)
        warnings.push_back("more modes are not tried; " + goal.describe(judged));
      return out;
    }
    if (more_modes) continue;
    if (cycle == kMostMeshes)
      throw std::runtime_error(fmt::format(
          "the accuracy is out of reach with {} meshes: {}; ask for less, for compliance separately "
          "(modes.compliance_accuracy), or start with a smaller mesh.size",
          cycle, goal.describe(judged)));
    try {
      input.cad.sizes = goal.next_sizes(out.modelled.part, dofs, judged);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(std::string("the accuracy is out of reach: ") + error.what());
    }
    ++cycle;
  }
}

}  // namespace

void reduce_part(const PartInput& input, const std::filesystem::path& output, const OutputOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  terminal::Progress line(stderr, options.quiet);
  StageLines log(stderr, options.quiet);
  const auto progress = [&](std::string_view stage, double fraction) {
    line(stage, fraction);
    log(stage, fraction);
  };
  const linalg::Session session;
  std::vector<linalg::UserOption> petsc = input.petsc;
  petsc.insert(petsc.end(), options.petsc.begin(), options.petsc.end());
  if (options.team && !petsc.empty())
    throw input::InputError(
        "options of PETSc are for one process; the processes of mpirun factorise by MUMPS: leave them out, or mpirun");
  const linalg::UserOptions user(std::move(petsc));
  const bool finished = !input.finished.vectors.empty();
  std::vector<std::string> warnings;
  Attempt done = reach(
      input, output, options_of(input, output, options, progress),
      [&](const std::string& text) {
        if (options.quiet) return;
        line.finish();
        fmt::print("  {}\n", text);
        std::fflush(stdout);
      },
      warnings);
  const Part& part = done.modelled.part;
  if (!options.mesh.empty()) write_mesh(options.mesh, part.mesh, part.materials);
  Reduction& reduction = done.reduction;
  SurfacePicture& picture = done.picture;
  std::vector<std::int32_t>& vertices = done.vertices;

  ReportData data{.mesh = done.mesh, .notes = done.modelled.notes};
  data.warnings = warnings;
  if (reduction.dropped.size() > 0) data.errors = mode_errors(reduction);
  if (options.compare > 0 && finished)
    throw input::InputError(
        "--compare solves the full model, which finished modes do not bring along; leave it out");
  if (!input.modes.struck.empty()) {
    StruckModes struck;
    try {
      struck = strike_modes(reduction, input.modes.struck);
    } catch (const std::invalid_argument& error) {
      throw input::InputError(input.modes.where + ".strike_modes: " + error.what());
    }
    for (std::size_t k = 0; k < struck.frequencies.size(); ++k)
      data.notes.push_back(
          fmt::format("mode {} ({:.5g} Hz) is struck out", input.modes.struck[k], struck.frequencies[k]));
    // Constraint modes are exact in statics; without all of them the interface is stiffer than it is.
    if (struck.interface_stiffer > 1e-6)
      data.warnings.push_back(
          fmt::format("striking these modes out takes part of the constraint modes: the interfaces are up to "
                      "{:.3g} % stiffer than the part is",
                      100.0 * struck.interface_stiffer));
  }
  if (options.compare > 0)
    data.comparison = compare(part, reduction, options.compare, input.modes.struck, progress);
  if (options.compare > 0 && data.comparison.full_hz.empty())
    data.warnings.push_back(
        "--compare has nothing to compare: the superelement has no elastic frequency of the free body");
  if (options.compare > 0 && data.comparison.static_error < 0.0)
    data.notes.push_back(
        "--compare: statics not compared, which needs two interfaces with all six directions and no other");
  data.mesh_error = reduction.mesh;
  for (const Material& material : part.materials) data.bulk_over_shear = std::max(data.bulk_over_shear, bulk_over_shear(material));
  if (const std::string coarse = too_coarse(data.mesh_error); !coarse.empty()) data.warnings.push_back(coarse);
  const MeshHints hints = mesh_hints(part, input.format == PartFormat::cad ? done.mesh.size : 0.0, data.mesh_error);
  data.warnings.insert(data.warnings.end(), hints.warnings.begin(), hints.warnings.end());
  data.notes.insert(data.notes.end(), hints.notes.begin(), hints.notes.end());
  if (!too_coarse(data.mesh_error).empty() && is_better(output))
    throw std::runtime_error(fmt::format("{}; {}, which resolves it, is kept: name another file by -o to write this one",
                                         too_coarse(data.mesh_error), output.string()));
  data.warnings.insert(data.warnings.end(), done.modelled.warnings.begin(), done.modelled.warnings.end());
  for (const Material& material : part.materials)
    if (const std::string odd = odd_material(material); !odd.empty()) data.warnings.push_back(odd);
  if (const std::string odd = odd_thickness(part.mesh); !odd.empty()) data.warnings.push_back(odd);
  if (input.has_damping) add_damping(reduction, input.damping);
  data.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Report report = make_report(input, reduction, data);
  progress("write", 0.0);
  std::vector<mesh::Index> stress_nodes;
  for (const std::int32_t vertex : vertices) stress_nodes.push_back(picture.nodes[vertex]);
  std::optional<superelement::MeshError> mesh_error;
  if (reduction.mesh) mesh_error = to_mesh_error(*reduction.mesh, part, picture.nodes);
  superelement::Superelement se = to_superelement(input, std::move(reduction), std::move(picture.surface),
                                                  report.json.dump(1), std::move(vertices));
  se.mesh_error = std::move(mesh_error);
  if (input.has_damping) se.modal_damping = 0.0;
  if (se.stress && !finished) add_compliance(part, stress_nodes, *se.stress);
  superelement::write(output, se);
  if (!options.report.empty()) superelement::write_whole(options.report, report.json.dump(2) + "\n");
  line.finish();
  log.finish();
  user.print_log();
  for (const std::string& name : user.unused())
    data.warnings.push_back(
        fmt::format("PETSc option {}: nothing in this reduction has given such a report; is it misspelt?", name));
  for (const std::string& warning : data.warnings) fmt::print(stderr, "warning: {}\n", warning);
  if (!options.quiet) fmt::print("{}wrote {}\n", report.text, output.string());
}

}  // namespace flexura::reduce
