// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/exact/element.hpp"
#include "mbs/bodies/flexible_body.hpp"

/// An element of a geometrically exact beam (beam/exact/element.hpp) as a body of a mechanism.
///
/// A beam is a chain of them, each welded with its start to the end of the one before: the tree of joints joins their
/// motions, so that poses, forces and factors of the mass matrix cost O(elements).  B is fixed to the section at the
/// start; s are the coordinates of the strains.
namespace flexura::mbs {

class ExactElement final : public FlexibleBody {
 public:
  struct Station {
    std::string name;
    double x = 0.0;  ///< from the start, along the unstrained axis [m]
  };

  /// `start` is the section's place and axes (x along the beam) in B; `damping_time` as in D = damping_time K.
  ExactElement(beam::exact::Element element, const Pose& start, double damping_time,
               const std::vector<Station>& stations);

  std::vector<LawError> error_sources() const override {
    return {{"elements", "a run with twice as many tells"}};
  }
  std::unique_ptr<Scratch> make_scratch() const override;
  void set_position(const double* s, Scratch& scratch) const override;
  bool moves_by_integrals() const override { return false; }
  const Eigen::MatrixXd& M_e(const Scratch& scratch) const override;
  using FlexibleBody::M_e;
  Spatial inverse_dynamics(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                           const Spatial& A, Scratch& scratch, double* need) const override;
  double strain_energy(const double* s) const override;
  double dissipated_power(const double* s, const double* s_dot) const override;

  Pose node_pose(int node, const double* s) const override;
  void node_motion(int node, const double* s, const double* s_dot, const double* s_ddot,
                   NodeMotion& out) const override;

  void turning_tangents(const double* s, const double* s_dot, const Vector3d& w, Scratch& scratch,
                        Eigen::Matrix<double, 6, 3>& need_w, Modal3& modal_w) const override;
  void deformation_tangents(const double* s, const double* s_dot, const double* s_ddot, const Spatial& V,
                            const Spatial& A, Scratch& scratch, DeformationTangents& out) const override;
  void node_tangents(int node, const double* s, const double* s_dot, const double* s_ddot,
                     const Vector6d& wrench, DeformationTangents& out) const override;
  void add_tangents(const double* s, const double* s_dot, MatrixRef K, MatrixRef D) const override;

 private:
  struct Work;

  beam::exact::Element element_;
  Pose start_;
  double damping_time_;
  std::vector<beam::exact::Element::Place> places_;
  std::vector<Matrix3d> R_rest_;  ///< of the nodes' sections, from their axes to B
};

}  // namespace flexura::mbs
