// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/superelement/to_superelement.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "reduce/estimate/cell_data.hpp"
#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {

namespace {

// Values of cells at the nodes of the surface, the mean over those that have the node.
Eigen::VectorXf at_vertices(const Part& part, const Eigen::VectorXd& of_cells,
                            const std::vector<mesh::Index>& nodes) {
  std::vector<double> sum(static_cast<std::size_t>(part.mesh.n_nodes()), 0.0), count = sum;
  Eigen::Index cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row, ++cell)
      for (const mesh::Index node : block.nodes.row(row)) {
        sum[static_cast<std::size_t>(node)] += of_cells(cell);
        count[static_cast<std::size_t>(node)] += 1.0;
      }
  Eigen::VectorXf out(static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t v = 0; v < nodes.size(); ++v) {
    const auto node = static_cast<std::size_t>(nodes[v]);
    out(static_cast<Eigen::Index>(v)) = static_cast<float>(count[node] > 0.0 ? sum[node] / count[node] : 0.0);
  }
  return out;
}

// Of each cell the greatest error of stress of a state over the root mean square of its stress, both by energy per volume.
Eigen::VectorXd stress_error_of_cells(const Part& part, const Eigen::MatrixXf& share) {
  Eigen::VectorXd volume(share.rows());
  Eigen::Index cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const TabulatedRule& rule = solid_element(block.type).mass;
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row, ++cell) {
      const NodePositions x = positions(part.mesh, block, row);
      volume(cell) = 0.0;
      for (const TabulatedRule::Point& point : rule.points) {
        const double det = (point.dN.transpose() * x).determinant();
        volume(cell) += point.weight * std::max(det, 0.0);
      }
    }
  }
  const double whole = volume.sum();
  Eigen::VectorXd out = share.rowwise().maxCoeff().cast<double>();
  for (Eigen::Index k = 0; k < out.size(); ++k)
    out(k) = volume(k) > 0.0 ? std::sqrt(std::max(out(k), 0.0) * whole / volume(k)) : 0.0;
  return out;
}

}  // namespace

superelement::MeshError to_mesh_error(const MeshShare& share, const Part& part,
                                      const std::vector<mesh::Index>& nodes) {
  superelement::MeshError out{.rough = share.rough};
  const auto relative = [](double error) { return std::min(error, 1.0); };
  const auto stress = [&](const MeshShare::Stress& from) {
    superelement::MeshError::Stress to{.mean = relative(from.mean), .singular = from.peak.singular};
    const auto at = std::lower_bound(nodes.begin(), nodes.end(), from.peak.node);
    if (from.peak.node < 0 || at == nodes.end() || *at != from.peak.node) return to;
    to.vertex = static_cast<int>(at - nodes.begin());
    if (from.peak.error >= 0.0) to.peak = relative(from.peak.error);
    return to;
  };
  for (const MeshShare::Mode& mode : share.modes)
    out.modes.push_back({.frequency_hz = frequency_hz(mode.omega2),
                         .error = relative(mode.error),
                         .stress = stress(mode.stress)});
  for (const MeshShare::Interface& from : share.interfaces)
    out.interfaces.push_back(
        {.name = from.name, .compliance_error = relative(from.error), .stress = stress(from.stress)});
  if (share.by_cell.rows() == part.mesh.n_solid_cells() && share.by_cell.cols() > 0)
    out.at_vertices = at_vertices(part, stress_error_of_cells(part, share.by_cell), nodes);
  return out;
}

superelement::NodalMotions to_nodal_motions(const NodeMotions& motions, const mesh::Mesh& mesh,
                                            bool double_precision) {
  superelement::NodalMotions out{.T = motions.T, .double_precision = double_precision};
  const bool labelled = !mesh.node_label.empty() && *std::ranges::max_element(mesh.node_label) <=
                                                        std::numeric_limits<std::int32_t>::max();
  out.positions.resize(static_cast<Eigen::Index>(motions.nodes.size()), 3);
  for (std::size_t k = 0; k < motions.nodes.size(); ++k) {
    const auto node = static_cast<std::size_t>(motions.nodes[k]);
    out.numbers.push_back(
        static_cast<std::int32_t>(labelled ? mesh.node_label[node] : static_cast<std::int64_t>(node) + 1));
    out.rotations.push_back(static_cast<superelement::NodalMotions::Rotation>(motions.rotations[k]));
    out.positions.row(static_cast<Eigen::Index>(k)) = mesh.points.row(motions.nodes[k]);
  }
  return out;
}

superelement::Superelement to_superelement(const ReductionRequest& input, Reduction&& reduction,
                                           superelement::Surface&& surface, std::string report_json,
                                           std::vector<std::int32_t> stress_vertices) {
  superelement::Superelement se;
  se.name = input.name;
  se.created_by = "flexura-reduce " FLEXURA_VERSION;
  se.source = input.source;
  se.report_json = std::move(report_json);
  for (const ReducedInterface& from : reduction.interfaces) {
    if (from.directions.empty() && from.following.empty()) continue;  // a rigid piece of the part
    superelement::Interface to{.name = from.name, .tie = name_of(from.tie), .p_BoN_B = from.point};
    for (const int d : from.directions) to.directions.push_back(static_cast<superelement::Direction>(d));
    to.first_dof = from.first_dof;
    for (const int d : from.following) to.following.push_back(static_cast<superelement::Direction>(d));
    to.follow = from.follow;
    for (const int d : from.free) to.free.push_back(static_cast<superelement::Direction>(d));
    to.free_motion = from.free_motion;
    se.interfaces.push_back(std::move(to));
  }
  se.n_b = reduction.n_b;
  se.n_q = reduction.n_q;
  se.K_se = std::move(reduction.K_se);
  se.M_se = std::move(reduction.M_se);
  se.omega2 = std::move(reduction.omega2);
  se.D_se = std::move(reduction.D_se);
  for (ReducedLoad& load : reduction.loads)
    se.load_cases.push_back({load.name, std::move(load.p_se), std::move(load.moment), load.is_preload});
  se.modal_damping = input.modes.damping;
  se.inertia.mass = reduction.inertia.mass;
  se.inertia.S_x = reduction.inertia.S_x;
  se.inertia.S_xx = reduction.inertia.S_xx;
  se.inertia.S_phi = std::move(reduction.inertia.S_phi);
  se.inertia.S_xphi = std::move(reduction.inertia.S_xphi);
  se.inertia.S_phiphi = std::move(reduction.inertia.S_phiphi);
  if (reduction.stiffening) {
    StiffeningTerms& terms = *reduction.stiffening;
    se.stiffening = superelement::StiffeningTerms{.K0t = std::move(terms.K0t),
                                                  .K0r = std::move(terms.K0r),
                                                  .K0omega = std::move(terms.K0omega),
                                                  .K0F = std::move(terms.K0F),
                                                  .K0p = std::move(terms.K0p)};
  }
  if (!stress_vertices.empty())
    se.stress = superelement::StressModes{.vertices = std::move(stress_vertices),
                                          .S = std::move(reduction.stress_modes),
                                          .double_precision = input.recovery.double_precision,
                                          .of_loads = std::move(reduction.stress_of_loads),
                                          .of_acceleration = std::move(reduction.stress_of_acceleration)};
  se.surface = std::move(surface);
  se.shapes = std::move(reduction.shapes);
  return se;
}

void add_compliance(const Part& part, const std::vector<mesh::Index>& nodes,
                    superelement::StressModes& stress) {
  std::map<int, std::int32_t> numbers;
  for (const auto& [material, cells] : nodal_materials(part, nodes)) {
    if (material < 0) throw std::logic_error("stresses are wanted at a node of no solid");
    const auto [found, is_new] = numbers.emplace(material, static_cast<std::int32_t>(numbers.size()));
    if (is_new) stress.compliance.push_back(part.materials[static_cast<std::size_t>(material)].D.inverse());
    stress.material.push_back(found->second);
  }
}

}  // namespace flexura::reduce
