// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>

#include "mbs/superelement/superelement.hpp"

/// A superelement that is exact by construction: a bar of rectangular section b x h along x, from x = 0 to L,
/// with the Euler-Bernoulli displacement field
///
///     u = (u - y v' - z w',  v - z t,  w + y t)        u, v, w, t functions of x
///
/// Interface shapes: u, t linear, v, w cubic Hermite, for six dofs at each end (theta_y = -w', theta_z = v').
/// Internal shapes: x (L - x) for u, and x^2 (L - x)^2 for v and w, which no interface shape couples to in K
/// (v'''' = 0). All integrands are polynomials of degree 8 in x and 2 in y and z, integrated exactly by 5 x 2
/// x 2 Gauss points.
namespace flexura::superelement::testing {

struct BoxBeam {
  double L = 0.8, b = 0.03, h = 0.05;         // [m]
  double E = 2.1e11, nu = 0.3, rho = 7850.0;  // steel
  Eigen::Vector3d p_BoA_B{0.3, -0.2, 0.1};    // of the end x = 0
};

namespace box_beam_detail {

struct Polynomial {
  std::array<double, 5> c{};
  double operator()(double x) const { return c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4]))); }
  Polynomial derivative() const { return {{c[1], 2 * c[2], 3 * c[3], 4 * c[4], 0.0}}; }
};

struct Shape {
  Polynomial u, v, w, t;
  Eigen::Vector3d operator()(double x, double y, double z) const {
    return {u(x) - y * v.derivative()(x) - z * w.derivative()(x), v(x) - z * t(x), w(x) + y * t(x)};
  }
};

inline std::vector<Shape> shapes(double L) {
  const Polynomial one_to_zero{{1, -1 / L}}, zero_to_one{{0, 1 / L}};
  const double L2 = L * L, L3 = L2 * L, L4 = L3 * L;
  const Polynomial deflect_1{{1, 0, -3 / L2, 2 / L3}}, slope_1{{0, 1, -2 / L, 1 / L2}};
  const Polynomial deflect_2{{0, 0, 3 / L2, -2 / L3}}, slope_2{{0, 0, -1 / L, 1 / L2}};
  const auto negative = [](Polynomial p) {
    for (double& c : p.c) c = -c;
    return p;
  };
  std::vector<Shape> all;
  for (const auto& [linear, deflect, slope] :
       {std::tuple{one_to_zero, deflect_1, slope_1}, std::tuple{zero_to_one, deflect_2, slope_2}}) {
    all.push_back({.u = linear, .v = {}, .w = {}, .t = {}});
    all.push_back({.u = {}, .v = deflect, .w = {}, .t = {}});
    all.push_back({.u = {}, .v = {}, .w = deflect, .t = {}});
    all.push_back({.u = {}, .v = {}, .w = {}, .t = linear});
    all.push_back({.u = {}, .v = {}, .w = negative(slope), .t = {}});
    all.push_back({.u = {}, .v = slope, .w = {}, .t = {}});
  }
  const Polynomial stretch_bubble{{0, 1 / L, -1 / L2}}, bend_bubble{{0, 0, 1 / L2, -2 / L3, 1 / L4}};
  all.push_back({.u = {}, .v = bend_bubble, .w = {}, .t = {}});
  all.push_back({.u = {}, .v = {}, .w = bend_bubble, .t = {}});
  all.push_back({.u = stretch_bubble, .v = {}, .w = {}, .t = {}});
  return all;
}

}  // namespace box_beam_detail

/// A point of the quadrature: its mass, its position in B, and the 15 shapes there (3 x 15).
struct BoxBeamPoint {
  double dm;
  Eigen::Vector3d x;
  Eigen::Matrix3Xd N;
};

namespace box_beam_detail {

constexpr double g5[] = {-0.90617984593866399280, -0.53846931010568309104, 0.0, 0.53846931010568309104,
                         0.90617984593866399280};
constexpr double w5[] = {0.23692688505618908751, 0.47862867049936646804, 0.56888888888888888889,
                         0.47862867049936646804, 0.23692688505618908751};

inline std::vector<BoxBeamPoint> points(const BoxBeam& beam, const std::vector<Shape>& phi) {
  const double g2 = 1 / std::sqrt(3.0);
  std::vector<BoxBeamPoint> all;
  for (int i = 0; i < 5; ++i) {
    for (const double gy : {-g2, g2}) {
      for (const double gz : {-g2, g2}) {
        const Eigen::Vector3d r(beam.L / 2 * (1 + g5[i]), beam.b / 2 * gy, beam.h / 2 * gz);
        BoxBeamPoint point{beam.rho * beam.b * beam.h * beam.L / 8 * w5[i], beam.p_BoA_B + r,
                           Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(phi.size()))};
        for (std::size_t k = 0; k < phi.size(); ++k) {
          point.N.col(static_cast<Eigen::Index>(k)) = phi[k](r[0], r[1], r[2]);
        }
        all.push_back(point);
      }
    }
  }
  return all;
}

// Internal shapes scaled to unit modal mass.
inline std::vector<Shape> normalised_shapes(const BoxBeam& beam) {
  std::vector<Shape> phi = shapes(beam.L);
  Eigen::VectorXd m = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(phi.size()));
  for (const BoxBeamPoint& p : points(beam, phi)) m += p.dm * p.N.colwise().squaredNorm().transpose();
  for (std::size_t k = 12; k < phi.size(); ++k) {
    for (Polynomial* p : {&phi[k].u, &phi[k].v, &phi[k].w}) {
      for (double& c : p->c) c /= std::sqrt(m[static_cast<Eigen::Index>(k)]);
    }
  }
  return phi;
}

}  // namespace box_beam_detail

inline std::vector<BoxBeamPoint> box_beam_points(const BoxBeam& beam = {}) {
  return box_beam_detail::points(beam, box_beam_detail::normalised_shapes(beam));
}

/// With internal shapes scaled to unit modal mass, 15 dofs.
inline Superelement make_box_beam(const BoxBeam& beam = {}) {
  using namespace box_beam_detail;
  const auto [L, b, h, E, nu, rho, p_BoA_B] = beam;
  const double A = b * h, I_y = b * h * h * h / 12, I_z = h * b * b * b / 12, I_x = I_y + I_z;
  const double GI_t = E / (2 * (1 + nu)) * I_x;  // any positive torsion constant will do here

  const std::vector<Shape> phi = normalised_shapes(beam);
  Superelement se;
  se.name = "box beam";
  se.created_by = "tests";
  se.source = "b = 0.03\nh = 0.05\n";
  se.report_json = "{\"mesh\": \"none\"}";
  se.n_b = 12;
  se.n_q = 3;
  const int n = se.n();
  const auto stiffness = [&](const Shape& k, const Shape& l) {
    double sum = 0;
    for (int i = 0; i < 5; ++i) {
      const double x = L / 2 * (1 + g5[i]), weight = L / 2 * w5[i];
      const auto second = [x](const Polynomial& p) { return p.derivative().derivative()(x); };
      sum +=
          weight * (E * A * k.u.derivative()(x) * l.u.derivative()(x) + E * I_z * second(k.v) * second(l.v) +
                    E * I_y * second(k.w) * second(l.w) + GI_t * k.t.derivative()(x) * l.t.derivative()(x));
    }
    return sum;
  };
  se.K_se = Eigen::MatrixXd(n, n);
  for (int k = 0; k < n; ++k) {
    for (int l = 0; l <= k; ++l) {
      const bool coupling_block = k >= 12 && (l < 12 || l != k);  // zero exactly, round-off by quadrature
      se.K_se(k, l) = se.K_se(l, k) =
          coupling_block ? 0.0
                         : stiffness(phi[static_cast<std::size_t>(k)], phi[static_cast<std::size_t>(l)]);
    }
  }
  se.omega2 = se.K_se.diagonal().tail(3);
  InertiaIntegrals& I = se.inertia;
  I.S_phi = Eigen::Matrix3Xd::Zero(3, n);
  I.S_xphi = Eigen::MatrixXd::Zero(9, n);
  for (auto& S : I.S_phiphi) S = Eigen::MatrixXd::Zero(n, n);
  for (const auto& [dm, r, N] : points(beam, phi)) {
    I.mass += dm;
    I.S_x += dm * r;
    I.S_xx += dm * r * r.transpose();
    I.S_phi += dm * N;
    constexpr int first[] = {0, 1, 2, 0, 1, 2}, second[] = {0, 1, 2, 1, 2, 0};
    for (int a = 0; a < 3; ++a) I.S_xphi.middleRows(3 * a, 3) += dm * r[a] * N;
    for (std::size_t p = 0; p < 6; ++p) I.S_phiphi[p] += dm * N.row(first[p]).transpose() * N.row(second[p]);
  }
  se.M_se = I.S_phiphi[0] + I.S_phiphi[1] + I.S_phiphi[2];

  for (int end = 0; end < 2; ++end) {
    Interface interface;
    interface.name = end == 0 ? "left" : "right";
    interface.tie = "rigid";
    interface.p_BoN_B = p_BoA_B + Eigen::Vector3d(end * L, 0, 0);
    for (int d = 0; d < 6; ++d) interface.directions.push_back(static_cast<Direction>(d));
    interface.first_dof = 6 * end;
    se.interfaces.push_back(interface);
  }

  // A box of four vertices at each end and the sections' shapes on them.
  se.surface.vertices.resize(8, 3);
  for (int v = 0; v < 8; ++v) {
    se.surface.vertices.row(v) =
        p_BoA_B.transpose() + Eigen::RowVector3d(v & 1 ? L : 0, (v & 2 ? b : -b) / 2, (v & 4 ? h : -h) / 2);
  }
  se.surface.triangles.resize(4, 3);
  se.surface.triangles << 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5;
  se.surface.edges.resize(4, 2);
  se.surface.edges << 0, 1, 2, 3, 4, 5, 6, 7;
  se.surface.triangle_interface = {0, 0, 1, 1};
  se.shapes.resize(24, n);
  for (int v = 0; v < 8; ++v) {
    const Eigen::RowVector3d x = se.surface.vertices.row(v) - p_BoA_B.transpose();
    for (int k = 0; k < n; ++k) {
      se.shapes.block<3, 1>(3 * v, k) = phi[static_cast<std::size_t>(k)](x[0], x[1], x[2]).cast<float>();
    }
  }
  return se;
}

}  // namespace flexura::superelement::testing
