// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/model/mechanism.hpp"

#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace flexura::beam {
namespace {

constexpr double kMechanism = 1e-17;  // relative energy; see the header

struct Strut {
  std::array<int, 2> node;
  Matrix12d K;  // in nodal dofs
};

// Element ends with releases, without the mid-span tapers' cost: a taper is taken with its first section,
// which is stiff in the same directions.
std::vector<Strut> struts_of(const Model& model) {
  std::vector<Strut> struts;
  for (const Member& member : model.members) {
    const Placement placement = placement_of(model, member);
    Releases releases;
    for (int dof = 0; dof < 6; ++dof) {
      releases[dof] = member.end[0].released[dof];
      releases[6 + dof] = member.end[1].released[dof];
    }
    try {
      const Element element(placement.length,
                            matrices_of(model.sections[member.section].section, member.theory), releases);
      const Matrix12d T = placement.transform();
      struts.push_back({{member.end[0].node, member.end[1].node}, T.transpose() * element.stiffness() * T});
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("member \"{}\": {}", member.name, error.what()));
    }
  }
  return struts;
}

}  // namespace

std::string mechanism_of(const Model& model) {
  bool any = false;
  for (const Member& member : model.members)
    any = any || member.end[0].released.any() || member.end[1].released.any();
  if (!any) return "";  // rigid joints leave no mechanism in a connected structure

  const std::vector<Strut> struts = struts_of(model);
  // Hold the first node of each part (any node that members join; rigid motions of the parts are not
  // mechanisms).
  std::vector<int> parent(model.nodes.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  for (const Member& member : model.members) parent[root(member.end[0].node)] = root(member.end[1].node);
  // The held node must be gripped in all six directions: one where a member is not released.
  std::vector<int> held(model.nodes.size(), -1);
  for (const bool gripped : {true, false})
    for (const Member& member : model.members)
      for (const MemberEnd& end : member.end) {
        int& hold = held[root(end.node)];
        if (hold < 0 && (!gripped || end.released.none())) hold = end.node;
      }
  // Anchors hold on solids: a part that has any is held there, all of them.
  std::vector<bool> fixed(model.nodes.size(), false), anchored(model.nodes.size(), false);
  for (const int anchor : model.anchors) fixed[anchor] = anchored[root(anchor)] = true;
  for (std::size_t node = 0; node < model.nodes.size(); ++node)
    if (const int part = root(static_cast<int>(node)); !anchored[part] && held[part] >= 0)
      fixed[held[part]] = true;
  std::vector<int> dof(6 * model.nodes.size(), -1);
  int n = 0;
  std::vector<bool> used(model.nodes.size(), false);
  for (const Strut& strut : struts) used[strut.node[0]] = used[strut.node[1]] = true;
  for (std::size_t node = 0; node < model.nodes.size(); ++node)
    if (used[node] && !fixed[node])
      for (int k = 0; k < 6; ++k) dof[6 * node + k] = n++;
  if (n == 0) return "";

  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(144 * struts.size());
  double largest[2] = {0.0, 0.0};  // translations, rotations
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n);
  for (const Strut& strut : struts)
    for (int i = 0; i < 12; ++i) {
      const int row = dof[6 * strut.node[i / 6] + i % 6];
      largest[i % 6 / 3] = std::max(largest[i % 6 / 3], strut.K(i, i));
      if (row < 0) continue;
      diagonal(row) += strut.K(i, i);
      for (int j = 0; j < 12; ++j) {
        const int column = dof[6 * strut.node[j / 6] + j % 6];
        if (column >= 0) triplets.emplace_back(row, column, strut.K(i, j));
      }
    }
  // A dof without any stiffness gets the scale of its kind; the shift of 1e-15 keeps the factorisation going.
  Eigen::VectorXd scale(n);
  for (std::size_t node = 0; node < model.nodes.size(); ++node)
    for (int k = 0; k < 6; ++k)
      if (const int row = dof[6 * node + k]; row >= 0)
        scale(row) = 1.0 / std::sqrt(std::max(diagonal(row), 1e-12 * largest[k / 3]));
  Eigen::SparseMatrix<double> K(n, n);
  K.setFromTriplets(triplets.begin(), triplets.end());
  K = scale.asDiagonal() * K * scale.asDiagonal();
  Eigen::SparseMatrix<double> shift(n, n);
  shift.setIdentity();
  K += 1e-15 * shift;
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(K);
  // No shortcut by the pivots: round-off in K, carried along a chain of n members, shows as a pivot of eps
  // n^3.

  Eigen::VectorXd z = Eigen::VectorXd::LinSpaced(n, 1.0, 2.0).array().sin();
  for (int iteration = 0; iteration < 20; ++iteration) {
    z = factor.solve(z).eval();
    z /= z.norm();
  }
  // Energy of each member from its stretch; z has unit length in the scale of the diagonal, so this is
  // relative.
  const Eigen::VectorXd u = scale.asDiagonal() * z;
  double energy = 0.0;
  const auto value = [&](int node, int k) { return dof[6 * node + k] < 0 ? 0.0 : u(dof[6 * node + k]); };
  for (const Member& member : model.members) {
    const Placement placement = placement_of(model, member);
    Releases releases;
    for (int k = 0; k < 6; ++k) {
      releases[k] = member.end[0].released[k];
      releases[6 + k] = member.end[1].released[k];
    }
    const SectionMatrices section = matrices_of(model.sections[member.section].section, member.theory);
    const Element element(placement.length, section, releases);
    Vector12d nodal;
    for (int i = 0; i < 12; ++i) nodal(i) = value(member.end[i / 6].node, i % 6);
    const Vector6d s = element.section_forces(0.5 * placement.length, placement.transform() * nodal);
    // s^T F s with F = l f + l^3/12 D^T f D.
    Vector6d slope = Vector6d::Zero();
    slope(M_y) = s(V_z);
    slope(M_z) = -s(V_y);
    const double l = placement.length;
    energy += l * s.dot(section.f * s) + l * l * l / 12.0 * slope.dot(section.f * slope);
  }
  if (energy > kMechanism) return "";

  // A turn counts by a tenth of the structure's size: what swings is named for its way, what only spins for
  // its turn.
  Eigen::Vector3d low = model.nodes[0].p_BoN_B, high = low;
  for (const Node& node : model.nodes) {
    low = low.cwiseMin(node.p_BoN_B);
    high = high.cwiseMax(node.p_BoN_B);
  }
  const double size = 0.1 * (high - low).norm();
  static const std::array<const char*, 6> directions = {"to move along x", "to move along y",
                                                        "to move along z", "to turn about x",
                                                        "to turn about y", "to turn about z"};
  double best = -1.0;
  std::size_t best_node = 0;
  int best_direction = 0;
  for (std::size_t node = 0; node < model.nodes.size(); ++node)
    for (int k = 0; k < 6; ++k) {
      const double amount = std::abs(value(static_cast<int>(node), k)) * (k < 3 ? 1.0 : size);
      if (amount > best * (1.0 + 1e-6)) {
        best = amount;
        best_node = node;
        best_direction = k;
      }
    }
  return fmt::format(
      "the releases leave a mechanism: node \"{}\" is free {} without straining any member; hold it by an "
      "interface, or release fewer directions there",
      model.nodes[best_node].name, directions[best_direction]);
}

}  // namespace flexura::beam
