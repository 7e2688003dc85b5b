// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>

namespace flexura::mbs {

/// The constants of a collocation method with three stages:
///
///     B = A^-1 = (v w conj(w)) diag(gamma, lambda, conj(lambda)) (v w conj(w))^-1
struct ThreeStages {
  std::array<double, 3> c;  ///< nodes
  Eigen::Matrix3d B;
  double gamma;                 ///< real eigenvalue of B
  std::complex<double> lambda;  ///< and one of the complex pair
  Eigen::Vector3d v;            ///< eigenvector of gamma
  Eigen::Vector3cd w;           ///< eigenvector of lambda
  Eigen::RowVector3d v_left;    ///< first row of (v w conj(w))^-1
  Eigen::RowVector3cd w_left;   ///< and the second

  /// At x, in steps: the polynomial of degree 3 that is 1 at node i and 0 at 0 and at the other nodes.
  double basis(int i, double x) const;
  /// Its derivative.
  double slope(int i, double x) const;

 protected:
  /// From B and its eigenvalues.
  void take_eigenvectors();
};

/// Radau IIA, of order five (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.5 and IV.8); the
/// last node is 1.
struct RadauTableau : ThreeStages {
  std::array<double, 3> e;  ///< weights of the error estimate

  RadauTableau();
};

/// Gauss, of order six (IV.5): it damps no vibration, whatever its steps.
struct GaussTableau : ThreeStages {
  GaussTableau();
};

/// The polynomial of a step of Radau IIA: y at its beginning and the stages' Z_i = y(t_begin + c_i h) - y.
struct RadauPolynomial {
  const RadauTableau& tableau;
  double t_begin = 0.0, h = 0.0;  ///< h = 0: there is none
  Eigen::VectorXd y_begin;
  std::array<Eigen::VectorXd, 3> Z;

  /// y at t_begin + x h.
  void value(double x, Eigen::VectorXd& y) const;
  /// y' there, of `count` entries from `first` on.
  template <class Out>
  void rate(double x, int first, int count, Out&& rate) const {
    rate = tableau.slope(0, x) / h * Z[0].segment(first, count);
    for (int i = 1; i < 3; ++i) rate += tableau.slope(i, x) / h * Z[i].segment(first, count);
  }
};

}  // namespace flexura::mbs
