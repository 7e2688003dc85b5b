// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/beams/exact_element.hpp"

#include "mbs/bodies/beams/carried_start.hpp"

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
  element_.integrate(s, work.integrals);
  take_about_origin(work.integrals, mass(), start_, work);
}

const MatrixXd& ExactElement::M_e(const Scratch& scratch) const {
  return static_cast<const Work&>(scratch).integrals.M;
}

Spatial ExactElement::inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot,
                                       const Spatial& V, const Spatial& A, Scratch&, double* need) const {
  const Spatial out = wrench_about_origin(
      element_.inertia_force(s, s_dot, s_ddot, carried_start(V, A, start_), need), start_);
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
  turn_columns(start_.R, out.map);
  if (s_dot) out.V = start_.R * Spatial::from(at.V);
  if (s_dot && s_ddot) out.A = start_.R * Spatial::from(at.A);
}

void ExactElement::turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch&,
                                    Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const {
  Eigen::Matrix<double, 6, 3> by_w;
  element_.turning_tangents(s, s_dot, start_.R.transpose() * w, by_w, modal_w);
  Element::Integrals at;
  element_.integrate(s, at);
  turning_about_origin(at, mass(), start_, w, by_w, need_w, modal_w);
}

void ExactElement::deformation_tangents(const double* s, const double* s_dot, const double* s_ddot,
                                        const Spatial& V, const Spatial& A, Scratch& scratch,
                                        DeformationTangents& out) const {
  Element::InertiaTangents& at = static_cast<Work&>(scratch).inertia;
  element_.inertia_tangents(s, s_dot, s_ddot, carried_start(V, A, start_), at);
  columns_about_origin(at.wrench_s, start_, out.need_s);
  columns_about_origin(at.wrench_v, start_, out.need_v);
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
  for (auto* x : {&at.V_s, &at.A_s, &at.A_v}) turn_columns(start_.R, *x);
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
