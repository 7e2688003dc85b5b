// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>
#include <vector>

#include "mbs/kinematics/deformation_derivatives.hpp"
#include "mbs/kinematics/derivatives.hpp"
#include "mbs/mechanism/elements/constraint_rows.hpp"
#include "mbs/mechanism/elements/element_states.hpp"
#include "mbs/mechanism/elements/followed_signals.hpp"
#include "mbs/mechanism/tangents/inertia_tangents.hpp"
#include "mbs/mechanism/tangents/marker_reach.hpp"

/// The chain rule from what elements see and do to the coordinates.
namespace flexura::mbs {

/// What ElementTangents leaves of one state.
struct ElementVariations {
  using Columns6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  MarkerReach at, axes, reaction, seen_F, seen_M;
  std::pair<int, int> seen;  ///< markers of seen_F and seen_M
  std::vector<int> columns, seen_columns;
  ReachMarks marks;
  Eigen::Matrix<double, 12, Eigen::Dynamic> motion;  ///< of seen_M in seen_F, pose and twist by q
  // What the element does: rows of the target and their derivatives by its numbers (6 at most).
  std::vector<int> rows;
  Columns6 by_row;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> signals;  ///< by (q, v, c, a)
  std::vector<bool> is_elastic;  ///< of each velocity coordinate
  std::vector<int> kept;         ///< of all constraint rows, -1 for redundant ones
  Eigen::MatrixXd z_q, h_q;      ///< of TangentMatrices, by the tangent coordinates of p

  void size(const Topology& tree, const ElementStates& states, const ConstraintRows& rows_of,
            int n_algebraic);
};

/// The partial derivatives of elements times how markers, coordinates and signals depend on the columns
/// (q, v, c, a), and times how loads act on the rows.
///
/// Loads are already in the wrenches F of inertia_tangents.cpp, which turn with the body that they act on.
/// What is left of a wrench (tau, f) about a point P in the axes of a marker A, on the body of a marker X,
/// is, for a coordinate that turns these by phi_A, phi_X and moves the point by p_P - p_X more than the body
/// does,
///
///     ((phi_A - phi_X) x tau + (p_P - p_X) x f, (phi_A - phi_X) x f)
///         + R_A times the change of its components
class ElementTangents final : public Derivatives, public DeformationDerivatives {
 public:
  /// The state at which all is taken.
  struct Instant {
    Motion& motion;
    const Signals& signals;
    RowValues& rows;
    const InertiaVariations& inertia;
    ElementVariations& elements;
  };
  ElementTangents(const Topology& tree, const ElementStates& states, const ConstraintRows& rows_of,
                  TangentScope scope, const Instant& at, TangentMatrices& out);

  void all_signals();
  void all_elements();
  /// What rows follow, after all_signals().
  void all_followed(const FollowedSignals& followed);

  using Derivatives::by_coordinate;
  using Derivatives::by_speed;
  using Derivatives::by_state;
  void between(int marker_F, int marker_M, const Vector6d& on_M_F) override;
  void wrench(int at, int axes, int reaction, const Vector6d& wrench) override;
  void force(CoordinateRef c, double value) override;
  void modal(int body, const Eigen::VectorXd& f) override;
  void rate(int i) override;
  void rows() override;
  void by_relative(int marker_F, int marker_M, const Matrix& d) override;
  void by_coordinate(CoordinateRef c, const Matrix& d) override;
  void by_speed(CoordinateRef c, const Matrix& d) override;
  void by_signal(int signal, const Matrix& d) override;
  void by_deformation(int body, int i, const Vector6d& d) override;
  void by_state(int i, const Matrix& d) override;
  void by_algebraic(double d) override;
  DeformationDerivatives& deformations() override { return *this; }
  void by_deformation_rate(int body, int i, const Vector6d& d) override;
  void modal_forces(int body, int marker_F, int marker_M, const Rows& by_relative) override;
  void modal_forces_by(int body, int by, const Rows& by_s, const Rows& by_s_dot) override;

 private:
  using Columns6 = ElementVariations::Columns6;
  enum class Target { z, h, g, signal };
  void followed_rows(const FollowedSignals& followed, const FollowedSignals::Follower& follower);
  void add_followed_rows(const double* by);
  void rate_of_signal(const FollowedSignals& followed, int place, double weight);
  void rate_of_formula(const FollowedSignals& followed, const Expression& f, double weight, int own);
  void by_eliminated(int algebraic, const Vector6d& change);

  void turn_load(const MarkerReach* reaction, const Matrix3d& R, const Vector6d& wrench);
  void see(int marker_F, int marker_M);
  void start(Target target);
  void add_row(int row, const Vector6d& by);
  void add_column(int column, const Vector6d& change);
  void add_signal(int signal, const Vector6d& change);
  void add(int row, int column, double value);
  Vector6d six(const Eigen::Ref<const Eigen::VectorXd>& d) const;
  bool skips(int j) const;

  const Topology& tree_;
  const ElementStates& states_;
  const ConstraintRows& rows_of_;
  TangentScope scope_;
  Instant at_;
  TangentMatrices& out_;
  ElementVariations& e_;
  MarkerReaches reaches_;
  double factor_ = 1.0;  // of loads in r
  // Of the element at work: its places in c, in a, among all constraint rows, among the signals.
  int first_state_ = 0, algebraic_ = -1, first_row_ = 0, n_rows_ = 0, signal_ = -1;
  Target target_ = Target::z;
  // Rates of a control's states as what rows follow: the row's derivative by each, and by what they are summed.
  const Eigen::VectorXd* rate_weights_ = nullptr;
  double rate_weight_ = 1.0;
  const double* followed_by_ = nullptr;
  bool eliminates_ = false;  ///< algebraic states are functions of what their equations read
  bool is_lifted_ = false;
  Vector6d lift_ = Vector6d::Zero();
};

}  // namespace flexura::mbs
