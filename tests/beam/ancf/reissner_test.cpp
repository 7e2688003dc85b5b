// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The fully parametrised beam against Reissner's, however thick: strains Gamma = R^T r' - e_x, kappa = axial(R^T R'), and
// (N, V_y, V_z, T, M_y, M_z) = C (Gamma, kappa) of the unstretched section.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <random>

#include "beam/ancf/ancf_kinematics.hpp"
#include "beam/ancf/ancf_statics.hpp"
#include "beam/ancf/frequencies.hpp"
#include "tests/beam/ancf/samples.hpp"

namespace flexura::beam::ancf {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

class Draw {
 public:
  explicit Draw(unsigned seed) : source_(seed) {}
  double in(double from, double to) { return std::uniform_real_distribution<double>(from, to)(source_); }
  double log_in(double from, double to) { return std::exp(in(std::log(from), std::log(to))); }
  Vector3d vector() { return {in(-1, 1), in(-1, 1), in(-1, 1)}; }

 private:
  std::mt19937 source_;
};

/// A cantilever of length 1 under dead loads at its tip, by its own equations: from any section at the tip backwards to the
/// root, and turned so that the root stands along x.  r' = R (e_x + Gamma), R' = R kappa^, m' = -r' x F by Runge and Kutta.
struct Bent {
  std::vector<Vector3d> r, r_x;  // at the nodes
  std::vector<Matrix3d> R;
  Vector3d F, M;      // at the tip
  double turn = 0.0;  // largest curvature
};

Bent exact_cantilever(const Matrix6d& C, const Vector3d& F, const Vector3d& M, int elements) {
  constexpr int kSteps = 320;  // a multiple of the elements: their error is (3/320)^4 / 100 = 1e-10
  const Matrix6d f = C.inverse();
  struct Y {
    Vector3d r = Vector3d::Zero(), m;
    Matrix3d R = Matrix3d::Identity();
  };
  const auto strain = [&](const Y& y) -> Vector6d {
    Vector6d s;
    s << y.R.transpose() * F, y.R.transpose() * y.m;
    return f * s;
  };
  const auto rate = [&](const Y& y) {
    const Vector6d e = strain(y);
    Y out;
    out.r = y.R * (Vector3d::UnitX() + e.head<3>());
    out.m = -out.r.cross(F);
    const Vector3d k = e.tail<3>();
    Matrix3d k_hat;
    k_hat << 0, -k.z(), k.y(), k.z(), 0, -k.x(), -k.y(), k.x(), 0;
    out.R = y.R * k_hat;
    return out;
  };
  const auto plus = [](const Y& y, double h, const Y& d) {
    Y out;
    out.r = y.r + h * d.r;
    out.m = y.m + h * d.m;
    out.R = y.R + h * d.R;
    return out;
  };
  Y y;
  y.m = M;
  std::vector<Y> at = {y};
  Bent out;
  const double h = -1.0 / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const Y a = rate(y), b = rate(plus(y, h / 2, a)), c = rate(plus(y, h / 2, b)), d = rate(plus(y, h, c));
    y = plus(plus(plus(plus(y, h / 6, a), h / 3, b), h / 3, c), h / 6, d);
    out.turn = std::max(out.turn, strain(y).tail<3>().norm());
    if ((i + 1) % (kSteps / elements) == 0) at.push_back(y);
  }
  const Matrix3d back = y.R.transpose();
  for (auto node = at.rbegin(); node != at.rend(); ++node) {
    out.r.push_back(back * (node->r - y.r));
    out.R.push_back(back * node->R);
    out.r_x.push_back(out.R.back() * (Vector3d::UnitX() + strain(*node).head<3>()));
  }
  out.F = back * F;
  out.M = back * M;
  return out;
}

// 200 beams of any section, with all its couplings, whose stretch is 1e6 to 30 times as stiff as their bending: bent by up
// to two radians out of any plane, twisted, and the thick ones stretched and sheared by up to a tenth.
TEST(AncfReissner, BeamsStretchedBentAndTwistedConvergeWithOrder2) {
  Draw draw(1);
  for (int sample = 0; sample < 200; ++sample) {
    SCOPED_TRACE(sample);
    double error[2];
    const double EI = draw.log_in(1e-6, 3e-2), EA = 1.0;
    Vector6d stiffness;
    stiffness << EA, EA * draw.in(0.2, 0.5), EA * draw.in(0.2, 0.5), EI * draw.in(0.5, 2), EI,
        EI * draw.in(1, 3);
    Matrix6d coupled = Matrix6d::Identity();
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < i; ++j) coupled(i, j) = coupled(j, i) = draw.in(-0.15, 0.15);
    const Vector6d root = stiffness.cwiseSqrt();
    const Matrix6d C = root.asDiagonal() * coupled * root.asDiagonal();
    const Vector3d F = EI * draw.vector(), M = EI * draw.vector();
    BeamSection section = uncoupled_section(1, 1, 1, 1, 1, 1, 1, EI, EI);
    section.C = C;
    for (const int k : {0, 1}) {
      const int n = k == 0 ? 8 : 16;
      const Bent exact = exact_cantilever(C, F, M, n);
      const AncfBody body = spatial_beam(section, straight_curve({0, 0, 0}, {1, 0, 0}, n));
      // From the exact shape on, so that of several equilibria it is this one.
      VectorXd q = body.rest();
      for (int i = 0; i <= n; ++i) {
        q.segment<3>(body.index(i, 0)) = exact.r[static_cast<std::size_t>(i)];
        q.segment<3>(body.index(i, 1)) = exact.r_x[static_cast<std::size_t>(i)];
        q.segment<3>(body.index(i, 2)) = exact.R[static_cast<std::size_t>(i)].col(1);
        q.segment<3>(body.index(i, 3)) = exact.R[static_cast<std::size_t>(i)].col(2);
      }
      Problem problem = held(body, kBeamClamp);
      const MaterialPoint tip = body.locate(1.0);
      problem.loads.push_back([&](double, const VectorXd& at, VectorRef f, Triplets* df_dq) {
        add_point_force(body, tip, exact.F, f);
        add_point_moment(body, tip, at, exact.M, f, df_dq);
      });
      const VectorXd found = solve_static(problem, q).q;
      const PointKinematics end = evaluate_point(body, tip, found, VectorXd::Zero(body.n_q()));
      error[k] = (end.p_WoP_W - exact.r.back()).norm() + (end.R_WS - exact.R.back()).norm();
      // The linear part errs by 1 / (4 n^2) of a deflection, the bent one by parts of theta^2, the turn of an element.
      const double theta = exact.turn / n;
      EXPECT_LT(error[k], exact.turn * (1.0 / (n * n) + theta * theta)) << "EI/EA " << EI << ", n " << n;
    }
    EXPECT_NEAR(error[0] / error[1], 4.0, 0.8) << "EI/EA " << EI;  // theta is up to 0.3, and theta^4 follows
  }
}

// A beam between a hinge and one that slides, under the tension N: of length lambda = 1 + N/EA, its vibrations are
// w = W sin k x, psi = Psi cos k x exactly, k = pi,
//   omega^2 m W = k^2 GA W - k (lambda GA - N) Psi
//   omega^2 rho_I Psi = (k^2 EI + lambda (lambda GA - N)) Psi - k (lambda GA - N) W,
// Timoshenko's at N = 0 and Euler's load at omega = 0 of a thin one.
TEST(AncfReissner, StretchedBeamsVibrateAsTheirEquationsSay) {
  Draw draw(2);
  double sum[2] = {0.0, 0.0};
  for (int sample = 0; sample < 20; ++sample) {
    const double EI = draw.log_in(1e-4, 1e-2), GA = draw.in(0.2, 0.5), k = M_PI, m = 1.0, rho_I = m * EI;
    const double N = draw.in(-0.5 * k * k * EI, 0.2), lambda = 1.0 + N;
    const double a = k * k * GA, b = -k * (lambda * GA - N), c = k * k * EI + lambda * (lambda * GA - N);
    const double trace = a / m + c / rho_I, product = (a * c - b * b) / (m * rho_I);
    const double omega = std::sqrt(2.0 * product / (trace + std::sqrt(trace * trace - 4.0 * product)));
    for (const int i : {0, 1}) {
      const int n = i == 0 ? 4 : 8;
      const AncfBody body = spatial_beam(uncoupled_section(1.0, GA, GA, 2 * EI, EI, 2 * EI, m, rho_I, rho_I),
                                         straight_curve({0, 0, 0}, {1, 0, 0}, n));
      VectorXd q = body.rest();
      for (int node = 0; node <= n; ++node) q.segment<6>(body.index(node, 0)) *= lambda;
      const Problem problem =
          held(body, {0, 1, 2, body.index(0, 2) + 2, body.index(n, 0) + 1, body.index(n, 0) + 2});
      const double found = vibrations(problem, q, VectorXd(), omega).s[0].imag();
      // Linear sections in an element take k l as their curvature's angle: (k l)^2 / 24 high of the bending's part of
      // omega^2, which the pressure makes twice as much of it at the most, and the higher orders.
      const double kl = k / n, error = std::abs(found / omega - 1.0);
      EXPECT_LT(error, kl * kl / 12.0) << "EI " << EI << ", N " << N << ", n " << n;
      sum[i] += error;
    }
  }
  EXPECT_GT(sum[0], 3.5 * sum[1]);
}

// A beam that spins about its root stretches: (EA r')' + m w^2 r = EA r'' + ..., r = sin(k x) / (k cos k), k^2 = m w^2 / EA.
TEST(AncfReissner, SpinningBeamStretchesAsItsEquationSays) {
  for (const double k : {0.1, 0.4, 0.8})  // by 0.3, 6 and 28 %
    for (const double EI : {1e-6, 1e-2}) {
      double error[2];
      for (const int i : {0, 1}) {
        const int n = i == 0 ? 4 : 8;
        const AncfBody body = spatial_beam(uncoupled_section(1, 0.4, 0.4, EI, EI, EI, 1, 1e-9, 1e-9),
                                           straight_curve({0, 0, 0}, {1, 0, 0}, n));
        Problem problem = held(body, kBeamClamp);
        problem.spin = Vector3d(0, 0, k);
        const VectorXd q = solve_static(problem, body.rest()).q;
        error[i] = std::abs(q[body.index(n, 0)] - std::sin(k) / (k * std::cos(k)));
      }
      // Cubics: order 4, (k l)^4 / 384 of the stretch; Newton's method leaves 1e-11 of a node.
      EXPECT_LT(error[1], 1e-10 + std::pow(k / 8, 4) / 384 * std::tan(k)) << k << " " << EI;
      EXPECT_LT(error[1], 1e-11 + error[0] / 12) << k << " " << EI;
    }
}

}  // namespace
}  // namespace flexura::beam::ancf
