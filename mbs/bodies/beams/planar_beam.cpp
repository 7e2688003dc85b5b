// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/beams/planar_beam.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/base/math/rotation.hpp"
#include "mbs/bodies/beams/carried_start.hpp"

namespace flexura::mbs {
namespace {

using beam::exact::Element;
using beam::exact::PlanarChain;
using beam::exact::Vec2;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd at_rest(const PlanarChain& chain) {
  return VectorXd::Zero(chain.n());
}

Element::Motion rest_motion(const PlanarChain& chain, const PlanarChain::Place& place) {
  PlanarChain::Pass pass = chain.make_pass();
  const VectorXd s = at_rest(chain);
  chain.move(s.data(), nullptr, nullptr, pass);
  return chain.motion(place, s.data(), nullptr, nullptr, pass);
}

MatrixXd mass_at_rest(const PlanarChain& chain) {
  PlanarChain::Pass pass = chain.make_pass();
  chain.move(at_rest(chain).data(), nullptr, nullptr, pass);
  Element::Integrals at;
  chain.integrate(pass, at);
  return at.M;
}

std::vector<NodePlace> places_of(const PlanarChain& chain, const Pose& start,
                                 const std::vector<PlanarBeam::Station>& stations) {
  std::vector<NodePlace> out;
  for (const auto& [name, element, x] : stations)
    out.push_back({name, start * rest_motion(chain, chain.place(element, x)).p});
  return out;
}

// Of one element.
std::vector<FlexibleBody::Alone> alone_in(const PlanarChain& element) {
  PlanarChain::Pass pass = element.make_pass();
  element.move(at_rest(element).data(), nullptr, nullptr, pass);
  Element::Integrals at;
  element.integrate(pass, at);
  PlanarChain::Columns map;
  element.map(element.place(0, element.length()), pass.ends.back().r, pass, map);
  std::vector<FlexibleBody::Alone> out;
  for (int j = 0; j < element.n(); ++j) {
    const double moved = map.col(j).tail<3>().norm(), turned = element.length() * map.col(j).head<3>().norm();
    const double reach = std::max(moved, turned), mass = at.M(j, j);
    // What does nothing at the end counts by what it does on the average.
    out.push_back({reach > 1e-12 * element.length() ? reach : std::sqrt(mass / element.mass()), mass});
  }
  return out;
}

Vec2 in_plane(const Vector3d& a) {
  return {a.x(), a.y()};
}

}  // namespace

struct PlanarBeam::Work final : Scratch {
  PlanarChain::Pass pass;
  Element::Integrals integrals;
  Element::InertiaTangents inertia;
};

PlanarBeam::PlanarBeam(PlanarChain chain, const Pose& start, double damping_time,
                       const std::vector<Station>& stations)
    : FlexibleBody(chain.mass(), places_of(chain, start, stations), mass_at_rest(chain)),
      chain_(std::move(chain)),
      start_(start),
      damping_time_(damping_time),
      alone_(alone_in(chain_.one_element())) {
  for (const Station& station : stations) {
    places_.push_back(chain_.place(station.element, station.x));
    R_rest_.push_back(start_.R * rest_motion(chain_, places_.back()).R);
  }
}

std::unique_ptr<FlexibleBody::Scratch> PlanarBeam::make_scratch() const {
  auto work = std::make_unique<Work>();
  work->C_t.setZero(3, m());
  work->C_r.setZero(3, m());
  work->pass = chain_.make_pass();
  work->integrals.M = M_e();
  return work;
}

void PlanarBeam::set_position(const double* s, Scratch& scratch) const {
  Work& work = static_cast<Work&>(scratch);
  chain_.move(s, nullptr, nullptr, work.pass);
  chain_.integrate(work.pass, work.integrals);
  take_about_origin(work.integrals, mass(), start_, work);
}

const MatrixXd& PlanarBeam::M_e(const Scratch& scratch) const {
  return static_cast<const Work&>(scratch).integrals.M;
}

Spatial PlanarBeam::inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot,
                                     const Spatial& V, const Spatial& A, Scratch& scratch,
                                     double* need) const {
  Work& work = static_cast<Work&>(scratch);
  chain_.move(s, s_dot, s_ddot, work.pass);
  const Spatial out =
      wrench_about_origin(chain_.inertia_force(work.pass, carried_start(V, A, start_), need), start_);
  const MatrixXd& K = chain_.stiffness();
  const auto n = static_cast<int>(K.cols());
  for (int first = 0; first < m(); first += n)
    for (int j = 0; j < n; ++j) {
      const double strain = s[first + j] + damping_time_ * s_dot[first + j];
      for (int i = 0; i < n; ++i) need[first + i] += K(i, j) * strain;
    }
  return out;
}

double PlanarBeam::product(const double* a, const double* b) const {
  const MatrixXd& K = chain_.stiffness();
  const auto n = static_cast<int>(K.cols());
  double sum = 0.0;
  for (int first = 0; first < m(); first += n)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) sum += a[first + i] * K(i, j) * b[first + j];
  return sum;
}

double PlanarBeam::strain_energy(const double* s) const {
  return 0.5 * product(s, s);
}

double PlanarBeam::dissipated_power(const double*, const double* s_dot) const {
  return damping_time_ * product(s_dot, s_dot);
}

Pose PlanarBeam::node_pose(int node, const double* s) const {
  const auto i = static_cast<std::size_t>(node);
  PlanarChain::Pass pass = chain_.make_pass();
  chain_.move(s, nullptr, nullptr, pass, places_[i].element + 1);
  const Element::Motion at = chain_.motion(places_[i], s, nullptr, nullptr, pass);
  return {start_.R * at.R * R_rest_[i].transpose(), start_ * at.p};
}

std::vector<Pose> PlanarBeam::chords(const double* s) const {
  PlanarChain::Pass pass = chain_.make_pass();
  chain_.move(s, nullptr, nullptr, pass);
  std::vector<Pose> out;
  for (std::size_t k = 0; k + 1 < pass.ends.size(); ++k) {
    const Vec2 &r = pass.ends[k].r, along = pass.ends[k + 1].r - r;
    Matrix3d R = rotation_exp(std::atan2(along.y, along.x) * Vector3d::UnitZ());
    out.push_back(start_ * Pose{R, {r.x, r.y, 0.0}});
  }
  return out;
}

void PlanarBeam::node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                             NodeMotion& out) const {
  const auto i = static_cast<std::size_t>(node);
  if (!s_dot) s_ddot = nullptr;
  thread_local PlanarChain::Pass pass;
  const auto n = static_cast<std::size_t>(chain_.elements());
  pass.points.resize(PlanarChain::kPoints * n);
  pass.ends.resize(n + 1);
  chain_.move(s, s_dot, s_ddot, pass, places_[i].element + 1);
  const Element::Motion at = chain_.motion(places_[i], s, s_dot, s_ddot, pass);
  chain_.map(places_[i], in_plane(at.p), pass, out.map);
  out.X_BN = {start_.R * at.R * R_rest_[i].transpose(), start_ * at.p};
  turn_columns(start_.R, out.map);
  if (s_dot) out.V = start_.R * Spatial::from(at.V);
  if (s_ddot) out.A = start_.R * Spatial::from(at.A);
}

void PlanarBeam::turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch& scratch,
                                  Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const {
  Work& work = static_cast<Work&>(scratch);
  const Vector3d w_start = start_.R.transpose() * w;
  if (!chain_.stays_in_plane({w_start, Vector3d::Zero(), Vector3d::Zero()})) {
    FlexibleBody::turning_tangents(s, s_dot, w, scratch, need_w, modal_w);
    return;
  }
  chain_.move(s, s_dot, nullptr, work.pass);
  Eigen::Matrix<double, 6, 3> by_w;
  chain_.turning_tangents(work.pass, w_start, by_w, modal_w);
  chain_.integrate(work.pass, work.integrals);
  turning_about_origin(work.integrals, mass(), start_, w, by_w, need_w, modal_w);
}

void PlanarBeam::deformation_tangents(const double* s, const double* s_dot, const double* s_ddot,
                                      const Spatial& V, const Spatial& A, Scratch& scratch,
                                      DeformationTangents& out) const {
  const Element::Carried start = carried_start(V, A, start_);
  if (!chain_.stays_in_plane(start)) {
    FlexibleBody::deformation_tangents(s, s_dot, s_ddot, V, A, scratch, out);
    return;
  }
  Work& work = static_cast<Work&>(scratch);
  chain_.move(s, s_dot, s_ddot, work.pass);
  chain_.inertia_tangents(work.pass, start, work.inertia);
  columns_about_origin(work.inertia.wrench_s, start_, out.need_s);
  columns_about_origin(work.inertia.wrench_v, start_, out.need_v);
  out.modal_s = work.inertia.need_s;
  out.modal_v = work.inertia.need_v;
  add_tangents(s, s_dot, out.modal_s, out.modal_v);
}

void PlanarBeam::node_tangents(int node, const double* s, const double* s_dot, const double* s_ddot,
                               const Vector6d& wrench, DeformationTangents& out) const {
  const auto i = static_cast<std::size_t>(node);
  Vector6d at_start;
  at_start << start_.R.transpose() * wrench.head<3>(), start_.R.transpose() * wrench.tail<3>();
  PlanarChain::Pass pass = chain_.make_pass();
  chain_.move(s, s_dot, s_ddot, pass, places_[i].element + 1);
  const Element::Motion moves = chain_.motion(places_[i], s, s_dot, s_ddot, pass);
  Element::MotionTangents at;
  chain_.motion_tangents(places_[i], in_plane(moves.p), in_plane(moves.V.tail<3>()),
                         in_plane(moves.A.tail<3>()), at_start, pass, at);
  for (auto* x : {&at.V_s, &at.A_s, &at.A_v}) turn_columns(start_.R, *x);
  out.motion_s = at.V_s;
  out.acceleration_s = at.A_s;
  out.acceleration_v = at.A_v;
  out.map_s = at.map_s;
}

void PlanarBeam::add_tangents(const double*, const double*, MatrixRef K, MatrixRef D) const {
  const MatrixXd& K_e = chain_.stiffness();
  const Eigen::Index n = K_e.cols();
  for (Eigen::Index first = 0; first < m(); first += n) {
    K.block(first, first, n, n) += K_e;
    D.block(first, first, n, n) += damping_time_ * K_e;
  }
}

}  // namespace flexura::mbs
