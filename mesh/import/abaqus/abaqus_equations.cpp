// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/abaqus/abaqus_ties.hpp"
#include "mesh/import/projection.hpp"

namespace flexura::mesh::abaqus {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d X;
  X << 0, -r(2), r(1), r(2), 0, -r(0), -r(1), r(0), 0;
  return X;
}

// What displacements of a face's nodes give to a point off it: theta x off with the mean rotation of the face, which for
// r_k from the nodes' middle is theta = J^-1 sum r_k x u_k, J = sum |r_k|^2 1 - r_k r_k^T.
std::vector<Eigen::Matrix3d> turned_with(const std::vector<Eigen::Vector3d>& nodes,
                                         const Eigen::Vector3d& off) {
  std::vector<Eigen::Matrix3d> out(nodes.size(), Eigen::Matrix3d::Zero());
  if (off.isZero(0.0)) return out;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& x : nodes) middle += x / static_cast<double>(nodes.size());
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& x : nodes) J -= cross_matrix(x - middle) * cross_matrix(x - middle);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    out[k] = -cross_matrix(off) * J.inverse() * cross_matrix(nodes[k] - middle);
  return out;
}

}  // namespace

Eigen::Matrix3d TiePlacer::axes_at(Index node) const {
  const auto found = axes_of_.find(node);
  return found == axes_of_.end() ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                 : found->second->axes_at(placed_.builder.place(node));
}

// Where terms name sets, there is an equation for each of their nodes, in order; a single node goes with all.
void TiePlacer::take_equations() {
  for (const Transform& transform : placed_.deck.transforms)
    for (const Index node : named_nodes(transform.set, transform.where)) axes_of_[node] = &transform;
  for (const EquationLine& equation : placed_.deck.equations) {
    std::vector<std::vector<Index>> nodes;
    std::size_t count = 1;
    for (const EquationLine::Term& term : equation.terms) {
      nodes.push_back(named_nodes(term.of, equation.where));
      if (nodes.back().size() != 1 && count != 1 && nodes.back().size() != count)
        throw std::invalid_argument(
            fmt::format("{}: *EQUATION between sets of {} and {} nodes; give sets of one size",
                        equation.where.text(), count, nodes.back().size()));
      count = std::max(count, nodes.back().size());
      if (nodes.back().empty())
        throw std::invalid_argument(
            fmt::format("{}: *EQUATION names the set {}, which is empty", equation.where.text(), term.of));
    }
    for (std::size_t k = 0; k < count; ++k) {
      ImportedEquation to{.terms = {}, .of = "*EQUATION in " + equation.where.text()};
      for (std::size_t t = 0; t < equation.terms.size(); ++t) {
        const Index node = nodes[t][nodes[t].size() == 1 ? 0 : k];
        const Eigen::Index d = equation.terms[t].dof - 1;
        ImportedEquation::Term term{.node = node};
        term.row.segment<3>(d < 3 ? 0 : 3) = equation.terms[t].coefficient * axes_at(node).col(d % 3);
        to.terms.push_back(term);
      }
      placed_.model.equations.push_back(std::move(to));
    }
  }
  if (!placed_.deck.equations.empty())
    placed_.model.messages.push_back(fmt::format("{} equation{} between dofs (*EQUATION)",
                                                 placed_.model.equations.size(),
                                                 placed_.model.equations.size() == 1 ? "" : "s"));
}

std::set<Index> TiePlacer::turning_nodes() const {
  std::set<Index> turns;
  for (const ModelBuilder::Cell& cell : placed_.builder.cells())
    if (dimension_of(cell.type) == 2) turns.insert(cell.nodes.begin(), cell.nodes.end());
  for (const ImportedBar& bar : placed_.model.bars) turns.insert(bar.nodes.begin(), bar.nodes.end());
  return turns;
}

void TiePlacer::follow_with_arm(const SurfaceTie& tie, Index slave, Index master) {
  const Eigen::Vector3d r = placed_.builder.place(slave) - placed_.builder.place(master);
  for (int d = 0; d < 6; ++d) {
    ImportedEquation equation{.terms = {{.node = slave}, {.node = master}},
                              .of = "*TIE in " + tie.where.text()};
    equation.terms[0].row(d) = -1;
    equation.terms[1].row(d) = 1;
    if (d < 3) equation.terms[1].row.tail<3>() = r.cross(Eigen::Vector3d::Unit(d));  // (theta x r)_d
    placed_.model.equations.push_back(std::move(equation));
  }
}

void TiePlacer::tie_between_nodes(const SurfaceTie& tie, const std::vector<Index>& slaves, double tolerance) {
  const std::vector<SurfaceFace> faces = surface_faces(tie.master, tie.where);
  if (!(tolerance > 0)) {  // a twentieth of the master's edges
    double sum = 0;
    std::size_t count = 0;
    for (const SurfaceFace& face : faces)
      for (std::size_t k = 1; k < 3; ++k, ++count)
        sum += (placed_.builder.place(face.nodes[k]) - placed_.builder.place(face.nodes[k - 1])).norm();
    tolerance = count > 0 ? 0.05 * sum / static_cast<double>(count) : 0;
  }
  const std::set<Index> turns = turning_nodes();
  std::size_t bound = 0, turning = 0, apart = 0;
  double moved = 0;
  for (const Index slave : slaves) {
    const auto at = project(
        placed_.builder.place(slave), faces,
        [&](Index node) -> const Eigen::Vector3d& { return placed_.builder.place(node); }, tolerance);
    if (!at) {
      ++apart;
      continue;
    }
    const std::vector<Index>& masters = faces[at->face].nodes;
    if (std::ranges::find(masters, slave) != masters.end()) continue;
    moved = std::max(moved, at->distance);
    const Eigen::Vector3d off =
        tie.adjust ? Eigen::Vector3d::Zero() : Eigen::Vector3d(placed_.builder.place(slave) - at->place);
    // Off the face it would not follow its turns: it is put there, as Abaqus adjusts it, or hangs on a rigid arm.
    if (tie.adjust) placed_.builder.move(slave, at->place);
    std::vector<Eigen::Vector3d> places;
    for (const Index node : masters) places.push_back(placed_.builder.place(node));
    const std::vector<Eigen::Matrix3d> arms = turned_with(places, off);
    for (int d = 0; d < 3; ++d) {
      ImportedEquation equation{.terms = {{.node = slave}}, .of = "*TIE in " + tie.where.text()};
      equation.terms[0].row(d) = -1;
      for (std::size_t k = 0; k < masters.size(); ++k) {
        Eigen::Vector3d c = arms[k].row(d).transpose();
        c(d) += at->N(static_cast<Eigen::Index>(k));
        if (c.cwiseAbs().maxCoeff() < 1e-14) continue;
        equation.terms.push_back({.node = masters[k]});
        equation.terms.back().row.head<3>() = c;
      }
      placed_.model.equations.push_back(std::move(equation));
    }
    ++bound;
    turning += turns.contains(slave);
  }
  if (bound > 0)
    placed_.model.messages.push_back(fmt::format(
        "*TIE in {}: {} nodes of {} follow the faces of {} between their nodes{}", tie.where.text(), bound,
        tie.slave, tie.master,
        moved > 0 ? fmt::format(" ({} them by at most {:.2g}{})", tie.adjust ? "moved onto" : "off", moved,
                                tie.adjust ? "" : ": ADJUST=NO")
                  : ""));
  if (turning > 0)
    placed_.model.warnings.push_back(
        fmt::format("*TIE in {}: {} of the nodes that follow between nodes have rotations, which stay free: "
                    "a hinge; mesh both sides alike "
                    "there",
                    tie.where.text(), turning));
  if (apart > 0)
    placed_.model.warnings.push_back(
        fmt::format("*TIE in {}: {} of the nodes of {} lie farther than {:.3g} from {} and stay apart: give "
                    "*TIE a POSITION TOLERANCE",
                    tie.where.text(), apart, tie.slave, tolerance, tie.master));
}

}  // namespace flexura::mesh::abaqus
