// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "beam/exact/element.hpp"
#include "beam/exact/rotation.hpp"

/// Element's equations for numbers of any kind: plain ones, and those that carry derivatives (dual.hpp).
namespace flexura::beam::exact {

template <class S>
Vec<S> vec(const Vector3d& a) {
  return {S(a.x()), S(a.y()), S(a.z())};
}
template <class S>
Vector3d values(const Vec<S>& a) {
  return {value(a.x), value(a.y), value(a.z)};
}

/// All strains of one state of the element, or their rates.
template <class S>
struct Strains {
  Vec<S> k_0, k_1;
  std::array<Vec<S>, Element::kPoints> c;  ///< e_1 + gamma at the points
};

/// The axes of a section, Theta and its rates, and the section's angular velocity and acceleration in them.
template <class S>
struct Turned {
  Rotation<S> rotation;
  Vec<S> w, w_dot;
};

/// What the four points say of one state.
template <class S>
struct Points {
  struct Point {
    Turned<S> turned;
    Vec<S> p, v, a;  ///< E c and its derivatives by time
  };
  std::array<Point, Element::kPoints> at;
};

template <class S>
struct SectionMotion {
  Turned<S> turned;
  Vec<S> r, v, a;
};

/// A strain field of N coordinates.
template <int N>
struct FieldOf {
  using Columns = Eigen::Map<const Eigen::Matrix<double, 3, N>>;
  explicit FieldOf(const StrainField& f)
      : k_0(f.k_0.data()),
        k_1(f.k_1.data()),
        g_0(f.g_0.data()),
        g_1(f.g_1.data()),
        is_constant(f.is_constant) {}
  Columns k_0, k_1, g_0, g_1;
  bool is_constant;  ///< k_1 = g_1 = 0
};

/// Of an element with N coordinates.
template <int N>
struct Kernel {
  explicit Kernel(const Element& of) : e(of), field(of.field_) {}
  const Element& e;
  const FieldOf<N> field;

  /// With the stress-free strains where `whole`.
  template <class S>
  Strains<S> strains(const S* s, bool whole) const {
    Strains<S> out;
    Vec<S> g_0, g_1;
    if (whole) {
      g_0 = vec<S>(Vector3d(1.0 + e.rest_(0), e.rest_(1), e.rest_(2)));
      out.k_0 = vec<S>(e.rest_.template tail<3>());
    }
    const auto add_all = [&](Vec<S>& to, const typename FieldOf<N>::Columns& columns) {
      for (int j = 0; j < N; ++j) {
        if (std::is_same_v<S, double> || columns(0, j) != 0.0) to.x += columns(0, j) * s[j];
        if (std::is_same_v<S, double> || columns(1, j) != 0.0) to.y += columns(1, j) * s[j];
        if (std::is_same_v<S, double> || columns(2, j) != 0.0) to.z += columns(2, j) * s[j];
      }
    };
    add_all(out.k_0, field.k_0);
    add_all(g_0, field.g_0);
    if (!field.is_constant) {
      add_all(out.k_1, field.k_1);
      add_all(g_1, field.g_1);
    }
    for (int h = 0; h < Element::kPoints; ++h) {
      const auto i = static_cast<std::size_t>(h);
      out.c[i] = g_0 + e.points_[i].x * g_1;
    }
    return out;
  }

  template <class S>
  static Turned<S> turn(double x, const Strains<S>& q, const Strains<S>* q_dot, const Strains<S>* q_ddot) {
    const double x_2 = 0.5 * x * x, x_3 = x * x * x / 12.0;
    Turned<S> out{Rotation<S>(x * q.k_0 + x_2 * q.k_1 + x_3 * cross(q.k_0, q.k_1)), {}, {}};
    if (!q_dot) return out;
    const Vec<S> rate =
        x * q_dot->k_0 + x_2 * q_dot->k_1 + x_3 * (cross(q_dot->k_0, q.k_1) + cross(q.k_0, q_dot->k_1));
    out.w = out.rotation.tangent(rate);
    if (!q_ddot) return out;
    const Vec<S> second =
        x * q_ddot->k_0 + x_2 * q_ddot->k_1 +
        x_3 * (cross(q_ddot->k_0, q.k_1) + 2.0 * cross(q_dot->k_0, q_dot->k_1) + cross(q.k_0, q_ddot->k_1));
    out.w_dot = out.rotation.tangent(second) + out.rotation.bias(rate);
    return out;
  }

  template <class S>
  Points<S> points(const Strains<S>& q, const Strains<S>* q_dot, const Strains<S>* q_ddot) const {
    const auto at = [&](std::size_t h) {
      const Vec<S>& c = q.c[h];
      typename Points<S>::Point out{turn(e.points_[h].x, q, q_dot, q_ddot), {}, {}, {}};
      const Mat<S>& E = out.turned.rotation.E;
      const Vec<S>&w = out.turned.w, &w_dot = out.turned.w_dot;
      out.p = E * c;
      if (!q_dot) return out;
      const Vec<S> w_c = cross(w, c);
      out.v = E * (w_c + q_dot->c[h]);
      if (!q_ddot) return out;
      out.a = E * (cross(w_dot, c) + cross(w, w_c + 2.0 * q_dot->c[h]) + q_ddot->c[h]);
      return out;
    };
    return {{at(0), at(1), at(2), at(3)}};
  }

  template <class S>
  void add_sums(const Element::Place& place, const Points<S>& points, Vec<S>& r, Vec<S>& v, Vec<S>& a) const {
    for (std::size_t h = 0; h < Element::kPoints; ++h) {
      r += place.weight[h] * points.at[h].p;
      v += place.weight[h] * points.at[h].v;
      a += place.weight[h] * points.at[h].a;
    }
  }

  template <class S>
  SectionMotion<S> motion(const Element::Place& place, const Strains<S>& q, const Strains<S>* q_dot,
                          const Strains<S>* q_ddot) const {
    SectionMotion<S> out{turn(place.x, q, q_dot, q_ddot), {}, {}, {}};
    add_sums(place, points(q, q_dot, q_ddot), out.r, out.v, out.a);
    return out;
  }

  /// Generalised forces on the strains themselves.
  template <class S>
  struct StrainForces {
    Vec<S> k_0, k_1;
    std::array<Vec<S>, Element::kPoints> c;

    /// Of a moment on the section at x, in the section's axes.
    void add_moment(double x, const Strains<S>& q, const Rotation<S>& rotation, const Vec<S>& moment) {
      const Vec<S> tau = rotation.transposed_tangent(moment);
      const double x_3 = x * x * x / 12.0;
      k_0 += x * tau + x_3 * cross(q.k_1, tau);
      k_1 += 0.5 * x * x * tau + x_3 * cross(tau, q.k_0);
    }
  };

  /// What P_h at the points' E c do.
  template <class S>
  void add_forces(const Strains<S>& q, const Points<S>& points, const std::array<Vec<S>, Element::kPoints>& P,
                  StrainForces<S>& out) const {
    for (std::size_t h = 0; h < Element::kPoints; ++h) {
      const Rotation<S>& rotation = points.at[h].turned.rotation;
      const Vec<S> f = rotation.E.transposed(P[h]);
      out.c[h] += f;
      out.add_moment(e.points_[h].x, q, rotation, cross(q.c[h], f));
    }
  }

  template <class S>
  void project(const StrainForces<S>& f, S* out) const {
    Vec<S> on_0, on_1;
    for (std::size_t h = 0; h < Element::kPoints; ++h) {
      on_0 += f.c[h];
      on_1 += e.points_[h].x * f.c[h];
    }
    for (int j = 0; j < N; ++j) {
      S sum(0.0);
      const auto add = [&](const Vec<S>& force, const typename FieldOf<N>::Columns& columns) {
        if (std::is_same_v<S, double> || columns(0, j) != 0.0) sum += columns(0, j) * force.x;
        if (std::is_same_v<S, double> || columns(1, j) != 0.0) sum += columns(1, j) * force.y;
        if (std::is_same_v<S, double> || columns(2, j) != 0.0) sum += columns(2, j) * force.z;
      };
      add(f.k_0, field.k_0);
      add(on_0, field.g_0);
      if (!field.is_constant) {
        add(f.k_1, field.k_1);
        add(on_1, field.g_1);
      }
      out[j] = sum;
    }
  }

  /// map^T wrench at a section.
  template <class S>
  void forces_at(const Element::Place& place, const S* s, const Vector6d& wrench, S* out) const {
    const Strains<S> q = strains<S>(s, true);
    const Points<S> at = points<S>(q, nullptr, nullptr);
    const Vec<S> force = vec<S>(wrench.tail<3>());
    std::array<Vec<S>, Element::kPoints> P;
    for (std::size_t h = 0; h < Element::kPoints; ++h) P[h] = place.weight[h] * force;
    StrainForces<S> f;
    add_forces(q, at, P, f);
    const Turned<S> end = turn<S>(place.x, q, nullptr, nullptr);
    f.add_moment(place.x, q, end.rotation, end.rotation.E.transposed(vec<S>(wrench.head<3>())));
    project(f, out);
  }

  /// Torque about the start and force of the inertia, and its generalised forces.
  template <class S>
  void inertia(const S* s, const S* s_dot, const S* s_ddot, const Vec<S>& w, const Vec<S>& alpha,
               const Vec<S>& a, Vec<S>& torque, Vec<S>& force, S* need) const {
    const Strains<S> q = strains<S>(s, true), q_dot = strains<S>(s_dot, false),
                     q_ddot = strains<S>(s_ddot, false);
    const Points<S> at = points(q, &q_dot, &q_ddot);
    const SectionInertia& I = e.inertia_;
    const Vec<S> first{S(0.0), S(I.m_y), S(I.m_z)};
    const auto turned_inertia = [&](const Vec<S>& x) -> Vec<S> {
      return {(I.m_yy + I.m_zz) * x.x, I.m_zz * x.y - I.m_yz * x.z, I.m_yy * x.z - I.m_yz * x.y};
    };
    std::array<Vec<S>, Element::kPoints> P;
    StrainForces<S> f;
    for (std::size_t g = 0; g < Element::kPoints; ++g) {
      const auto& point = at.at[g];
      const Mat<S>& E = point.turned.rotation.E;
      Vec<S> r, v, acceleration;
      add_sums(e.points_[g], at, r, v, acceleration);
      const Vec<S> E_w = E * point.turned.w;
      const Vec<S> Omega = E.transposed(w) + point.turned.w;
      const Vec<S> Omega_dot = E.transposed(alpha + cross(w, E_w)) + point.turned.w_dot;
      acceleration += a + cross(alpha, r) + cross(w, cross(w, r) + 2.0 * v);
      Vec<S> F = I.m * acceleration;
      Vec<S> T = turned_inertia(Omega_dot) + cross(Omega, turned_inertia(Omega));
      if (e.has_offset_) {
        F += E * (cross(Omega_dot, first) + cross(Omega, cross(Omega, first)));
        T += cross(first, E.transposed(acceleration));
      }
      F = e.mass_weight_[g] * F;
      T = e.mass_weight_[g] * T;
      force += F;
      torque += cross(r, F) + E * T;
      for (std::size_t h = 0; h < Element::kPoints; ++h) P[h] += e.points_[g].weight[h] * F;
      f.add_moment(e.points_[g].x, q, point.turned.rotation, T);
    }
    add_forces(q, at, P, f);
    project(f, need);
  }
};

}  // namespace flexura::beam::exact
