// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>

#include "mbs/base/math/spatial.hpp"
#include "tests/mbs/model/lattice.hpp"

/// The deformable bodies of random mechanisms: point masses joined by bars (lattice.hpp), known point by point.  What
/// a run with one of them has to hold follows from sums over the points; nothing is taken from the runtime's integrals.
namespace flexura::mbs::chance {

class FlexiblePart {
 public:
  /// With n_q fixed-interface modes beside the 12 of its two interfaces; its bars have this E A [N].
  FlexiblePart(std::string name, int n_q, double bar_stiffness);
  /// What is known of a beam without its equations: its frame is the section at the root, its six coordinates are the way
  /// and the turn of its tip, and half of its mass is about either end.  Rows and their ranks follow from that.
  FlexiblePart(double length, double mass);

  const std::string& name() const { return name_; }
  const Eigen::Matrix3Xd& points() const { return lattice_.x; }  ///< undeformed, from Bo
  const Eigen::VectorXd& mass() const { return lattice_.mass; }  ///< of each point
  int n_modes() const { return static_cast<int>(omega2_.size()); }
  /// Modes of the free body, by M_se of unit size, lowest first, without momentum (mean axes): n_se x n_modes.
  const Eigen::MatrixXd& modes() const { return modes_; }
  const Eigen::VectorXd& omega2() const { return omega2_; }  ///< [rad^2/s^2]
  /// Displacements of the points, x y z of the first, then of the second, ...: 3 N x n_modes.
  const Eigen::MatrixXd& shapes() const { return shapes_; }
  /// Of the coordinates u_se: those of the modes.
  Eigen::VectorXd modal(const Eigen::VectorXd& u_se) const;

  const std::string& interface_name(int i) const { return lattice_.se.interfaces[i].name; }
  /// How the interface's node stands in B beside where it is undeformed, for modal coordinates q (the first so many).
  Pose carried(int interface, const Eigen::VectorXd& q) const;
  Vector3d interface_at(int i) const { return lattice_.se.interfaces[i].p_BoN_B; }

  /// The superelement where what was 1 m, 1 kg is written as `length`, `mass`, in the folder, once.
  std::string file(const std::filesystem::path& folder, double length, double mass) const;
  /// Coordinates u_se of the superelement in that file as those of this one.
  Eigen::VectorXd from_units(const Eigen::VectorXd& u_se, double length, double mass) const;

 private:
  superelement::Superelement in_units(double length, double mass) const;
  /// What 1 of the coordinate u_se,k is written as.
  Eigen::VectorXd unit_of_coordinates(double length, double mass) const;

  std::string name_;
  lattice::Lattice lattice_;
  Eigen::MatrixXd modes_, shapes_;
  Eigen::VectorXd omega2_;
};

/// One of a few; the same for the same number.
std::shared_ptr<const FlexiblePart> flexible_part(int which);
constexpr int kFlexibleParts = 4;

}  // namespace flexura::mbs::chance
