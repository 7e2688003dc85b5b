// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/craig_chang.hpp"

#include <Eigen/Cholesky>
#include <stdexcept>

#include "reduce/cms/shapes/fixed_interface.hpp"
#include "reduce/cms/shapes/full_model.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

HeldAnswers held_answers(const TiedModel& model, const TiedSolver& solver, const linalg::Progress& progress) {
  HeldAnswers out;
  const linalg::EigenProblem problem = fixed_interface_problem(model, solver);
  if (problem.n_free == 0)
    throw std::invalid_argument(
        "modes.set = \"craig_chang\": all dofs of the part are its interfaces', so that there is nothing to "
        "reduce; take "
        "\"craig_bampton\", which is exact there");
  out.omega2_first = linalg::block_lanczos(problem, {1, 0.0, 1e-6}, progress).omega2(0);
  out.R = model.motions().rigid_nodes();
  model.m().multiply_kron3(out.R, out.M_R);
  model.gather(out.M_R, out.g_i, out.g_b);
  out.answer = solver.solve(out.g_i);
  return out;
}

CraigChangSpan craig_chang_span(const Part& part, const TiedModel& model, const HeldAnswers& held,
                                const MatrixXd& Psi, const MatrixXd& K_bb, const ReductionOptions& options) {
  const Index n_b = model.n_b(), n_rows = model.n_rows();
  // The free body's shift: the first fixed-interface eigenvalue has the right size.
  const FreeModes free = free_modes_on_nodes(part,
                                             {options.n_modes > 0 ? options.n_modes + 6 : 0,
                                              options.omega_max * options.omega_max, options.tolerance},
                                             held.omega2_first, options.progress, model.share());
  // The six rigid modes are known exactly; the computed ones are left out.
  const Index n_free = std::max<Index>(free.U.cols() - 6, 0), m = 6 + n_free + n_b;

  CraigChangSpan span;
  span.first_attachment = static_cast<int>(6 + n_free);
  span.residual = free.pairs.residual.tail(n_free);
  span.round_off = free.pairs.round_off.tail(n_free);
  span.W.setZero(n_rows, m);
  span.C_b.setZero(n_b, m);
  const MatrixXd R_b = model.motions().rigid_b();
  span.C_b.leftCols(6) = R_b;
  if (n_free > 0) {
    std::vector<MatrixXd> motion;
    for (int k = 0; k < model.n_interfaces(); ++k) {
      motion.push_back(free.motion[k].rightCols(n_free));
      for (std::size_t d = 0; d < model.numbering().directions(k).size(); ++d)
        span.C_b.block(model.numbering().first_dof(k) + static_cast<Index>(d), 6, 1, n_free) =
            motion.back().row(model.numbering().directions(k)[d]);
    }
    span.W.middleCols(6, n_free) = model.own_rows(model.motions().interior_part(
                                       free.U.rightCols(n_free), free.rotations.rightCols(n_free), motion)) -
                                   linalg::times(Psi, span.C_b.middleCols(6, n_free));
  }

  // Unit loads on the interface, balanced by the inertia forces M R c.
  const MatrixXd c = model.inner(held.R, held.M_R).ldlt().solve(R_b.transpose());  // 6 x n_b
  const MatrixXd p = MatrixXd::Identity(n_b, n_b) - (held.g_b + model.inner(Psi, held.g_i)) * c;
  // p is in equilibrium, so springs on the rigid motions carry nothing.
  const MatrixXd sprung = K_bb + K_bb.norm() / R_b.squaredNorm() * R_b * R_b.transpose();
  span.C_b.rightCols(n_b) = sprung.ldlt().solve(p);
  span.W.rightCols(n_b) = linalg::times(held.answer, -c);

  MatrixXd U, M_U, K_W;
  model.expand(span.W + linalg::times(Psi, span.C_b), span.C_b, U);
  model.m().multiply_kron3(U, M_U);
  span.M = model.inner(U, M_U);
  model.multiply_K(span.W, K_W);
  span.K = model.inner(span.W, K_W) + span.C_b.transpose() * K_bb * span.C_b;
  span.M = (0.5 * (span.M + span.M.transpose())).eval();
  span.K = (0.5 * (span.K + span.K.transpose())).eval();
  return span;
}

}  // namespace flexura::reduce
