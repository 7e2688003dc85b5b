// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "mesh/import/abaqus_keywords.hpp"
#include "mesh/import/abaqus_placer.hpp"
#include "mesh/import/projection.hpp"

namespace flexura::mesh::abaqus {

Eigen::Matrix3d Placer::axes_at(Index node) const {
  const auto found = axes_of_.find(node);
  return found == axes_of_.end() ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                                 : found->second->axes_at(builder_.place(node));
}

// Where terms name sets, there is an equation for each of their nodes, in order; a single node goes with all.
void Placer::take_equations() {
  for (const Transform& transform : deck_.transforms)
    for (const Index node : named_nodes(transform.set, transform.where)) axes_of_[node] = &transform;
  for (const EquationLine& equation : deck_.equations) {
    std::vector<std::vector<Index>> nodes;
    std::size_t count = 1;
    for (const EquationLine::Term& term : equation.terms) {
      nodes.push_back(named_nodes(term.of, equation.where));
      if (nodes.back().size() != 1 && count != 1 && nodes.back().size() != count)
        throw std::invalid_argument(fmt::format("{}: *EQUATION between sets of {} and {} nodes; give sets of one size",
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
      model_.equations.push_back(std::move(to));
    }
  }
  if (!deck_.equations.empty())
    model_.messages.push_back(fmt::format("{} equation{} between dofs (*EQUATION)", model_.equations.size(),
                                          model_.equations.size() == 1 ? "" : "s"));
}

void Placer::tie_between_nodes(const SurfaceTie& tie, const std::vector<Index>& slaves, double tolerance) {
  const std::vector<SurfaceFace> faces = surface_faces(tie.master, tie.where);
  if (!(tolerance > 0)) {  // a twentieth of the master's edges
    double sum = 0;
    std::size_t count = 0;
    for (const SurfaceFace& face : faces)
      for (std::size_t k = 1; k < 3; ++k, ++count)
        sum += (builder_.place(face.nodes[k]) - builder_.place(face.nodes[k - 1])).norm();
    tolerance = count > 0 ? 0.05 * sum / static_cast<double>(count) : 0;
  }
  std::set<Index> turns;
  for (const ModelBuilder::Cell& cell : builder_.cells())
    if (dimension_of(cell.type) == 2) turns.insert(cell.nodes.begin(), cell.nodes.end());
  for (const ImportedBar& bar : model_.bars) turns.insert(bar.nodes.begin(), bar.nodes.end());
  std::size_t bound = 0, turning = 0, apart = 0;
  double moved = 0;
  for (const Index slave : slaves) {
    const auto at = project(
        builder_.place(slave), faces, [&](Index node) -> const Eigen::Vector3d& { return builder_.place(node); }, tolerance);
    if (!at) {
      ++apart;
      continue;
    }
    const std::vector<Index>& masters = faces[at->face].nodes;
    if (std::ranges::find(masters, slave) != masters.end()) continue;
    // Off the face it would not follow its turns: it is put there, as Abaqus adjusts it.
    moved = std::max(moved, at->distance);
    builder_.move(slave, at->place);
    for (int d = 0; d < 3; ++d) {
      ImportedEquation equation{.terms = {{.node = slave}}, .of = "*TIE in " + tie.where.text()};
      equation.terms[0].row(d) = -1;
      for (std::size_t k = 0; k < masters.size(); ++k) {
        if (std::abs(at->N(static_cast<Eigen::Index>(k))) < 1e-14) continue;
        equation.terms.push_back({.node = masters[k]});
        equation.terms.back().row(d) = at->N(static_cast<Eigen::Index>(k));
      }
      model_.equations.push_back(std::move(equation));
    }
    ++bound;
    turning += turns.contains(slave);
  }
  if (bound > 0)
    model_.messages.push_back(fmt::format(
        "*TIE in {}: {} nodes of {} follow the faces of {} between their nodes{}", tie.where.text(), bound, tie.slave,
        tie.master, moved > 0 ? fmt::format(" (moved onto them by at most {:.2g})", moved) : ""));
  if (turning > 0)
    model_.warnings.push_back(fmt::format(
        "*TIE in {}: {} of the nodes that follow between nodes have rotations, which stay free: a hinge; mesh both sides alike "
        "there",
        tie.where.text(), turning));
  if (apart > 0)
    model_.warnings.push_back(fmt::format(
        "*TIE in {}: {} of the nodes of {} lie farther than {:.3g} from {} and stay apart: give *TIE a POSITION TOLERANCE",
        tie.where.text(), apart, tie.slave, tolerance, tie.master));
}

}  // namespace flexura::mesh::abaqus
