// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <memory>
#include <string>

#include "mbs/formulas/expression.hpp"
#include "mbs/kinematics/derivatives.hpp"
#include "mbs/kinematics/kinematics.hpp"
#include "mbs/kinematics/output_info.hpp"

/// Constraints: rows g(p, t) = 0 with g' = G v + g_t and g'' = G v' + gamma.  Adding one: one file in
/// constraints/ and one line in constraint_types(), or rows on a relative pose (RelativeRows) put into a
/// RelativeConstraint.
namespace flexura::mbs {

/// What is open where a row's g is not 0: so much of a coordinate that it binds, or of none of these.
enum class GapKind { length, angle, coordinate, other };

/// What a drive prescribes.
enum class DriveLevel { position, speed, acceleration };

/// A motion that is prescribed by a formula: of time alone, or of signals (a control's states), which the mechanism then
/// evaluates and leaves in Kinematics::own.
class Prescribed {
 public:
  Prescribed(std::shared_ptr<const Expression> formula)
      : formula_(std::move(formula)) {}  // NOLINT: it is one
  /// Nothing is prescribed.
  Prescribed(std::nullptr_t = nullptr) {}  // NOLINT
  explicit operator bool() const { return formula_ != nullptr; }
  bool follows() const { return formula_ && !formula_->reads().empty(); }
  /// What it prescribes may change with time.
  bool moves() const { return formula_ && (formula_->reads_time() || follows()); }
  /// `i`: which of the formulas that its constraint follows it is.
  Jet at(const Kinematics& kin, int i = 0) const {
    return follows() ? kin.own.followed[i] : formula_->time_derivatives(kin.t);
  }
  const std::shared_ptr<const Expression>& formula() const { return formula_; }

 private:
  std::shared_ptr<const Expression> formula_;
};

/// A formula of signals that rows follow, and on which level: its first derivative by time is needed for a speed, the
/// second for a position.
struct Following {
  const Expression* formula = nullptr;  ///< null: nothing is followed
  DriveLevel level = DriveLevel::position;
};

/// The angle of a joint that closes a loop: its frames tell it but for whole turns.
bool is_without_turns(const Kinematics& kin, CoordinateRef c);

class Constraint {
 public:
  explicit Constraint(std::string name) : name_(std::move(name)) {}
  virtual ~Constraint() = default;
  const std::string& name() const { return name_; }

  virtual int n_rows() const = 0;
  virtual std::string row_name(int i) const = 0;
  /// What is open where g of the row is `residual`: the same unless the row is no length and no angle.
  virtual double gap(int /*row*/, double residual) const { return residual; }
  virtual GapKind gap_kind(int /*row*/) const {
    return coordinates().empty() ? GapKind::other : GapKind::coordinate;
  }
  /// False for a row on velocities only, whose position residual is always 0.
  virtual bool is_holonomic(int /*row*/) const { return true; }
  /// True for a row whose g at the same positions may change with time (a drive): the mechanism then gets
  /// where the row, as it is now, does not let it.
  virtual bool reads_time(int /*row*/) const { return false; }
  /// Joint coordinates it binds: these joints are taken into the tree first.
  virtual std::vector<CoordinateRef> coordinates() const { return {}; }
  /// Markers whose bodies its reactions load: flexible ones may take response modes there.
  virtual std::vector<int> markers() const { return {}; }
  virtual void position(const Kinematics& kin, double* g) const = 0;
  virtual void velocity(const Kinematics& kin, double* g_dot) const = 0;
  virtual void acceleration(const Kinematics& kin, double* g_ddot) const = 0;
  /// Adds G^T x as loads.
  virtual void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const = 0;
  /// True where differentiate() is there; what a constraint does without is differenced.
  virtual bool has_derivatives() const { return false; }
  /// Of apply_GT(x) and of velocity().
  virtual void differentiate(const Kinematics& /*kin*/, const double* /*x*/, Derivatives& /*d*/) const {}
  /// Of contact_residual(a).
  virtual void differentiate_contact(const Kinematics& /*kin*/, double /*a*/, Derivatives& /*d*/) const {}
  /// g_t: what makes a moving constraint do work.
  virtual void rate(const Kinematics& /*kin*/, double* g_t) const {
    for (int i = 0; i < n_rows(); ++i) g_t[i] = 0.0;
  }
  /// Formulas that it follows; their values are kin.own.followed[0], [1], ...
  virtual int n_followed() const { return 0; }
  virtual Following following(int /*i*/) const { return {}; }
  /// Of formula y that it follows as its i-th: the derivatives of g by y, and of g' by y and y', one for each row.
  virtual void by_followed(const Kinematics& /*kin*/, int /*i*/, double* g_y, double* h_y,
                           double* h_y_dot) const {
    for (int row = 0; row < n_rows(); ++row) g_y[row] = h_y[row] = h_y_dot[row] = 0.0;
  }
  /// A contact that travels along a curve: its parameter is an algebraic state on position level.
  virtual bool has_contact() const { return false; }
  virtual double contact_residual(const Kinematics& /*kin*/, double /*a*/) const { return 0.0; }
  virtual double start_contact(const Kinematics& /*kin*/) const { return 0.0; }
  /// [m] How far the path of its outputs "place" and "speed" goes from 0, beyond which nothing is known of the
  /// body; infinite without one, and where it goes on.
  virtual double path_length() const { return std::numeric_limits<double>::infinity(); }
  /// The forces it exerts, by name.  Without more, one generalised force for each row, "force_ROW", whose
  /// power is the force times the rate of the row.
  virtual std::vector<OutputInfo> outputs() const;
  /// Their values where the multipliers are x: the generalised forces are -G^T x.
  virtual void evaluate_outputs(const Kinematics& kin, const double* x, double* values) const;

 private:
  std::string name_;
};

/// Outputs of what puts a wrench on the body of M about Mo, in the axes of F: the sizes, then the components.
std::vector<OutputInfo> wrench_outputs(bool has_force, bool has_torque);
/// Their values.
void put_wrench(const Vector6d& on_M_F, bool has_force, bool has_torque, double* values);

/// Rows on the pose of one marker relative to another: a joint that closes a loop, a point on a line, ...  A single row
/// may be held at a motion that is prescribed in place of 0.
class RelativeConstraint final : public Constraint {
 public:
  RelativeConstraint(std::string name, int marker_F, int marker_M, std::shared_ptr<const RelativeRows> rows,
                     Prescribed held_at = nullptr);
  int n_rows() const override { return rows_->n_rows(); }
  std::string row_name(int i) const override { return rows_->row_name(i); }
  double gap(int row, double residual) const override { return rows_->gap(row, residual); }
  /// A row whose multiplier pushes is a length; one that only turns an angle (or the sine of a small one).
  GapKind gap_kind(int row) const override;
  bool reads_time(int) const override { return held_at_.moves(); }
  int n_followed() const override { return held_at_.follows() ? 1 : 0; }
  Following following(int) const override { return {held_at_.formula().get(), DriveLevel::position}; }
  void by_followed(const Kinematics&, int, double* g_y, double* h_y, double* h_y_dot) const override {
    g_y[0] = h_y_dot[0] = -1.0;
    h_y[0] = 0.0;
  }
  void position(const Kinematics& kin, double* g) const override;
  void velocity(const Kinematics& kin, double* g_dot) const override;
  void acceleration(const Kinematics& kin, double* g_ddot) const override;
  void rate(const Kinematics& kin, double* g_t) const override;
  void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const override;
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* x, Derivatives& d) const override;
  void differentiate_contact(const Kinematics& kin, double a, Derivatives& d) const override;
  /// The wrench that multipliers x stand for, on M about Mo, in F: G_rel^T x.
  Vector6d wrench_on_M(const Kinematics& kin, const double* x) const;
  std::vector<int> markers() const override { return {marker_F_, marker_M_}; }
  int marker_F() const { return marker_F_; }
  int marker_M() const { return marker_M_; }
  bool has_contact() const override { return rows_->has_contact(); }
  double contact_residual(const Kinematics& kin, double a) const override {
    return rows_->contact_residual(kin.relative_pose(marker_F_, marker_M_), a);
  }
  double start_contact(const Kinematics& kin) const override {
    return rows_->start_contact(kin.relative_pose(marker_F_, marker_M_));
  }
  std::vector<OutputInfo> outputs() const override;
  void evaluate_outputs(const Kinematics& kin, const double* x, double* values) const override;

 private:
  struct Exerts {
    bool force = false, torque = false;
  };
  Exerts exerts() const;

  int marker_F_, marker_M_;
  std::shared_ptr<const RelativeRows> rows_;
  Prescribed held_at_;
  Exerts exerts_;
};

/// A driven coordinate of a joint, on one of three levels.  Its multiplier is minus the drive's force or torque.
///
///     position       q = f(t)
///     speed          v = f(t): one integration's drift is that of q, since nothing says where q should be
///     acceleration   v = v_0 + integral of f from t = 0 on, by adaptive Gauss-Kronrod quadrature to 1e-12
///
/// f may be a formula of signals on the first two levels; its acceleration is then that of a dynamic state v.
class DriveConstraint final : public Constraint {
 public:
  /// `speed` says which by its speed, `coordinate` by its place among coordinates, of which a quaternion has one more.
  DriveConstraint(std::string name, CoordinateRef speed, int coordinate,
                  std::shared_ptr<const Expression> motion, DriveLevel level = DriveLevel::position,
                  double start_speed = 0.0);
  bool is_holonomic(int) const override { return level_ == DriveLevel::position; }
  bool reads_time(int) const override { return motion_.moves(); }
  int n_followed() const override { return motion_.follows() ? 1 : 0; }
  Following following(int) const override { return {motion_.formula().get(), level_}; }
  void by_followed(const Kinematics& kin, int i, double* g_y, double* h_y, double* h_y_dot) const override;
  int n_rows() const override { return 1; }
  std::string row_name(int) const override { return "drive"; }
  void position(const Kinematics& kin, double* g) const override;
  void velocity(const Kinematics& kin, double* g_dot) const override;
  void acceleration(const Kinematics& kin, double* g_ddot) const override;
  void apply_GT(const Kinematics& kin, const double* x, Loads& loads) const override;
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* x, Derivatives& d) const override;
  void rate(const Kinematics& kin, double* g_t) const override;

 private:
  double wanted_speed(const Kinematics& kin) const;
  double wanted_acceleration(const Kinematics& kin) const;

  CoordinateRef speed_, coordinate_;
  Prescribed motion_;
  DriveLevel level_;
  double start_speed_;
};

}  // namespace flexura::mbs
