// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/model/lattice.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "tests/mbs/model/checks.hpp"

namespace flexura::mbs::lattice {

Lattice make_lattice(int n_q, double bar_stiffness) {
  Lattice out;
  const int nx = 4, ny = 3, nz = 2, N = nx * ny * nz;
  out.x.resize(3, N);
  out.mass.resize(N);
  std::vector<int> face_a, face_b, inner;
  for (int i = 0, k = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int l = 0; l < nz; ++l, ++k) {
        // Slightly skewed and unevenly heavy, so that no term vanishes by symmetry.
        out.x.col(k) << 0.3 * i + 0.02 * j, 0.2 * j - 0.03 * i + 0.1, 0.25 * l + 0.04 * i * j;
        out.mass(k) = 0.03 + 0.005 * ((7 * k) % 5);
        (i == 0 ? face_a : i == nx - 1 ? face_b : inner).push_back(k);
      }
  MatrixXd K = MatrixXd::Zero(3 * N, 3 * N);
  for (int p = 0; p < N; ++p)
    for (int q = p + 1; q < N; ++q) {
      const Vector3d r = out.x.col(q) - out.x.col(p);
      if (r.norm() > 0.52) continue;
      const Eigen::Matrix3d k = bar_stiffness / r.squaredNorm() * r * r.transpose() / r.norm();
      K.block<3, 3>(3 * p, 3 * p) += k;
      K.block<3, 3>(3 * q, 3 * q) += k;
      K.block<3, 3>(3 * p, 3 * q) -= k;
      K.block<3, 3>(3 * q, 3 * p) -= k;
    }

  // u = L (u_A, u_B, u_inner).
  const int n_i = 3 * static_cast<int>(inner.size());
  MatrixXd L = MatrixXd::Zero(3 * N, 12 + n_i);
  superelement::Superelement& se = out.se;
  se.name = "lattice";
  se.n_b = 12;
  using D = superelement::Direction;
  const auto tie = [&](const std::vector<int>& face, const std::string& name, int first) {
    Vector3d center = Vector3d::Zero();
    for (int k : face) center += out.x.col(k) / static_cast<double>(face.size());
    for (int k : face) {
      const Vector3d r = out.x.col(k) - center;
      L.block<3, 3>(3 * k, first).setIdentity();
      L.block<3, 3>(3 * k, first + 3) << 0, r.z(), -r.y(), -r.z(), 0, r.x(), r.y(), -r.x(), 0;
    }
    se.interfaces.push_back(
        {name, "rigid", center, {D::u_x, D::u_y, D::u_z, D::theta_x, D::theta_y, D::theta_z}, first});
  };
  tie(face_a, "left", 0);
  tie(face_b, "right", 6);
  for (std::size_t k = 0; k < inner.size(); ++k)
    L.block<3, 3>(3 * inner[k], 12 + 3 * static_cast<int>(k)).setIdentity();

  const VectorXd m3 = out.mass.replicate(1, 3).transpose().reshaped();
  const MatrixXd K_L = L.transpose() * K * L, M_L = L.transpose() * m3.asDiagonal() * L;
  const MatrixXd K_ii = K_L.bottomRightCorner(n_i, n_i), M_ii = M_L.bottomRightCorner(n_i, n_i);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> fixed(K_ii, M_ii);
  MatrixXd C = MatrixXd::Zero(12 + n_i, 12 + n_q);
  C.topLeftCorner(12, 12).setIdentity();
  C.bottomLeftCorner(n_i, 12) = -K_ii.llt().solve(K_L.bottomLeftCorner(n_i, 12));
  C.bottomRightCorner(n_i, n_q) = fixed.eigenvectors().leftCols(n_q);
  se.n_q = n_q;
  se.omega2 = fixed.eigenvalues().head(n_q);
  se.modal_damping = 0.01;
  out.T = L * C;
  se.K_se = out.T.transpose() * K * out.T;
  se.M_se = out.T.transpose() * m3.asDiagonal() * out.T;

  superelement::InertiaIntegrals& I = se.inertia;
  const int n = se.n();
  I.S_phi = Matrix3Xd::Zero(3, n);
  I.S_xphi = MatrixXd::Zero(9, n);
  const int ab[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (MatrixXd& S : I.S_phiphi) S = MatrixXd::Zero(n, n);
  for (int k = 0; k < N; ++k) {
    const double m = out.mass(k);
    const Vector3d x = out.x.col(k);
    const auto phi = out.T.middleRows(3 * k, 3);
    I.mass += m;
    I.S_x += m * x;
    I.S_xx += m * x * x.transpose();
    I.S_phi += m * phi;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) I.S_xphi.row(3 * a + b) += m * x(a) * phi.row(b);
    for (int c = 0; c < 6; ++c) I.S_phiphi[c] += m * phi.row(ab[c][0]).transpose() * phi.row(ab[c][1]);
  }
  return out;
}

superelement::StiffeningTerms any_stiffening(int n, unsigned seed) {
  checks::Random random(seed);
  const auto any = [&] {
    MatrixXd x(n, n);
    for (int j = 0; j < n; ++j) x.col(j) = random.vector(n);
    return MatrixXd(x + x.transpose());
  };
  superelement::StiffeningTerms terms;
  for (MatrixXd& x : terms.K0t) x = any();
  for (MatrixXd& x : terms.K0r) x = any();
  for (MatrixXd& x : terms.K0omega) x = any();
  for (int k = 0; k < 12; ++k) terms.K0F.push_back(any());
  return terms;
}

superelement::Superelement with_surface(const Lattice& lattice) {
  superelement::Superelement se = lattice.se;
  se.surface.vertices = lattice.x.transpose();
  se.surface.triangles.resize(1, 3);
  se.surface.triangles << 0, 1, 2;
  se.surface.edges.resize(0, 2);
  se.shapes = lattice.T.cast<float>();
  return se;
}

}  // namespace flexura::mbs::lattice
