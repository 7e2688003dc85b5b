// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/attempt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/files/output.hpp"
#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/finished_modes.hpp"
#include "reduce/library/accuracy_goal.hpp"
#include "reduce/part/read_matrices.hpp"
#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {

namespace {

/// The surface vertices at which stress modes are wanted.
std::vector<std::int32_t> stress_vertices(const RecoveryInput& wanted, const mesh::Mesh& mesh,
                                          const std::vector<mesh::Index>& surface_nodes, const Part& part) {
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

/// Stresses of elements, six rows each, or six for each of an element's nodes, as those of nodes: of each the mean of the
/// elements that have it.  Elements by ascending number, of corners each element's nodes by ascending number.
Eigen::MatrixXd averaged_at_nodes(const Eigen::MatrixXd& given, bool by_corners, const mesh::Mesh& mesh,
                                  const std::filesystem::path& file) {
  std::map<std::int64_t, std::vector<mesh::Index>> elements;
  std::int64_t next = 0;
  Eigen::Index n_rows = 0;
  for (const auto* blocks : {&mesh.solids, &mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell) {
        std::vector<mesh::Index>& nodes = elements[block.label.empty() ? ++next : block.label[cell]];
        if (!nodes.empty())
          throw std::invalid_argument(
              fmt::format("{}: the mesh has several elements of the number {}, so their order is not known; "
                          "give stresses at "
                          "nodes",
                          file.string(), block.label.empty() ? next : block.label[cell]));
        nodes.assign(block.nodes.row(cell).begin(), block.nodes.row(cell).end());
        std::ranges::sort(nodes);
        nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
        n_rows += by_corners ? 6 * static_cast<Eigen::Index>(nodes.size()) : 6;
      }
  if (given.rows() != n_rows)
    throw std::invalid_argument(fmt::format("{}: {} rows, {} are wanted: six for each {} of the {} elements",
                                            file.string(), given.rows(), n_rows,
                                            by_corners ? "node of each" : "one", elements.size()));
  Eigen::MatrixXd at_nodes =
      Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(mesh.n_nodes()), given.cols());
  std::vector<int> count(mesh.n_nodes(), 0);
  Eigen::Index row = 0;
  for (const auto& [label, nodes] : elements) {
    for (const mesh::Index node : nodes) {
      at_nodes.middleRows<6>(6 * static_cast<Eigen::Index>(node)) += given.middleRows<6>(row);
      ++count[node];
      if (by_corners) row += 6;
    }
    if (!by_corners) row += 6;
  }
  for (mesh::Index node = 0; node < mesh.n_nodes(); ++node)
    if (count[node] > 1) at_nodes.middleRows<6>(6 * static_cast<Eigen::Index>(node)) /= count[node];
  return at_nodes;
}

/// The vectors and matrices of the part file in SI: V has no unit or that of the file's lengths, in which
/// V^T K V and V^T M V were computed, so that forces per length and masses count as those of the file.
FinishedModes load_finished_modes(const PartInput& input, const mesh::Mesh& mesh) {
  FinishedModes modes{.V = read_dense(input.finished.vectors),
                      .K = read_dense(input.finished.stiffness, 'K')};
  if (const Eigen::Index n = mesh.n_nodes(); modes.V.rows() == 6 * n) {
    const Eigen::MatrixXd both = modes.V;
    modes.V.resize(3 * n, both.cols());
    modes.rotations.resize(3 * n, both.cols());
    for (Eigen::Index node = 0; node < n; ++node) {
      modes.V.middleRows<3>(3 * node) = both.middleRows<3>(6 * node);
      modes.rotations.middleRows<3>(3 * node) = both.middleRows<3>(6 * node + 3) / input.unit_length;
    }
  }
  modes.K *= input.unit_mass;
  if (!input.finished.damping.empty()) modes.D = input.unit_mass * read_dense(input.finished.damping, 'B');
  if (!input.finished.reduced_mass.empty())
    modes.M = input.unit_mass * read_dense(input.finished.reduced_mass, 'M');
  // Stress per displacement: (M L^-1 T^-2) / L.
  if (!input.finished.stress.empty()) {
    const Eigen::MatrixXd stress =
        input.unit_mass / (input.unit_length * input.unit_length) * read_dense(input.finished.stress);
    modes.stress = input.finished.stress_at == StressPlace::nodes
                       ? stress
                       : averaged_at_nodes(stress, input.finished.stress_at == StressPlace::corners, mesh,
                                           input.finished.stress);
  }
  return modes;
}

std::string per_cent(double x) {
  return std::isfinite(x) ? fmt::format("{:.2g} %", 100.0 * x) : std::string("beyond measure");
}

std::string why_unjudged(const Part& part) {
  if (part.matrices) return "its matrices come from another program, without elements";
  if (!part.mesh.shells.empty() || !part.frames.empty())
    return "it has shells or beams, of which no estimate is known";
  if (is_nearly_incompressible(part))
    return "a material is nearly incompressible, where its elements lock and no estimate sees it";
  if (!part.dependent.empty())
    return "constraints (*EQUATION, MPC, *TIE between nodes) bind its mesh, whose error is not known";
  if (part.mesh.solids.empty()) return "it has no solid elements";
  return "the part has no elastic mode";
}

// Whether there are elements of reduced integration, which have all their points now.
bool integrate_in_full(mesh::Mesh& mesh) {
  bool any = false;
  for (mesh::CellBlock& block : mesh.solids)
    if (block.variant == mesh::CellVariant::reduced) block.variant = mesh::CellVariant::standard, any = true;
  return any;
}

}  // namespace

Attempt attempt(const PartInput& input, const std::filesystem::path& output, ReductionOptions how) {
  PartMesh from = load_part_mesh(input, how.progress);
  Attempt out;
  out.mesh = from.report;
  std::optional<FinishedModes> finished;
  if (!input.finished.vectors.empty()) finished = load_finished_modes(input, from.mesh);
  out.modelled = make_part(input, std::move(from));
  const Part& part = out.modelled.part;
  std::vector<std::vector<mesh::Index>> interface_nodes;
  for (int k = 0; k < out.modelled.n_interfaces; ++k) interface_nodes.push_back(part.interfaces[k].set.nodes);
  for (std::vector<mesh::Index>& nodes : interface_nodes) {  // and the skins of shells at them
    const auto n = static_cast<std::ptrdiff_t>(nodes.size());
    for (const Follower& follower : part.followers)
      if (follower.from.size() == 1 &&
          std::binary_search(nodes.begin(), nodes.begin() + n, follower.from.front().first))
        nodes.push_back(follower.point);
  }
  out.picture = make_surface(part.mesh, interface_nodes);
  if (finished && part.mesh.boundary.empty()) {
    // A table of nodes has no surface: all nodes are kept, as points.
    const Eigen::Index n_nodes = finished->V.rows() / 3;
    for (mesh::Index node = 0; node < n_nodes; ++node) out.picture.nodes.push_back(node);
    out.picture.surface.vertices = part.mesh.points.topRows(n_nodes);
  }
  // Shapes of the surface at four bytes a number, which shrink to a half or so: a tenth is the least.
  const double n_shapes = 6.0 * out.modelled.n_interfaces + std::max(0, input.modes.count);
  if (!output.empty())
    files::expect_size(output, 0.1 * 4.0 * 3.0 * static_cast<double>(out.picture.nodes.size()) * n_shapes);
  out.graded = !input.cad.sizes.empty();
  how.loads = out.modelled.loads;
  how.shape_nodes = out.picture.nodes;
  out.vertices = stress_vertices(input.recovery, part.mesh, out.picture.nodes, part);
  for (const std::int32_t vertex : out.vertices) how.stress_nodes.push_back(out.picture.nodes[vertex]);
  try {
    out.reduction = finished ? reduce_finished_modes(part, *finished, how) : craig_bampton(part, how);
  } catch (const SingularStiffness& singular) {
    if (input.strict || how.team || !integrate_in_full(out.modelled.part.mesh)) throw;
    out.modelled.warnings.push_back(
        "elements of reduced integration (C3D20R, C3D8R) leave the body without stiffness somewhere, so few "
        "of "
        "them lie side by side: all are integrated in full");
    out.reduction = craig_bampton(part, how);
  }
  return out;
}

Attempt reach(PartInput input, const std::filesystem::path& output, ReductionOptions how,
              const std::function<void(const std::string&)>& say, std::vector<std::string>& warnings) {
  constexpr int kMostMeshes = 7, kMostModes = 200;
  AccuracyGoal goal(input.modes);
  const bool own_mesh = input.format != PartFormat::cad;
  std::optional<Attempt> best;  // the one before, should a finer mesh fail
  std::string reached;
  const auto end_with_best = [&](const std::string& why) {
    best->missed = fmt::format("the accuracy asked for is not reached; {}; {}", reached, why);
    return std::move(*best);
  };
  for (int cycle = 1;;) {
    linalg::Stopwatch watch;
    Attempt out;
    try {
      out = attempt(input, output, how);
    } catch (const std::exception& error) {
      if (!best) throw;
      return end_with_best(fmt::format("the next mesh came to nothing ({})", error.what()));
    }
    if (!goal.asked()) return out;
    Judgement judged = goal.judge(out.reduction);
    const int dofs = out.reduction.report.n_i + out.reduction.report.n_b;
    if (!judged.known)
      throw std::runtime_error(
          fmt::format("an accuracy of {:.3g} % is asked, but the mesh cannot be judged: {}; leave the "
                      "accuracy out and choose the modes "
                      "by modes.count, then nothing is promised of the mesh",
                      100.0 * input.modes.accuracy, why_unjudged(out.modelled.part)));
    if (out.reduction.mesh->rough && warnings.empty())
      warnings.push_back(
          fmt::format("the accuracy of {:.3g} % asked for is judged only roughly, from recovered stresses "
                      "(to a factor of five): compare "
                      "with a finer mesh",
                      100.0 * input.modes.accuracy));
    if (say)
      say(
          fmt::format("mesh {}: {} dofs, {} modes; estimated error of the mesh: frequencies {}, static "
                      "compliance {}; of the "
                      "modes left out {}; {:.1f} s",
                      cycle, dofs, out.reduction.n_q, per_cent(judged.frequencies),
                      per_cent(judged.compliance), per_cent(judged.modes), watch.lap()));
    const bool more_modes = !goal.modes_reached(judged) && how.accuracy == 0.0 && how.n_modes < kMostModes;
    if (more_modes) {
      // Of an interface that is small beside the part the modes say little: their error falls slowly with their number.  Its
      // answer at rest, a shape for each of its directions, is worth all that are left out.
      if (how.response_omegas.empty() && std::isfinite(judged.modes))
        how.response_omegas = {0.0};
      else
        how.n_modes = std::min(kMostModes, how.n_modes + std::max(8, how.n_modes / 2));
    }
    const bool mesh_done = goal.mesh_reached(judged) || own_mesh;
    if (mesh_done && !more_modes) {
      if (!goal.mesh_reached(judged))
        warnings.push_back("the mesh comes with the part and cannot be made finer here; " +
                           goal.describe(judged));
      else if (!goal.modes_reached(judged) && how.accuracy == 0.0)
        out.missed =
            "the accuracy asked for is not reached; " + goal.describe(judged) + "; more modes are not tried";
      return out;
    }
    if (mesh_done) continue;
    best = std::move(out);
    reached = goal.describe(judged);
    if (cycle == kMostMeshes)
      return end_with_best(
          fmt::format("{} meshes were tried: ask for less, for compliance separately "
                      "(modes.compliance_accuracy), or start with a smaller mesh.size",
                      cycle));
    try {
      input.cad.sizes = goal.next_sizes(best->modelled.part, dofs);
    } catch (const std::runtime_error& error) {
      return end_with_best(error.what());
    }
    ++cycle;
  }
}

}  // namespace flexura::reduce
