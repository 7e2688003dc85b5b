// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/craig_bampton.hpp"

#include <sys/resource.h>

#include <cmath>
#include <stdexcept>

#include "reduce/linalg/block_lanczos.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/krylov_schur.hpp"
#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Constraint modes and the static stiffness of the interface.
struct ConstraintModes {
  MatrixXd Psi;   // n_i x n_b
  MatrixXd K_bb;  // condensed
  double residual = 0.0;
};

ConstraintModes constraint_modes(const TiedModel& model, const TiedSolver& solver) {
  const auto& averaged = model.averaged_dofs();
  const Index n_a = static_cast<Index>(averaged.size());
  const MatrixXd K_ib = model.K_ib();
  MatrixXd g = MatrixXd::Zero(n_a, model.n_b());
  for (Index r = 0; r < n_a; ++r) g(r, averaged[r]) = 1.0;
  TiedSolver::Solution solution = solver.solve_refined(-K_ib, g);
  ConstraintModes modes{std::move(solution.U), model.K_bb(), 0.0};
  MatrixXd K_Psi;
  model.K_ii().multiply(modes.Psi, K_Psi);
  MatrixXd reaction = MatrixXd::Zero(model.n_i(), model.n_b());
  if (n_a > 0) reaction = model.A().transpose() * solution.mu;
  const double scale = K_ib.norm() + reaction.norm();
  if (scale > 0.0) modes.residual = (K_Psi + K_ib + reaction).norm() / scale;
  modes.K_bb += linalg::transpose_times(K_ib, modes.Psi);
  for (Index r = 0; r < n_a; ++r) modes.K_bb.row(averaged[r]) -= solution.mu.row(r);
  modes.K_bb = (0.5 * (modes.K_bb + modes.K_bb.transpose())).eval();
  return modes;
}

void require_finite(const MatrixXd& X, const char* what) {
  if (!X.allFinite()) throw std::runtime_error(std::string(what) + " hold a number that is not finite");
}

}  // namespace

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

linalg::EigenProblem fixed_interface_problem(const TiedModel& model, const TiedSolver& solver) {
  linalg::EigenProblem problem;
  problem.n = model.n_i();
  problem.n_free = model.n_i() - static_cast<int>(model.A().rows());
  problem.solve = [&solver](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = solver.solve(X); };
  problem.multiply_K = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.K_ii().multiply(X, Y);
  };
  problem.multiply_M = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.multiply_M_ii(X, Y);
  };
  problem.project_residual = [&solver](MatrixXd& R) { solver.remove_reactions(R); };
  return problem;
}

Reduction craig_bampton(const Part& part, const ReductionOptions& options) {
  Reduction reduction;
  ReductionReport& report = reduction.report;
  linalg::Stopwatch watch;
  AssemblyOptions assembly;
  assembly.progress = options.progress;
  const TiedModel model(part, assembly);
  report.seconds_assembly = watch.lap();
  const TiedSolver solver(model, options.progress);
  watch.lap();
  const linalg::FactorFigures& factor = solver.figures();
  report.seconds_ordering = factor.seconds_ordering;
  report.seconds_symbolic = factor.seconds_symbolic;
  report.seconds_factor = factor.seconds_numeric;
  report.factor_nonzeros = factor.nonzeros;
  report.factor_flops = factor.flops;
  report.smallest_pivot = factor.smallest_pivot;

  linalg::report(options.progress, "constraint modes", 0.0);
  const ConstraintModes constraint = constraint_modes(model, solver);
  require_finite(constraint.Psi, "the constraint modes");
  report.constraint_residual = constraint.residual;
  report.seconds_constraint_modes = watch.lap();
  linalg::report(options.progress, "constraint modes", 1.0);

  const linalg::EigenProblem problem = fixed_interface_problem(model, solver);
  linalg::EigenPairs pairs;
  pairs.Phi.resize(model.n_i(), 0);
  if (options.n_modes > 0 || options.omega_max > 0.0) {
    const linalg::EigenRequest request{options.n_modes, options.omega_max * options.omega_max,
                                       options.tolerance};
    pairs = options.eigensolver == Eigensolver::krylov_schur
                ? linalg::krylov_schur(problem, request, options.progress)
                : linalg::block_lanczos(problem, request, options.progress);
  }
  require_finite(pairs.Phi, "the normal modes");
  report.mode_residual = pairs.residual;
  report.solved_right_hand_sides = pairs.n_solves;
  report.seconds_normal_modes = watch.lap();

  // T on all nodes, n_nodes * 3 * n: the one dense array of that size.
  linalg::report(options.progress, "projection", 0.0);
  const Index n_b = model.n_b(), n_q = pairs.Phi.cols(), n = n_b + n_q;
  MatrixXd T(3 * static_cast<Index>(model.n_nodes()), n);
  {
    MatrixXd U;
    model.expand(constraint.Psi, MatrixXd::Identity(n_b, n_b), U);
    T.leftCols(n_b) = U;
    for (Index q = 0; q < n_q; q += 16) {
      const Index width = std::min<Index>(16, n_q - q);
      model.expand(pairs.Phi.middleCols(q, width), MatrixXd::Zero(n_b, width), U);
      T.middleCols(n_b + q, width) = U;
    }
  }
  reduction.inertia = inertia_integrals(model.m(), part.mesh.points, T);
  const auto& S = reduction.inertia.S_phiphi;
  reduction.M_se = S[0] + S[1] + S[2];
  reduction.K_se = MatrixXd::Zero(n, n);
  reduction.K_se.topLeftCorner(n_b, n_b) = constraint.K_bb;
  reduction.K_se.diagonal().tail(n_q) = pairs.omega2;
  reduction.omega2 = pairs.omega2;
  reduction.n_b = static_cast<int>(n_b);
  reduction.n_q = static_cast<int>(n_q);
  for (int k = 0; k < model.n_interfaces(); ++k)
    reduction.interfaces.push_back({part.interfaces[k].name, part.interfaces[k].tie, model.point(k),
                                    model.directions(k), model.first_dof(k)});
  reduction.shapes.resize(3 * static_cast<Index>(options.shape_nodes.size()), n);
  for (std::size_t v = 0; v < options.shape_nodes.size(); ++v)
    reduction.shapes.middleRows<3>(3 * static_cast<Index>(v)) =
        T.middleRows<3>(3 * static_cast<Index>(options.shape_nodes[v])).cast<float>();
  const MatrixXd R = model.rigid_b();
  report.rigid_strain = (constraint.K_bb * R).norm() / (constraint.K_bb.norm() * R.norm());
  report.seconds_projection = watch.lap();
  linalg::report(options.progress, "projection", 1.0);

  if (options.estimate_error) {
    // Mhat = M_ib + M_ii Psi on the interior; F_rs = K_ii^-1 - Phi Omega^-2 Phi^T.
    MatrixXd M_T, Mhat, boundary;
    model.m().multiply_kron3(T.leftCols(n_b), M_T);
    model.gather(M_T, Mhat, boundary);
    const MatrixXd participation = linalg::transpose_times(pairs.Phi, Mhat);  // n_q x n_b
    reduction.dropped = linalg::transpose_times(Mhat, solver.solve(Mhat));
    if (n_q > 0)
      reduction.dropped -=
          participation.transpose() * pairs.omega2.cwiseInverse().asDiagonal() * participation;
    reduction.dropped = (0.5 * (reduction.dropped + reduction.dropped.transpose())).eval();
    reduction.omega2_dropped = pairs.omega2_next;
    report.seconds_estimate = watch.lap();
  }
  if (options.stiffening) {
    reduction.stiffening =
        stiffening_terms(part, solver, constraint.Psi, constraint.K_bb, T, options.progress);
    report.seconds_stiffening = watch.lap();
  }
  if (!options.stress_nodes.empty()) {
    reduction.stress_modes = nodal_stress_modes(part, T, options.stress_nodes);
    report.seconds_stress = watch.lap();
  }
  report.n_nodes = model.n_nodes();
  for (const mesh::CellBlock& block : part.mesh.solids)
    report.n_cells += static_cast<int>(block.nodes.rows());
  report.n_i = model.n_i();
  report.n_b = reduction.n_b;
  report.n_q = reduction.n_q;
  report.peak_memory_bytes = peak_memory();
  return reduction;
}

}  // namespace flexura::reduce
