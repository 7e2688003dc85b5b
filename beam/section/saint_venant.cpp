// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/saint_venant.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <array>
#include <cmath>
#include <stdexcept>

namespace flexura::beam {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

struct Matrices {
  Sparse E, C, M;
  MatrixX6 R, L;
  Matrix6d A = Matrix6d::Zero();
};

Matrices assemble(const SectionMesh& mesh, const std::vector<Matrix6d>& Q_of_cell) {
  const int n = 3 * static_cast<int>(mesh.points.rows());
  Matrices m;
  m.R = m.L = MatrixX6::Zero(n, 6);
  std::vector<Eigen::Triplet<double>> E, C, M;
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell) {
    Eigen::Matrix<double, 18, 18> E_c = Eigen::Matrix<double, 18, 18>::Zero(), C_c = E_c, M_c = E_c;
    for (const QuadraturePoint& q : triangle_quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      const Operators o = operators_at(p);
      const Matrix6d Q = Q_of_cell[cell] * (q.weight * p.det);
      const Matrix6x18 QS = Q * o.S;
      const Matrix6d QPhi = Q * o.Phi;
      E_c += o.B.transpose() * Q * o.B;
      C_c += o.B.transpose() * QS;
      M_c += o.S.transpose() * QS;
      m.A += o.Phi.transpose() * QPhi;
      const Eigen::Matrix<double, 18, 6> R_c = o.B.transpose() * QPhi, L_c = o.S.transpose() * QPhi;
      for (int k = 0; k < 18; ++k) {
        const int row = 3 * mesh.triangles(cell, k / 3) + k % 3;
        m.R.row(row) += R_c.row(k);
        m.L.row(row) += L_c.row(k);
      }
    }
    for (int i = 0; i < 18; ++i)
      for (int j = 0; j < 18; ++j) {
        const int row = 3 * mesh.triangles(cell, i / 3) + i % 3,
                  column = 3 * mesh.triangles(cell, j / 3) + j % 3;
        E.emplace_back(row, column, E_c(i, j));
        if (C_c(i, j) != 0.0) C.emplace_back(row, column, C_c(i, j));
        if (M_c(i, j) != 0.0) M.emplace_back(row, column, M_c(i, j));
      }
  }
  for (Sparse* matrix : {&m.E, &m.C, &m.M}) matrix->resize(n, n);
  m.E.setFromTriplets(E.begin(), E.end());
  m.C.setFromTriplets(C.begin(), C.end());
  m.M.setFromTriplets(M.begin(), M.end());
  return m;
}

// The warping is free up to a rigid motion of the section (and u_x linear in y, z, which is shear): six dofs
// at three nodes are pinned.  The flexibility does not depend on which.
std::array<int, 6> pinned_dofs(const SectionMesh& mesh) {
  const int n = static_cast<int>(mesh.points.rows());
  const Eigen::RowVector2d middle = mesh.points.colwise().mean();
  int a = 0, b = 0, c = 0;
  for (int k = 0; k < n; ++k)
    if ((mesh.points.row(k) - middle).norm() < (mesh.points.row(a) - middle).norm()) a = k;
  for (int k = 0; k < n; ++k)
    if ((mesh.points.row(k) - mesh.points.row(a)).norm() > (mesh.points.row(b) - mesh.points.row(a)).norm())
      b = k;
  const Eigen::RowVector2d ab = mesh.points.row(b) - mesh.points.row(a);
  const auto off = [&](int k) {
    const Eigen::RowVector2d d = mesh.points.row(k) - mesh.points.row(a);
    return std::abs(ab(0) * d(1) - ab(1) * d(0));
  };
  for (int k = 0; k < n; ++k)
    if (off(k) > off(c)) c = k;
  const int turn = std::abs(ab(0)) > std::abs(ab(1)) ? 2 : 1;
  return {3 * a, 3 * a + 1, 3 * a + 2, 3 * b, 3 * b + turn, 3 * c};
}

}  // namespace

SaintVenantFields solve_saint_venant(const std::string& name, const SectionMesh& mesh,
                                     const std::vector<Matrix6d>& Q_of_cell) {
  const Matrices m = assemble(mesh, Q_of_cell);
  const int n = static_cast<int>(m.E.rows());
  std::vector<int> index(n, 0);
  for (const int dof : pinned_dofs(mesh)) index[dof] = -1;
  int free = 0;
  for (int& i : index)
    if (i == 0) i = free++;
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(m.E.nonZeros());
  for (int column = 0; column < n; ++column)
    for (Sparse::InnerIterator it(m.E, column); it; ++it)
      if (index[it.row()] >= 0 && index[column] >= 0)
        triplets.emplace_back(index[it.row()], index[column], it.value());
  Sparse E_ff(free, free);
  E_ff.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLLT<Sparse> factor(E_ff);
  if (factor.info() != Eigen::Success)
    throw std::invalid_argument(fmt::format(
        "section \"{}\": its warping problem is singular; mesh it so that its cells hang together by edges",
        name));
  const auto solve_E = [&](const MatrixX6& right) {
    MatrixX6 reduced(free, 6), full = MatrixX6::Zero(n, 6);
    for (int i = 0; i < n; ++i)
      if (index[i] >= 0) reduced.row(index[i]) = right.row(i);
    const MatrixX6 solution = factor.solve(reduced);
    for (int i = 0; i < n; ++i)
      if (index[i] >= 0) full.row(i) = solution.row(index[i]);
    return full;
  };

  const MatrixX6 U = solve_E(m.R);
  const Matrix6d schur = inverse_spd(Matrix6d(m.A - m.R.transpose() * U),
                                     fmt::format("section \"{}\": the stiffness of the free section", name));
  Matrix6d D = Matrix6d::Zero();
  D(M_y, V_z) = 1.0;
  D(M_z, V_y) = -1.0;
  SaintVenantFields s;
  s.Y_1 = schur * D;
  s.X_1 = -U * s.Y_1;
  const MatrixX6 W = solve_E(m.C.transpose() * s.X_1 - m.C * s.X_1 + m.L * s.Y_1);
  s.Y = schur * (Matrix6d::Identity() - m.L.transpose() * s.X_1 - m.R.transpose() * W);
  s.X = W - U * s.Y;

  const MatrixX6 on_X = m.E * s.X + m.C * s.X_1 + m.R * s.Y;
  const MatrixX6 on_X_1 = m.C.transpose() * s.X + m.M * s.X_1 + m.L * s.Y;
  const Matrix6d on_Y = m.R.transpose() * s.X + m.L.transpose() * s.X_1 + m.A * s.Y;
  const Matrix6d f = s.X.transpose() * on_X + s.X_1.transpose() * on_X_1 + s.Y.transpose() * on_Y;
  s.f = 0.5 * (f + f.transpose());
  return s;
}

}  // namespace flexura::beam
