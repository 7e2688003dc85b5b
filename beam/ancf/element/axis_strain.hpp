// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>

#include "beam/exact/dual.hpp"

namespace flexura::beam::ancf {

/// Strains of the axis of a fully parametrised beam, x = (r_x, r_y, r_z, r_yx, r_zx), in the order of the section's
/// resultants (N, V_y, V_z, T, M_y, M_z): those of E. Reissner's and J. C. Simo's beam (Comput. Methods Appl. Mech. Eng.
/// 49 (1985) 55), with the section frame of ancf_kinematics.hpp, E = (e_x, e_y, e_z), as its rotation
/// (K. Nachbagauer, P. Gruber, J. Gerstmayr, J. Comput. Nonlinear Dyn. 8 (2012) 021004, the "structural mechanics"
/// strains):
///
///     Gamma = E^T r_x - (1, 0, 0),   kappa = axial(E^T E_x)
///
/// Curvatures count over the unstretched length, so that stretch and bending do not couple.  The lengths of r_y and r_z
/// and the angle between them do not enter: SectionStrain holds these.
struct AxisStrain {
  static constexpr int dim = 3, n_x = 5, n_z = 6;
  static constexpr bool projects_rates = false;
  using X = Eigen::Matrix<double, dim, n_x>;
  using Z = Eigen::Matrix<double, n_z, 1>;
  using Gradient = Eigen::Matrix<double, n_z, dim * n_x>;
  using Hessian = Eigen::Matrix<double, dim * n_x, dim * n_x>;

  static void evaluate(const X& x, Z& z, Gradient& g) {
    const At<double> at([&](int i) { return x(i % 3, i / 3); });
    z << at.a.x - 1.0, at.a.y, at.a.z, at.p.z / at.Y, at.kappa_y(), -at.p.x / at.Y;
    for (int k = 0; k < n_z; ++k) {
      std::array<exact::Vec<double>, n_x> row;
      at.pull_back(Z::Unit(k), row);
      for (int i = 0; i < n_x; ++i)
        g.block<1, 3>(k, 3 * i) << row[index(i)].x, row[index(i)].y, row[index(i)].z;
    }
  }

  static void add_hessian(const X& x, const Z& sigma, Hessian& H) {
    using S = exact::Dual<dim * n_x>;
    const At<S> at([&](int i) { return S::variable(x(i % 3, i / 3), i); });
    std::array<exact::Vec<S>, n_x> f;
    at.pull_back(sigma, f);
    for (int i = 0; i < n_x; ++i)
      for (int j = 0; j < dim * n_x; ++j)
        H.block<3, 1>(3 * i, j) +=
            Eigen::Vector3d(f[index(i)].x.d[index(j)], f[index(i)].y.d[index(j)], f[index(i)].z.d[index(j)]);
  }

  static void gradient_rate(const X& x, const X& x_dot, Gradient& g_dot) {
    using S = exact::Dual<1>;
    const At<S> at([&](int i) {
      S value(x(i % 3, i / 3));
      value.d[0] = x_dot(i % 3, i / 3);
      return value;
    });
    for (int k = 0; k < n_z; ++k) {
      std::array<exact::Vec<S>, n_x> row;
      at.pull_back(Z::Unit(k), row);
      for (int i = 0; i < n_x; ++i)
        g_dot.block<1, 3>(k, 3 * i) << row[index(i)].x.d[0], row[index(i)].y.d[0], row[index(i)].z.d[0];
    }
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  static double inverse(double x) { return 1.0 / x; }
  template <int n>
  static exact::Dual<n> inverse(const exact::Dual<n>& x) {
    return exact::chain(1.0 / x.v, -1.0 / (x.v * x.v), x);
  }
  template <class S>
  static S norm(const exact::Vec<S>& v) {
    const S p = exact::dot(v, v);
    const double root = std::sqrt(exact::value(p));
    return exact::chain(root, 0.5 / root, p);
  }

  /// The section frame, and the components in it of a = r_x, p = r_yx, q = r_zx; r_y = Y e_y, r_z = c e_y + b e_z.
  template <class S>
  struct At {
    exact::Mat<S> E;
    S Y, b, c, per_Y, per_b;
    exact::Vec<S> a, p, q;

    template <class Value>
    explicit At(const Value& x) {
      const auto vector = [&](int i) { return exact::Vec<S>{x(3 * i), x(3 * i + 1), x(3 * i + 2)}; };
      const exact::Vec<S> y = vector(1), z = vector(2), n = exact::cross(y, z);
      Y = norm(y);
      per_Y = inverse(Y);
      E.y = per_Y * y;
      E.x = inverse(norm(n)) * n;
      E.z = exact::cross(E.x, E.y);
      b = exact::dot(E.z, z);
      c = exact::dot(E.y, z);
      per_b = inverse(b);
      a = E.transposed(vector(0));
      p = E.transposed(vector(3));
      q = E.transposed(vector(4));
    }

    /// e_x . e_z,x; the others are kappa_x = p_z/Y and kappa_z = -p_x/Y.
    S kappa_y() const { return per_b * (q.x - c * per_Y * p.x); }

    /// f_i = d(sigma . z)/dx_i.  Turning the frame by w (in its own axes) counts with T; of r_y and r_z
    ///     w = (dr_y,z/Y, (dr_z,x + c w_z)/b, -dr_y,x/Y),   dc = dr_z,y + b w_x,   db = dr_z,z - c w_x.
    void pull_back(const Z& sigma, std::array<exact::Vec<S>, n_x>& f) const {
      const exact::Vec<S> n{sigma[0], sigma[1], sigma[2]};
      const double m_x = sigma[3], m_y = sigma[4], m_z = sigma[5];
      const exact::Vec<S> f_p{-per_Y * (S(m_z) + m_y * (per_b * c)), 0.0, m_x * per_Y};
      const exact::Vec<S> f_q{m_y * per_b, 0.0, 0.0};
      const exact::Vec<S> T = exact::cross(n, a) + exact::cross(f_p, p) + exact::cross(f_q, q);
      const S f_Y = -per_Y * exact::dot(f_p, p), f_c = -m_y * (per_Y * per_b * p.x),
              f_b = -m_y * (per_b * kappa_y());
      const S T_x = T.x + b * f_c - c * f_b, T_z = T.z + per_b * c * T.y;
      f[0] = E * n;
      f[1] = E * exact::Vec<S>{-per_Y * T_z, f_Y, per_Y * T_x};
      f[2] = E * exact::Vec<S>{per_b * T.y, f_c, f_b};
      f[3] = E * f_p;
      f[4] = E * f_q;
    }
  };
};

}  // namespace flexura::beam::ancf
