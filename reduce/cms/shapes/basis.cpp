// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/basis.hpp"

#include <fmt/format.h>

#include "reduce/cms/result/load_case.hpp"
#include "reduce/cms/shapes/response_modes.hpp"
#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

Basis craig_chang_basis(const Part& part, const TiedModel& model, const HeldAnswers& held,
                        const ConstraintModes& constraint, const ReductionOptions& options,
                        ReductionReport& report) {
  const MatrixXd &Psi = constraint.Psi, &K_bb = constraint.K_bb;
  const CraigChangSpan span = craig_chang_span(part, model, held, Psi, K_bb, options);
  const CanonicalShapes shapes = canonical_shapes(span.K, span.M, span.C_b);
  if (!shapes.dropped.empty()) {
    int n_rigid = 0;
    std::string others;
    for (const int j : shapes.dropped) {
      if (j >= span.first_attachment)
        ++n_rigid;
      else
        others += fmt::format("{}free mode {}", others.empty() ? "" : ", ", j + 1);
    }
    report.notes.push_back(
        fmt::format("{} of {} attachment modes depend on the other shapes and are dropped{}{}", n_rigid,
                    K_bb.rows(), others.empty() ? "" : ", so are ", others));
  }
  const Index n_b = K_bb.rows(), n_q = shapes.omega2.size();
  Basis basis;
  basis.U_b = Psi + linalg::times(span.W, shapes.Y.leftCols(n_b));
  basis.Phi = linalg::times(span.W, shapes.Y.rightCols(n_q));
  basis.omega2 = shapes.omega2;
  basis.K_bb = shapes.Y.leftCols(n_b).transpose() * span.K * shapes.Y.leftCols(n_b);
  basis.K_bb = rigid_projection(model).strain_free(basis.K_bb);
  part_by_pieces(part, model, basis.K_bb);
  report.mode_residual = span.residual;
  report.mode_round_off = span.round_off;
  return basis;
}

namespace {

// Response and load shapes join the normal modes.
void add_shapes(const Part& part, const TiedModel& model, const TiedSolver& solver,
                const linalg::EigenProblem& problem, const MatrixXd& Mhat, const ReductionOptions& options,
                linalg::EigenPairs& pairs, std::vector<StaticAnswer>& answers, ReductionReport& report) {
  const Index n_normal = pairs.omega2.size();
  ExtraShapes all;
  if (!options.response_omegas.empty()) {
    constexpr const char* kDirections[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
    std::vector<std::string> names;
    for (int k = 0; k < model.n_interfaces(); ++k)
      for (const int d : model.numbering().directions(k))
        names.push_back(part.interfaces[k].name + "." + kDirections[d]);
    for (const double omega : options.response_omegas)
      add_to(all, response_shapes(problem, pairs, Mhat, omega, names));
  }
  for (const LoadField& load : options.loads) {
    if (!load.keep_shape) continue;
    MatrixXd f_i, f_b;
    model.gather(nodal_forces(model.m(), model.n_nodes(), load), f_i, f_b);
    const MatrixXd u_i = solver.solve(f_i);
    add_to(all, whole_shapes(problem, u_i, {"static answer to load " + load.name}));
    answers.push_back({load.name, f_i, model.inner(f_i, u_i)(0, 0)});
  }
  if (all.names.empty()) return;
  for (const std::string& name : append_shapes(problem, pairs, all))
    report.notes.push_back(name + " is dropped: it depends on the other shapes");
  report.n_extra = static_cast<int>(pairs.omega2.size() - n_normal);
  report.notes.push_back(
      fmt::format("{} response and load shapes beside {} normal modes", report.n_extra, n_normal));
}

}  // namespace

Basis fixed_interface_basis(const Part& part, const TiedModel& model, const TiedSolver& solver,
                            const linalg::EigenProblem& problem, const ConstraintModes& constraint,
                            const MatrixXd& Mhat, linalg::EigenPairs&& pairs, const ReductionOptions& options,
                            ReductionReport& report) {
  std::vector<StaticAnswer> answers;
  add_shapes(part, model, solver, problem, Mhat, options, pairs, answers, report);
  require_ritz(problem, pairs.Phi, pairs.omega2, answers);
  return {constraint.Psi, std::move(pairs.Phi), std::move(pairs.omega2), constraint.K_bb};
}

}  // namespace flexura::reduce
