// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>

#include "mbs/constraints/constraint.hpp"

namespace flexura::mbs {

/// A rotation R_FM with its angular velocity and acceleration w_FM, w_FM', in F.
struct DrivenRotation {
  Matrix3d R;
  Vector3d w, alpha;
};

/// A rotation by three prescribed numbers q: the rotation vector, or turns about axes i, j, k, each turned by those before it:
///
///     R = exp(q)                          w = J_l(q) q'
///     R = R_i(q_1) R_j(q_2) R_k(q_3)      w = sum q'_n a_n, a_n the n-th axis turned by those before it
///
/// Both have w = A(q) q' and w' = A q'' + A' q'.
class PrescribedRotation {
 public:
  using Sequence = std::array<int, 3>;  ///< axes, 0 to 2
  /// Without axes the numbers are a rotation vector.
  PrescribedRotation(std::array<Prescribed, 3> q, std::optional<Sequence> axes)
      : q_(std::move(q)), axes_(axes) {}
  const std::array<Prescribed, 3>& angles() const { return q_; }
  bool follows() const { return q_[0].follows() || q_[1].follows() || q_[2].follows(); }
  bool moves() const { return q_[0].moves() || q_[1].moves() || q_[2].moves(); }
  /// Where it is that of time alone.
  DrivenRotation at_time(double t) const;
  DrivenRotation at(const Kinematics& kin) const { return of(jets(kin)); }
  /// A (columns by q), and how A q' changes by each q at a fixed q'.
  Matrix3d by_rates(const Kinematics& kin) const;
  Matrix3d by_angles(const Kinematics& kin) const;

 private:
  using Jets = std::array<Jet, 3>;
  Jets jets(const Kinematics& kin) const;
  DrivenRotation of(const Jets& q) const;
  /// A q' and A' q' for these rates.
  std::pair<Vector3d, Vector3d> turn(Jets q, const Vector3d& q_dot) const;

  std::array<Prescribed, 3> q_;
  std::optional<Sequence> axes_;
};

/// A driven rotation of a joint that turns in any direction, whose first speeds are w_FM.  Rows: the rotation vector, in F,
/// by which M is ahead; their rates are w less that wanted.  The multipliers are minus the drive's torque in the axes of F.
class RotationDrive final : public Constraint {
 public:
  RotationDrive(std::string name, int joint, int marker_F, int marker_M, PrescribedRotation rotation)
      : Constraint(std::move(name)),
        joint_(joint),
        marker_F_(marker_F),
        marker_M_(marker_M),
        rotation_(std::move(rotation)) {}
  int n_rows() const override { return 3; }
  std::string row_name(int) const override { return "drive"; }
  GapKind gap_kind(int) const override { return GapKind::angle; }
  bool reads_time(int) const override { return rotation_.moves(); }
  int n_followed() const override { return rotation_.follows() ? 3 : 0; }
  Following following(int i) const override;
  void by_followed(const Kinematics& kin, int i, double* g_y, double* h_y, double* h_y_dot) const override;
  void position(const Kinematics& kin, double* g) const override;
  void velocity(const Kinematics& kin, double* g_dot) const override;
  void acceleration(const Kinematics& kin, double* g_ddot) const override;
  void rate(const Kinematics& kin, double* g_t) const override;
  void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const override;
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* x, Derivatives& d) const override;
  /// On the level that `kin` is on.
  DrivenRotation wanted(const Kinematics& kin) const { return rotation_.at(kin); }

 private:
  int joint_, marker_F_, marker_M_;
  PrescribedRotation rotation_;
};

}  // namespace flexura::mbs
