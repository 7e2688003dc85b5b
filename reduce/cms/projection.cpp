// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/projection.hpp"

#include <algorithm>
#include <utility>

#include "reduce/assembly/input/average.hpp"
#include "reduce/cms/dampers.hpp"
#include "reduce/cms/shapes/free_directions.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/recovery/part_near.hpp"
#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// Each rank's are those of its elements.
void sum_up(const TiedModel& model, InertiaIntegrals& s) {
  if (!model.share()) return;
  Eigen::MatrixXd small(1, 13);
  small << s.mass, s.S_x.transpose(), s.S_xx.reshaped().transpose();
  small = model.sum(std::move(small));
  s.mass = small(0);
  s.S_x = small.middleCols<3>(1).transpose();
  s.S_xx = small.rightCols<9>().reshaped(3, 3);
  s.S_phi = model.sum(s.S_phi);
  s.S_xphi = model.sum(s.S_xphi);
  for (MatrixXd& S : s.S_phiphi) S = model.sum(std::move(S));
}

// (u, theta) of an interface's node by the shapes: 6 x n on rank 0.  Where its own dofs are not at hand, from its nodes' displacements.
MatrixXd motion_by_shapes(const Part& whole, const TiedModel& model, const Basis& basis, const MatrixXd& T,
                          int k) {
  const Index n = T.cols(), n_b = model.n_b(), n_phi = basis.Phi.cols(),
              n_dofs = model.share() ? 0 : n_b + n_phi;
  MatrixXd motion(6, n);
  if (n_dofs > 0) {
    motion.leftCols(n_b) = model.motions().interface_motion(k, basis.U_b, MatrixXd::Identity(n_b, n_b));
    motion.middleCols(n_b, n_phi) =
        model.motions().interface_motion(k, basis.Phi, MatrixXd::Zero(n_b, n_phi));
  }
  if (n_dofs == n) return motion;
  const InterfaceSpec& spec = whole.interfaces[static_cast<std::size_t>(k)];
  const MatrixXd at_nodes = model.at_nodes(T.rightCols(n - n_dofs), spec.set.nodes);
  if (model.leads()) motion.rightCols(n - n_dofs) = averaging_map(whole.mesh, spec) * at_nodes;
  return motion;
}

}  // namespace

MatrixXd shapes_on_nodes(const TiedModel& model, const Basis& basis, const InterfaceModes& faces) {
  const Index n_b = model.n_b(), n_phi = basis.Phi.cols(), n_w = faces.omega2.size();
  MatrixXd T(3 * static_cast<Index>(model.n_nodes()), n_b + n_phi + n_w), U;
  model.expand(basis.U_b, MatrixXd::Identity(n_b, n_b), U);
  T.leftCols(n_b) = U;
  for (Index q = 0; q < n_phi; q += 16) {
    const Index width = std::min<Index>(16, n_phi - q);
    model.expand(basis.Phi.middleCols(q, width), MatrixXd::Zero(n_b, width), U);
    T.middleCols(n_b + q, width) = U;
  }
  if (n_w > 0) T.rightCols(n_w) = faces.U;
  return T;
}

void project(const Part& whole, const Part& part, const TiedModel& model, const Basis& basis,
             const InterfaceModes& faces, const MatrixXd& T, const ReductionOptions& options,
             Reduction& reduction) {
  const Index n_b = model.n_b(), n_phi = basis.Phi.cols(), n_w = faces.omega2.size(), n = T.cols();
  reduction.inertia = inertia_integrals(model.m(), model.numbering().points(), T);
  sum_up(model, reduction.inertia);
  const auto& S = reduction.inertia.S_phiphi;
  reduction.M_se = S[0] + S[1] + S[2];
  reduction.K_se = MatrixXd::Zero(n, n);
  reduction.K_se.topLeftCorner(n_b, n_b) = basis.K_bb;
  reduction.K_se.diagonal().segment(n_b, n_phi) = basis.omega2;
  if (n_w > 0) {
    reduction.K_se.topRightCorner(n_b, n_w) = faces.K_bw;
    reduction.K_se.bottomLeftCorner(n_w, n_b) = faces.K_bw.transpose();
    reduction.K_se.bottomRightCorner(n_w, n_w) = faces.K_ww;
  }
  reduction.omega2 = basis.omega2;
  reduction.n_b = static_cast<int>(n_b);
  reduction.n_q = static_cast<int>(n_phi + n_w);
  for (int k = 0; k < model.n_interfaces(); ++k) {
    reduction.interfaces.push_back({part.interfaces[k].name, whole.interfaces[k].tie,
                                    model.numbering().point(k), model.numbering().directions(k),
                                    model.numbering().first_dof(k)});
    if (model.numbering().directions(k).size() == 6) continue;
    const MatrixXd motion = motion_by_shapes(whole, model, basis, T, k);
    if (model.leads())
      set_free_motion(reduction.interfaces.back(), motion, rigid_boundary(model.numbering()));
  }
  reduction.shapes.resize(model.leads() ? 3 * static_cast<Index>(options.shape_nodes.size()) : 0, n);
  constexpr Index kColumns = 32;
  for (Index first = 0; first < n; first += kColumns) {
    const Index width = std::min(kColumns, n - first);
    const MatrixXd at_nodes = model.at_nodes(T.middleCols(first, width), options.shape_nodes);
    if (model.leads()) reduction.shapes.middleCols(first, width) = at_nodes.cast<float>();
  }
}

void project_loads(const TiedModel& model, const MatrixXd& T, const ReductionOptions& options,
                   Reduction& reduction) {
  for (const LoadField& load : options.loads) {
    ReducedLoad reduced = reduced_load(load, T, model.m());
    reduced.p_se = model.sum(reduced.p_se);
    reduced.moment = model.sum(reduced.moment);
    reduction.loads.push_back(std::move(reduced));
  }
}

namespace {

// True where there are rotations beside the displacements.
bool turns(const Part& part) {
  return !part.mesh.shells.empty() || !part.beam_stresses.empty();
}

// Each node's place among those that turn, or -1.
std::vector<int> rotation_places(const Part& part, const TiedModel& model) {
  std::vector<int> places;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node)
    places.push_back(model.numbering().rotation_of(node));
  return places;
}

// Of displacements U on all nodes, which in a part that turns are those of the dofs u_i and u_b.
MatrixXd stress_of(const Part& part, const TiedModel& model, const MatrixXd& u_i, const MatrixXd& u_b,
                   const MatrixXd& U, const ReductionOptions& options) {
  if (!turns(part)) return nodal_stress_modes(part, U, options.stress_nodes);
  return nodal_stress_modes(part, U, options.stress_nodes, model.motions().expand_rotations(u_i, u_b),
                            rotation_places(part, model));
}

// 3 n_rotations x n; empty without rotations, with which there are no interface modes and no team.
MatrixXd rotations_of_shapes(const TiedModel& model, const Basis& basis) {
  if (model.numbering().n_rotations() == 0) return {};
  const Index n = model.n_b() + basis.Phi.cols();
  MatrixXd boundary = MatrixXd::Zero(model.n_b(), n);
  boundary.leftCols(model.n_b()).setIdentity();
  MatrixXd interior(model.n_i(), n);
  interior << basis.U_b, basis.Phi;
  return model.motions().expand_rotations(interior, boundary);
}

}  // namespace

void project_damping(const Part& part, const TiedModel& model, const Basis& basis, const MatrixXd& T,
                     Reduction& reduction) {
  reduction.D_se = damping_matrix(part, model, T, rotations_of_shapes(model, basis), reduction);
}

NodeMotions all_node_motions(const Part& whole, const TiedModel& model, const Basis& basis,
                             const MatrixXd& T) {
  if (!model.share())
    return node_motions(whole, T, rotations_of_shapes(model, basis), rotation_places(whole, model));
  std::vector<mesh::Index> nodes;
  for (mesh::Index node = 0; model.leads() && node < whole.mesh.n_nodes(); ++node) nodes.push_back(node);
  const MatrixXd everywhere = model.at_nodes(T, nodes);
  return model.leads() ? node_motions(whole, everywhere) : NodeMotions{};
}

namespace {

// 12 n_bars x k: (u, theta) of both nodes of displacements U and the rotations of the nodes that turn.
MatrixXd at_bars(const Part& part, const TiedModel& model, const MatrixXd& U, const MatrixXd& rotations) {
  MatrixXd out = MatrixXd::Zero(12 * std::ssize(part.bars), U.cols());
  Index row = 0;
  for (const CutBar& bar : part.bars)
    for (const mesh::Index node : bar.nodes) {
      out.middleRows<3>(row) = U.middleRows<3>(3 * static_cast<Index>(node));
      if (const int turns = model.numbering().rotation_of(node); turns >= 0)
        out.middleRows<3>(row + 3) = rotations.middleRows<3>(3 * static_cast<Index>(turns));
      row += 6;
    }
  return out;
}

}  // namespace

BarMotions bar_motions(const Part& part, const TiedModel& model, const Basis& basis, const MatrixXd& T,
                       const MatrixXd& left_out) {
  BarMotions out{.nodes = at_bars(part, model, T, rotations_of_shapes(model, basis))};
  std::vector<Index> rows;
  for (const CutBar& bar : part.bars)
    for (const CutBar::Mass& mass : bar.masses)
      for (Index a = 0; a < 3; ++a) rows.push_back(3 * static_cast<Index>(mass.point) + a);
  out.points = T(rows, Eigen::all);
  if (left_out.cols() == 0) return out;
  const MatrixXd at_rest = MatrixXd::Zero(model.n_b(), left_out.cols());
  MatrixXd U;
  model.expand(left_out, at_rest, U);
  out.lacks = at_bars(part, model, U, model.motions().expand_rotations(left_out, at_rest));
  return out;
}

MatrixXd stress_modes(const Part& whole, const Part& part, const TiedModel& model, const Basis& basis,
                      const MatrixXd& T, const ReductionOptions& options) {
  if (model.share()) {
    // The rows of T that it takes come to rank 0.
    const PartNear near = model.leads() ? cells_at(whole, options.stress_nodes) : PartNear{};
    const MatrixXd T_near = model.at_nodes(T, near.nodes);
    return model.leads() ? nodal_stress_modes(near.part, T_near, near.wanted, {}, {}) : MatrixXd();
  }
  const Index n = T.cols(), n_b = model.n_b();
  MatrixXd shapes_i, shapes_b;
  if (turns(part)) {
    shapes_i.setZero(model.n_i(), n);
    shapes_b.setZero(n_b, n);
    shapes_i.leftCols(n_b) = basis.U_b;
    shapes_i.middleCols(n_b, basis.Phi.cols()) = basis.Phi;
    shapes_b.leftCols(n_b).setIdentity();
  }
  return stress_of(part, model, shapes_i, shapes_b, T, options);
}

MatrixXd stress_of_interior(const Part& part, const TiedModel& model, const MatrixXd& X,
                            const ReductionOptions& options) {
  const MatrixXd at_rest = MatrixXd::Zero(model.n_b(), X.cols());
  MatrixXd U;
  model.expand(X, at_rest, U);
  return stress_of(part, model, X, at_rest, U, options);
}

MatrixXd stress_of_preloads(const Part& part, const ReductionOptions& options) {
  MatrixXd out;
  for (std::size_t k = 0; k < options.loads.size(); ++k) {
    const CellStrains& strain = options.loads[k].strain;
    if (strain.rows() == 0) continue;
    if (out.size() == 0)
      out.setZero(6 * static_cast<Index>(options.stress_nodes.size()),
                  static_cast<Index>(options.loads.size()));
    out.col(static_cast<Index>(k)) = nodal_initial_stress(part, strain, options.stress_nodes);
  }
  return out;
}

}  // namespace flexura::reduce
