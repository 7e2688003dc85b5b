// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/beams/ancf_part.hpp"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "beam/ancf/ancf_kinematics.hpp"

namespace flexura::mbs {
namespace {

using beam::ancf::AncfBody;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The angle over which a beam is bent to have its stiffness EI from the strain energy EI kappa^2 L / 2 of an arc: the
// energy's terms of higher order are its square.
constexpr double kArc = 1e-3;

// Coordinates of the first node that B leaves free: r_x of a beam, the stretch of a planar line.
int n_first_of(const AncfBody& body) {
  return body.dim() == 3 ? 3 : 1;
}

MatrixXd free_mass(const AncfBody& body) {
  if (body.vectors() != 4 && body.dim() != 2)
    throw std::invalid_argument(
        "a beam with r, r_x, r_y, r_z at its nodes is needed; a line in space has no sections to join to");
  const MatrixXd M = body.mass().to_sparse();
  const int first = n_first_of(body), node = body.node_coordinates();
  const Eigen::Index m = M.rows() - node + first;
  const auto coordinate = [&](Eigen::Index i) { return i < first ? body.dim() + i : node - first + i; };
  MatrixXd out(m, m);
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < m; ++j) out(i, j) = M(coordinate(i), coordinate(j));
  return out;
}

std::vector<NodePlace> nodes_of(const AncfBody& body, const std::vector<AncfPart::Station>& stations,
                                const Matrix3d& R, const Vector3d& origin) {
  std::vector<NodePlace> nodes;
  const VectorXd still = VectorXd::Zero(body.n_q());
  for (const AncfPart::Station& station : stations) {
    NodePlace node;
    node.name = station.name;
    node.p_BoN_B = origin + R * beam::ancf::evaluate_point(body, station.at, body.rest(), still).p_WoP_W;
    nodes.push_back(std::move(node));
  }
  return nodes;
}

}  // namespace

AncfPart::AncfPart(AncfBody body, std::vector<Station> stations)
    : AncfPart(std::move(body), std::move(stations), Matrix3d::Identity(), Vector3d::Zero()) {}

AncfPart::AncfPart(AncfBody body, std::vector<Station> stations, const Matrix3d& R, const Vector3d& origin)
    : FlexibleBody(body.total_mass(), nodes_of(body, stations, R, origin), free_mass(body)),
      body_(std::move(body)),
      stations_(std::move(stations)),
      R_(R),
      origin_(origin),
      n_node_(body_.node_coordinates()),
      n_first_(n_first_of(body_)) {
  const VectorXd still = VectorXd::Zero(body_.n_q());
  for (const Station& station : stations_) R_rest_.push_back(evaluate(station.at, body_.rest(), still).R_WS);
  weight_.setZero(body_.n_q() / body_.dim());
  const int n = body_.vectors();
  for (int k = 0; k < body_.n_elements(); ++k)
    weight_.segment(n * k, 2 * n) += body_.element(k).compact_weight();
}

void AncfPart::expand(const double* s, bool from_rest, VectorXd& q) const {
  if (from_rest)
    q = body_.rest();
  else
    q.setZero(body_.n_q());
  for (int i = 0; i < m(); ++i) q(coordinate(i)) += s[i];
}

// The nodal vectors as columns, in the axes of B.
void AncfPart::lift(const VectorXd& q, Eigen::Matrix3Xd& Q) const {
  const int dim = body_.dim();
  Q.noalias() = R_.leftCols(dim) * q.reshaped(dim, q.size() / dim);
}

MatrixXd AncfPart::in_plane(const Matrix3d& W) const {
  const auto E = R_.leftCols(body_.dim());
  return E.transpose() * W * E;
}

beam::ancf::PointKinematics AncfPart::evaluate(const beam::ancf::MaterialPoint& at, const VectorXd& q,
                                               const VectorXd& v) const {
  beam::ancf::PointKinematics point = beam::ancf::evaluate_point(body_, at, q, v);
  if (body_.dim() == 3) return point;
  point.p_WoP_W = (origin_ + R_ * point.p_WoP_W).eval();
  point.R_WS = (R_ * point.R_WS).eval();
  for (Vector3d* const x : {&point.v_WP_W, &point.w_WS_W, &point.w_bias_W}) *x = (R_ * *x).eval();
  point.J_v = (R_ * point.J_v).eval();
  point.J_w = (R_ * point.J_w).eval();
  return point;
}

std::optional<Vector3d> AncfPart::stiff_direction() const {
  if (body_.dim() == 3) return {};
  return R_.col(2);
}

std::unique_ptr<FlexibleBody::Scratch> AncfPart::make_scratch() const {
  return std::make_unique<Work>();
}

void AncfPart::set_position(const double* s, Scratch& scratch) const {
  Work& work = static_cast<Work&>(scratch);
  expand(s, true, work.q);
  work.f.setZero(work.q.size());
  body_.mass().multiply_add(1.0, work.q, work.f);
  lift(work.q, work.Q);
  lift(work.f, work.P);
  if (!origin_.isZero(0.0)) {  // of all positions; the shape functions of r sum up to 1
    for (Eigen::Index k = 0; k < work.Q.cols(); k += body_.vectors()) work.Q.col(k) += origin_;
    work.P += origin_ * weight_.transpose();
  }
  work.d.noalias() = work.Q * weight_;
  Matrix3d rho_rho;
  rho_rho.noalias() = work.Q * work.P.transpose();
  work.J = rho_rho.trace() * Matrix3d::Identity() - rho_rho;
  work.C_t.setZero(3, m());
  work.C_r.setZero(3, m());
  for (int i = 0; i < m(); ++i) {
    const int k = vector(coordinate(i));
    const Vector3d e = axis(coordinate(i));
    work.C_t.col(i) = weight_(k) * e;
    work.C_r.col(i) = Vector3d(work.P.col(k)).cross(e);
  }
}

// The coordinates' rates into work.v and P' into work.P_dot.
AncfPart::Rates AncfPart::take_rates(const double* s_dot, Work& work) const {
  expand(s_dot, false, work.v);
  work.f.setZero(work.v.size());
  body_.mass().multiply_add(1.0, work.v, work.f);
  lift(work.f, work.P_dot);
  Rates out;
  const int dim = body_.dim();
  out.d_dot = R_.leftCols(dim) * (work.v.reshaped(dim, work.v.size() / dim) * weight_);
  out.G.noalias() = work.Q * work.P_dot.transpose();
  return out;
}

Spatial AncfPart::inverse_dynamics(const double*, const double* s_dot, const double* s_ddot, const Spatial& V,
                                   const Spatial& A, Scratch& scratch, double* modal) const {
  Work& work = static_cast<Work&>(scratch);
  const Vector3d &w = V.angular, &alpha = A.angular, &a = A.linear, &d = work.d;
  // P'' in F, then the rest of the acceleration's share.
  expand(s_ddot, false, work.v);
  work.f.setZero(work.v.size());
  body_.mass().multiply_add(1.0, work.v, work.f);
  lift(work.f, work.F);
  const int dim = body_.dim();
  Vector3d torque = Vector3d::Zero();
  const Vector3d d_ddot = R_.leftCols(dim) * (work.v.reshaped(dim, work.v.size() / dim) * weight_);
  for (Eigen::Index i = 0; i < work.Q.cols(); ++i)
    torque += Vector3d(work.Q.col(i)).cross(Vector3d(work.F.col(i)));

  const auto [d_dot, G] = take_rates(s_dot, work);
  Spatial need;
  need.linear = mass() * a + alpha.cross(d) + w.cross(w.cross(d)) + 2.0 * w.cross(d_dot) + d_ddot;
  need.angular =
      d.cross(a) + work.J * alpha + w.cross(work.J * w) + 2.0 * (w * G.trace() - G.transpose() * w) + torque;
  for (Eigen::Index i = 0; i < weight_.size(); ++i) {
    const Vector3d P = work.P.col(i), Pd = work.P_dot.col(i);
    work.F.col(i) += weight_(i) * a + alpha.cross(P) + w.cross(w.cross(P)) + 2.0 * w.cross(Pd);
  }
  body_.force(work.q, &work.v, work.f);
  for (int i = 0; i < m(); ++i) {
    const int k = coordinate(i);
    modal[i] = axis(k).dot(work.F.col(vector(k))) + work.f(k);
  }
  return need;
}

double AncfPart::strain_energy(const double* s) const {
  VectorXd q;
  expand(s, true, q);
  return body_.strain_energy(q);
}

double AncfPart::largest_turn(const double* s) const {
  VectorXd q;
  expand(s, true, q);
  Eigen::Matrix3Xd Q;
  lift(q, Q);
  const int n = body_.vectors();
  double largest = 0.0;
  for (int k = 0; k < body_.n_elements(); ++k)
    for (int axis = n == 4 ? 2 : 1; axis < n; ++axis) {
      const Vector3d from = Q.col(n * k + axis), to = Q.col(n * (k + 1) + axis);
      largest = std::max(largest, std::atan2(from.cross(to).norm(), from.dot(to)));
    }
  return largest;
}

double AncfPart::dissipated_power(const double* s, const double* s_dot) const {
  VectorXd q, v;
  expand(s, true, q);
  expand(s_dot, false, v);
  return body_.dissipation(q, v);
}

Pose AncfPart::node_pose(int node, const double* s) const {
  VectorXd q;
  expand(s, true, q);
  const beam::ancf::PointKinematics point = evaluate(stations_[node].at, q, VectorXd::Zero(q.size()));
  return {point.R_WS * R_rest_[node].transpose(), point.p_WoP_W};
}

void AncfPart::node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                           NodeMotion& out) const {
  // Only the element's own coordinates matter; q is kept in the scratch.
  VectorXd& q = out.second;
  VectorXd& v = out.rates;
  expand(s, true, q);
  if (s_dot)
    expand(s_dot, false, v);
  else
    v.setZero(q.size());
  const beam::ancf::PointKinematics point = evaluate(stations_[node].at, q, v);
  out.X_BN = {point.R_WS * R_rest_[node].transpose(), point.p_WoP_W};
  out.map.setZero();
  for (Eigen::Index j = 0; j < point.J_v.cols(); ++j) {
    const int i = free_of(point.first + static_cast<int>(j));
    if (i < 0) continue;
    out.map.col(i).head<3>() = point.J_w.col(j);
    out.map.col(i).tail<3>() = point.J_v.col(j);
  }
  if (!s_dot) return;
  out.V = {point.w_WS_W, point.v_WP_W};
  if (!s_ddot) return;
  Vector6d A;
  A.noalias() = out.map * Eigen::Map<const VectorXd>(s_ddot, m());
  A.head<3>() += point.w_bias_W;
  out.A = Spatial::from(A);
}

void AncfPart::turning_tangents(const double*, const double* s_dot, const Vector3d& w, Scratch& scratch,
                                Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const {
  Work& work = static_cast<Work&>(scratch);
  const auto [d_dot, G] = take_rates(s_dot, work);
  need_w.topRows<3>() =
      skew(w) * work.J - skew(work.J * w) + 2.0 * (G.trace() * Matrix3d::Identity() - G.transpose());
  need_w.bottomRows<3>() = -skew(w.cross(work.d) + 2.0 * d_dot) - skew(w) * skew(work.d);
  for (int i = 0; i < m(); ++i) {
    const int k = vector(coordinate(i));
    const Vector3d P = work.P.col(k), Pd = work.P_dot.col(k);
    const Matrix3d by_w = -skew(w.cross(P) + 2.0 * Pd) - skew(w) * skew(P);
    modal_w.row(i) = axis(coordinate(i)).transpose() * by_w;
  }
}

// Of the terms of inverse_dynamics(), s_l moving vector k along c: Q_k changes by e_c, and P_j by m_jk e_c; s'_l and
// s''_l change P'_j and P''_j alike.
void AncfPart::deformation_tangents(const double* s, const double* s_dot, const double* s_ddot,
                                    const Spatial& V, const Spatial& A, Scratch& scratch,
                                    DeformationTangents& out) const {
  Work& work = static_cast<Work&>(scratch);
  const Vector3d &w = V.angular, &alpha = A.angular, &a = A.linear;
  out.modal_s.setZero();
  out.modal_v.setZero();
  add_tangents(s, s_dot, out.modal_s, out.modal_v);
  const Matrix3d turning = skew(alpha) + skew(w) * skew(w);
  if (!turning.isZero(0.0)) add_free(body_.mass_times(in_plane(turning)), out.modal_s);
  if (!w.isZero(0.0)) add_free(body_.mass_times(in_plane(2.0 * skew(w))), out.modal_v);

  expand(s_ddot, false, work.v);
  work.f.setZero(work.v.size());
  body_.mass().multiply_add(1.0, work.v, work.f);
  lift(work.f, work.F);
  take_rates(s_dot, work);
  for (int l = 0; l < m(); ++l) {
    const int k = vector(coordinate(l));
    const Vector3d e = axis(coordinate(l)), C_t = weight_(k) * e, P = work.P.col(k), Pd = work.P_dot.col(k),
                   Pdd = work.F.col(k);
    Spatial by_s, by_v;
    by_s.linear = alpha.cross(C_t) + w.cross(w.cross(C_t));
    by_v.linear = 2.0 * w.cross(C_t);
    const auto turned = [&](const Vector3d& x) -> Vector3d {  // dJ x
      return 2.0 * P.dot(e) * x - e * P.dot(x) - P * x.dot(e);
    };
    by_s.angular = C_t.cross(a) + turned(alpha) + w.cross(turned(w)) + 2.0 * (w * Pd.dot(e) - Pd * w.dot(e)) +
                   e.cross(Pdd);
    by_v.angular = 2.0 * (w * P.dot(e) - e * P.dot(w));
    out.need_s.col(l) = by_s.vector();
    out.need_v.col(l) = by_v.vector();
  }
}

std::pair<int, int> AncfPart::coordinates_of(int node) const {
  const int first = stations_[node].at.element * n_node_, fixed = n_node_ - n_first_;
  return {first == 0 ? 0 : first - fixed, first + 2 * n_node_ - fixed};
}

int AncfPart::free_of(int coordinate) const {
  if (coordinate >= n_node_) return coordinate - n_node_ + n_first_;
  const int i = coordinate - body_.dim();
  return i >= 0 && i < n_first_ ? i : -1;
}

// Without the rows and columns that B fixes.
void AncfPart::add_free(const beam::ancf::BlockTridiagonal& from, MatrixRef to) const {
  for (int a = 0; a < body_.n_nodes(); ++a)
    for (int b = std::max(a - 1, 0); b < std::min(a + 2, body_.n_nodes()); ++b) {
      const auto block = from.block(a, b);
      for (int k = 0; k < n_node_; ++k)
        for (int h = 0; h < n_node_; ++h)
          if (const int i = free_of(n_node_ * a + k), j = free_of(n_node_ * b + h); i >= 0 && j >= 0)
            to(i, j) += block(k, h);
    }
}

void AncfPart::add_tangents(const double* s, const double* s_dot, MatrixRef K, MatrixRef D) const {
  VectorXd q, v, f(body_.n_q());
  expand(s, true, q);
  expand(s_dot, false, v);
  beam::ancf::BlockTridiagonal dK(body_.n_nodes(), n_node_), dD(body_.n_nodes(), n_node_);
  AncfBody::Scratch scratch = body_.make_scratch();
  body_.force_and_tangents(q, &v, scratch, f, dK, dD);
  add_free(dK, K);
  add_free(dD, D);
}

std::shared_ptr<const AncfPart> straight_ancf_part(
    const beam::ancf::BeamSection& section, const Vector3d& from_B, const Vector3d& to_B,
    const Vector3d& y_axis_B, int elements, const std::vector<std::pair<std::string, double>>& stations) {
  AncfBody body =
      beam::ancf::spatial_beam(section, beam::ancf::straight_curve(from_B, to_B, elements, y_axis_B));
  std::vector<AncfPart::Station> all = {{"root", body.locate(0.0)}, {"tip", body.locate(body.length())}};
  for (const auto& [name, s] : stations) all.push_back({name, body.locate(s)});
  return std::make_shared<AncfPart>(std::move(body), std::move(all));
}

std::shared_ptr<const AncfPart> planar_ancf_part(
    const beam::ancf::LineSection& section, const Vector3d& from_B, const Matrix3d& R_BE, double length,
    int elements, const std::vector<std::pair<std::string, double>>& stations) {
  AncfBody body = beam::ancf::planar_line(
      section, beam::ancf::straight_curve(Vector3d::Zero(), length * Vector3d::UnitX(), elements));
  std::vector<AncfPart::Station> all = {{"root", body.locate(0.0)}, {"tip", body.locate(body.length())}};
  for (const auto& [name, s] : stations) all.push_back({name, body.locate(s)});
  return std::make_shared<AncfPart>(std::move(body), std::move(all), R_BE, from_B);
}

}  // namespace flexura::mbs
