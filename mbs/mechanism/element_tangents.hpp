// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/kinematics/derivatives.hpp"
#include "mbs/mechanism/work.hpp"

/// Private to the sources of Mechanism: the chain rule from what elements see and do to the coordinates.
namespace flexura::mbs {

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
class Mechanism::ElementDerivatives final : public Derivatives {
 public:
  ElementDerivatives(const Mechanism& mechanism, TangentScope scope, Work& work, TangentMatrices& out);

  void all_signals();
  void all_elements();

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

 private:
  using Columns6 = Work::Columns6;
  using Reach = Work::Reach;
  enum class Target { z, h, signal };

  int base_of(std::initializer_list<int> markers) const;
  void reach(int marker, const Vector3d& point, int base, Reach& out) const;
  void turn_load(const Reach* reaction, const Matrix3d& R, const Vector6d& wrench);
  void collect(std::initializer_list<const Reach*> reaches, std::vector<int>& out);
  void see(int marker_F, int marker_M);
  void start(Target target);
  void add_row(int row, const Vector6d& by);
  void add_column(int column, const Vector6d& change);
  void add(int row, int column, double value);
  Vector6d six(const Eigen::Ref<const Eigen::VectorXd>& d) const;
  bool skips(int j) const;

  const Mechanism& m_;
  TangentScope scope_;
  Work& work_;
  TangentMatrices& out_;
  Work::ElementTangent& e_;
  double factor_ = 1.0;  // of loads in r
  // Of the element at work: its places in c, in a, among all constraint rows, among the signals.
  int first_state_ = 0, algebraic_ = -1, first_row_ = 0, n_rows_ = 0, signal_ = -1;
  Target target_ = Target::z;
  bool is_lifted_ = false;
  Vector6d lift_ = Vector6d::Zero();
};

}  // namespace flexura::mbs
