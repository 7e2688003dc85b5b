// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/full_modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "reduce/beams/numbering.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/factor/cholesky.hpp"

namespace flexura::reduce {
namespace {

using Eigen::MatrixXd;

// Rows and columns `index` >= 0 of a symmetric sparse matrix with the pattern of `pattern`.
linalg::SymmetricMatrix part_of(const beam::SparseMatrix& A, const beam::SparseMatrix& pattern,
                                const std::vector<int>& index, const std::vector<int>& dof_of) {
  std::vector<int> begin = {0}, columns;
  for (std::size_t i = 0; i < dof_of.size(); ++i) {
    columns.push_back(static_cast<int>(i));
    std::vector<int> row;
    for (beam::SparseMatrix::InnerIterator it(pattern, dof_of[i]); it; ++it)
      if (index[it.row()] > static_cast<int>(i)) row.push_back(index[it.row()]);
    std::sort(row.begin(), row.end());
    columns.insert(columns.end(), row.begin(), row.end());
    begin.push_back(static_cast<int>(columns.size()));
  }
  linalg::SymmetricMatrix matrix(std::move(begin), std::move(columns));
  MatrixXd block = MatrixXd::Zero(2, 2);
  for (std::size_t i = 0; i < dof_of.size(); ++i)
    for (beam::SparseMatrix::InnerIterator it(A, dof_of[i]); it; ++it) {
      const int j = index[it.row()];
      if (j == static_cast<int>(i)) matrix.add_to_diagonal(j, it.value());
      if (j <= static_cast<int>(i)) continue;
      block(0, 1) = block(1, 0) = it.value();
      const std::array<int, 2> dofs = {static_cast<int>(i), j};
      matrix.add(dofs, block);
    }
  matrix.finish();
  return matrix;
}

// The size of the first elastic eigenvalue: the softest member's section over the whole structure's length,
// as a free beam, 500 EI / (m L^4).
double elastic_scale(const beam::BeamMesh& mesh) {
  Eigen::Vector3d low = mesh.points()[0], high = low;
  for (const Eigen::Vector3d& p : mesh.points()) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double L = (high - low).norm();
  double scale = 0.0;
  for (const beam::Member& member : mesh.model().members) {
    const beam::Section& s = mesh.model().sections[member.section].section;
    const double f = std::max(s.f(beam::M_y, beam::M_y), s.f(beam::M_z, beam::M_z));
    if (s.inertia.m > 0.0) scale = std::max(scale, 500.0 / (f * s.inertia.m * std::pow(L, 4)));
  }
  return scale > 0.0 ? scale : 1.0;
}

}  // namespace

MatrixXd free_beam_shapes(const Structure& structure, int count, double omega_max, bool rotary_inertia,
                          const linalg::Progress& progress) {
  std::vector<int> index(structure.n_dofs(), -1), dof_of;
  for (int dof = 0; dof < structure.n_dofs(); ++dof)
    if (structure.used()[dof]) {
      index[dof] = static_cast<int>(dof_of.size());
      dof_of.push_back(dof);
    }
  const double shift = elastic_scale(structure.mesh());
  const beam::SparseMatrix K_all = structure.stiffness(), M_all = structure.mass(rotary_inertia);
  const beam::SparseMatrix shifted = K_all + shift * M_all;
  const linalg::SymmetricMatrix K = part_of(K_all, shifted, index, dof_of),
                                M = part_of(M_all, shifted, index, dof_of);
  const linalg::SymmetricMatrix K_shifted = part_of(shifted, shifted, index, dof_of);
  const linalg::CholeskyFactor factor(K_shifted);
  linalg::EigenProblem problem;
  problem.n = problem.n_free = static_cast<int>(dof_of.size());
  problem.shift = shift;
  problem.solve = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = factor.solve(X); };
  problem.multiply_K = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { K.multiply(X, Y); };
  problem.multiply_M = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { M.multiply(X, Y); };
  problem.multiply_magnitudes = [&](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    K.multiply_magnitudes(X, Y);
  };
  const linalg::EigenPairs pairs =
      linalg::block_lanczos(problem, {std::min(6 + count, problem.n), omega_max * omega_max, 1e-8}, progress);
  MatrixXd U = MatrixXd::Zero(structure.n_dofs(), pairs.Phi.cols());
  for (std::size_t i = 0; i < dof_of.size(); ++i) U.row(dof_of[i]) = pairs.Phi.row(i);
  return U;
}

Eigen::VectorXd full_beam_modes(const Structure& structure, int count, bool rotary_inertia,
                                const linalg::Progress& progress) {
  return structure.strain_energy(free_beam_shapes(structure, count, 0.0, rotary_inertia, progress))
      .diagonal();
}

}  // namespace flexura::reduce
