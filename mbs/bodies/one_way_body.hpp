// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/bodies/modal_body.hpp"

namespace flexura::mbs {

/// One-way deformation (kineto-elastodynamics): the mechanism moves with the body rigid, and the deformation answers to
/// that motion,
///
///     s'' = -( D s' + K s + C_t^T (a - g) + C_r^T alpha + centrifugal and Coriolis terms - Phi^T F ),
///
/// F all loads on the body's nodes, joint reactions of the rigid motion included.  It is right as long as the deformation
/// does not change the motion.
class OneWayBody final : public FlexibleBody {
 public:
  /// Modes normalised to mass.
  explicit OneWayBody(ModalData data) : OneWayBody(ModalBody(std::move(data))) {}
  explicit OneWayBody(ModalBody body)
      : FlexibleBody(body.mass(), body.nodes(), body.M_e()), body_(std::move(body)) {}

  std::vector<LawError> error_sources() const override {
    return {{"modes", "a run of its superelement, added as a part, tells"}};
  }
  bool acts_back() const override { return false; }
  bool is_linear() const override { return true; }
  bool has_geometric_stiffness() const override { return body_.has_geometric_stiffness(); }
  const ModalData* modal() const override { return body_.modal(); }
  Spring spring(int i) const override { return body_.spring(i); }
  double amplitude(int i) const override { return body_.amplitude(i); }
  RigidInertia undeformed_inertia() const override { return body_.undeformed_inertia(); }

  std::unique_ptr<Scratch> make_scratch() const override { return body_.make_scratch(); }
  void set_position(const double* s, Scratch& scratch) const override { body_.set_position(s, scratch); }
  Spatial inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                           const Spatial& A, Scratch& scratch, double* need) const override {
    return body_.inverse_dynamics(s, s_dot, s_ddot, V, A, scratch, need);
  }
  double strain_energy(const double* s) const override { return body_.strain_energy(s); }
  double dissipated_power(const double* s, const double* s_dot) const override {
    return body_.dissipated_power(s, s_dot);
  }
  Pose node_pose(int node, const double* s) const override { return body_.node_pose(node, s); }
  void node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                   NodeMotion& out) const override {
    body_.node_motion(node, s, s_dot, s_ddot, out);
  }
  void deformation_tangents(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                            const Spatial& A, Scratch& scratch, DeformationTangents& out) const override {
    body_.deformation_tangents(s, s_dot, s_ddot, V, A, scratch, out);
  }
  void add_tangents(const double*, const double*, MatrixRef, MatrixRef) const override {}

 private:
  ModalBody body_;
};

}  // namespace flexura::mbs
