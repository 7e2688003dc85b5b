// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/flexible/beam_superelement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <functional>
#include <string>

#include "beam/model/mesh.hpp"

namespace flexura::mbs::beams {
namespace {

using Eigen::MatrixXd;

/// int N(x) (v'^2 + w'^2 + r2 theta_x'^2) dx on the mesh; N is a polynomial of degree two at most.
MatrixXd geometric_stiffness(const beam::BeamMesh& mesh, double r2, const std::function<double(double)>& N) {
  MatrixXd K_G = MatrixXd::Zero(mesh.n_dofs(), mesh.n_dofs());
  // Cubic shapes: slopes of degree two, products with N of degree six: four Gauss points are exact.
  const double xi[4] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
  const double weight[4] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
  for (const beam::MeshElement& element : mesh.elements()) {
    const double x_1 = mesh.points()[element.node[0]].x(), l = mesh.points()[element.node[1]].x() - x_1;
    for (int g = 0; g < 4; ++g) {
      const double s = 0.5 * (1.0 + xi[g]), w = 0.5 * l * weight[g] * N(x_1 + s * l);
      const double slope[4] = {(-6 * s + 6 * s * s) / l, 1 - 4 * s + 3 * s * s, (6 * s - 6 * s * s) / l,
                               -2 * s + 3 * s * s};
      const int n_1 = 6 * element.node[0], n_2 = 6 * element.node[1];
      Eigen::VectorXd v = Eigen::VectorXd::Zero(mesh.n_dofs()), w_z = v, twist = v;
      v(n_1 + 1) = w_z(n_1 + 2) = slope[0];
      v(n_2 + 1) = w_z(n_2 + 2) = slope[2];
      v(n_1 + 5) = slope[1];
      v(n_2 + 5) = slope[3];
      w_z(n_1 + 4) = -slope[1];  // w' = -theta_y
      w_z(n_2 + 4) = -slope[3];
      twist(n_1 + 3) = -1.0 / l;
      twist(n_2 + 3) = 1.0 / l;
      K_G += w * (v * v.transpose() + w_z * w_z.transpose() + r2 * twist * twist.transpose());
    }
  }
  return K_G;
}

}  // namespace

superelement::Superelement beam_superelement(const StraightBeam& b) {
  beam::Matrix6d C = beam::Matrix6d::Zero(), mass = beam::Matrix6d::Zero();
  const double shear = 1e3 * b.EA;  // without effect in Euler-Bernoulli theory
  C.diagonal() << b.EA, shear, shear, b.GI_t, b.EI_y, b.EI_z;
  const double m = b.mass_per_length, L = b.length;
  mass.diagonal() << m, m, m, b.rho_I_y + b.rho_I_z, b.rho_I_y, b.rho_I_z;
  beam::Model model;
  model.nodes = {{"root", {0, 0, 0}}, {"tip", {L, 0, 0}}};
  for (int i = 1; i <= b.between; ++i)
    model.nodes.push_back({"p" + std::to_string(i), {L * i / (b.between + 1), 0, 0}});
  model.sections.push_back({beam::matrix_section("section", C, mass), {}, {}});
  for (int i = 0; i <= b.between; ++i) {
    beam::Member member;
    member.name = "beam" + std::to_string(i);
    member.end[0].node = i == 0 ? 0 : i + 1;
    member.end[1].node = i == b.between ? 1 : i + 2;
    member.section = 0;
    member.theory = beam::Theory::euler_bernoulli;
    member.direction_B = Eigen::Vector3d::UnitY();
    member.elements = b.elements / (b.between + 1);
    model.members.push_back(member);
  }
  const beam::BeamMesh mesh(model, {});

  const MatrixXd K = beam::stiffness_matrix(mesh);
  const beam::InertiaSums sums = beam::inertia_sums(mesh);
  const MatrixXd M = sums.S_uu[0] + sums.S_uu[1] + sums.S_uu[2];
  const int n_b = 6 * (2 + b.between);
  const int n = mesh.n_dofs(), n_i = n - n_b;  // the model's nodes come first
  const MatrixXd K_ii = K.bottomRightCorner(n_i, n_i), M_ii = M.bottomRightCorner(n_i, n_i);
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> fixed(K_ii, M_ii);
  MatrixXd T = MatrixXd::Zero(n, n);
  T.topLeftCorner(n_b, n_b).setIdentity();
  T.bottomLeftCorner(n_i, n_b) = -K_ii.llt().solve(K.bottomLeftCorner(n_i, n_b));
  T.bottomRightCorner(n_i, n_i) = fixed.eigenvectors();

  superelement::Superelement se;
  se.name = "beam";
  se.n_b = n_b;
  se.n_q = n_i;
  using D = superelement::Direction;
  const std::vector<D> all = {D::u_x, D::u_y, D::u_z, D::theta_x, D::theta_y, D::theta_z};
  se.interfaces = {{"root", "node", {0, 0, 0}, all, 0}, {"tip", "node", {L, 0, 0}, all, 6}};
  for (int i = 1; i <= b.between; ++i)
    se.interfaces.push_back({model.nodes[static_cast<std::size_t>(i + 1)].name,
                             "node",
                             {L * i / (b.between + 1), 0, 0},
                             all,
                             6 + 6 * i});
  const auto in_shapes = [&T](const MatrixXd& X) {
    const MatrixXd Y = T.transpose() * X * T;
    return MatrixXd(0.5 * (Y + Y.transpose()));
  };
  se.K_se = in_shapes(K);
  se.M_se = in_shapes(M);
  se.omega2 = fixed.eigenvalues();
  se.inertia.mass = sums.mass;
  se.inertia.S_x = sums.S_x;
  se.inertia.S_xx = sums.S_xx;
  se.inertia.S_phi = sums.S_u * T;
  se.inertia.S_xphi = sums.S_xu * T;
  for (int k = 0; k < 6; ++k) se.inertia.S_phiphi[k] = T.transpose() * sums.S_uu[k] * T;

  const double r2 = (b.rho_I_y + b.rho_I_z) / m;
  const auto K0 = [&](const std::function<double(double)>& N) {
    return in_shapes(geometric_stiffness(mesh, r2, N));
  };
  const MatrixXd zero = MatrixXd::Zero(n, n);
  superelement::StiffeningTerms& terms = se.stiffening.emplace();
  terms.K0t = {K0([&](double x) { return -m * (L - x); }), zero, zero};
  terms.K0r = {zero, zero, zero};
  const MatrixXd spin = K0([&](double x) { return 0.5 * m * (L * L - x * x); });
  terms.K0omega = {zero, spin, spin, zero, zero, zero};
  terms.K0F.assign(static_cast<std::size_t>(n_b), zero);
  terms.K0F[6] = K0([](double) { return 1.0; });
  return se;
}

}  // namespace flexura::mbs::beams
