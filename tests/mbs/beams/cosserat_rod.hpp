// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <stdexcept>

/// A clamped rod under a dead force at its tip by the equations of Simo and Reissner themselves, no elements:
///
///     r' = R (e_1 + gamma),   R' = R (k_0 + kappa)^,   m' = -r' x F,   [gamma; kappa] = C^-1 [R^T F; R^T m],   m(L) = 0
///
/// (S. S. Antman, Nonlinear Problems of Elasticity, ch. VIII) from the clamp to the tip by Kutta's method, with the moment at the
/// clamp that leaves none at the tip by Newton's.  The force grows by steps.
namespace flexura::mbs::beams {

class CosseratRod {
 public:
  /// C: of N, V_y, V_z, T, M_y, M_z; k_0: stress-free twist and curvature.  The error falls with the fourth power of the steps.
  CosseratRod(double L, const Eigen::Matrix<double, 6, 6>& C,
              const Eigen::Vector3d& k_0 = Eigen::Vector3d::Zero(), int steps = 400)
      : L(L), compliance(C.inverse()), k_0(k_0), steps(steps) {}

  struct Section {
    Eigen::Vector3d r = Eigen::Vector3d::Zero(), m;
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  };

  Section tip(const Eigen::Vector3d& force, int loads = 10) const {
    Eigen::Vector3d m = Eigen::Vector3d::Zero();
    Section end;
    for (int load = 1; load <= loads; ++load) {
      const Eigen::Vector3d F = force * load / loads;
      const double size = F.norm() * L;
      for (int i = 0;; ++i) {
        if (i > 50) throw std::runtime_error("the rod's moment was not found");
        end = integrate(F, m);
        Eigen::Matrix3d J;
        for (int k = 0; k < 3; ++k) {
          const Eigen::Vector3d h = 1e-6 * size * Eigen::Vector3d::Unit(k);
          J.col(k) = (integrate(F, m + h).m - integrate(F, m - h).m) / (2e-6 * size);
        }
        const Eigen::Vector3d step = J.lu().solve(end.m);
        m -= step;
        if (step.norm() < 1e-11 * size) break;
      }
    }
    return end;
  }

 private:
  Section slope(const Section& at, const Eigen::Vector3d& F) const {
    Eigen::Matrix<double, 6, 1> stress;
    stress << at.R.transpose() * F, at.R.transpose() * at.m;
    const Eigen::Matrix<double, 6, 1> strain = compliance * stress;
    const Eigen::Vector3d k = k_0 + strain.tail<3>();
    Section d;
    d.r = at.R * (Eigen::Vector3d::UnitX() + strain.head<3>());
    d.m = -d.r.cross(F);
    for (int i = 0; i < 3; ++i) d.R.col(i) = at.R * k.cross(Eigen::Vector3d::Unit(i));
    return d;
  }
  Section integrate(const Eigen::Vector3d& F, const Eigen::Vector3d& m_0) const {
    const double h = L / steps;
    const auto ahead = [](const Section& at, double l, const Section& d) {
      Section to;
      to.r = at.r + l * d.r;
      to.R = at.R + l * d.R;
      to.m = at.m + l * d.m;
      return to;
    };
    Section at;
    at.m = m_0;
    for (int i = 0; i < steps; ++i) {
      const Section a = slope(at, F), b = slope(ahead(at, 0.5 * h, a), F),
                    c = slope(ahead(at, 0.5 * h, b), F), d = slope(ahead(at, h, c), F);
      at = ahead(ahead(ahead(ahead(at, h / 6.0, a), h / 3.0, b), h / 3.0, c), h / 6.0, d);
    }
    return at;
  }

  double L;
  Eigen::Matrix<double, 6, 6> compliance;
  Eigen::Vector3d k_0;
  int steps;
};

}  // namespace flexura::mbs::beams
