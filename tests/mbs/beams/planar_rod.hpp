// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <numbers>

/// A free rod in a plane by E. Reissner's strains (J. Appl. Math. Phys. 23 (1972) 795),
///
///     eps = x' cos theta + y' sin theta - 1,   gamma = -x' sin theta + y' cos theta,   kappa = theta',
///
/// with places and angles as polynomials through N + 1 points of Gauss, Lobatto and Legendre on the whole of it, their masses
/// lumped there (an error beyond all powers of N, as the rest), and Kutta's method: nothing of it is the program's.  Loads act on
/// its first end.
namespace flexura::mbs::beams {

class PlanarRod {
 public:
  using Array = Eigen::ArrayXd;
  struct Constants {
    double L, EA, GA, EI, rho_A, rho_I;
  };
  /// Force along x and y and torque at the first end.
  using Load = std::function<Eigen::Vector3d(double t)>;

  PlanarRod(const Constants& c, int N) : c_(c), at_(N + 1), weight_(N + 1), slope_(N + 1, N + 1) {
    // Roots of (1 - z^2) P_N'(z) by Newton's method from Chebyshev's points; weights 2 / (N (N + 1) P_N^2).
    Array P(N + 1);
    for (int i = 0; i <= N; ++i) {
      double z = -std::cos(std::numbers::pi * i / N), p = 1.0;
      for (int k = 0; k < 50; ++k) {
        double before = 1.0;
        p = z;
        for (int n = 2; n <= N; ++n) {
          const double next = ((2 * n - 1) * z * p - (n - 1) * before) / n;
          before = p;
          p = next;
        }
        z -= (z * p - before) / ((N + 1) * p);
      }
      at_(i) = z;
      P(i) = p;
    }
    weight_ = c_.L / (N * (N + 1)) / P.square();  // on [0, L]
    for (int i = 0; i <= N; ++i)
      for (int j = 0; j <= N; ++j)
        slope_(i, j) = 2.0 / c_.L * (i == j ? 0.0 : P(i) / (P(j) * (at_(i) - at_(j))));
    slope_(0, 0) = -N * (N + 1) / (2.0 * c_.L);
    slope_(N, N) = -slope_(0, 0);
    at_ = 0.5 * c_.L * (at_ + 1.0);
  }

  /// At rest, straight, from `first` at the angle theta.
  void place(const Eigen::Vector2d& first, double theta) {
    const long n = at_.size();
    q_.setZero(n, 3);
    v_.setZero(n, 3);
    q_.col(0) = first.x() + at_ * std::cos(theta);
    q_.col(1) = first.y() + at_ * std::sin(theta);
    q_.col(2) = theta;
  }

  /// To the time t; a step of `step`, or a little less.
  void run(double t, double step, const Load& load) {
    const int n = static_cast<int>(std::ceil((t - t_) / step - 1e-9));
    const double h = (t - t_) / n, from = t_;
    using Table = Eigen::ArrayX3d;
    for (int i = 0; i < n; ++i) {
      const double now = from + i * h;
      // A load that ends at a step's end is still there within it.
      const Eigen::Vector3d first = load(now), half = load(now + 0.5 * h),
                            last = load(now + h * (1.0 - 1e-9));
      const Table a_1 = acceleration(q_, first), v_2 = v_ + 0.5 * h * a_1,
                  a_2 = acceleration(q_ + 0.5 * h * v_, half), v_3 = v_ + 0.5 * h * a_2,
                  a_3 = acceleration(q_ + 0.5 * h * v_2, half), v_4 = v_ + h * a_3,
                  a_4 = acceleration(q_ + h * v_3, last);
      q_ += h / 6.0 * (v_ + 2.0 * v_2 + 2.0 * v_3 + v_4);
      v_ += h / 6.0 * (a_1 + 2.0 * a_2 + 2.0 * a_3 + a_4);
    }
    t_ = t;
  }

  double kinetic() const {
    return 0.5 *
           (weight_ * (c_.rho_A * (v_.col(0).square() + v_.col(1).square()) + c_.rho_I * v_.col(2).square()))
               .sum();
  }
  double strain() const {
    const Strains e = strains(q_);
    return 0.5 *
           (weight_ * (c_.EA * e.eps.square() + c_.GA * e.gamma.square() + c_.EI * e.kappa.square())).sum();
  }
  /// x, y, theta of the first and the last section.
  Eigen::Vector3d first() const { return q_.row(0).transpose().matrix(); }
  Eigen::Vector3d last() const { return q_.row(q_.rows() - 1).transpose().matrix(); }

 private:
  struct Strains {
    Array c, s, x, y, eps, gamma, kappa;  ///< cos, sin, x', y'
  };
  Strains strains(const Eigen::ArrayX3d& q) const {
    const Eigen::ArrayX3d d = (slope_ * q.matrix()).array();
    Strains e{q.col(2).cos(), q.col(2).sin(), d.col(0), d.col(1), {}, {}, d.col(2)};
    e.eps = e.x * e.c + e.y * e.s - 1.0;
    e.gamma = e.y * e.c - e.x * e.s;
    return e;
  }
  Eigen::ArrayX3d acceleration(const Eigen::ArrayX3d& q, const Eigen::Vector3d& load) const {
    const Strains e = strains(q);
    const Array N = c_.EA * e.eps, Q = c_.GA * e.gamma, M = c_.EI * e.kappa;
    Eigen::ArrayX3d stress(q.rows(), 3);
    stress.col(0) = weight_ * (N * e.c - Q * e.s);
    stress.col(1) = weight_ * (N * e.s + Q * e.c);
    stress.col(2) = weight_ * M;
    Eigen::ArrayX3d f = -(slope_.transpose() * stress.matrix()).array();
    f.col(2) -=
        weight_ * (N * e.gamma - Q * (1.0 + e.eps));  // eps by theta is gamma, gamma by theta -(1 + eps)
    f.row(0) += load.transpose().array();
    f.leftCols(2).colwise() /= c_.rho_A * weight_;
    f.col(2) /= c_.rho_I * weight_;
    return f;
  }

  Constants c_;
  Array at_, weight_;
  Eigen::MatrixXd slope_;
  Eigen::ArrayX3d q_, v_;
  double t_ = 0.0;
};

}  // namespace flexura::mbs::beams
