// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/mbs/random/scene.hpp"

/// What is right of a scene, by equations that share nothing with the runtime's: every body has six coordinates (a
/// turn about its centre of mass and the way of that), every joint and constraint is rows on poses, derivatives are
/// differences, and accelerations are Gauss's,
///
///     a = argmin (a - M^-1 f)^T M (a - M^-1 f) / 2   subject to  G a = -gamma,
///
/// unique also where rows are redundant.
namespace flexura::mbs::chance {

struct BodyMotion {
  Pose X_WB;
  Spatial V, A;  ///< (w, v) and (alpha, a) of the centre of mass, in W
};

class ScenePhysics {
 public:
  explicit ScenePhysics(const Scene& scene);

  /// Angles are counted on from here: whole turns are not seen in a pose.
  void count_turns_from(const std::vector<BodyMotion>& motion, double t);
  double coordinate(int joint, int coordinate, const std::vector<Pose>& X_WB) const;
  double speed(int joint, int coordinate, const std::vector<BodyMotion>& motion) const;

  /// g of all rows, drives included; lengths in m, else angles or numbers.
  Eigen::VectorXd rows(const std::vector<Pose>& X_WB, double t) const;
  std::string row_name(int row) const { return names_[row]; }
  int n_rows() const { return static_cast<int>(names_.size()); }
  bool row_is_length(int row) const { return is_length_[row]; }
  /// A drive by speed or acceleration: its position is what the integrator makes of it.
  bool row_is_integrated(int row) const { return is_integrated_[row]; }
  double size() const { return size_; }  ///< of the mechanism [m]

  /// G (n_rows x 6 n): by turns and displacements of the bodies, and g_t.
  Eigen::MatrixXd jacobian(const std::vector<Pose>& X_WB, double t, Eigen::VectorXd* g_t = nullptr) const;
  /// G v + g_t, and the same once more along constant velocities.
  Eigen::VectorXd rates(const std::vector<BodyMotion>& motion, double t) const;
  Eigen::VectorXd gamma(const std::vector<BodyMotion>& motion, double t) const;

  /// Rank of the rows, in units in which a body's inertia is 1 and lengths count by size().
  struct Rank {
    int rank = 0;
    double smallest = 1.0;  ///< of the singular values counted, over the largest
    double next = 0.0;      ///< of those not counted
    bool is_clear() const { return smallest > 1e-3 && next < 1e-8; }
  };
  Rank rank(const std::vector<Pose>& X_WB, double t) const;
  int n_freedoms() const { return 6 * n_; }

  struct Gauss {
    Eigen::VectorXd a;          ///< 6 n: (alpha, a) of each body
    double contradiction = 0.0;  ///< what the rows leave open, over their size
    Rank rank;
  };
  Gauss accelerations(const std::vector<BodyMotion>& motion, double t) const;

  /// Whether a switch of a force stands at this row within what its position is known to.
  bool stands_at_switch(const std::vector<BodyMotion>& motion, double t) const;

  /// Kinetic energy, and potential of weight and springs [J].
  double kinetic(const std::vector<BodyMotion>& motion) const;
  double potential(const std::vector<BodyMotion>& motion) const;
  Vector3d momentum(const std::vector<BodyMotion>& motion) const;
  Vector3d angular_momentum(const std::vector<BodyMotion>& motion) const;  ///< about the world's origin
  double mass() const;
  Vector3d centre(const std::vector<BodyMotion>& motion) const;

  /// What the scene is at its start, found by moving it a little.
  enum class Nature {
    moves,        ///< its rows hold and can go on doing so, at a rank that lasts
    contradicts,  ///< they cannot hold a moment later
    unclear       ///< a dead point, nearly lost rank, rows that are open
  };
  Nature nature(std::string* why = nullptr) const;
  /// Poses near X_WB at which the rows hold at t, with what is left of them.
  double close(std::vector<Pose>& X_WB, double t) const;

 private:
  struct Row;
  Pose marker(int i, const std::vector<Pose>& X) const { return scene_.marker(i, X); }
  double counted(double angle, int key) const;
  double value(int joint, int coordinate, const std::vector<Pose>& X) const;
  /// Of every rolling disc: its first slip row, and the speed over the plane of its lowest point for speeds v (6 n).
  Eigen::VectorXd slip(const std::vector<Pose>& X_WB, const Eigen::VectorXd& v) const;
  double bushing_energy(const SceneForce& force, const std::vector<Pose>& X) const;
  double gap(const SceneForce& force, const std::vector<Pose>& X) const;
  double contact_push(const SceneForce& force, const std::vector<BodyMotion>& motion) const;
  std::vector<Pose> moved(const std::vector<Pose>& X_WB, const Eigen::VectorXd& d) const;
  Eigen::VectorXd forces(const std::vector<BodyMotion>& motion, double t) const;
  Matrix3d inertia(int b, const Pose& X) const;
  Eigen::MatrixXd inverse_root_mass(const std::vector<Pose>& X_WB) const;
  Eigen::VectorXd row_scale() const;

  const Scene& scene_;
  int n_;  // bodies without ground
  double size_ = 1.0;
  std::vector<std::string> names_;
  std::vector<bool> is_length_, is_integrated_;
  std::vector<int> slip_rows_;  // two of each rolling disc, in their order; they have no position
  std::vector<std::vector<double>> turns_;  // reference value of each joint's angles
};

}  // namespace flexura::mbs::chance
