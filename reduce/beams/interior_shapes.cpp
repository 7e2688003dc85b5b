// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/interior_shapes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "reduce/beams/full_modes.hpp"
#include "reduce/cms/errors/choose_modes.hpp"
#include "reduce/cms/errors/mode_choice.hpp"
#include "reduce/cms/shapes/response_modes.hpp"
#include "reduce/cms/shapes/sturm.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/factor/inertia.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd BeamInterior::on_all_dofs(const MatrixXd& u_b, const MatrixXd& u_i) const {
  MatrixXd U = MatrixXd::Zero(structure.n_dofs(), u_b.cols());
  for (int dof = 0; dof < structure.n_dofs(); ++dof) {
    const int code = numbering.code[dof];
    if (code == Numbering::kUnused) continue;
    U.row(dof) = code < 0 ? u_b.row(-code - 1) : u_i.row(code);
  }
  return U;
}

namespace {

linalg::EigenProblem problem_of(const BeamInterior& in) {
  linalg::EigenProblem problem;
  problem.n = problem.n_free = in.numbering.n_i;
  problem.solve = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = in.factor.solve(X); };
  problem.multiply_K = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { in.K.ii->multiply(X, Y); };
  problem.multiply_M = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { in.M.ii->multiply(X, Y); };
  problem.multiply_magnitudes = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    in.K.ii->multiply_magnitudes(X, Y);
  };
  return problem;
}

// M_ib + M_ii Psi.
MatrixXd inertia_loads(const BeamInterior& in) {
  MatrixXd M_Psi;
  in.M.ii->multiply(in.Psi, M_Psi);
  return in.M.ib + M_Psi;
}

InteriorDynamics dynamics_of(const BeamInterior& in, const MatrixXd& Mhat) {
  const Index n_b = in.numbering.n_b;
  const MatrixXd constraint = in.on_all_dofs(MatrixXd::Identity(n_b, n_b), in.Psi);
  InteriorDynamics out;
  out.K_bb = in.structure.strain_energy(constraint);
  const MatrixXd M_T = in.structure.mass() * constraint;
  out.M_bb = linalg::transpose_times(constraint, M_T);
  out.M_bb = (0.5 * (out.M_bb + out.M_bb.transpose())).eval();
  const MatrixXd answer = in.factor.solve(Mhat);
  out.compliance = linalg::transpose_times(Mhat, answer);
  MatrixXd M_answer;
  in.M.ii->multiply(answer, M_answer);
  out.growth = linalg::transpose_times(answer, M_answer);
  return out;
}

InteriorMass mass_of(const BeamInterior& in) {
  const beam::InertiaSums sums = in.structure.inertia();
  const Eigen::Vector3d centre = sums.S_x / sums.mass;
  MatrixXd R_b = in.R_b, R_i = in.R_i;
  for (MatrixXd* motions : {&R_b, &R_i})
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d shift = Eigen::Vector3d::Unit(a).cross(centre);
      motions->col(3 + a) = (motions->col(3 + a) - motions->leftCols(3) * shift).eval();
    }
  MatrixXd M_R;
  in.M.ii->multiply(R_i, M_R);
  return {std::move(R_b), linalg::transpose_times(R_i, M_R)};
}

// What Craig and Chang's space has beside the constraint modes: free modes and answers to rigid acceleration, less the motion
// that the constraint modes give them.
ExtraShapes craig_chang_shapes(const BeamInterior& in, const linalg::EigenProblem& problem,
                               const ReductionOptions& options) {
  const MatrixXd U =
      free_beam_shapes(in.structure, options.n_modes, options.omega_max, true, options.progress);
  const Index n_free = std::max<Index>(0, U.cols() - 6);
  MatrixXd at_interfaces(in.numbering.n_b, n_free);
  for (int dof = 0; dof < in.structure.n_dofs(); ++dof)
    if (const int code = in.numbering.code[dof]; code < 0 && code != Numbering::kUnused)
      at_interfaces.row(-code - 1) = U.row(dof).tail(n_free);
  MatrixXd M_R;
  in.M.ii->multiply(in.R_i, M_R);
  M_R += in.M.ib * in.R_b;
  MatrixXd X(in.numbering.n_i, n_free + 6);
  X << U(in.numbering.dof_of, Eigen::all).rightCols(n_free) - in.Psi * at_interfaces,
      solve_refined(in.factor, *in.K.ii, M_R);
  std::vector<std::string> names;
  for (Index k = 0; k < n_free; ++k) names.push_back(fmt::format("free mode {}", k + 7));
  for (const char* motion : {"x", "y", "z", "about x", "about y", "about z"})
    names.push_back(fmt::format("answer to acceleration {}", motion));
  return whole_shapes(problem, std::move(X), std::move(names));
}

// Counts the eigenvalues below the first left out.
void certify_modes(const BeamInterior& in, const linalg::EigenPairs& pairs, ReductionReport& report) {
  const auto n_modes = static_cast<int>(pairs.omega2.size());
  if (n_modes == in.numbering.n_i) return;  // all there are
  const double last = pairs.omega2(n_modes - 1);
  if (pairs.counted) {
    note_count(last, pairs.omega2_next, n_modes, report);
    return;
  }
  const beam::SparseMatrix K = in.structure.stiffness(), M = in.structure.mass();
  bool is_counted = false;
  const auto count = [&](double omega2) {
    const SplitMatrix shifted(K - omega2 * M, in.numbering);
    const int n = linalg::IndefiniteFactor(*shifted.ii).n_negative();
    is_counted = true;
    return n;
  };
  try {
    certify(count, last, pairs.omega2_next, n_modes, report);
  } catch (const std::runtime_error& error) {
    if (is_counted) throw;
    report.certified_modes = -1;
    report.notes.push_back(fmt::format(
        "warning: that no mode was missed is not proved, as no factor is good enough to count them ({})",
        error.what()));
  }
}

std::vector<std::string> names_of_dofs(const BeamInterior& in) {
  constexpr const char* kDirections[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
  std::vector<std::string> names;
  for (const BeamInterface& interface : in.interfaces)
    for (const int d : interface.directions) names.push_back(interface.name + "." + kDirections[d]);
  return names;
}

ExtraShapes preload_shapes(const BeamInterior& in, const linalg::EigenProblem& problem,
                           const std::vector<LoadCase>& cases) {
  MatrixXd answers(in.numbering.n_i, 0);
  std::vector<std::string> names;
  for (const LoadCase& load : cases) {
    if (load.preloads.empty()) continue;
    const VectorXd p = load_vector(in.structure, load);
    answers.conservativeResize(Eigen::NoChange, answers.cols() + 1);
    answers.rightCols<1>() = solve_refined(in.factor, *in.K.ii, MatrixXd(p(in.numbering.dof_of)));
    names.push_back("static answer to load " + load.name);
  }
  return whole_shapes(problem, std::move(answers), std::move(names));
}

}  // namespace

linalg::EigenPairs interior_shapes(const BeamInterior& in, const ReductionOptions& options,
                                   const std::vector<LoadCase>& cases, ReductionReport& report) {
  linalg::EigenPairs pairs;
  const int n_i = in.numbering.n_i;
  pairs.Phi.resize(n_i, 0);
  pairs.omega2_next = std::numeric_limits<double>::infinity();
  const bool preloaded = std::ranges::any_of(cases, [](const LoadCase&c) { return !c.preloads.empty(); }),
             by_goal = options.accuracy > 0.0 || options.effective_mass > 0.0,
             wants_modes =
                 options.set != ModeSet::guyan && (options.n_modes > 0 || options.omega_max > 0.0 || by_goal),
             free = options.set == ModeSet::craig_chang, responds = !options.response_omegas.empty();
  if (n_i == 0 || !(wants_modes || preloaded || free || responds)) return pairs;
  bool massless = true;
  for (int i = 0; i < n_i && massless; ++i) massless = !(in.M.ii->diagonal(i) > 0.0);
  if (massless)
    throw std::invalid_argument(
        "normal modes are wanted of beams without mass; give the materials a density");
  const linalg::EigenProblem problem = problem_of(in);
  MatrixXd Mhat;
  if (by_goal || responds) Mhat = inertia_loads(in);
  InteriorDynamics interior;
  if (by_goal) interior = dynamics_of(in, Mhat);
  const auto solve_for = [&](int count, double omega) {
    const linalg::EigenRequest request{std::min(count, n_i), omega * omega, options.tolerance};
    pairs = options.eigensolver == Eigensolver::krylov_schur
                ? linalg::krylov_schur(problem, request, options.progress)
                : linalg::block_lanczos(problem, request, options.progress);
    if (!by_goal) return;
    interior.participation = linalg::transpose_times(pairs.Phi, Mhat);
    interior.omega2 = pairs.omega2;
    interior.omega2_next = pairs.omega2_next;
  };
  ExtraShapes extra;
  if (free)
    extra = craig_chang_shapes(in, problem, options);
  else if (by_goal)
    choose_modes(
        options, interior, [&] { return mass_of(in); }, solve_for, pairs, report);
  else if (wants_modes)
    solve_for(options.n_modes, options.omega_max);
  const Index n_normal = pairs.omega2.size();
  if (options.certify && n_normal > 0) certify_modes(in, pairs, report);
  for (const double omega : options.response_omegas)
    add_to(extra, response_shapes(problem, pairs, Mhat, omega, names_of_dofs(in)));
  if (preloaded) add_to(extra, preload_shapes(in, problem, cases));
  if (extra.names.empty()) return pairs;
  const std::vector<std::string> dropped = append_shapes(problem, pairs, extra);
  report.n_extra = static_cast<int>(pairs.omega2.size() - n_normal);
  if (free || responds) {
    for (const std::string& name : dropped)
      report.notes.push_back(name + " is dropped: it depends on the other shapes");
    report.notes.push_back(
        free ? fmt::format("{} shapes of free modes and attachment modes beside the constraint modes",
                           report.n_extra)
             : fmt::format("{} response and load shapes beside {} normal modes", report.n_extra, n_normal));
  }
  return pairs;
}

}  // namespace flexura::reduce
