// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/QR>
#include <chrono>
#include <filesystem>
#include <random>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/superelement/file.hpp"

/// Time of one evaluation of a flexible body (position and inverse dynamics) over its modes, with and without
/// geometric stiffening, and of reading and preparing parts of 1e4 and 1e6 surface nodes: neither may depend
/// on the mesh.
namespace flexura::mbs {
namespace {

using Clock = std::chrono::steady_clock;
using Eigen::MatrixXd;

double seconds(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

std::mt19937 engine(1);
MatrixXd random(int rows, int cols, double size) {
  std::normal_distribution<double> normal(0.0, size);
  MatrixXd A(rows, cols);
  for (double& a : A.reshaped()) a = normal(engine);
  return A;
}

/// Point masses with random shapes: consistent integrals, any number of modes.
superelement::Superelement part(int n_q, int surface_nodes) {
  const int n = 12 + n_q, points = n + 10;
  superelement::Superelement se;
  se.name = "part";
  se.n_b = 12;
  se.n_q = n_q;
  using D = superelement::Direction;
  const std::vector<D> all = {D::u_x, D::u_y, D::u_z, D::theta_x, D::theta_y, D::theta_z};
  se.interfaces = {{"a", "rigid", {0, 0, 0}, all, 0}, {"b", "rigid", {1, 0, 0}, all, 6}};
  const MatrixXd x = random(3, points, 0.5);
  // The interface columns hold the rigid motions; the rest is arbitrary.
  MatrixXd T = random(3 * points, n, 0.3);
  const MatrixXd R = superelement::rigid_motions(se);
  MatrixXd rigid(3 * points, 6);
  for (int k = 0; k < points; ++k) {
    const Eigen::Vector3d p = x.col(k);
    rigid.middleRows(3 * k, 3) << 1, 0, 0, 0, p.z(), -p.y(), 0, 1, 0, -p.z(), 0, p.x(), 0, 0, 1, p.y(),
        -p.x(), 0;
  }
  T += (rigid - T * R) * R.completeOrthogonalDecomposition().pseudoInverse();
  const double m = 1.0 / points;
  superelement::InertiaIntegrals& in = se.inertia;
  in.S_phi = Eigen::Matrix3Xd::Zero(3, n);
  in.S_xphi = MatrixXd::Zero(9, n);
  for (MatrixXd& S : in.S_phiphi) S = MatrixXd::Zero(n, n);
  const int ab[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (int k = 0; k < points; ++k) {
    const auto phi = T.middleRows(3 * k, 3);
    in.mass += m;
    in.S_x += m * x.col(k);
    in.S_xx += m * x.col(k) * x.col(k).transpose();
    in.S_phi += m * phi;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) in.S_xphi.row(3 * a + b) += m * x(a, k) * phi.row(b);
    for (int c = 0; c < 6; ++c)
      in.S_phiphi[c].noalias() += m * phi.row(ab[c][0]).transpose() * phi.row(ab[c][1]);
  }
  se.M_se = in.S_phiphi[0] + in.S_phiphi[1] + in.S_phiphi[2];
  // Stiff against everything but the rigid motions.
  MatrixXd P = MatrixXd::Identity(n, n) - R * R.completeOrthogonalDecomposition().pseudoInverse();
  const MatrixXd B = random(n, n, 1.0) + 10.0 * MatrixXd::Identity(n, n);
  se.K_se = 1e6 * P.transpose() * B.transpose() * B * P;
  se.K_se = (0.5 * (se.K_se + se.K_se.transpose())).eval();
  se.omega2 = se.K_se.diagonal().tail(n_q);
  superelement::StiffeningTerms& terms = se.stiffening.emplace();
  const MatrixXd K0 = 1e-3 * MatrixXd::Identity(n, n);
  terms.K0t.fill(K0);
  terms.K0r.fill(K0);
  terms.K0omega.fill(K0);
  terms.K0F.assign(12, K0);
  if (surface_nodes > 0) {
    se.surface.vertices = random(surface_nodes, 3, 1.0);
    se.shapes = Eigen::MatrixXf::Zero(3 * surface_nodes, n);
  }
  return se;
}

double evaluation_time(const FlexibleBody& body) {
  const int m = body.m();
  const Eigen::VectorXd s = 1e-3 * random(m, 1, 1.0), v = random(m, 1, 1.0), a = random(m, 1, 1.0);
  Eigen::VectorXd modal(m);
  const auto scratch = body.make_scratch();
  auto& work = *scratch;
  const Spatial V{{1, 2, 3}, {1, 0, 0}}, A{{3, 2, 1}, {0, 1, 0}};
  double best = 1e9;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const int count = 20 + 400000 / (m * m + 50);
    const auto start = Clock::now();
    for (int k = 0; k < count; ++k) {
      body.set_position(s.data(), work);
      body.inverse_dynamics(s.data(), v.data(), a.data(), V, A, work, modal.data());
    }
    best = std::min(best, seconds(start) / count);
  }
  return best;
}

}  // namespace
}  // namespace flexura::mbs

int main() {
  using namespace flexura;
  using namespace flexura::mbs;
  for (const int m : {5, 10, 20, 50, 100, 200}) {
    const superelement::Superelement se = part(std::max(m - 6, 0) + 6, 0);
    BasisOptions options;
    options.modes = m;
    const double plain = evaluation_time(ModalBody(modal_data(se, options)));
    options.stiffening = true;
    const double stiffened = evaluation_time(ModalBody(modal_data(se, options)));
    fmt::print("flexible_evaluation_{}_modes = {:.3g} us\n", m, 1e6 * plain);
    fmt::print("flexible_evaluation_{}_modes_stiffened = {:.3g} us\n", m, 1e6 * stiffened);
  }
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("flexura_bench_{}", std::random_device{}());
  std::filesystem::create_directory(folder);
  for (const int nodes : {10000, 1000000}) {
    const auto path = folder / fmt::format("{}.se.h5", nodes);
    superelement::write(path, part(8, nodes));
    double best = 1e9, evaluation = 0.0;
    for (int repeat = 0; repeat < 5; ++repeat) {
      const auto start = Clock::now();
      const ModalBody body(modal_data(superelement::read(path)));
      best = std::min(best, seconds(start));
      evaluation = evaluation_time(body);
    }
    fmt::print("read_and_prepare_{}_nodes = {:.3g} ms\n", nodes, 1e3 * best);
    fmt::print("flexible_evaluation_{}_nodes = {:.3g} us\n", nodes, 1e6 * evaluation);
  }
  std::filesystem::remove_all(folder);
}
