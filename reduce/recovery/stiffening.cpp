// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/recovery/stiffening.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>
#include <utility>

#include "reduce/elements/strain.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Inertia forces per unit mass of the twelve motions of the frame at x: minus the acceleration.
Eigen::Matrix<double, 3, 12> inertia_forces(const Eigen::Vector3d& x) {
  Eigen::Matrix<double, 3, 12> f;
  f.leftCols<3>() = -Eigen::Matrix3d::Identity();
  constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  for (int a = 0; a < 3; ++a) f.col(3 + a) = -Eigen::Vector3d::Unit(a).cross(x);
  for (int k = 0; k < 6; ++k) {
    // omega x (omega x x) = omega (omega . x) - omega^2 x
    const auto [a, b] = kPairs[k];
    const Eigen::Vector3d e_a = Eigen::Vector3d::Unit(a), e_b = Eigen::Vector3d::Unit(b);
    f.col(6 + k) = a == b ? Eigen::Vector3d(x - e_a * x(a)) : Eigen::Vector3d(-(e_a * x(b) + e_b * x(a)));
  }
  return f;
}

// Six boundary dofs that hold the body: the ones that a pivoted QR of the rigid motions takes first.
std::vector<int> statically_determinate(const TiedModel& model, double length) {
  MatrixXd R = model.motions().rigid_b();
  // About the middle of the interfaces and with rotations in lengths, so that neither is preferred.
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int k = 0; k < model.n_interfaces(); ++k) centre += model.numbering().point(k) / model.n_interfaces();
  for (int a = 0; a < 3; ++a) {
    const Eigen::Vector3d shift = Eigen::Vector3d::Unit(a).cross(centre);
    R.col(3 + a) = ((R.col(3 + a) - R.leftCols(3) * shift) / length).eval();
  }
  // An interface with all six directions does it alone and keeps the matrices easy to read.
  for (int k = 0; k < model.n_interfaces(); ++k)
    if (model.numbering().directions(k).size() == 6) {
      std::vector<int> held(6);
      for (int d = 0; d < 6; ++d) held[d] = model.numbering().first_dof(k) + d;
      return held;
    }
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(R.transpose());
  std::vector<int> held(6);
  for (int k = 0; k < 6; ++k) held[k] = static_cast<int>(qr.colsPermutation().indices()(k));
  std::sort(held.begin(), held.end());
  return held;
}

// The scalar matrix g_ac = integral grad N_a . sigma grad N_c dV for the stress of a displacement field and of initial strains
// of the cells (or none).
linalg::SymmetricMatrix stress_stiffness(const Part& part, const linalg::SymmetricMatrix& m,
                                         const VectorXd& U, const CellStrains& initial) {
  const linalg::UpperCsr pattern = m.csr();
  linalg::SymmetricMatrix g({pattern.row_begin.begin(), pattern.row_begin.end()},
                            {pattern.columns.begin(), pattern.columns.end()});
  constexpr int kChunk = 512;
  std::vector<MatrixXd> results(kChunk);
  Index before = 0;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const Element& element = solid_element(block.type, formulation_of(block, part.formulation));
    for (Index first = 0; first < block.nodes.rows(); first += kChunk) {
      const int count = static_cast<int>(std::min<Index>(kChunk, block.nodes.rows() - first));
      linalg::parallel_for(count, [&](int k) {
        const Index cell = first + k;
        const std::size_t material = block.material.empty() ? 0 : block.material[cell];
        NodePositions x(element.n_nodes, 3), u(element.n_nodes, 3), gradients;
        for (int a = 0; a < element.n_nodes; ++a) {
          x.row(a) = part.mesh.points.row(block.nodes(cell, a));
          u.row(a) = U.segment<3>(3 * static_cast<Index>(block.nodes(cell, a)));
        }
        results[k].setZero(element.n_nodes, element.n_nodes);
        const StrainField field(element, x, part.materials[material].D);
        StrainMatrix B;
        for (const TabulatedRule::Point& point : element.stiffness.points) {
          const double det = spatial_gradients(point, x, gradients);
          field.at(point, B);
          Eigen::Matrix<double, 6, 1> strain = B * u.reshaped<Eigen::RowMajor>();
          if (initial.rows() > 0) strain -= initial.row(before + cell).transpose();
          const Eigen::Matrix<double, 6, 1> s = part.materials[material].D * strain;
          Eigen::Matrix3d sigma;
          sigma << s(0), s(3), s(5), s(3), s(1), s(4), s(5), s(4), s(2);
          results[k] += (point.weight * det) * gradients * sigma * gradients.transpose();
        }
      });
      for (int k = 0; k < count; ++k) {
        const auto cell = block.nodes.row(first + k);
        g.add({cell.data(), static_cast<std::size_t>(cell.size())}, results[k]);
      }
    }
    before += block.nodes.rows();
  }
  g.finish();
  return g;
}

}  // namespace

StiffeningTerms stiffening_terms(const Part& part, const TiedSolver& solver, const MatrixXd& Psi,
                                 const MatrixXd& K_bb, const MatrixXd& T,
                                 const std::vector<StressingLoad>& more, const linalg::Progress& progress) {
  if (!part.mesh.shells.empty() || !part.frames.empty())
    throw std::invalid_argument(
        "geometric stiffening of shells and of beams among solids is not computed: leave it out (stiffening "
        "= false)");
  if (!part.dependent.empty())
    throw std::invalid_argument(
        "geometric stiffening is not computed with constraints (*EQUATION, MPC, *TIE between nodes): leave "
        "it out "
        "(stiffening = false)");
  const TiedModel& model = solver.model();
  const Index n_b = model.n_b(), n = T.cols(), n_nodes = model.n_nodes();
  const auto& points = part.mesh.points;
  const double length = model.numbering().length();

  StiffeningTerms terms;
  terms.held = statically_determinate(model, length);
  std::vector<int> free;
  for (int b = 0; b < n_b; ++b)
    if (std::find(terms.held.begin(), terms.held.end(), b) == terms.held.end()) free.push_back(b);

  // Static displacements of all nodes: twelve inertia loads, then the load cases, then a unit load on each boundary dof.
  const auto n_more = static_cast<Index>(more.size()), n_nodal = 12 + n_more, n_loads = n_nodal + n_b;
  MatrixXd U;
  {
    MatrixXd A(3 * n_nodes, 12), F, f_i, f_b;
    for (Index node = 0; node < n_nodes; ++node) A.middleRows<3>(3 * node) = inertia_forces(points.row(node));
    model.m().multiply_kron3(A, F);
    F.conservativeResize(Eigen::NoChange, n_nodal);
    for (Index k = 0; k < n_more; ++k) F.col(12 + k) = more[static_cast<std::size_t>(k)].forces;
    model.gather(F, f_i, f_b);
    MatrixXd load(n_b, n_loads);
    load << f_b + model.inner(Psi, f_i), MatrixXd::Identity(n_b, n_b);
    MatrixXd u_b = MatrixXd::Zero(n_b, n_loads);
    if (!free.empty()) {
      const MatrixXd K = K_bb(free, free), p = load(free, Eigen::all);
      const MatrixXd u_free = K.ldlt().solve(p);
      u_b(free, Eigen::all) = u_free;
    }
    MatrixXd u_i = linalg::times(Psi, u_b);
    u_i.leftCols(n_nodal) += solver.solve(f_i);
    model.expand(u_i, u_b, U);
  }

  // The rows of T for one direction, contiguous.
  MatrixXd Phi[3];
  for (int a = 0; a < 3; ++a) {
    Phi[a].resize(n_nodes, n);
    for (Index k = 0; k < n; ++k)
      for (Index node = 0; node < n_nodes; ++node) Phi[a](node, k) = T(3 * node + a, k);
  }
  const auto reduced = [&](Index load) -> MatrixXd {
    linalg::report(progress, "geometric stiffening",
                   static_cast<double>(load) / static_cast<double>(n_loads));
    if (load >= n_nodal &&
        std::find(terms.held.begin(), terms.held.end(), load - n_nodal) != terms.held.end())
      return MatrixXd::Zero(n, n);
    const bool is_case = load >= 12 && load < n_nodal;
    const linalg::SymmetricMatrix g =
        stress_stiffness(part, model.m(), U.col(load),
                         is_case ? more[static_cast<std::size_t>(load - 12)].strain : CellStrains());
    MatrixXd K_0 = MatrixXd::Zero(n, n), gPhi;
    for (const MatrixXd& shapes : Phi) {
      g.multiply(shapes, gPhi);
      K_0 += linalg::transpose_times(shapes, gPhi);
    }
    K_0 = model.sum(std::move(K_0));
    return 0.5 * (K_0 + K_0.transpose());
  };
  for (int a = 0; a < 3; ++a) terms.K0t[a] = reduced(a);
  for (int a = 0; a < 3; ++a) terms.K0r[a] = reduced(3 + a);
  for (int k = 0; k < 6; ++k) terms.K0omega[k] = reduced(6 + k);
  for (Index k = 12; k < n_nodal; ++k) terms.K0p.push_back(reduced(k));
  for (Index b = 0; b < n_b; ++b) terms.K0F.push_back(reduced(n_nodal + b));
  linalg::report(progress, "geometric stiffening", 1.0);
  return terms;
}

}  // namespace flexura::reduce
