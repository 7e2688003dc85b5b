// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/reach_accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "reduce/cms/error_estimate.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// The estimate of the mesh is worth half to twice the truth (docs/mesh_error.md): half of what is asked is aimed at, and
// modes left out may take a quarter.
constexpr double kMeshShare = 0.5, kModesShare = 0.25;
constexpr std::size_t kFrequencies = 6;  // without up_to
constexpr double kMostDofs = 1e6;

std::string percent(double x) {
  return std::isfinite(x) && x < 0.5 ? fmt::format("{:.2g} %", 100.0 * x) : std::string("50 % or more");
}

}  // namespace

AccuracyGoal::AccuracyGoal(const ModesInput& modes)
    : frequencies_(modes.accuracy),
      compliance_(modes.compliance_accuracy),
      up_to_(2.0 * std::numbers::pi * modes.up_to) {}

Judgement AccuracyGoal::judge(const Reduction& reduction) {
  Judgement out;
  if (!reduction.mesh || reduction.mesh->modes.empty()) return out;
  out.known = true;
  before_ = share_.modes;
  share_ = *reduction.mesh;
  n_judged_ = 0;
  for (const MeshShare::Mode& mode : share_.modes)
    n_judged_ += up_to_ > 0.0 ? mode.omega2 <= up_to_ * up_to_ : n_judged_ < kFrequencies;
  n_judged_ = std::max<std::size_t>(n_judged_, 1);
  for (std::size_t k = 0; k < n_judged_; ++k) out.frequencies = std::max(out.frequencies, share_.modes[k].error);
  raised_ = 1.0;
  const bool only_mesh = n_shapes_ == reduction.n();  // other modes move frequencies as well
  n_shapes_ = reduction.n();
  for (std::size_t k = 0; only_mesh && k < std::min(n_judged_, before_.size()); ++k) {
    const double moved = std::sqrt(before_[k].omega2 / share_.modes[k].omega2) - 1.0, said = before_[k].error;
    if (std::isfinite(said) && said > 0.2 * frequencies_)
      raised_ = std::max(raised_, (moved + share_.modes[k].error) / said);
  }
  raised_ = std::min(raised_, 3.0);
  out.frequencies *= raised_;
  for (const MeshShare::Interface& interface : share_.interfaces)
    if (interface.error > out.compliance) {
      out.compliance = interface.error;
      out.interface = interface.name;
    }
  if (reduction.dropped.size() > 0) {
    const std::vector<ModeError> errors = mode_errors(reduction);
    for (std::size_t k = 0; k < std::min(n_judged_, errors.size()); ++k)
      out.modes = std::max(out.modes, 0.5 * errors[k].safe_estimate);
  }
  return out;
}

bool AccuracyGoal::mesh_reached(const Judgement& j) const {
  return j.frequencies <= kMeshShare * frequencies_ && j.compliance <= kMeshShare * compliance_;
}

bool AccuracyGoal::modes_reached(const Judgement& j) const {
  return j.modes <= kModesShare * frequencies_;
}

std::vector<double> AccuracyGoal::next_sizes(const mesh::Mesh& mesh, int dofs, const Judgement& j) const {
  // Of each cell the greatest share of what a state may have; all of them together may have one.
  constexpr double kAim = 0.7;  // a little less, so that the next mesh is not just above
  const Eigen::MatrixXf& by_cell = share_.by_cell;
  VectorXd share = VectorXd::Zero(by_cell.rows());
  for (Index k = 0; k < by_cell.cols(); ++k) {
    const bool mode = k < static_cast<Index>(share_.modes.size());
    if (mode && k >= static_cast<Index>(n_judged_)) continue;
    const double may = mode ? 2.0 * kMeshShare * frequencies_ / raised_ : kMeshShare * compliance_;
    share = share.cwiseMax(by_cell.col(k).cast<double>() / may);
  }
  std::vector<double> nodes_size(static_cast<std::size_t>(mesh.n_nodes()), 0.0);
  std::vector<int> nodes_cells(static_cast<std::size_t>(mesh.n_nodes()), 0);
  int degree = 2;
  for (const mesh::CellBlock& block : mesh.solids)
    if (block.nodes.cols() == mesh::shape_of(block.type).corners) degree = 1;
  // Corners and edges converge more slowly than the degree says.
  const double p = degree == 2 ? 1.5 : 1.0, d = 3.0, least = 1e-6 * share.maxCoeff();
  const double sum = share.cwiseMax(least).array().pow(d / (2.0 * p + d)).sum();
  // Finer by more than four is a guess; coarser at most by a half.
  VectorXd factor(share.size());
  for (Index k = 0; k < share.size(); ++k)
    factor(k) = std::clamp(std::pow(kAim, 1.0 / (2.0 * p)) /
                               (std::pow(std::max(share(k), least), 1.0 / (2.0 * p + d)) * std::pow(sum, 1.0 / (2.0 * p))),
                           0.25, 1.5);
  const double growth = factor.array().pow(-3.0).mean();
  double scale = 1.0;
  if (growth * dofs > kMostDofs) {
    if (1.5 * dofs > kMostDofs)
      throw std::runtime_error(fmt::format(
          "{}; a mesh that may reach it would have about {:.2g} dofs, more than the {:.2g} that are tried: ask for "
          "less, for compliance separately (modes.compliance_accuracy), or choose mesh.size yourself",
          describe(j), growth * dofs, kMostDofs));
    scale = std::cbrt(growth * dofs / kMostDofs);
  }
  Index cell = 0;
  for (const mesh::CellBlock& block : mesh.solids) {
    const mesh::CellShape& shape = mesh::shape_of(block.type);
    for (Index row = 0; row < block.nodes.rows(); ++row, ++cell) {
      double length = 0.0;
      for (const auto& edge : shape.edges)
        length += (mesh.points.row(block.nodes(row, edge[0])) - mesh.points.row(block.nodes(row, edge[1]))).norm();
      const double size = std::log(scale * factor(cell) * length / static_cast<double>(shape.edges.size()));
      for (int a = 0; a < shape.corners; ++a) {
        nodes_size[static_cast<std::size_t>(block.nodes(row, a))] += size;
        ++nodes_cells[static_cast<std::size_t>(block.nodes(row, a))];
      }
    }
  }
  for (std::size_t node = 0; node < nodes_size.size(); ++node)
    if (nodes_cells[node] > 0) nodes_size[node] = std::exp(nodes_size[node] / nodes_cells[node]);
  // From node to node sizes grow by no more than a part of the way.
  constexpr double kGrowth = 0.5;
  for (int sweep = 0; sweep < 3; ++sweep)
    for (const mesh::CellBlock& block : mesh.solids)
      for (Index row = 0; row < block.nodes.rows(); ++row)
        for (const auto& edge : mesh::shape_of(block.type).edges) {
          const auto a = static_cast<std::size_t>(block.nodes(row, edge[0])),
                     b = static_cast<std::size_t>(block.nodes(row, edge[1]));
          const double way = kGrowth * (mesh.points.row(block.nodes(row, edge[0])) -
                                        mesh.points.row(block.nodes(row, edge[1])))
                                           .norm();
          nodes_size[a] = std::min(nodes_size[a], nodes_size[b] + way);
          nodes_size[b] = std::min(nodes_size[b], nodes_size[a] + way);
        }
  std::vector<double> out;
  for (mesh::Index node = 0; node < mesh.n_nodes(); ++node) {
    if (nodes_cells[static_cast<std::size_t>(node)] == 0) continue;
    for (int a = 0; a < 3; ++a) out.push_back(mesh.points(node, a));
    out.push_back(nodes_size[static_cast<std::size_t>(node)]);
  }
  return out;
}

std::string AccuracyGoal::describe(const Judgement& j) const {
  std::string text = fmt::format("frequencies: {} asked, the mesh leaves {} and the dropped modes {} by their estimates",
                                 percent(frequencies_), percent(j.frequencies), percent(j.modes));
  if (!j.interface.empty())
    text += fmt::format("; static compliance: {} asked, the mesh leaves {} (interface {})", percent(compliance_),
                        percent(j.compliance), j.interface);
  return text;
}

}  // namespace flexura::reduce
