// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/beam_reduction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

#include "reduce/linalg/block_lanczos.hpp"
#include "reduce/linalg/cholesky.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/krylov_schur.hpp"
#include "reduce/linalg/symmetric_matrix.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// Boundary dofs -(b + 1), interior dofs i, nodes that no member uses kUnused.
constexpr int kUnused = std::numeric_limits<int>::min();

struct Numbering {
  std::vector<int> code;         // 6 n_nodes
  std::vector<int> dof_of;       // interior dof -> nodal dof
  std::vector<int> group_begin;  // of interior dofs, by nodes
  int n_i = 0, n_b = 0;
};

std::string describe(const beam::BeamMesh& mesh, int dof) {
  static const std::array<const char*, 6> names = {"x", "y", "z", "about x", "about y", "about z"};
  const int node = dof / 6, named = static_cast<int>(mesh.model().nodes.size());
  const std::string place = node < named
                                ? fmt::format("node \"{}\"", mesh.model().nodes[node].name)
                                : fmt::format("the beam at ({:g}, {:g}, {:g})", mesh.points()[node].x(),
                                              mesh.points()[node].y(), mesh.points()[node].z());
  return fmt::format("{}, {}", place, names[dof % 6]);
}

Numbering number_dofs(const beam::BeamMesh& mesh, const std::vector<BeamInterface>& interfaces) {
  if (interfaces.empty())
    throw std::invalid_argument("the beam part has no interface; name at least one node as an interface");
  Numbering numbering;
  numbering.code.assign(mesh.n_dofs(), kUnused);
  const int n_nodes = mesh.n_dofs() / 6;
  std::vector<bool> used(n_nodes, false);
  for (const beam::MeshElement& element : mesh.elements())
    for (const int node : element.node) used[node] = true;
  std::set<int> taken;
  for (const BeamInterface& interface : interfaces) {
    if (interface.node < 0 || interface.node >= static_cast<int>(mesh.model().nodes.size()) ||
        !used[interface.node])
      throw std::invalid_argument(fmt::format("interface \"{}\": there is no node number {} with a member",
                                              interface.name, interface.node));
    if (!taken.insert(interface.node).second)
      throw std::invalid_argument(fmt::format("interface \"{}\": node \"{}\" is an interface already",
                                              interface.name, mesh.model().nodes[interface.node].name));
    if (interface.directions.empty() ||
        !std::is_sorted(interface.directions.begin(), interface.directions.end()) ||
        interface.directions.front() < 0 || interface.directions.back() > 5)
      throw std::invalid_argument(
          fmt::format("interface \"{}\": its directions must be some of 0 to 5, ascending", interface.name));
    for (const int direction : interface.directions)
      numbering.code[6 * interface.node + direction] = -(++numbering.n_b);
  }
  numbering.group_begin.push_back(0);
  for (int node = 0; node < n_nodes; ++node) {
    if (!used[node]) continue;
    for (int k = 0; k < 6; ++k)
      if (numbering.code[6 * node + k] == kUnused) {
        numbering.code[6 * node + k] = numbering.n_i++;
        numbering.dof_of.push_back(6 * node + k);
      }
    if (numbering.group_begin.back() < numbering.n_i) numbering.group_begin.push_back(numbering.n_i);
  }
  if (numbering.n_i == 0)
    throw std::invalid_argument(
        "every node of the beam part is an interface, which leaves nothing to reduce; divide the members "
        "into elements");
  return numbering;
}

// Interior block of a symmetric sparse matrix in the solver's form, and its interior-boundary block.
struct Split {
  std::unique_ptr<linalg::SymmetricMatrix> ii;
  MatrixXd ib;
};

Split split(const beam::SparseMatrix& A, const beam::SparseMatrix& pattern, const Numbering& numbering) {
  Split parts;
  parts.ib = MatrixXd::Zero(numbering.n_i, numbering.n_b);
  std::vector<int> begin = {0}, columns;
  std::vector<std::pair<int, int>> row;
  for (int i = 0; i < numbering.n_i; ++i) {
    std::vector<int> entries;
    for (beam::SparseMatrix::InnerIterator it(pattern, numbering.dof_of[i]); it; ++it) {
      const int j = numbering.code[it.row()];
      if (j > i) entries.push_back(j);
    }
    std::sort(entries.begin(), entries.end());
    columns.push_back(i);
    columns.insert(columns.end(), entries.begin(), entries.end());
    begin.push_back(static_cast<int>(columns.size()));
  }
  parts.ii = std::make_unique<linalg::SymmetricMatrix>(std::move(begin), std::move(columns));
  const auto add = [&](int i, int j, double value) {
    const std::array<int, 2> dofs = {i, j};
    MatrixXd block = MatrixXd::Zero(2, 2);
    block(0, 1) = block(1, 0) = value;
    parts.ii->add(dofs, block);
  };
  for (int column = 0; column < A.outerSize(); ++column)
    for (beam::SparseMatrix::InnerIterator it(A, column); it; ++it) {
      const int r = numbering.code[it.row()], c = numbering.code[column];
      if (r == kUnused || c == kUnused) continue;
      if (r >= 0 && c >= 0) {
        if (r == c)
          parts.ii->add_to_diagonal(r, it.value());
        else if (r < c)
          add(r, c, it.value());
      } else if (r >= 0) {
        parts.ib(r, -c - 1) = it.value();
      }
    }
  parts.ii->finish();
  return parts;
}

// One step of iterative refinement on top of the factor's solution.
MatrixXd solve_refined(const linalg::CholeskyFactor& factor, const linalg::SymmetricMatrix& K,
                       const MatrixXd& B) {
  MatrixXd X = factor.solve(B), KX;
  K.multiply(X, KX);
  X += factor.solve(B - KX);
  return X;
}

MatrixXd rigid_motions(const beam::BeamMesh& mesh, const Numbering& numbering) {
  MatrixXd R = MatrixXd::Zero(numbering.n_b, 6);
  for (int dof = 0; dof < mesh.n_dofs(); ++dof) {
    const int b = -numbering.code[dof] - 1;
    if (numbering.code[dof] == kUnused || b < 0) continue;
    const Eigen::Vector3d& p = mesh.points()[dof / 6];
    const int k = dof % 6;
    R(b, k) = 1.0;
    if (k == 0) R.block<1, 3>(b, 3) << 0, p.z(), -p.y();
    if (k == 1) R.block<1, 3>(b, 3) << -p.z(), 0, p.x();
    if (k == 2) R.block<1, 3>(b, 3) << p.y(), -p.x(), 0;
  }
  return R;
}

}  // namespace

BeamReduction reduce_beams(const beam::BeamMesh& mesh, const std::vector<BeamInterface>& interfaces,
                           const ReductionOptions& options) {
  BeamReduction result;
  Reduction& reduction = result.reduction;
  ReductionReport& report = reduction.report;
  linalg::Stopwatch watch;
  linalg::report(options.progress, "assembly", 0.0);
  const Numbering numbering = number_dofs(mesh, interfaces);
  const int n_i = numbering.n_i, n_b = numbering.n_b;
  Split K, M;
  {
    const beam::SparseMatrix K_all = beam::stiffness_matrix(mesh), M_all = beam::mass_matrix(mesh);
    K = split(K_all, K_all, numbering);
    M = split(M_all, M_all, numbering);
  }
  report.seconds_assembly = watch.lap();
  linalg::report(options.progress, "factorisation", 0.0);

  const auto factorise = [&] {
    try {
      return linalg::CholeskyFactor(*K.ii, numbering.group_begin);
    } catch (const linalg::SingularMatrix& error) {
      throw std::invalid_argument(
          fmt::format("the interfaces do not hold the beam part: it can move without strain, noticed at {}; "
                      "let the interfaces "
                      "keep more directions",
                      describe(mesh, numbering.dof_of[error.dof])));
    }
  };
  const linalg::CholeskyFactor factor = factorise();
  const linalg::FactorFigures& figures = factor.figures();
  report.seconds_ordering = figures.seconds_ordering;
  report.seconds_symbolic = figures.seconds_symbolic;
  report.seconds_factor = figures.seconds_numeric;
  report.factor_nonzeros = figures.nonzeros;
  report.factor_flops = figures.flops;
  report.smallest_pivot = figures.smallest_pivot;
  watch.lap();

  linalg::report(options.progress, "constraint modes", 0.0);
  const MatrixXd Psi = solve_refined(factor, *K.ii, -K.ib);
  MatrixXd K_Psi;
  K.ii->multiply(Psi, K_Psi);
  report.constraint_residual = K.ib.norm() > 0.0 ? (K_Psi + K.ib).norm() / K.ib.norm() : 0.0;
  MatrixXd K_bb;
  report.seconds_constraint_modes = watch.lap();

  linalg::EigenPairs pairs;
  pairs.Phi.resize(n_i, 0);
  if (options.n_modes > 0 || options.omega_max > 0.0) {
    bool massless = true;
    for (int i = 0; i < n_i && massless; ++i) massless = !(M.ii->diagonal(i) > 0.0);
    if (massless)
      throw std::invalid_argument(
          "normal modes are wanted of beams without mass; give the materials a density");
    linalg::EigenProblem problem;
    problem.n = problem.n_free = n_i;
    problem.solve = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = factor.solve(X); };
    problem.multiply_K = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { K.ii->multiply(X, Y); };
    problem.multiply_M = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { M.ii->multiply(X, Y); };
    const linalg::EigenRequest request{std::min(options.n_modes, n_i), options.omega_max * options.omega_max,
                                       options.tolerance};
    pairs = options.eigensolver == Eigensolver::krylov_schur
                ? linalg::krylov_schur(problem, request, options.progress)
                : linalg::block_lanczos(problem, request, options.progress);
  }
  if (!Psi.allFinite() || !pairs.Phi.allFinite())
    throw std::runtime_error("the modes of the beam part hold a number that is not finite");
  report.mode_residual = pairs.residual;
  report.solved_right_hand_sides = pairs.n_solves;
  report.seconds_normal_modes = watch.lap();

  linalg::report(options.progress, "projection", 0.0);
  const Index n_q = pairs.Phi.cols(), n = n_b + n_q;
  MatrixXd& T = result.T;
  T = MatrixXd::Zero(mesh.n_dofs(), n);
  for (int dof = 0; dof < mesh.n_dofs(); ++dof) {
    const int code = numbering.code[dof];
    if (code == kUnused) continue;
    if (code < 0)
      T(dof, -code - 1) = 1.0;
    else
      T.row(dof) << Psi.row(code), pairs.Phi.row(code);
  }
  {
    // Stiffness from the elements' stretch: rigid motions stay free of strain and eigenvalues keep their
    // digits however fine the mesh (strain_energy).  The coupling of Psi and Phi is zero in exact arithmetic.
    const MatrixXd energy = beam::strain_energy(mesh, T);
    K_bb = energy.topLeftCorner(n_b, n_b);
    pairs.omega2 = energy.diagonal().tail(n_q);
  }
  {
    const beam::InertiaSums sums = beam::inertia_sums(mesh);
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
    reduction.interfaces.push_back(
        {interface.name, Tie::node, mesh.points()[interface.node], interface.directions, first});
    first += static_cast<int>(interface.directions.size());
  }

  result.surface = beam::extruded_surface(mesh);
  const Index n_v = result.surface.vertices.rows();
  reduction.shapes.resize(3 * n_v, n);
  for (Index v = 0; v < n_v; ++v) {
    const beam::MeshElement& element = mesh.elements()[result.surface.element[v]];
    const MatrixXd rows = result.surface.at[v].leftCols<6>() * T.middleRows<6>(6 * element.node[0]) +
                          result.surface.at[v].rightCols<6>() * T.middleRows<6>(6 * element.node[1]);
    reduction.shapes.middleRows<3>(3 * v) = rows.cast<float>();
  }
  const MatrixXd R = rigid_motions(mesh, numbering);
  report.rigid_strain = (K_bb * R).norm() / (K_bb.norm() * R.norm());
  report.seconds_projection = watch.lap();

  if (options.estimate_error) {
    MatrixXd M_Psi;
    M.ii->multiply(Psi, M_Psi);
    const MatrixXd Mhat = M.ib + M_Psi;
    const MatrixXd participation = linalg::transpose_times(pairs.Phi, Mhat);
    reduction.dropped = linalg::transpose_times(Mhat, factor.solve(Mhat));
    if (n_q > 0)
      reduction.dropped -=
          participation.transpose() * pairs.omega2.cwiseInverse().asDiagonal() * participation;
    reduction.dropped = (0.5 * (reduction.dropped + reduction.dropped.transpose())).eval();
    reduction.omega2_dropped = n_q > 0 ? pairs.omega2(n_q - 1) : 0.0;
    report.seconds_estimate = watch.lap();
  }
  report.n_nodes = mesh.n_dofs() / 6;
  report.n_cells = static_cast<int>(mesh.elements().size());
  report.n_i = n_i;
  report.n_b = n_b;
  report.n_q = static_cast<int>(n_q);
  report.peak_memory_bytes = peak_memory();
  linalg::report(options.progress, "projection", 1.0);
  return result;
}

}  // namespace flexura::reduce
