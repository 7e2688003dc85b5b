// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/kinematics/kinematics.hpp"

/// How an element's doings change with what it sees: its partial derivatives, which the mechanism chains with
/// the motion of markers.  An element names one thing it does, then each thing that this depends on:
///
///     d.force(c, f);            // what follows is about the force f that it puts on the coordinate c
///     d.by_coordinate(c, -k);
///     d.by_speed(c, -damping);
///
/// Derivatives by a quantity have one row for each number done: 6 for a wrench, 1 for a force, ...
namespace flexura::mbs {

class DeformationDerivatives;
class Expression;

class Derivatives {
 public:
  /// At most 6 x 12; its storage lies inside, so that nothing is allocated.
  using Matrix = Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 12>, 0,
                            Eigen::OuterStride<>>;
  virtual ~Derivatives() = default;

  // What the element does; derivatives of what it says is 0 are not asked for.
  /// Loads::apply_between with this wrench.
  virtual void between(int marker_F, int marker_M, const Vector6d& on_M_F) = 0;
  /// A wrench at the origin of the marker `at`, expressed in the axes of the marker `axes` (-1: W), on its
  /// body, and where `reaction` is not -1 its reaction there, at the same point.
  virtual void wrench(int at, int axes, int reaction, const Vector6d& wrench) = 0;
  /// Loads::apply on a coordinate.
  virtual void force(CoordinateRef c, double value) = 0;
  /// Loads::apply_modal with factor 1: what follows is about the factor.
  virtual void modal(int body, const Eigen::VectorXd& f) = 0;
  /// The rate of its dynamic state i.
  virtual void rate(int i) = 0;
  /// Of a constraint: all its rows of velocity().  Of a measure or a control: its value.  Of an algebraic
  /// control and of a contact on a curve: what must vanish.
  virtual void rows() = 0;

  // What it sees.
  /// A relative motion, 12 columns: X_FM turned by (dtheta, dp), then V_FM, all in F as in Relative.
  virtual void by_relative(int marker_F, int marker_M, const Matrix& d) = 0;
  virtual void by_coordinate(CoordinateRef c, const Matrix& d) = 0;
  virtual void by_speed(CoordinateRef c, const Matrix& d) = 0;
  virtual void by_signal(int signal, const Matrix& d) = 0;
  /// The modal coordinate i of a body that deforms.
  virtual void by_deformation(int body, int i, const Vector6d& d) = 0;
  /// Its dynamic state i.
  virtual void by_state(int i, const Matrix& d) = 0;
  /// Its algebraic state.
  virtual void by_algebraic(double d) = 0;
  /// For what follows a whole deformation.
  virtual DeformationDerivatives& deformations() = 0;

  void by_coordinate(CoordinateRef c, double d) { by_coordinate(c, one(d)); }
  void by_speed(CoordinateRef c, double d) { by_speed(c, one(d)); }
  void by_state(int i, double d) { by_state(i, one(d)); }
  /// Through all signals that a formula reads, d times its own derivatives.
  virtual void by_formula(const Expression& f, const double* signals, const Matrix& d);
  void by_formula(const Expression& f, const double* signals, double d = 1.0) {
    by_formula(f, signals, one(d));
  }

 protected:
  static Eigen::Matrix<double, 1, 1> one(double d) { return Eigen::Matrix<double, 1, 1>(d); }
};

}  // namespace flexura::mbs
