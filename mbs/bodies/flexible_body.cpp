// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/flexible_body.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/base/math/differences.hpp"

namespace flexura::mbs {
namespace {

using ConstMap = Eigen::Map<const Eigen::VectorXd>;
using Eigen::VectorXd;

}  // namespace

FlexibleBody::FlexibleBody(double mass, std::vector<NodePlace> nodes, Eigen::MatrixXd M_e)
    : mass_(mass), nodes_(std::move(nodes)), M_e_(std::move(M_e)) {}

int FlexibleBody::find_node(const std::string& name) const {
  const auto found = std::ranges::find(nodes_, name, &NodePlace::name);
  return found == nodes_.end() ? -1 : static_cast<int>(found - nodes_.begin());
}

double FlexibleBody::amplitude(int i) const {
  NodeMotion motion = make_node_motion();
  const VectorXd rest = VectorXd::Zero(m());
  double largest = 1.0 / std::sqrt(mass());
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    node_motion(static_cast<int>(node), rest.data(), nullptr, nullptr, motion);
    largest = std::max(largest, motion.map.col(i).tail<3>().norm());
  }
  return largest;
}

RigidInertia FlexibleBody::undeformed_inertia() const {
  const auto scratch = make_scratch();
  set_position(VectorXd(VectorXd::Zero(m())).data(), *scratch);
  return {mass(), scratch->d, scratch->J};
}

std::unique_ptr<FlexibleBody::Scratch> FlexibleBody::make_scratch() const {
  auto scratch = std::make_unique<Scratch>();
  scratch->C_t.setZero(3, m());
  scratch->C_r.setZero(3, m());
  return scratch;
}

double FlexibleBody::kinetic_energy(const double* s_dot_values, const Spatial& V,
                                    const Scratch& scratch) const {
  const ConstMap s_dot(s_dot_values, m());
  const Vector3d &w = V.angular, &v = V.linear;
  const Vector3d C_t_s_dot = scratch.C_t * s_dot, C_r_s_dot = scratch.C_r * s_dot;
  double modal = 0.0;
  const Eigen::MatrixXd& M = M_e(scratch);
  for (int j = 0; j < m(); ++j) modal += s_dot(j) * M.col(j).dot(s_dot);
  return 0.5 * mass() * v.squaredNorm() + v.dot(w.cross(scratch.d)) + 0.5 * w.dot(scratch.J * w) +
         v.dot(C_t_s_dot) + w.dot(C_r_s_dot) + 0.5 * modal;
}

Pose FlexibleBody::node_pose(int node, const double* s) const {
  NodeMotion motion = make_node_motion();
  node_motion(node, s, nullptr, nullptr, motion);
  return motion.X_BN;
}

NodeMotion FlexibleBody::make_node_motion() const {
  NodeMotion out;
  out.map.setZero(6, m());
  out.second.setZero(6 * m());
  out.rates.setZero(8 * m());
  return out;
}

DeformationTangents FlexibleBody::make_deformation_tangents() const {
  DeformationTangents out;
  for (auto* x : {&out.need_s, &out.need_v, &out.motion_s, &out.acceleration_s, &out.acceleration_v})
    x->setZero(6, m());
  for (auto* x : {&out.modal_s, &out.modal_v, &out.map_s}) x->setZero(m(), m());
  out.moved_s.setZero(m());
  out.moved_v.setZero(m());
  out.modal.setZero(m());
  out.scratch = make_scratch();
  out.node = make_node_motion();
  out.T_v.setZero(9 * m());
  out.turn.setZero(3 * m());
  return out;
}

void FlexibleBody::turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch& scratch,
                                    Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const {
  // The terms with w alone: quadratic in it, so that differences are exact at any step.
  const VectorXd still = VectorXd::Zero(m());
  VectorXd need(m());
  need_w.setZero();
  modal_w.setZero();
  const double h = std::max(1.0, w.norm());
  for (int i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0}) {
      const Spatial V{w + sign * h * Vector3d::Unit(i), Vector3d::Zero()};
      const Spatial f = inverse_dynamics(s, s_dot, still.data(), V, {}, scratch, need.data());
      need_w.col(i) += sign / (2.0 * h) * f.vector();
      modal_w.col(i) += sign / (2.0 * h) * need;
    }
}

void FlexibleBody::deformation_tangents(const double* s, const double* s_dot, const double* s_ddot,
                                        const Spatial& V, const Spatial& A, Scratch&,
                                        DeformationTangents& out) const {
  out.moved_s = ConstMap(s, m());
  out.moved_v = ConstMap(s_dot, m());
  const auto along = [&](VectorXd& x, int l, DeformationTangents::Columns& need, Eigen::MatrixXd& modal) {
    const double x_l = x(l);
    need.col(l).setZero();
    modal.col(l).setZero();
    for (const double sign : {1.0, -1.0}) {
      x(l) = x_l + sign * kCentralStep;
      set_position(out.moved_s.data(), *out.scratch);
      const Spatial f = inverse_dynamics(out.moved_s.data(), out.moved_v.data(), s_ddot, V, A, *out.scratch,
                                         out.modal.data());
      need.col(l) += sign / (2.0 * kCentralStep) * f.vector();
      modal.col(l) += sign / (2.0 * kCentralStep) * out.modal;
    }
    x(l) = x_l;
  };
  for (int l = 0; l < m(); ++l) {
    along(out.moved_s, l, out.need_s, out.modal_s);
    along(out.moved_v, l, out.need_v, out.modal_v);
  }
}

void FlexibleBody::node_tangents(int node, const double* s, const double* s_dot, const double* s_ddot,
                                 const Vector6d& wrench, DeformationTangents& out) const {
  out.moved_s = ConstMap(s, m());
  out.moved_v = ConstMap(s_dot, m());
  for (auto* x : {&out.motion_s, &out.acceleration_s, &out.acceleration_v}) x->setZero();
  out.map_s.setZero();
  const auto [first, end] = coordinates_of(node);
  for (int l = first; l < end; ++l) {
    for (const double sign : {1.0, -1.0}) {
      const double factor = sign / (2.0 * kCentralStep);
      out.moved_s(l) = s[l] + sign * kCentralStep;
      node_motion(node, out.moved_s.data(), s_dot, s_ddot, out.node);
      out.motion_s.col(l) += factor * out.node.V.vector();
      out.acceleration_s.col(l) += factor * out.node.A.vector();
      out.map_s.col(l).noalias() += factor * out.node.map.transpose() * wrench;
      out.moved_s(l) = s[l];
      out.moved_v(l) = s_dot[l] + sign * kCentralStep;
      node_motion(node, s, out.moved_v.data(), s_ddot, out.node);
      out.acceleration_v.col(l) += factor * out.node.A.vector();
      out.moved_v(l) = s_dot[l];
    }
  }
}

void FlexibleBody::add_tangents(const double* s, const double* s_dot, MatrixRef K, MatrixRef D) const {
  // At rest but for s': inertia has its share of s'^2 only where rho is not linear in s.
  DeformationTangents at = make_deformation_tangents();
  const VectorXd still = VectorXd::Zero(m());
  FlexibleBody::deformation_tangents(s, s_dot, still.data(), {}, {}, *at.scratch, at);
  K += at.modal_s;
  D += at.modal_v;
  for (int i = 0; i < m(); ++i) {
    const Spring own = spring(i);
    K(i, i) -= own.stiffness;
    D(i, i) -= own.damping;
  }
}

}  // namespace flexura::mbs
