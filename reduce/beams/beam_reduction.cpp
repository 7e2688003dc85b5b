// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/beam_reduction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/rigid_projection.hpp"
#include "reduce/beams/beam_stiffening.hpp"
#include "reduce/beams/interior_shapes.hpp"
#include "reduce/cms/errors/mode_choice.hpp"
#include "reduce/cms/shapes/free_directions.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/factor/cholesky.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The rigid motions (about Bo) of the boundary and of the interior dofs; coordinates of attached solids' own
// deformation have no part in them.
struct RigidMotions {
  MatrixXd R_b, R_i;              // n_b x 6, n_i x 6
  std::vector<char> is_rotation;  // of the boundary dofs
};

RigidMotions rigid_motions(const beam::BeamMesh& mesh, const Numbering& numbering) {
  RigidMotions out{MatrixXd::Zero(numbering.n_b, 6), MatrixXd::Zero(numbering.n_i, 6),
                   std::vector<char>(numbering.n_b, 0)};
  for (int dof = 0; dof < mesh.n_dofs(); ++dof) {
    const int code = numbering.code[dof];
    if (code == Numbering::kUnused) continue;
    const int k = dof % 6;
    if (code < 0) out.is_rotation[-code - 1] = k >= 3;
    (code < 0 ? out.R_b.row(-code - 1) : out.R_i.row(code)) = node_motion_at(mesh.points()[dof / 6]).row(k);
  }
  return out;
}

}  // namespace

std::optional<BeamInterface> body_interface(const Structure& structure,
                                            const std::vector<BeamInterface>& interfaces) {
  const std::vector<beam::Node>& nodes = structure.mesh().model().nodes;
  std::vector<std::array<char, 6>> taken(nodes.size());
  std::string name = "body";
  MatrixXd H(0, 6);
  for (const BeamInterface& interface : interfaces) {
    if (interface.node < 0 || interface.node >= static_cast<int>(nodes.size())) return {};
    for (const int d : interface.directions) taken[interface.node][d] = 1;
    if (interface.name == name) name = "whole_body";
    H.conservativeResize(H.rows() + static_cast<Index>(interface.directions.size()), 6);
    H.bottomRows(static_cast<Index>(interface.directions.size())) =
        node_motion_at(structure.mesh().points()[interface.node])(interface.directions, Eigen::all);
  }
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low, middle = Eigen::Vector3d::Zero();
  int n_used = 0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (!structure.used()[6 * k]) continue;
    const Eigen::Vector3d& x = structure.mesh().points()[k];
    low = low.cwiseMin(x), high = high.cwiseMax(x);
    middle += x;
    ++n_used;
  }
  if (n_used == 0) return {};
  middle /= n_used;
  const double length = high != low ? 0.5 * (high - low).norm() : 1.0;
  if (H.rows() > 0 && free_motions(H, 0.5 * (low + high), length).cols() == 0) return {};
  // A node that is no interface; else one that has directions left.
  int best = -1;
  const auto kept = [&](int node) { return std::accumulate(taken[node].begin(), taken[node].end(), 0); };
  const auto away = [&](int node) {
    return std::pair(kept(node) > 0, (structure.mesh().points()[node] - middle).norm());
  };
  for (int k = 0; k < static_cast<int>(nodes.size()); ++k)
    if (kept(k) < 6 && structure.used()[6 * k] && (best < 0 || away(k) < away(best))) best = k;
  if (best < 0) return {};
  BeamInterface body{name, best, {}};
  for (int d = 0; d < 6; ++d)
    if (!taken[best][d]) body.directions.push_back(d);
  return body;
}

BeamReduction reduce_beams(const Structure& structure, const std::vector<BeamInterface>& interfaces,
                           const ReductionOptions& options, const std::vector<LoadCase>& cases) {
  const beam::BeamMesh& mesh = structure.mesh();
  BeamReduction result;
  Reduction& reduction = result.reduction;
  ReductionReport& report = reduction.report;
  linalg::Stopwatch watch;
  linalg::report(options.progress, "assembly", 0.0);
  const Numbering numbering(structure, interfaces);
  const int n_i = numbering.n_i, n_b = numbering.n_b;
  const auto stiffness = std::make_shared<const SplitMatrix>(structure.stiffness(), numbering);
  const SplitMatrix& K = *stiffness;
  const SplitMatrix M(structure.mass(), numbering);
  report.seconds_assembly = watch.lap();
  linalg::report(options.progress, "factorisation", 0.0);

  const auto factored = std::make_shared<const linalg::CholeskyFactor>(factorise(structure, numbering, K));
  const linalg::CholeskyFactor& factor = *factored;
  report.factor = factor.figures();
  watch.lap();

  linalg::report(options.progress, "constraint modes", 0.0);
  MatrixXd Psi = solve_refined(factor, *K.ii, -K.ib);
  MatrixXd K_Psi;
  K.ii->multiply(Psi, K_Psi);
  report.constraint_residual = K.ib.norm() > 0.0 ? (K_Psi + K.ib).norm() / K.ib.norm() : 0.0;
  const RigidMotions rigid = rigid_motions(mesh, numbering);
  const RigidProjection projection(rigid.R_b, rigid.is_rotation);
  report.rigid_error = projection.error(Psi, rigid.R_i);
  Psi = projection.corrected(Psi, rigid.R_i);
  MatrixXd K_bb;
  report.seconds_constraint_modes = watch.lap();

  const BeamInterior interior{structure, interfaces, numbering, factor, K, M, Psi, rigid.R_b, rigid.R_i};
  linalg::EigenPairs pairs = interior_shapes(interior, options, cases, report);
  if (!Psi.allFinite() || !pairs.Phi.allFinite())
    throw std::runtime_error("the modes of the beam part hold a number that is not finite");
  report.mode_residual = pairs.residual;
  report.solved_right_hand_sides = pairs.n_solves;
  report.seconds_normal_modes = watch.lap();

  linalg::report(options.progress, "projection", 0.0);
  const Index n_q = pairs.Phi.cols(), n = n_b + n_q;
  MatrixXd& T = result.T;
  MatrixXd boundary = MatrixXd::Zero(n_b, n), inside(n_i, n);
  boundary.leftCols(n_b).setIdentity();
  inside << Psi, pairs.Phi;
  T = interior.on_all_dofs(boundary, inside);
  {
    // Stiffness from the elements' stretch: rigid motions stay free of strain and eigenvalues keep their
    // digits however fine the mesh (strain_energy).  The coupling of Psi and Phi is zero in exact arithmetic.
    const MatrixXd energy = structure.strain_energy(T);
    K_bb = energy.topLeftCorner(n_b, n_b);
    pairs.omega2 = energy.diagonal().tail(n_q);
    if (n_b <= 6) K_bb.setZero();  // held, and not more than held: every motion of the interface is rigid
  }
  {
    const beam::InertiaSums sums = structure.inertia();
    InertiaIntegrals& inertia = reduction.inertia;
    inertia.mass = sums.mass;
    inertia.S_x = sums.S_x;
    inertia.S_xx = sums.S_xx;
    inertia.S_phi = sums.S_u * T;
    inertia.S_xphi = sums.S_xu * T;
    for (int k = 0; k < 6; ++k) {
      const MatrixXd S_T = sums.S_uu[k] * T;
      inertia.S_phiphi[k] = linalg::transpose_times(T, S_T);
      if (k < 3) inertia.S_phiphi[k] = (0.5 * (inertia.S_phiphi[k] + inertia.S_phiphi[k].transpose())).eval();
    }
  }
  reduction.M_se =
      reduction.inertia.S_phiphi[0] + reduction.inertia.S_phiphi[1] + reduction.inertia.S_phiphi[2];
  reduction.K_se = MatrixXd::Zero(n, n);
  reduction.K_se.topLeftCorner(n_b, n_b) = K_bb;
  reduction.K_se.diagonal().tail(n_q) = pairs.omega2;
  reduction.omega2 = pairs.omega2;
  reduction.n_b = n_b;
  reduction.n_q = static_cast<int>(n_q);
  int first = 0;
  for (const BeamInterface& interface : interfaces) {
    ReducedInterface& out = reduction.interfaces.emplace_back(ReducedInterface{
        interface.name, Tie::node, mesh.points()[interface.node], interface.directions, first});
    first += static_cast<int>(interface.directions.size());
    set_free_motion(out, T.middleRows<6>(6 * interface.node), rigid.R_b);
  }

  reduction.D_se = structure.damping(T);
  reduction.shapes = structure.shapes(T);
  report.rigid_strain = n_b > 6 ? (K_bb * rigid.R_b).norm() / (K_bb.norm() * rigid.R_b.norm()) : 0.0;
  report.seconds_projection = watch.lap();

  if (options.stiffening) {
    reduction.stiffening = beam_stiffening_terms(structure, interfaces, T, cases);
    report.seconds_stiffening = watch.lap();
  }
  if (options.estimate_error && n_i > 0 && options.set != ModeSet::craig_chang) {
    MatrixXd M_Psi;
    M.ii->multiply(Psi, M_Psi);
    const MatrixXd Mhat = M.ib + M_Psi;
    const MatrixXd participation = linalg::transpose_times(pairs.Phi, Mhat);
    const MatrixXd answer = factor.solve(Mhat);
    MatrixXd M_answer;
    M.ii->multiply(answer, M_answer);
    InteriorDynamics whole;
    whole.compliance = linalg::transpose_times(Mhat, answer);
    whole.growth = linalg::transpose_times(answer, M_answer);
    DroppedModes dropped = dropped_modes(whole, participation, pairs.omega2);
    reduction.dropped = std::move(dropped.share);
    reduction.dropped_growth = std::move(dropped.growth);
    reduction.omega2_dropped = n_q == 0 ? 0.0
                               : std::isfinite(pairs.omega2_next) && pairs.omega2_next > 0.0
                                   ? pairs.omega2_next
                                   : pairs.omega2(n_q - 1);
    report.seconds_estimate = watch.lap();
  }
  result.left_out = [stiffness, factored, numbering, Phi = pairs.Phi, omega2 = pairs.omega2,
                     n_dofs = structure.n_dofs()](const MatrixXd& P) {
    MatrixXd out = MatrixXd::Zero(n_dofs, P.cols());
    if (numbering.n_i == 0 || P.cols() == 0) return out;
    const MatrixXd P_i = P(numbering.dof_of, Eigen::all);
    MatrixXd X = solve_refined(*factored, *stiffness->ii, P_i);
    if (Phi.cols() > 0) X -= Phi * (omega2.cwiseInverse().asDiagonal() * linalg::transpose_times(Phi, P_i));
    out(numbering.dof_of, Eigen::all) = X;
    return out;
  };
  report.n_nodes = mesh.n_dofs() / 6;
  report.n_cells = static_cast<int>(mesh.elements().size());
  for (const AttachedSolid& solid : structure.solids()) {
    report.n_nodes += solid.reduction.report.n_nodes;
    report.n_cells += solid.reduction.report.n_cells;
  }
  report.n_i = n_i;
  report.n_b = n_b;
  report.n_q = static_cast<int>(n_q);
  report.peak_memory_bytes = linalg::peak_memory();
  linalg::report(options.progress, "projection", 1.0);
  return result;
}

}  // namespace flexura::reduce
