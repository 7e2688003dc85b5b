// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/exact/planar_chain.hpp"
#include "mbs/bodies/flexible_body.hpp"

/// A geometrically exact beam that bends in a plane of its own (beam/exact/planar_chain.hpp), all elements in one body.
///
/// B is fixed to the section at the start and may move in space: across its plane the beam is rigid.
namespace flexura::mbs {

class PlanarBeam final : public FlexibleBody {
 public:
  struct Station {
    std::string name;
    int element = 0;
    double x = 0.0;  ///< from the element's start, along the unstrained axis [m]
  };

  /// `start` is the section's place and axes (x along the beam, y in the plane) in B; `damping_time` as in D = damping_time K.
  PlanarBeam(beam::exact::PlanarChain chain, const Pose& start, double damping_time,
             const std::vector<Station>& stations);

  int elements() const { return chain_.elements(); }
  double element_length() const { return chain_.length() / chain_.elements(); }
  /// In B: where each element starts, x along the line to its end.
  std::vector<Pose> chords(const double* s) const;

  std::vector<LawError> error_sources() const override {
    return {{"elements", "a run with twice as many tells"}};
  }
  /// Normal to the plane, in B.
  std::optional<Vector3d> stiff_direction() const override { return start_.R.col(2); }

  std::optional<Alone> alone(int i) const override {
    return alone_[static_cast<std::size_t>(i) % alone_.size()];
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

  double product(const double* a, const double* b) const;  // a^T K b

  beam::exact::PlanarChain chain_;
  Pose start_;
  double damping_time_;
  std::vector<beam::exact::PlanarChain::Place> places_;
  std::vector<Alone> alone_;      ///< of the coordinates of one element
  std::vector<Matrix3d> R_rest_;  ///< of the nodes' sections, from their axes to B
};

}  // namespace flexura::mbs
