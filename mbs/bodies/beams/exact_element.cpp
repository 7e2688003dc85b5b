// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/beams/exact_element.hpp"

namespace flexura::mbs {
namespace {

using beam::exact::Element;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using ConstMap = Eigen::Map<const VectorXd>;

MatrixXd mass_at_rest(const Element& element) {
  Element::Integrals at;
  element.integrate(VectorXd(VectorXd::Zero(element.n())).data(), at);
  return at.M;
}

Element::Motion at_rest(const Element& element, double x) {
  return element.motion(element.place(x), VectorXd(VectorXd::Zero(element.n())).data(), nullptr, nullptr);
}

std::vector<NodePlace> places_of(const Element& element, const Pose& start,
                                 const std::vector<ExactElement::Station>& stations) {
  std::vector<NodePlace> out;
  for (const auto& [name, x] : stations) out.push_back({name, start * at_rest(element, x).p});
  return out;
}

// Angular and linear columns, turned.
template <class Columns>
void turn(const Matrix3d& R, Columns& x) {
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const Vector3d w = R * x.col(j).template head<3>(), v = R * x.col(j).template tail<3>();
    x.col(j) << w, v;
  }
}

}  // namespace

struct ExactElement::Work final : Scratch {
  Element::Integrals integrals;
  Element::InertiaTangents inertia;
};

ExactElement::ExactElement(Element element, const Pose& start, double damping_time,
                           const std::vector<Station>& stations)
    : FlexibleBody(element.mass(), places_of(element, start, stations), mass_at_rest(element)),
      element_(std::move(element)),
      start_(start),
      damping_time_(damping_time) {
  for (const Station& station : stations) {
    places_.push_back(element_.place(station.x));
    R_rest_.push_back(start_.R * at_rest(element_, station.x).R);
  }
}

std::unique_ptr<FlexibleBody::Scratch> ExactElement::make_scratch() const {
  auto work = std::make_unique<Work>();
  work->C_t.setZero(3, m());
  work->C_r.setZero(3, m());
  work->integrals.M = M_e();
  return work;
}

void ExactElement::set_position(const double* s, Scratch& scratch) const {
  Work& work = static_cast<Work&>(scratch);
  Element::Integrals& at = work.integrals;
  element_.integrate(s, at);
  const Matrix3d& R = start_.R;
  const Vector3d &p = start_.p, d = R * at.d;
  // About Bo instead of the start.
  work.d = mass() * p + d;
  work.J = R * at.J * R.transpose() + (mass() * p.squaredNorm() + 2.0 * p.dot(d)) * Matrix3d::Identity() -
           mass() * p * p.transpose() - p * d.transpose() - d * p.transpose();
  work.C_t.noalias() = R * at.C_t;
  work.C_r.noalias() = R * at.C_r;
  work.C_r.noalias() += skew(p) * work.C_t;
}

const MatrixXd& ExactElement::M_e(const Scratch& scratch) const {
  return static_cast<const Work&>(scratch).integrals.M;
}

Element::Carried ExactElement::carried(const Spatial& V, const Spatial& A) const {
  const Vector3d &w = V.angular, &alpha = A.angular, &p = start_.p;
  const auto to_start = start_.R.transpose();
  return {to_start * w, to_start * alpha, to_start * (A.linear + alpha.cross(p) + w.cross(w.cross(p)))};
}

Spatial ExactElement::wrench(const Vector6d& at_start) const {
  const Vector3d force = start_.R * at_start.tail<3>();
  return {start_.R * at_start.head<3>() + start_.p.cross(force), force};
}

Spatial ExactElement::inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot,
                                       const Spatial& V, const Spatial& A, Scratch&, double* need) const {
  const Spatial out = wrench(element_.inertia_force(s, s_dot, s_ddot, carried(V, A), need));
  const MatrixXd& K = element_.stiffness();
  for (int j = 0; j < m(); ++j) {
    const double strain = s[j] + damping_time_ * s_dot[j];
    for (int i = 0; i < m(); ++i) need[i] += K(i, j) * strain;
  }
  return out;
}

double ExactElement::strain_energy(const double* s) const {
  const ConstMap x(s, m());
  return 0.5 * x.dot(element_.stiffness() * x);
}

double ExactElement::dissipated_power(const double*, const double* s_dot) const {
  const ConstMap x(s_dot, m());
  return damping_time_ * x.dot(element_.stiffness() * x);
}

Pose ExactElement::node_pose(int node, const double* s) const {
  const auto i = static_cast<std::size_t>(node);
  const Element::Motion at = element_.motion(places_[i], s, nullptr, nullptr);
  return {start_.R * at.R * R_rest_[i].transpose(), start_ * at.p};
}

void ExactElement::node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                               NodeMotion& out) const {
  const auto i = static_cast<std::size_t>(node);
  Element::Motion at;
  element_.motion_and_map(places_[i], s, s_dot, s_dot ? s_ddot : nullptr, at, out.map);
  out.X_BN = {start_.R * at.R * R_rest_[i].transpose(), start_ * at.p};
  turn(start_.R, out.map);
  if (s_dot) out.V = start_.R * Spatial::from(at.V);
  if (s_dot && s_ddot) out.A = start_.R * Spatial::from(at.A);
}

void ExactElement::turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch&,
                                    Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const {
  // By w at the start, and by the start's acceleration w x (w x p).
  const Matrix3d& R = start_.R;
  const Vector3d& p = start_.p;
  Eigen::Matrix<double, 6, 3> by_w;
  element_.turning_tangents(s, s_dot, R.transpose() * w, by_w, modal_w);
  turn(R, by_w);
  Element::Integrals at;
  element_.integrate(s, at);
  const Matrix3d p_w = -(skew(w.cross(p)) + skew(w) * skew(p));  // of w x (w x p) by w
  const Matrix3d force = by_w.bottomRows<3>() * R.transpose() + mass() * p_w;
  need_w.bottomRows<3>() = force;
  need_w.topRows<3>() = by_w.topRows<3>() * R.transpose() + skew(R * at.d) * p_w + skew(p) * force;
  modal_w = (modal_w * R.transpose() + at.C_t.transpose() * R.transpose() * p_w).eval();
}

void ExactElement::deformation_tangents(const double* s, const double* s_dot, const double* s_ddot,
                                        const Spatial& V, const Spatial& A, Scratch& scratch,
                                        DeformationTangents& out) const {
  Element::InertiaTangents& at = static_cast<Work&>(scratch).inertia;
  element_.inertia_tangents(s, s_dot, s_ddot, carried(V, A), at);
  const auto take = [&](const Element::Columns& from, DeformationTangents::Columns& to) {
    to.bottomRows<3>().noalias() = start_.R * from.bottomRows<3>();
    to.topRows<3>().noalias() = start_.R * from.topRows<3>();
    to.topRows<3>().noalias() += skew(start_.p) * to.bottomRows<3>();
  };
  take(at.wrench_s, out.need_s);
  take(at.wrench_v, out.need_v);
  out.modal_s = at.need_s;
  out.modal_v = at.need_v;
  add_tangents(s, s_dot, out.modal_s, out.modal_v);
}

void ExactElement::node_tangents(int node, const double* s, const double* s_dot, const double* s_ddot,
                                 const Vector6d& wrench, DeformationTangents& out) const {
  const auto i = static_cast<std::size_t>(node);
  Vector6d at_start;
  at_start << start_.R.transpose() * wrench.head<3>(), start_.R.transpose() * wrench.tail<3>();
  Element::MotionTangents at;
  element_.motion_tangents(places_[i], s, s_dot, s_ddot, at_start, at);
  for (auto* x : {&at.V_s, &at.A_s, &at.A_v}) turn(start_.R, *x);
  out.motion_s = at.V_s;
  out.acceleration_s = at.A_s;
  out.acceleration_v = at.A_v;
  out.map_s = at.map_s;
}

void ExactElement::add_tangents(const double*, const double*, MatrixRef K, MatrixRef D) const {
  K += element_.stiffness();
  D += damping_time_ * element_.stiffness();
}

}  // namespace flexura::mbs
