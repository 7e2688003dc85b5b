// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mbs/bodies/left_out_modes.hpp"
#include "mbs/bodies/particle_acceleration.hpp"
#include "mbs/superelement/superelement.hpp"

namespace flexura::mbs {

/// (N, V_y, V_z, T, M_y, M_z) on the section that looks along +x of its member [N, N m].
using SectionForce = Eigen::Matrix<double, 6, 1>;

/// Section forces of a beam part in motion, at places of which the whole history is wanted:
///
///     S Y (s + Omega^-2 D s') + G c + H B + L f + sum of l_k Q_k Y s
///
/// the elasticity's and the dampers' part by the shapes S and the body's stiffness Omega^2 and damping D, and what its own
/// acceleration (c, B: particle_acceleration.hpp), load cases (factors f) and, with geometric stiffness, tension (loads l_k:
/// stiffening_loads.hpp) add along the members; the modes left out (left_out_modes.hpp) add S u_left.  So each cut is in
/// balance with all that acts on either side of it.  Between the places that the superelement knows they follow by a cubic
/// along the member.
///
/// This is in the member's axes.  They come in those of the section as it has turned with the deformation: what frame the body has
/// is then of no account.  With geometric stiffness but without Q the shapes' forces are nearer to the section's axes.
class SectionPoints {
 public:
  enum class Axes { section, member };
  struct Wanted {
    std::string name;
    int member = -1;
    double share = 0.0;  ///< of the member's length, from its first node
    Axes axes = Axes::section;
  };
  struct Point {
    Wanted wanted;
    double distance = 0.0;  ///< from where it was wanted, along the member [m]
  };
  /// A place on a member.
  struct Near {
    int member = -1;
    double share = 0.0, distance = 0.0;
  };

  SectionPoints(const superelement::SectionForces& forces, const ModalData& body,
                std::optional<LeftOutModes> left_out = {}, StiffeningLoads stiffening = {});
  const std::vector<std::string>& members() const { return forces_.members; }
  double length(int member) const;  ///< [m]
  /// The nearest places (of `member` alone where that is not -1) to a position [m] in B: several where members meet.
  std::vector<Near> nearest(const Eigen::Vector3d& wanted, int member = -1) const;
  void add_point(const Wanted& wanted);
  const std::vector<Point>& points() const { return points_; }
  /// `section force at 2 m of member "arm", in the section's axes`.
  std::string describe(int point) const;

  /// False for a superelement that does not know what bears on a cut within a member: then the shapes' part at the nearest place,
  /// in the member's axes, and of the load cases the preloads.
  bool is_whole() const { return forces_.of_acceleration.size() > 0; }
  /// False for a stiffened body of a superelement that does not know what tension bears on a cut: see Axes.
  bool knows_stiffening() const { return !is_stiffened_ || forces_.of_stiffening.size() > 0; }
  /// True where at() wants to know what acts on the nodes.
  bool takes_node_loads() const { return is_whole() && (left_out_.has_value() || is_stiffened_); }
  /// `factors` of the load cases; may be null.
  SectionForce at(int point, const BodyMotion& motion, const double* factors = nullptr) const;

 private:
  struct Maps {
    Eigen::Matrix3d R_BS;
    Eigen::Matrix<double, 6, Eigen::Dynamic> of_s, of_rates, of_loads, of_deformation, of_nodes,
        dropped_acceleration, dropped_deformation, of_stiffening;
    Eigen::Matrix<double, 6, 12> of_acceleration;
    Eigen::Matrix3Xd turning;
  };
  std::pair<Eigen::Index, Eigen::Index> places_of(int member) const;

  superelement::SectionForces forces_;
  Eigen::MatrixXd Y_, of_damping_;  // of_damping_: Y Omega^-2 D
  Coupling coupling_;
  bool is_stiffened_;
  std::optional<LeftOutModes> left_out_;
  StiffeningLoads stiffening_;
  std::vector<Point> points_;
  std::vector<Maps> maps_;
};

}  // namespace flexura::mbs
