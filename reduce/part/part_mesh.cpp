// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/part_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>

#include "mesh/gmsh/mesh_file.hpp"
#include "mesh/gmsh/sheet.hpp"
#include "mesh/import/abaqus.hpp"
#include "mesh/import/nastran.hpp"
#include "mesh/import/unv.hpp"
#include "reduce/part/deck_materials.hpp"
#include "reduce/part/largest_piece.hpp"
#include "reduce/part/read_matrices.hpp"

namespace flexura::reduce {
namespace {

mesh::ImportedModel read_foreign(const PartInput& input) {
  const std::filesystem::path& path = input.cad.path;
  switch (input.format) {
    case PartFormat::abaqus:
      return mesh::read_abaqus(path, input.program);
    case PartFormat::nastran:
      return mesh::read_nastran(path);
    case PartFormat::unv:
      return mesh::read_unv(path);
    case PartFormat::nodes: {
      mesh::ImportedModel model;
      model.mesh = read_nodes(path);
      return model;
    }
    default:
      break;
  }
  mesh::MeshFile file = mesh::read_mesh_file(
      path, input.cad.worker, input.cad.time_limit_s,
      input.sheet_thickness > 0.0 ? mesh::MeshFileCells::shells : mesh::MeshFileCells::solids);
  mesh::ImportedModel model;
  model.mesh = std::move(file.mesh);
  model.messages = std::move(file.messages);
  return model;
}

/// Which nodes belong to elements, or have entries in the matrices that stand for them.
std::vector<char> nodes_in_cells(const mesh::Mesh& mesh, const PartMesh& part) {
  std::vector<char> inside(mesh.n_nodes(), 0);
  if (part.matrices) {
    for (const auto& pair : part.matrices->u.pairs)
      for (const mesh::Index node : pair) inside[node] = 1;
    return inside;
  }
  for (const mesh::ImportedBar& bar : part.bars)
    for (const mesh::Index node : bar.nodes) inside[node] = 1;
  for (const mesh::ImportedSpring& spring : part.springs)
    for (const mesh::Index node : spring.nodes) inside[node] = 1;
  for (const auto* blocks : {&mesh.solids, &mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      for (Eigen::Index k = 0; k < block.nodes.size(); ++k) inside[block.nodes.data()[k]] = 1;
  return inside;
}

// Some of the three displacements, or of the three rotations: a hinge, a slide.
bool ties_some(const std::array<bool, 6>& dofs) {
  const auto some = [&](std::size_t first) {
    const int n = dofs[first] + dofs[first + 1] + dofs[first + 2];
    return n != 0 && n != 3;
  };
  return some(0) || some(3) || !(dofs[0] || dofs[3]) || (dofs[3] && !dofs[0]);
}

// Each direction a that a node at r from the reference follows: a . u = a . (u_ref + theta_ref x r), a . theta = a . theta_ref.
void bind_some(const mesh::ImportedTie& tie, PartMesh& part) {
  for (std::size_t k = 0; k < tie.nodes.size(); ++k) {
    const Eigen::Vector3d r =
        (part.mesh.points.row(tie.nodes[k]) - part.mesh.points.row(tie.reference)).transpose();
    const Eigen::Matrix3d axes = tie.axes.empty() ? Eigen::Matrix3d::Identity() : tie.axes[k];
    for (Eigen::Index d = 0; d < 6; ++d) {
      if (!tie.dofs[static_cast<std::size_t>(d)]) continue;
      const Eigen::Vector3d a = axes.col(d % 3);
      mesh::ImportedEquation equation{.terms = {{.node = tie.nodes[k]}, {.node = tie.reference}},
                                      .of = fmt::format("tie {} (RBE2)", tie.label)};
      equation.terms[0].row.segment<3>(d < 3 ? 0 : 3) = a;
      equation.terms[1].row.segment<3>(d < 3 ? 0 : 3) = -a;
      if (d < 3) {
        Eigen::Vector3d arm = -r.cross(a);
        for (double& c : arm)  // round-off of places
          if (std::abs(c) < 1e-12 * r.norm()) c = 0.0;
        equation.terms[1].row.tail<3>() = arm;
      }
      part.equations.push_back(std::move(equation));
    }
  }
}

bool is_whole_rigid(const DeckTie& tie) {
  return tie.spec.tie == Tie::rigid && tie.spec.rotations;
}

bool holds(const DeckTie& tie, mesh::Index node) {
  return std::ranges::binary_search(tie.spec.set.nodes, node);
}

// A spider at the foot, or at the end of an arm, of another is one piece with it.
void join_rigid_ties(std::vector<DeckTie>& ties) {
  const auto hangs_on = [](const DeckTie& tie, const DeckTie& other) {
    return is_whole_rigid(tie) && is_whole_rigid(other) &&
           (tie.spec.turning_node == other.spec.turning_node || holds(other, tie.spec.turning_node));
  };
  for (std::size_t k = 0; k < ties.size();) {
    const auto other = std::ranges::find_if(
        ties, [&](const DeckTie& tie) { return &tie != &ties[k] && hangs_on(ties[k], tie); });
    if (other == ties.end()) {
      ++k;
      continue;
    }
    DeckTie& tie = ties[k];
    std::vector<mesh::Index>& nodes = other->spec.set.nodes;
    nodes.insert(nodes.end(), tie.spec.set.nodes.begin(), tie.spec.set.nodes.end());
    std::ranges::sort(nodes);
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    other->joined.push_back({tie.label, tie.node, tie.spec.point});
    other->joined.insert(other->joined.end(), tie.joined.begin(), tie.joined.end());
    ties.erase(ties.begin() + static_cast<std::ptrdiff_t>(k));
    k = 0;
  }
}

void take_ties(const mesh::ImportedModel& model, const std::vector<char>& in_cell, PartMesh& part) {
  for (const mesh::ImportedTie& from : model.ties) {
    const bool rigid = from.kind == mesh::ImportedTie::Kind::rigid;
    if (rigid && ties_some(from.dofs) && in_cell[from.reference]) {
      bind_some(from, part);
      part.messages.push_back(
          fmt::format("tie {} binds only some directions of its nodes: equations between dofs", from.label));
      continue;
    }
    if (rigid && !(from.dofs[0] && from.dofs[1] && from.dofs[2]))
      throw std::invalid_argument(
          fmt::format("RBE2 {} ties only some of the three displacements of its nodes to a node that belongs "
                      "to no element; tie all (CM = 123 "
                      "or 123456)",
                      from.label));
    DeckTie tie{
        .label = from.label,
        .node = part.mesh.node_label.empty() ? from.reference + 1 : part.mesh.node_label[from.reference]};
    tie.spec.name = fmt::format("tie {}", from.label);
    tie.spec.tie = rigid ? Tie::rigid : Tie::average;
    tie.spec.rotations = from.dofs[3] && from.dofs[4] && from.dofs[5];
    if (rigid && !tie.spec.rotations && (from.dofs[3] || from.dofs[4] || from.dofs[5]))
      throw std::invalid_argument(fmt::format(
          "RBE2 {} ties only some of the three rotations of its nodes; tie all or none (CM = 123456 or 123)",
          from.label));
    tie.spec.point = part.mesh.points.row(from.reference);
    std::vector<std::pair<mesh::Index, double>> nodes;
    for (std::size_t k = 0; k < from.nodes.size(); ++k)
      nodes.emplace_back(from.nodes[k], rigid || from.weights.empty() ? 1.0 : from.weights[k]);
    // A reference node that solid elements share moves with its own spider.
    if (rigid && in_cell[from.reference]) nodes.emplace_back(from.reference, 1.0);
    tie.spec.turning_node = from.reference;
    tie.dofs = from.dofs;
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end(), [](auto& a, auto& b) { return a.first == b.first; }),
                nodes.end());
    for (const auto& [node, weight] : nodes) {
      tie.spec.set.nodes.push_back(node);
      if (!rigid) tie.spec.weights.push_back(weight);
    }
    part.ties.push_back(std::move(tie));
  }
  join_rigid_ties(part.ties);
}

/// The rigid tie that carries a node of no element, as one of its rigid arms.
const DeckTie* rigid_carrier(const PartMesh& part, mesh::Index node) {
  const auto tie = std::ranges::find_if(part.ties, [&](const DeckTie& candidate) {
    return is_whole_rigid(candidate) && holds(candidate, node);
  });
  return tie == part.ties.end() ? nullptr : &*tie;
}

void take_masses(const mesh::ImportedModel& model, const std::vector<char>& in_cell, PartMesh& part) {
  for (const mesh::ImportedMass& from : model.masses) {
    PointMass mass{.node = from.node,
                   .mass = from.mass,
                   .offset = from.offset,
                   .inertia = from.inertia,
                   .alpha = from.alpha};
    // At the end of a rigid arm, or of several one after the other: it moves as their reference node does.
    for (std::size_t arms = 0; arms < part.ties.size() && !in_cell[mass.node]; ++arms) {
      const DeckTie* const tie = rigid_carrier(part, mass.node);
      if (!tie || tie->spec.turning_node == mass.node) break;
      mass.offset +=
          (part.mesh.points.row(mass.node) - part.mesh.points.row(tie->spec.turning_node)).transpose();
      mass.node = tie->spec.turning_node;
    }
    const auto tie = std::find_if(part.ties.begin(), part.ties.end(),
                                  [&](const DeckTie& t) { return t.spec.turning_node == mass.node; });
    if (tie != part.ties.end()) {
      mass.node = static_cast<mesh::Index>(tie - part.ties.begin());
      part.tied_masses.push_back(mass);
    } else if (in_cell[mass.node]) {
      part.masses.push_back(mass);
    } else {
      part.warnings.push_back(fmt::format(
          "point mass {} hangs on a node that belongs to no element and to no tie: it moves on its "
          "own and is left out",
          from.label));
    }
  }
}

// --strict: all that is repaired or left out at once.
std::string refusal_of(const PartInput& input, const std::vector<std::string>& warnings) {
  std::string text = fmt::format("{}: strict, and not all of the deck is taken as it stands:",
                                 input.cad.path.filename().string());
  for (const std::string& warning : warnings) text += "\n  " + warning;
  return text;
}

}  // namespace

mesh::Mesh load_nodes(const PartInput& input) {
  mesh::ImportedModel model = read_foreign(input);
  mesh::scale_to_si(model, input.unit_length, input.unit_mass, 1.0);
  return std::move(model.mesh);
}

PartMesh load_part_mesh(const PartInput& input, const mesh::Progress& progress) {
  PartMesh part;
  if (input.format == PartFormat::cad) {
    mesh::CadMesh cad = input.sheet_thickness > 0.0
                            ? mesh::mesh_sheet(input.cad, input.sheet_thickness, progress)
                            : mesh::mesh_cad(input.cad, progress);
    part.mesh = std::move(cad.mesh);
    part.faces = std::move(cad.cad.faces);
    part.report = std::move(cad.report);
    part.messages = part.report.messages;
    part.materials = input.materials;
    return part;
  }
  const auto start = std::chrono::steady_clock::now();
  if (progress) progress("read", 0.0);
  mesh::ImportedModel model = read_foreign(input);
  if (input.keep_largest) keep_largest_piece(model);
  mesh::scale_to_si(model, input.unit_length, input.unit_mass, 1.0);
  part.mesh = std::move(model.mesh);
  if (input.sheet_thickness > 0.0)
    for (mesh::CellBlock& block : part.mesh.shells)
      block.thickness.assign(static_cast<std::size_t>(block.nodes.rows()), input.sheet_thickness);
  part.messages = std::move(model.messages);
  part.warnings = std::move(model.warnings);
  if (!input.finished.vectors.empty()) {
    scale(part.matrices.emplace(read_mass_matrix(input.finished.mass, part.mesh)), input.unit_mass,
          input.unit_length);
  } else if (input.stiffness.empty()) {
    choose_materials(input, model, part);
  } else {
    scale(part.matrices.emplace(
              read_matrices(input.stiffness, input.mass_matrix, input.damping_matrix, part.mesh)),
          input.unit_mass, input.unit_length);
    part.messages.push_back(fmt::format("stiffness and mass are those of {} and {}",
                                        input.stiffness.filename().string(),
                                        input.mass_matrix.filename().string()));
  }
  if (!part.matrices) {
    part.bars = std::move(model.bars);
    for (mesh::ImportedBar& bar : part.bars)
      if (const mesh::ImportedMaterial& of = model.materials[static_cast<std::size_t>(bar.material)];
          std::ranges::none_of(input.materials, [&](const Material& ours) {
            return ours.name == of.name && !ours.D.isZero(0.0);
          }))
        bar.G = of.G;
    part.springs = std::move(model.springs);
    part.equations = std::move(model.equations);
  }
  const std::vector<char> in_cell = nodes_in_cells(part.mesh, part);
  take_ties(model, in_cell, part);
  if (!part.matrices)
    take_masses(model, in_cell, part);
  else if (!model.masses.empty())
    part.messages.push_back(fmt::format(
        "the {} point mass{} of the deck {} in the mass matrix that is given, and not added to it",
        model.masses.size(), model.masses.size() == 1 ? "" : "es", model.masses.size() == 1 ? "is" : "are"));
  if (!part.bars.empty() || !part.springs.empty())
    part.messages.push_back(
        fmt::format("{} beams and rods, {} springs and dampers", part.bars.size(), part.springs.size()));
  say_damping(part);
  if (!model.fixed.empty())
    part.messages.push_back(fmt::format(
        "the supports at {} node{} (SPC) are left out: a superelement is a free body, joints hold it at run "
        "time",
        model.fixed.size(), model.fixed.size() == 1 ? "" : "s"));
  if (input.strict && !part.warnings.empty()) throw std::invalid_argument(refusal_of(input, part.warnings));
  part.report.n_nodes = part.mesh.n_nodes();
  if (part.mesh.solids.empty() && part.mesh.shells.empty()) return part;
  const mesh::Volumes volumes = mesh::measure_volume(part.mesh);
  part.report.n_cells = part.mesh.n_solid_cells();
  for (const mesh::CellBlock& block : part.mesh.shells)
    part.report.n_cells += static_cast<mesh::Index>(block.nodes.rows());
  part.report.quality = mesh::measure_quality(part.mesh);
  part.report.volume = volumes.volume;
  part.report.centroid = volumes.centroid;
  part.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return part;
}

}  // namespace flexura::reduce
