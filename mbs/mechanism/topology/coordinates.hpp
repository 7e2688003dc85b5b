// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/mechanism/topology/topology.hpp"

/// The coordinates of a mechanism for themselves: how p changes with v, their names and sizes.
namespace flexura::mbs {

class Coordinates {
 public:
  explicit Coordinates(const Topology& tree);

  // As in Equations.
  void kinematic(ConstVectorRef p, ConstVectorRef w, VectorRef p_dot) const;
  void retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const;
  bool elastic_coordinate(int i_v, int& i_p, double& k, double& d) const;
  void add_elastic_tangents(const State& s, MatrixRef r_p, MatrixRef r_v) const;
  double position_scale(int i) const;
  double velocity_scale(int i) const;
  double rate_scale(int i) const;
  std::string name_of_position(int i) const;
  std::string name_of_velocity(int i) const;
  /// Of a deformation that does not act back; `i` is its place in c.
  std::string name_of_following(int i) const;

  /// by_p = by_tangent T^+, T^+ the inverse of p' = T v on the manifold: how p's own numbers change them.
  void take_to_coordinates(const double* p, const Eigen::MatrixXd& by_tangent, Eigen::MatrixXd& by_p) const;
  /// What a coordinate changes by in a motion about as large as the mechanism: 1 rad, its extent [m], a mode's
  /// amplitude of that size (n_v).
  Eigen::VectorXd kinematic_scale(double extent) const;
  /// The coordinates of a body's deformation; nullptr of a rigid body.
  const double* modal_coordinates(int body, const State& s) const;

 private:
  const Topology& tree_;
  /// By body and its elastic coordinate: the circular frequency at which it vibrates alone [rad/s].
  std::vector<std::vector<double>> own_frequency_;
};

}  // namespace flexura::mbs
