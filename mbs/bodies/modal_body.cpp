// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/modal_body.hpp"

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "mbs/base/math/rotation.hpp"
#include "mbs/base/math/simd.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::mbs {
namespace {

using ConstMap = Eigen::Map<const Eigen::VectorXd>;

using Map = Eigen::Map<Eigen::VectorXd>;

/// Block 3 a + b of a vector of nine blocks of m.
auto block(const Eigen::VectorXd& x, int a, int b, int m) {
  return x.segment((3 * a + b) * m, m);
}

// y = A x of a tall matrix by columns, four of them at once.
FLEXURA_INLINE void tall_product(const double* A, int rows, int columns, const double* x,
                                 double* __restrict y) {
  for (int i = 0; i < rows; ++i) y[i] = 0.0;
  int j = 0;
  for (; j + 4 <= columns; j += 4, A += 4 * rows)
    for (int i = 0; i < rows; ++i)
      y[i] +=
          (A[i] * x[j] + A[rows + i] * x[j + 1]) + (A[2 * rows + i] * x[j + 2] + A[3 * rows + i] * x[j + 3]);
  for (; j < columns; ++j, A += rows)
    for (int i = 0; i < rows; ++i) y[i] += A[i] * x[j];
}

void multiply(const Eigen::MatrixXd& A, const double* x, Eigen::VectorXd& y) {
  const int rows = static_cast<int>(A.rows()), columns = static_cast<int>(A.cols());
  on_this_machine([&]()
                      __attribute__((always_inline)) { tall_product(A.data(), rows, columns, x, y.data()); });
}

/// Three numbers and one to spare, which fill a register.
using Four = Lanes<4>::Row;

// By copies: a reference into an array would lose that its four numbers are aligned as doubles only.
FLEXURA_INLINE void load(const double* from, Four& x) {
  std::memcpy(&x, from, sizeof x);
}
FLEXURA_INLINE void store(const Four& x, double* to) {
  std::memcpy(to, &x, sizeof x);
}

// sum_i s_i shape_i; a shape is eight numbers, (rotation, 0, displacement, 0).
FLEXURA_INLINE void add_columns(const double* shapes, const double* s, int m, double* sum) {
  Four angular = {}, linear = {}, of_angular, of_linear;
  for (int i = 0; i < m; ++i) {
    load(shapes + 8 * i, of_angular);
    load(shapes + 8 * i + 4, of_linear);
    angular += s[i] * of_angular;
    linear += s[i] * of_linear;
  }
  store(angular, sum);
  store(linear, sum + 4);
}

struct MapSums {
  double V[8] = {}, A[8] = {}, theta_dot[4] = {};  ///< shaped as above
};

// Columns (J theta_i, u_i) of the map, w = J theta', and what the rates make of them, in one pass.
FLEXURA_INLINE void map_columns(const double* shapes, const Matrix3d& J, const double* s_dot,
                                const double* s_ddot, int m, double* map, MapSums& sums) {
  const Four J_x = {J(0, 0), J(1, 0), J(2, 0), 0.0}, J_y = {J(0, 1), J(1, 1), J(2, 1), 0.0},
             J_z = {J(0, 2), J(1, 2), J(2, 2), 0.0};
  Four V_angular = {}, V_linear = {}, A_angular = {}, A_linear = {}, theta_dot = {};
  for (int i = 0; i < m; ++i, map += 6) {
    const double* shape = shapes + 8 * i;
    Four theta, linear;
    load(shape, theta);
    load(shape + 4, linear);
    const Four angular = shape[0] * J_x + shape[1] * J_y + shape[2] * J_z;
    for (int k = 0; k < 3; ++k) {
      map[k] = angular[k];
      map[3 + k] = linear[k];
    }
    if (!s_dot) continue;
    V_angular += s_dot[i] * angular;
    V_linear += s_dot[i] * linear;
    if (!s_ddot) continue;
    A_angular += s_ddot[i] * angular;
    A_linear += s_ddot[i] * linear;
    theta_dot += s_dot[i] * theta;
  }
  store(V_angular, sums.V);
  store(V_linear, sums.V + 4);
  store(A_angular, sums.A);
  store(A_linear, sums.A + 4);
  store(theta_dot, sums.theta_dot);
}

// (rotation, 0, displacement, 0) of each mode.
Eigen::Matrix<double, 8, Eigen::Dynamic> padded(const FlexibleNode& node) {
  Eigen::Matrix<double, 8, Eigen::Dynamic> out;
  out.setZero(8, node.Phi_t.cols());
  out.topRows<3>() = node.Phi_r;
  out.middleRows<3>(4) = node.Phi_t;
  return out;
}

const ModalData& checked(const ModalData& data) {
  const Eigen::Index m = data.stiffness.size();
  const superelement::InertiaIntegrals& in = data.inertia;
  const auto is_none_or_m = [m](const Eigen::MatrixXd& A) {
    return A.size() == 0 || (A.rows() == m && A.cols() == m);
  };
  bool fits = data.damping.size() == m && is_none_or_m(data.damping_coupling) && in.S_phi.cols() == m &&
              in.S_xphi.rows() == 9 && in.S_xphi.cols() == m;
  for (const Eigen::MatrixXd& S : in.S_phiphi) fits = fits && S.rows() == m && S.cols() == m;
  for (const FlexibleNode& node : data.nodes) fits = fits && node.Phi_t.cols() == m && node.Phi_r.cols() == m;
  if (data.second)
    fits = fits && data.second->t.rows() == 3 * m && data.second->t.cols() == m &&
           data.second->x.rows() == 9 * m && data.second->x.cols() == m;
  if (!fits)
    throw std::invalid_argument("the inertia integrals of a flexible body do not have one column per mode");
  if (data.second && data.coupling != Coupling::full)
    throw std::invalid_argument("geometric stiffening needs the full inertia coupling of a flexible body");
  return data;
}

std::vector<NodePlace> places(const std::vector<FlexibleNode>& nodes) {
  std::vector<NodePlace> out;
  for (const FlexibleNode& node : nodes) out.push_back({node.name, node.p_BoN_B});
  return out;
}

Eigen::MatrixXd elastic_mass(const superelement::InertiaIntegrals& in) {
  return in.S_phiphi[0] + in.S_phiphi[1] + in.S_phiphi[2];
}

std::pair<ModalData, BasisReport> with_report(const superelement::Superelement& se,
                                              const BasisOptions& options) {
  std::pair<ModalData, BasisReport> made;
  made.first = modal_data(se, options, &made.second);
  return made;
}

}  // namespace

ModalBody ModalBody::read(const std::filesystem::path& file, const BasisOptions& options) {
  return ModalBody(superelement::read(file, {.stiffening = options.stiffening}), options);
}

ModalBody::ModalBody(const superelement::Superelement& se, const BasisOptions& options)
    : ModalBody(with_report(se, options)) {}

ModalBody::ModalBody(std::pair<ModalData, BasisReport> made) : ModalBody(std::move(made.first)) {
  report_ = std::move(made.second);
}

ModalBody::ModalBody(ModalData data)
    : FlexibleBody(checked(data).inertia.mass, places(data.nodes), elastic_mass(data.inertia)),
      data_(std::move(data)),
      m_(m()) {
  const superelement::InertiaIntegrals& in = data_.inertia;
  for (const FlexibleNode& node : data_.nodes) shapes_.push_back(padded(node));
  T_.resize(9 * m_, m_);
  B_0_.resize(9 * m_);
  // S_phiphi of (a, b) has k, l: int Phi_k,a Phi_l,b; B_ab,i sums s_k over k, hence the transpose.
  const int stored[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  const bool direct[3][3] = {
      {true, true, false}, {false, true, true}, {true, false, true}};  // xy, yz, zx stored
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      const Eigen::MatrixXd& S = in.S_phiphi[stored[a][b]];
      if (direct[a][b])
        T_.middleRows((3 * a + b) * m_, m_) = S.transpose();
      else
        T_.middleRows((3 * a + b) * m_, m_) = S;
      B_0_.segment((3 * a + b) * m_, m_) = in.S_xphi.row(3 * a + b).transpose();
    }
  }
  T_skew_.resize(3 * m_, m_);
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    T_skew_.middleRows(c * m_, m_) =
        T_.middleRows((3 * a + b) * m_, m_) - T_.middleRows((3 * b + a) * m_, m_);
  }
  if (!data_.second) return;
  N_skew_.resize(3 * m_, m_);
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    N_skew_.middleRows(c * m_, m_) =
        data_.second->x.middleRows((3 * a + b) * m_, m_) - data_.second->x.middleRows((3 * b + a) * m_, m_);
  }
}

RigidInertia ModalBody::undeformed_inertia() const {
  const superelement::InertiaIntegrals& in = data_.inertia;
  return {in.mass, in.S_x, in.S_xx.trace() * Matrix3d::Identity() - in.S_xx};
}

std::unique_ptr<FlexibleBody::Scratch> ModalBody::make_scratch() const {
  auto work = std::make_unique<Work>();
  work->B = B_0_;
  work->W = Eigen::VectorXd::Zero(3 * m_);
  work->T_s = Eigen::VectorXd::Zero(9 * m_);
  work->N_s = Eigen::VectorXd::Zero(9 * m_);
  work->K0t_s = Eigen::VectorXd::Zero(3 * m_);
  work->C_t = data_.inertia.S_phi;
  work->C_r = Eigen::Matrix3Xd::Zero(3, m_);
  return work;
}

void ModalBody::set_position(const double* s_values, Scratch& scratch) const {
  Work& work = static_cast<Work&>(scratch);
  const ConstMap s(s_values, m_);
  const superelement::InertiaIntegrals& in = data_.inertia;
  if (data_.coupling == Coupling::full) {
    multiply(T_, s_values, work.T_s);
    work.B = B_0_ + work.T_s;
  }
  work.d = in.S_x;
  work.d.noalias() += in.S_phi * s;
  // int rho_a rho_b = S_xx + s_i int Phi_i,a x_b + B_ab,i s_i.
  Matrix3d rho_rho = in.S_xx;
  if (data_.coupling != Coupling::constant)
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        rho_rho(a, b) += block(B_0_, b, a, m_).dot(s) + block(work.B, a, b, m_).dot(s);
  if (data_.second) {
    multiply(data_.second->t, s_values, work.K0t_s);
    multiply(data_.second->x, s_values, work.N_s);
    work.B += work.N_s;
    Matrix3d x_u2;
    for (int a = 0; a < 3; ++a) {
      const auto K0t_s = work.K0t_s.segment(a * m_, m_);
      work.d(a) += 0.5 * K0t_s.dot(s);
      work.C_t.row(a) = in.S_phi.row(a) + K0t_s.transpose();
      for (int b = 0; b < 3; ++b) x_u2(a, b) = 0.5 * block(work.N_s, a, b, m_).dot(s);
    }
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) rho_rho(a, b) += x_u2(a, b) + x_u2(b, a);
  }
  work.J = rho_rho.trace() * Matrix3d::Identity() - rho_rho;
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    work.C_r.row(c) = (block(work.B, a, b, m_) - block(work.B, b, a, m_)).transpose();
  }
}

Spatial ModalBody::inverse_dynamics(const double* s_values, const double* s_dot_values,
                                    const double* s_ddot_values, const Spatial& V, const Spatial& A,
                                    Scratch& scratch, double* modal_values) const {
  Work& work = static_cast<Work&>(scratch);
  const ConstMap s(s_values, m_), s_dot(s_dot_values, m_), s_ddot(s_ddot_values, m_);
  Map modal(modal_values, m_);
  const Vector3d &w = V.angular, &alpha = A.angular, &a = A.linear, &d = work.d;

  Vector3d C_t_s_dot = Vector3d::Zero(), C_t_s_ddot = Vector3d::Zero(), C_r_s_ddot = Vector3d::Zero();
  C_t_s_dot.noalias() += work.C_t * s_dot;
  C_t_s_ddot.noalias() += work.C_t * s_ddot;
  C_r_s_ddot.noalias() += work.C_r * s_ddot;

  Spatial need;
  need.linear = mass() * a + alpha.cross(d) + w.cross(w.cross(d)) + 2.0 * w.cross(C_t_s_dot) + C_t_s_ddot;
  need.angular = d.cross(a) + work.J * alpha + w.cross(work.J * w) + C_r_s_ddot;

  modal = data_.stiffness.cwiseProduct(s) + data_.damping.cwiseProduct(s_dot);
  if (data_.damping_coupling.size() > 0) modal.noalias() += data_.damping_coupling * s_dot;
  modal.noalias() += M_e() * s_ddot;
  modal.noalias() += work.C_t.transpose() * a;
  modal.noalias() += work.C_r.transpose() * alpha;
  if (data_.coupling == Coupling::constant) {
    // The Lagrange equations of a kinetic energy whose J and C_r do not depend on s.
    Vector3d C_r_s_dot = Vector3d::Zero();
    C_r_s_dot.noalias() += work.C_r * s_dot;
    need.angular += w.cross(C_r_s_dot);
    return need;
  }
  Matrix3d P;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) P(i, j) = block(work.B, i, j, m_).dot(s_dot);
  need.angular += 2.0 * (w * P.trace() - P.transpose() * w);
  const double w2 = w.squaredNorm();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) modal += (w(i) * w(j) - (i == j ? w2 : 0.0)) * block(work.B, i, j, m_);
  if (data_.coupling == Coupling::full) {
    multiply(T_skew_, s_dot_values, work.W);
    for (int i = 0; i < 3; ++i) modal += 2.0 * w(i) * work.W.segment(i * m_, m_);
  }
  if (data_.second) {
    // W is free now: s'^T K0t s' and s'^T (N_ab - N_ba) s', the centripetal part of u2''.
    multiply(data_.second->t, s_dot_values, work.W);
    for (int i = 0; i < 3; ++i) need.linear(i) += work.W.segment(i * m_, m_).dot(s_dot);
    multiply(N_skew_, s_dot_values, work.W);
    for (int i = 0; i < 3; ++i) need.angular(i) += work.W.segment(i * m_, m_).dot(s_dot);
  }
  return need;
}

void ModalBody::turning_tangents(const double*, const double* s_dot_values, const Vector3d& w,
                                 Scratch& scratch, Eigen::Matrix<double, 6, 3>& need_w,
                                 Modal3& modal_w) const {
  Work& work = static_cast<Work&>(scratch);
  const ConstMap s_dot(s_dot_values, m_);
  Vector3d C_t_s_dot = Vector3d::Zero(), C_r_s_dot = Vector3d::Zero();
  C_t_s_dot.noalias() += work.C_t * s_dot;
  C_r_s_dot.noalias() += work.C_r * s_dot;
  need_w.topRows<3>() = skew(w) * work.J - skew(work.J * w);
  need_w.bottomRows<3>() = -skew(w.cross(work.d) + 2.0 * C_t_s_dot) - skew(w) * skew(work.d);
  modal_w.setZero();
  if (data_.coupling == Coupling::constant) {
    need_w.topRows<3>() -= skew(C_r_s_dot);
    return;
  }
  Matrix3d P;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) P(i, j) = block(work.B, i, j, m_).dot(s_dot);
  need_w.topRows<3>() += 2.0 * (P.trace() * Matrix3d::Identity() - P.transpose());
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      modal_w.col(i) +=
          w(j) * (block(work.B, i, j, m_) + block(work.B, j, i, m_)) - 2.0 * w(i) * block(work.B, j, j, m_);
  if (data_.coupling != Coupling::full) return;
  multiply(T_skew_, s_dot_values, work.W);
  for (int i = 0; i < 3; ++i) modal_w.col(i) += 2.0 * work.W.segment(i * m_, m_);
}

double ModalBody::strain_energy(const double* s) const {
  return 0.5 * data_.stiffness.dot(ConstMap(s, m_).cwiseAbs2());
}

double ModalBody::dissipated_power(const double*, const double* s_dot_values) const {
  const ConstMap s_dot(s_dot_values, m_);
  double power = data_.damping.dot(s_dot.cwiseAbs2());
  if (data_.damping_coupling.size() > 0) power += s_dot.dot(data_.damping_coupling * s_dot);
  return power;
}

void ModalBody::add_tangents(const double*, const double*, MatrixRef, MatrixRef D) const {
  if (data_.damping_coupling.size() > 0) D += data_.damping_coupling;
}

Pose ModalBody::node_pose(int index, const double* s_values) const {
  const ConstMap s(s_values, m_);
  const FlexibleNode& node = data_.nodes[index];
  Vector3d u = node.Phi_t * s, theta = node.Phi_r * s;
  if (node.second.size() > 0)
    for (int k = 0; k < 6; ++k)
      (k < 3 ? u(k) : theta(k - 3)) += 0.5 * s.dot(node.second.middleRows(k * m_, m_) * s);
  return {rotation_exp(theta), node.p_BoN_B + u};
}

void ModalBody::node_motion(int index, const double* s_values, const double* s_dot_values,
                            const double* s_ddot_values, NodeMotion& out) const {
  const FlexibleNode& node = data_.nodes[index];
  const double* shapes = shapes_[index].data();
  double sums[8];
  on_this_machine([&]() __attribute__((always_inline)) { add_columns(shapes, s_values, m_, sums); });
  Vector3d theta(sums[0], sums[1], sums[2]), u(sums[4], sums[5], sums[6]);
  const bool second = node.second.size() > 0;
  if (second) {
    const ConstMap s(s_values, m_);
    out.second.noalias() = node.second * s;
    out.rates = ConstMap(shapes, 8 * m_);
    for (int k = 0; k < 6; ++k) {
      const auto K_s = out.second.segment(k * m_, m_);
      (k < 3 ? u(k) : theta(k - 3)) += 0.5 * K_s.dot(s);
      Eigen::Map<Eigen::VectorXd, 0, Eigen::InnerStride<8>>(out.rates.data() + (k < 3 ? 4 + k : k - 3), m_) +=
          K_s;
    }
    shapes = out.rates.data();
  }
  const Matrix3d J_l = left_jacobian(theta);
  out.X_BN = {rotation_exp(theta), node.p_BoN_B + u};
  MapSums of_rates;
  on_this_machine([&]() __attribute__((always_inline)) {
    map_columns(shapes, J_l, s_dot_values, s_ddot_values, m_, out.map.data(), of_rates);
  });
  if (!s_dot_values) return;
  const auto spatial = [](const double* x) { return Spatial{{x[0], x[1], x[2]}, {x[4], x[5], x[6]}}; };
  out.V = spatial(of_rates.V);
  if (!s_ddot_values) return;
  out.A = spatial(of_rates.A);
  const double* rate = of_rates.theta_dot;
  out.A.angular += left_jacobian_bias(theta, {rate[0], rate[1], rate[2]});
  if (!second) return;
  Vector3d theta_ddot;
  const ConstMap s_dot(s_dot_values, m_);
  out.second.noalias() = node.second * s_dot;
  for (int k = 0; k < 3; ++k) {
    out.A.linear(k) += out.second.segment(k * m_, m_).dot(s_dot);
    theta_ddot(k) = out.second.segment((3 + k) * m_, m_).dot(s_dot);
  }
  out.A.angular += J_l * theta_ddot;
}

double ModalBody::amplitude(int i) const {
  double largest = 1.0 / std::sqrt(mass());
  for (const FlexibleNode& node : data_.nodes) largest = std::max(largest, node.Phi_t.col(i).norm());
  return largest;
}

}  // namespace flexura::mbs
