// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/shell.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "reduce/elements/material.hpp"
#include "reduce/elements/shell_bending.hpp"
#include "reduce/elements/shell_cell.hpp"
#include "reduce/elements/shell_section.hpp"

namespace flexura::reduce {
namespace {

using namespace shell;

// What a moment meets where nothing else holds the middle surface from stretching.
Matrix3d bending_alone(const ShellSection& section) {
  if (!section.coupled) return section.D;
  return section.D - section.B * section.A.ldlt().solve(section.B);
}

// Membrane and bending of the quadrilateral: u, v, theta_3 of each corner, then w, theta_1, theta_2, then four of the bubbles.
struct Quadrilateral {
  MatrixXd K;        // 24 x 24, condensed
  MatrixXd bubbles;  // 4 x 24: alpha = bubbles * q
};

// In-plane strains (11, 22, 12) of corners and bubbles, 3 x 16, and the rotation (v,1 - u,2)/2 - theta_3, 1 x 16.
void membrane_operators(const Functions& f, const Jacobian& J, const Jacobian& J_0, MatrixXd& B,
                        Eigen::RowVectorXd& drill) {
  const MatrixXd dN = f.dN * J.inverse, dM = J_0.det / J.det * (f.dM * J_0.inverse);
  B.setZero(3, 16);
  drill.setZero(16);
  const auto add = [&](Index column_u, const Eigen::RowVector2d& d) {
    B(0, column_u) = d(0), B(1, column_u + 1) = d(1);
    B(2, column_u) = d(1), B(2, column_u + 1) = d(0);
    drill(column_u) = -0.5 * d(1), drill(column_u + 1) = 0.5 * d(0);
  };
  for (Index i = 0; i < 4; ++i) {
    add(3 * i, dN.row(i));
    drill(3 * i + 2) = -f.N(i);
  }
  for (Index k = 0; k < 2; ++k) add(12 + 2 * k, dM.row(k));
}

Quadrilateral quadrilateral(const Corners& x, const ShellSection& section) {
  const Jacobian J_0 = jacobian(functions_at(4, 0, 0), x);
  const Bending bending(x, bending_alone(section), section.S);
  MatrixXd K = MatrixXd::Zero(28, 28), B;
  Eigen::RowVectorXd drill;
  for (const Place& p : quadrature(4)) {
    const Functions f = functions_at(4, p.r, p.s);
    const Jacobian J = jacobian(f, x);
    membrane_operators(f, J, J_0, B, drill);
    MatrixXd stretch = MatrixXd::Zero(3, 28), curvature = stretch, shear = MatrixXd::Zero(2, 28);
    Eigen::RowVectorXd turn = Eigen::RowVectorXd::Zero(28);
    stretch.leftCols(12) = B.leftCols(12), stretch.rightCols(4) = B.rightCols(4);
    turn.head(12) = drill.head(12), turn.tail(4) = drill.tail(4);
    curvature.middleCols(12, 12) = bending.curvature(f, J.inverse);
    shear.middleCols(12, 12) = bending.shear(f, J.inverse, p.r, p.s);
    const double w = p.weight * J.det;
    K += w * (stretch.transpose() * section.A * stretch + section.A(2, 2) * turn.transpose() * turn +
              curvature.transpose() * section.D * curvature + shear.transpose() * section.S * shear);
    if (!section.coupled) continue;
    const MatrixXd mixed = w * stretch.transpose() * section.B * curvature;
    K += mixed + mixed.transpose();
  }
  Quadrilateral out;
  out.bubbles = -K.bottomRightCorner(4, 4).ldlt().solve(K.bottomLeftCorner(4, 24));
  out.K = K.topLeftCorner(24, 24) + K.topRightCorner(24, 4) * out.bubbles;
  return out;
}

// Membrane of the triangle, dofs u, v, theta_3 of each corner.  L (9 x 3) lumps boundary tractions of a constant
// stress; the mean strain is L^T q / area.
MatrixXd lumping(const Corners& x) {
  constexpr double kAlpha = 1.5;  // of the optimal element
  MatrixXd L(9, 3);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const auto X = [&](int a, int b) { return x(a, 0) - x(b, 0); };
    const auto Y = [&](int a, int b) { return x(a, 1) - x(b, 1); };
    L.row(3 * i) << Y(j, k), 0, X(k, j);
    L.row(3 * i + 1) << 0, X(k, j), Y(j, k);
    L.row(3 * i + 2) << kAlpha / 6 * Y(j, k) * (Y(i, k) - Y(j, i)),  //
        kAlpha / 6 * X(k, j) * (X(k, i) - X(i, j)),                  //
        kAlpha / 3 * (X(k, i) * Y(i, k) - X(i, j) * Y(j, i));
  }
  return 0.5 * L;
}

MatrixXd triangle_membrane(const Corners& x, const Matrix3d& A, double area) {
  const MatrixXd L = lumping(x);
  const MatrixXd basic = L * A * L.transpose() / area;
  const auto X = [&](int a, int b) { return x(a - 1, 0) - x(b - 1, 0); };
  const auto Y = [&](int a, int b) { return x(a - 1, 1) - x(b - 1, 1); };
  const auto l2 = [&](int a, int b) { return X(a, b) * X(a, b) + Y(a, b) * Y(a, b); };
  const double A4 = 4.0 * area;
  MatrixXd H(3, 9);  // hierarchical rotations
  for (int i = 0; i < 3; ++i) {
    H.row(i) << X(3, 2), Y(3, 2), 0, X(1, 3), Y(1, 3), 0, X(2, 1), Y(2, 1), 0;
    H(i, 3 * i + 2) = A4;
  }
  H /= A4;
  const double l21 = l2(2, 1), l32 = l2(3, 2), l13 = l2(1, 3);
  Matrix3d T;  // strains from those along the sides 2-1, 3-2, 1-3
  T << Y(2, 3) * Y(1, 3) * l21, Y(3, 1) * Y(2, 1) * l32, Y(1, 2) * Y(3, 2) * l13,  //
      X(2, 3) * X(1, 3) * l21, X(3, 1) * X(2, 1) * l32, X(1, 2) * X(3, 2) * l13,   //
      (Y(2, 3) * X(3, 1) + X(3, 2) * Y(1, 3)) * l21, (Y(3, 1) * X(1, 2) + X(1, 3) * Y(2, 1)) * l32,
      (Y(1, 2) * X(2, 3) + X(2, 1) * Y(3, 2)) * l13;
  T /= A4 * area;
  const auto Q = [&](std::array<double, 9> b) {
    Matrix3d out;
    out << b[0] / l21, b[1] / l21, b[2] / l21, b[3] / l32, b[4] / l32, b[5] / l32, b[6] / l13, b[7] / l13,
        b[8] / l13;
    return Matrix3d(2.0 * area / 3.0 * out);
  };
  // beta_1 ... beta_9 = 1, 2, 1, 0, 1, -1, -1, -1, -2.
  const Matrix3d Q1 = Q({1, 2, 1, 0, 1, -1, -1, -1, -2}), Q2 = Q({-2, -1, -1, 1, 1, 2, -1, 0, 1}),
                 Q3 = Q({1, -1, 0, -1, -2, -1, 2, 1, 1});
  const Matrix3d natural = T.transpose() * A * T;
  Matrix3d K_theta = Matrix3d::Zero();
  for (const Matrix3d& q : {Matrix3d(0.5 * (Q1 + Q2)), Matrix3d(0.5 * (Q2 + Q3)), Matrix3d(0.5 * (Q3 + Q1))})
    K_theta += q.transpose() * natural * q;
  // Poisson's ratio of the optimal factor, for any elasticity that of its in-plane stiffness.
  const double nu = (A(0, 1) + A(1, 0)) / (A(0, 0) + A(1, 1));
  const double beta_0 = std::max(0.5 * (1.0 - 4.0 * nu * nu), 0.01);
  return basic + 0.75 * beta_0 * area * H.transpose() * K_theta * H;
}

// Membrane and bending: u, v, theta_3 of each corner, then w, theta_1, theta_2.
MatrixXd triangle(const Corners& x, const ShellSection& section, double area) {
  const Bending bending(x, bending_alone(section), section.S);
  MatrixXd K = MatrixXd::Zero(18, 18), whole = MatrixXd::Zero(3, 9);  // whole: the integral of the curvature
  K.topLeftCorner(9, 9) = triangle_membrane(x, section.A, area);
  for (const Place& p : quadrature(3)) {
    const Functions f = functions_at(3, p.r, p.s);
    const Jacobian J = jacobian(f, x);
    const MatrixXd B = bending.curvature(f, J.inverse), B_s = bending.shear(f, J.inverse, p.r, p.s);
    const double w = p.weight * J.det;
    K.bottomRightCorner(9, 9) += w * (B.transpose() * section.D * B + B_s.transpose() * section.S * B_s);
    whole += w * B;
  }
  if (section.coupled) {
    K.topRightCorner(9, 9) = lumping(x) * section.B * whole / area;
    K.bottomLeftCorner(9, 9) = K.topRightCorner(9, 9).transpose();
  }
  return K;
}

// q_local = T q: the axes turned, the (warped) corner carried to the middle surface.
MatrixXd transform(const ShellFrame& frame, double offset) {
  const Index n = frame.x.rows();
  MatrixXd T = MatrixXd::Zero(6 * n, 6 * n);
  const Matrix3d Rt = frame.R.transpose();
  for (Index a = 0; a < n; ++a) {
    T.block<3, 3>(6 * a, 6 * a) = Rt;
    T.block<3, 3>(6 * a + 3, 6 * a + 3) = Rt;
    // u' = u + theta x (arm e_3); in the axes: (arm theta_2, -arm theta_1, 0).
    const double arm = offset - frame.warp(a);
    T.block<1, 3>(6 * a, 6 * a + 3) = arm * Rt.row(1);
    T.block<1, 3>(6 * a + 1, 6 * a + 3) = -arm * Rt.row(0);
  }
  return T;
}

// Places of the membrane's (u, v, theta_3) and the bending's (w, theta_1, theta_2) among six local dofs.
constexpr std::array<int, 3> kMembrane = {0, 1, 5}, kBending = {2, 3, 4};

// Of the dofs of membrane and bending, one after the other, of n corners: their places in 6n.
std::vector<Index> places(Index n) {
  std::vector<Index> out;
  for (const auto& kind : {kMembrane, kBending})
    for (Index a = 0; a < n; ++a)
      for (const int d : kind) out.push_back(6 * a + d);
  return out;
}

}  // namespace

ShellFrame shell_frame(const NodePositions& X) {
  const Index n = X.rows();
  ShellFrame frame;
  frame.centre = X.colwise().mean().transpose();
  const auto at = [&](Index a) { return Vector3d(X.row(a).transpose()); };
  const Vector3d normal =
      n == 3 ? (at(1) - at(0)).cross(at(2) - at(0)) : (at(2) - at(0)).cross(at(3) - at(1));
  const Vector3d along = n == 3 ? Vector3d(at(1) - at(0)) : Vector3d(at(1) + at(2) - at(0) - at(3));
  const Vector3d e3 = normal.normalized(), e1 = (along - e3 * e3.dot(along)).normalized();
  frame.R << e1, e3.cross(e1), e3;
  const NodePositions local = (X.rowwise() - frame.centre.transpose()) * frame.R;
  frame.x = local.leftCols<2>();
  frame.warp = local.col(2);
  frame.smallest_det = std::numeric_limits<double>::infinity();
  for (const Place& p : quadrature(n)) {
    const double det = jacobian(functions_at(n, p.r, p.s), frame.x).det;
    frame.area += p.weight * det;
    frame.smallest_det = std::min(frame.smallest_det, det);
  }
  // At the corners as well: a quadrilateral with an angle above 180 degrees is no element.
  if (n == 4)
    for (const auto& [r, s] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
      frame.smallest_det = std::min(frame.smallest_det, jacobian(functions_at(4, r, s), frame.x).det);
  if (!(frame.smallest_det > -std::numeric_limits<double>::infinity()))
    frame.smallest_det = 0.0;  // no number
  return frame;
}

double shell_stiffness(const NodePositions& X, const Material& material, double t, double offset,
                       MatrixXd& K_e) {
  const ShellFrame frame = shell_frame(X);
  const Index n = X.rows();
  if (!(frame.smallest_det > 0.0)) return frame.smallest_det;
  const ShellSection section = shell_section(material, t, frame.R);
  const MatrixXd K = n == 3 ? triangle(frame.x, section, frame.area) : quadrilateral(frame.x, section).K;
  MatrixXd local(6 * n, 6 * n);
  const std::vector<Index> place = places(n);
  for (Index i = 0; i < 6 * n; ++i)
    for (Index j = 0; j < 6 * n; ++j)
      local(place[static_cast<std::size_t>(i)], place[static_cast<std::size_t>(j)]) = K(i, j);
  const MatrixXd T = transform(frame, offset);
  K_e = T.transpose() * local * T;
  K_e = (0.5 * (K_e + K_e.transpose())).eval();
  return frame.smallest_det;
}

double shell_mass(const NodePositions& X, double density, double t, MassKind kind, MatrixXd& m_e) {
  const ShellFrame frame = shell_frame(X);
  const Index n = X.rows();
  m_e.setZero(n, n);
  if (!(frame.smallest_det > 0.0)) return frame.smallest_det;
  for (const Place& p : quadrature(n)) {
    const Functions f = functions_at(n, p.r, p.s);
    m_e += p.weight * jacobian(f, frame.x).det * density * t * f.N * f.N.transpose();
  }
  if (kind == MassKind::lumped) m_e = Eigen::VectorXd(m_e.rowwise().sum()).asDiagonal().toDenseMatrix();
  return frame.smallest_det;
}

ShellStress shell_stress(const NodePositions& X, const Material& material, double t, double offset) {
  const ShellFrame frame = shell_frame(X);
  const Index n = X.rows();
  const ShellSection section = shell_section(material, t, frame.R);
  const MatrixXd T = transform(frame, offset);
  // In-plane stresses (11, 22, 12) of the element's axes to six of the mesh's.
  Eigen::Matrix<double, 6, 3> turn;
  const Vector3d a = frame.R.col(0), b = frame.R.col(1);
  const Matrix3d of[3] = {a * a.transpose(), b * b.transpose(), a * b.transpose() + b * a.transpose()};
  for (int k = 0; k < 3; ++k)
    turn.col(k) << of[k](0, 0), of[k](1, 1), of[k](2, 2), of[k](0, 1), of[k](1, 2), of[k](2, 0);

  // Strains (3 x 6n, membrane then bending) where the element is most accurate, then at the corners.
  std::vector<MatrixXd> membrane, curvature;
  const Bending bending(frame.x, bending_alone(section), section.S);
  const auto of_bending = [&](const MatrixXd& B) {
    MatrixXd out = MatrixXd::Zero(3, 6 * n);
    out.rightCols(3 * n) = B;
    return out;
  };
  if (n == 3) {
    MatrixXd mean = MatrixXd::Zero(3, 18);
    mean.leftCols(9) = lumping(frame.x).transpose() / frame.area;
    for (const auto& [r, s] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}) {  // curvatures are linear
      const Functions f = functions_at(3, r, s);
      membrane.push_back(mean);
      curvature.push_back(of_bending(bending.curvature(f, jacobian(f, frame.x).inverse)));
    }
  } else {
    const Quadrilateral plane = quadrilateral(frame.x, section);
    const Jacobian J_0 = jacobian(functions_at(4, 0, 0), frame.x);
    std::vector<MatrixXd> m, c;
    MatrixXd B;
    Eigen::RowVectorXd drill;
    for (const Place& p : quadrature(4)) {
      const Functions f = functions_at(4, p.r, p.s);
      const Jacobian J = jacobian(f, frame.x);
      membrane_operators(f, J, J_0, B, drill);
      MatrixXd stretch = B.rightCols(4) * plane.bubbles;
      stretch.leftCols(12) += B.leftCols(12);
      m.push_back(std::move(stretch));
      c.push_back(of_bending(bending.curvature(f, J.inverse)));
    }
    const double g = std::sqrt(3.0);  // a corner in units of the Gauss points
    for (const auto& [r, s] : {std::pair{-g, -g}, {g, -g}, {g, g}, {-g, g}}) {
      const Eigen::VectorXd N = functions_at(4, r, s).N;
      membrane.push_back(N(0) * m[0] + N(1) * m[1] + N(2) * m[2] + N(3) * m[3]);
      curvature.push_back(N(0) * c[0] + N(1) * c[1] + N(2) * c[2] + N(3) * c[3]);
    }
  }
  ShellStress stress;
  const std::vector<Index> place = places(n);
  for (std::size_t corner = 0; corner < membrane.size(); ++corner)
    for (const bool top : {true, false}) {
      const MatrixXd of_dofs = turn * (top ? section.top : section.bottom) *
                               (membrane[corner] + (top ? 0.5 * t : -0.5 * t) * curvature[corner]);
      MatrixXd local(6, 6 * n);
      for (Index j = 0; j < 6 * n; ++j) local.col(place[static_cast<std::size_t>(j)]) = of_dofs.col(j);
      (top ? stress.top : stress.bottom).emplace_back(local * T);
    }
  return stress;
}

}  // namespace flexura::reduce
