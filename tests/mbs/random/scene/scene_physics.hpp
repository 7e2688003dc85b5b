// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "tests/mbs/random/scene/scene.hpp"

/// What is right of a scene, by equations that share nothing with the runtime's: every body is a set of point masses
/// (a rigid one six, on its principal axes) with the coordinates (turn of its frame, way of Bo, modal coordinates),
/// every joint and constraint is rows on poses, derivatives are differences, and accelerations are Gauss's,
///
///     a = argmin (a - M^-1 f)^T M (a - M^-1 f) / 2   subject to  G a = -gamma,
///
/// unique also where rows are redundant.
namespace flexura::mbs::chance {

struct BodyMotion {
  Place place;
  Spatial V, A;  ///< (w, v) and (alpha, a) of Bo, in W
  Eigen::VectorXd q_dot = {}, q_ddot = {};
};
Places places_of(const std::vector<BodyMotion>& motion);

/// Point masses at x + Phi q in B.
struct PointBody {
  Eigen::Matrix3Xd x;
  Eigen::VectorXd mass;
  Eigen::MatrixXd Phi;     ///< 3 N x modes
  Eigen::VectorXd omega2;  ///< of the modes, which are mass-normalised
  double damping = 0.0;    ///< ratio
};

class ScenePhysics {
 public:
  explicit ScenePhysics(const Scene& scene);

  /// Angles are counted on from here: whole turns are not seen in a pose.
  void count_turns_from(const Places& places);
  double coordinate(int joint, int coordinate, const Places& places) const;
  double speed(int joint, int coordinate, const std::vector<BodyMotion>& motion) const;

  /// g of all rows, drives included; lengths in m, else angles or numbers.
  Eigen::VectorXd rows(const Places& places, double t) const;
  std::string row_name(int row) const { return names_[row]; }
  int n_rows() const { return static_cast<int>(names_.size()); }
  bool row_is_length(int row) const { return is_length_[row]; }
  /// A drive by speed or acceleration: its position is what the integrator makes of it.
  bool row_is_integrated(int row) const { return is_integrated_[row]; }
  double size() const { return size_; }  ///< of the mechanism [m]

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
  Rank rank(const Places& places, double t) const;
  int n_freedoms() const { return n_; }

  struct Gauss {
    Eigen::VectorXd a;           ///< n_freedoms
    double contradiction = 0.0;  ///< what the rows leave open, over their size
    Rank rank;
  };
  Gauss accelerations(const std::vector<BodyMotion>& motion, double t) const;
  /// (alpha, a) of Bo of a body.
  Vector6d of_frame(const Gauss& gauss, int body) const { return gauss.a.segment<6>(first(body)); }
  Eigen::VectorXd of_modes(const Gauss& gauss, int body) const {
    return gauss.a.segment(first(body) + 6, scene_.bodies[body].modes);
  }

  /// Whether a switch of a force stands at this row within what its position is known to.
  bool stands_at_switch(const std::vector<BodyMotion>& motion, double t) const;

  /// Kinetic energy, and potential of weight, springs and deformation [J].
  double kinetic(const std::vector<BodyMotion>& motion) const;
  double potential(const std::vector<BodyMotion>& motion) const;
  Vector3d momentum(const std::vector<BodyMotion>& motion) const;
  Vector3d angular_momentum(const std::vector<BodyMotion>& motion) const;  ///< about the world's origin
  double mass() const;
  Vector3d centre(const std::vector<BodyMotion>& motion) const;
  /// Largest displacement of a point by deformation, over the size of the points' cloud.
  double deformation(const Places& places) const;

  /// What the scene is at its start, found by moving it a little.
  enum class Nature {
    moves,        ///< its rows hold and can go on doing so, at a rank that lasts
    contradicts,  ///< they cannot hold a moment later
    unclear       ///< a dead point, nearly lost rank, rows that are open
  };
  Nature nature(std::string* why = nullptr) const;
  /// Places near these at which the rows hold at t, with what is left of them.
  double close(Places& places, double t) const;
  /// The same a moment later, with every body going on at its speed.
  Places later(const std::vector<BodyMotion>& motion, double dt) const;

 private:
  int first(int body) const { return first_[body]; }  ///< of the body's coordinates
  int n_bodies() const { return static_cast<int>(scene_.bodies.size()); }
  void list_rows();
  Pose marker(int i, const Places& places) const { return scene_.marker(i, places); }
  double value(int joint, int coordinate, const Places& places) const;
  /// G (n_rows x n_freedoms).
  Eigen::MatrixXd jacobian(const Places& places, double t) const;
  /// Of every rolling disc: the speed over the plane of its lowest point for speeds v.
  Eigen::VectorXd slip(const Places& places, const Eigen::VectorXd& v) const;
  /// The places after a way d along the coordinates.
  Places moved(const Places& places, const Eigen::VectorXd& d) const;
  Eigen::VectorXd speeds(const std::vector<BodyMotion>& motion) const;
  double calm(const Eigen::VectorXd& v) const;
  Eigen::VectorXd row_scale() const;

  /// 6 x the body's coordinates: (turn, way) of a marker's origin; of ground without columns.
  Eigen::MatrixXd marker_map(int marker, const Places& places) const;
  Spatial marker_twist(int marker, const Places& places, const Eigen::VectorXd& v) const;
  Eigen::MatrixXd inverse_root_mass(const Places& places) const;
  Eigen::MatrixXd mass_matrix(int body, const Place& place) const;
  Eigen::VectorXd body_forces(int body, const BodyMotion& motion) const;
  Eigen::VectorXd forces(const std::vector<BodyMotion>& motion, double t) const;
  double along_joint(const SceneForce& force, const std::vector<BodyMotion>& motion, double t) const;
  double bushing_energy(const SceneForce& force, const Places& places) const;
  double gap(const SceneForce& force, const Places& places) const;
  double contact_push(const SceneForce& force, const std::vector<BodyMotion>& motion) const;

  const Scene& scene_;
  std::vector<int> first_;
  int n_ = 0;
  std::vector<PointBody> points_;  ///< by body; ground has none
  double size_ = 1.0;
  std::vector<std::string> names_;
  std::vector<bool> is_length_, is_integrated_;
  std::vector<int> slip_rows_;  ///< two of each rolling disc, in their order; they have no position
  std::vector<std::vector<double>> turns_;  ///< reference value of each joint's angles
};

}  // namespace flexura::mbs::chance
