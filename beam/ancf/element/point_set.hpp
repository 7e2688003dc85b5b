// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "beam/ancf/element/strain.hpp"

/// Quadrature of an ANCF element: forces and exact tangents from a strain measure.
///
///     x = (N (x) 1) e,   f = sum_points w (N (x) 1)^T g^T sigma,   sigma = C (z - z_0) + C_d z_dot
///
/// N (n_x x n_s) holds the shape functions of the vectors x, e the nodal vectors one after another; since
/// every shape function multiplies all directions alike, N stays compact.
namespace flexura::beam::ancf {

template <class Strain, int n_s>
class PointSet {
 public:
  static constexpr int dim = Strain::dim, n_x = Strain::n_x, n_z = Strain::n_z, n = dim * n_s;
  using Measure = Strain;
  using Rows = Eigen::Matrix<double, n_x, n_s>;
  using Law = Eigen::Matrix<double, n_z, n_z>;
  using X = typename Strain::X;
  using Z = typename Strain::Z;
  using Nodal = Eigen::Map<const Eigen::Matrix<double, dim, n_s>>;

  /// A point of weight w (a length [m] or volume [m^3]).  `e_0` is the stress-free configuration, or nullptr
  /// for z_0 = 0.
  void add(double w, const Rows& N, const Law& C, const Law& C_d, const double* e_0) {
    Point point{w, N, C, C_d, Z::Zero(), {}, !C_d.isZero(0.0)};
    for (int i = 0; i < n_x; ++i)
      for (int s = 0; s < n_s; ++s)
        if (N(i, s) != 0.0) point.entries.push_back({i, s, N(i, s)});
    if (e_0) {
      typename Strain::Gradient g;
      Strain::evaluate(X(Nodal(e_0) * N.transpose()), point.z_0, g);
    }
    points_.push_back(std::move(point));
  }

  double energy(const double* e) const {
    double sum = 0.0;
    Z z;
    typename Strain::Gradient g;
    for (const Point& point : points_) {
      Strain::evaluate(X(Nodal(e) * point.N.transpose()), z, g);
      z -= point.z_0;
      sum += 0.5 * point.w * z.dot(point.C * z);
    }
    return sum;
  }

  /// Power that the viscous part takes out, >= 0.
  double dissipation(const double* e, const double* e_dot) const {
    double sum = 0.0;
    Z z;
    typename Strain::Gradient g;
    for (const Point& point : points_) {
      if (!point.damped) continue;
      const X x = Nodal(e) * point.N.transpose(), x_dot = Nodal(e_dot) * point.N.transpose();
      Strain::evaluate(x, z, g);
      Z z_dot = g * x_dot.reshaped();
      if constexpr (Strain::projects_rates) z_dot = Strain::project(x, z_dot);
      sum += point.w * z_dot.dot(point.C_d * z_dot);
    }
    return sum;
  }

  int size() const { return static_cast<int>(points_.size()); }

  /// sigma at point k.
  Z stress(int k, const double* e, const double* e_dot) const {
    const Point& point = points_[k];
    const X x = Nodal(e) * point.N.transpose(), x_dot = Nodal(e_dot) * point.N.transpose();
    Z z;
    typename Strain::Gradient g;
    Strain::evaluate(x, z, g);
    Z z_dot = g * x_dot.reshaped();
    if constexpr (Strain::projects_rates) z_dot = Strain::project(x, z_dot);
    return point.C * (z - point.z_0) + point.C_d * z_dot;
  }

  /// Adds the internal force to f (n) and, unless nullptr, df/de to K and df/de_dot to D (n x n,
  /// column-major).
  /// With `e_before` the geometric part of K takes the stress extrapolated linearly from e_before to e
  /// (Element).
  void add_force(const double* e, const double* e_dot, const double* e_before, double* f, double* K,
                 double* D) const {
    Eigen::Map<Eigen::Matrix<double, dim, n_s>> force(f);
    typename Strain::Gradient g, g_dot;
    for (const Point& point : points_) {
      const X x = Nodal(e) * point.N.transpose();
      Z z, sigma, sigma_d = Z::Zero(), z_dot = Z::Zero();
      X x_dot;
      Strain::evaluate(x, z, g);
      sigma.noalias() = point.C * (z - point.z_0);
      if (point.damped) {
        x_dot = Nodal(e_dot) * point.N.transpose();
        z_dot = g * x_dot.reshaped();
        sigma_d.noalias() = point.C_d * z_dot;
        // C_d weights all directions of a projected rate alike, so projecting the stress is the same.
        if constexpr (Strain::projects_rates) sigma_d = Strain::project(x, sigma_d);
        sigma += sigma_d;
      }
      X f_x;
      f_x.reshaped() = point.w * (g.transpose() * sigma);
      force.noalias() += f_x * point.N;

      if (K) {
        typename Strain::Hessian K_x = Strain::Hessian::Zero();
        if (e_before) {
          const X x_before = Nodal(e_before) * point.N.transpose();
          Z z_before;
          Strain::evaluate(x_before, z_before, g_dot);
          z_before += g_dot * (x - x_before).reshaped() - point.z_0;
          Strain::add_hessian(x, Z(point.C * z_before + sigma_d), K_x);
        } else {
          Strain::add_hessian(x, sigma, K_x);
        }
        typename Strain::Gradient d_sigma = point.C * g;
        if (point.damped) {
          Strain::gradient_rate(x, x_dot, g_dot);
          typename Strain::Gradient d_rate = point.C_d * g_dot;
          if constexpr (Strain::projects_rates) {
            for (int c = 0; c < dim * n_x; ++c) d_rate.col(c) = Strain::project(x, d_rate.col(c));
            d_rate += Strain::project_gradient(x, point.C_d * z_dot);
          }
          d_sigma += d_rate;
        }
        K_x.noalias() += g.transpose() * d_sigma;
        scatter(point, K_x, K);
      }
      if (D && point.damped) {
        typename Strain::Gradient d_sigma = point.C_d * g;
        if constexpr (Strain::projects_rates)
          for (int c = 0; c < dim * n_x; ++c) d_sigma.col(c) = Strain::project(x, d_sigma.col(c));
        const typename Strain::Hessian D_x = g.transpose() * d_sigma;
        scatter(point, D_x, D);
      }
    }
  }

 private:
  struct Entry {
    int i, s;
    double value;
  };
  struct Point {
    double w;
    Rows N;
    Law C, C_d;
    Z z_0;
    std::vector<Entry> entries;  // non-zeros of N: two thirds of a beam's are zero
    bool damped;
  };

  static void scatter(const Point& point, const typename Strain::Hessian& T_x, double* T) {
    Eigen::Map<Eigen::Matrix<double, n, n>> out(T);
    for (const Entry& col : point.entries)
      for (const Entry& row : point.entries)
        out.template block<dim, dim>(dim * row.s, dim * col.s) +=
            (point.w * row.value * col.value) * T_x.template block<dim, dim>(dim * row.i, dim * col.i);
  }

  std::vector<Point> points_;
};

}  // namespace flexura::beam::ancf
