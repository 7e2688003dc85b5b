// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/exact/element.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "beam/exact/gauss.hpp"
#include "beam/exact/kernel.hpp"

namespace flexura::beam::exact {
namespace {

using Eigen::MatrixXd;

using gauss::kAt;
using gauss::kWeight;
using gauss::polynomial_integral;

Matrix3d matrix(const Mat<double>& E) {
  Matrix3d R;
  R << values(E.x), values(E.y), values(E.z);
  return R;
}

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d s;
  s << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return s;
}

template <int N>
using Columns3 = Eigen::Matrix<double, 3, N>;

// 3 x n: the angular velocity of the section at x, in its axes, for unit rates.
template <int N>
Columns3<N> turning(const FieldOf<N>& f, double x, const Strains<double>& q,
                    const Rotation<double>& rotation) {
  Columns3<N> Theta_s = x * f.k_0;
  if (!f.is_constant) {
    const double x_3 = x * x * x / 12.0;
    const Matrix3d k_0 = x_3 * cross_matrix(values(q.k_0)), k_1 = x_3 * cross_matrix(values(q.k_1));
    Theta_s.noalias() += 0.5 * x * x * f.k_1;
    Theta_s.noalias() += k_0 * f.k_1;
    Theta_s.noalias() -= k_1 * f.k_0;
  }
  const Matrix3d Theta = cross_matrix(values(rotation.Theta)),
                 T = Matrix3d::Identity() - rotation.b * Theta + rotation.c * Theta * Theta;
  return T * Theta_s;
}

// At point h: the rates of the angular velocity and of E c, in the start's axes.
template <int N>
struct Rates {
  Columns3<N> turned, moved;

  Rates(const FieldOf<N>& f, double x, const Strains<double>& q, const Vec<double>& c,
        const Rotation<double>& rotation, const Matrix3d& E) {
    const Columns3<N> own = turning<N>(f, x, q, rotation);
    turned.noalias() = E * own;
    Columns3<N> of_c = f.g_0;
    if (!f.is_constant) of_c += x * f.g_1;
    of_c.noalias() -= cross_matrix(values(c)) * own;
    moved.noalias() = E * of_c;
  }
};

template <int N>
std::array<Dual<N>, Element::kMost> constants(const double* x) {
  std::array<Dual<N>, Element::kMost> out;
  for (int i = 0; i < N && x; ++i) out[static_cast<std::size_t>(i)] = Dual<N>(x[i]);
  return out;
}
template <int N>
std::array<Dual<N>, Element::kMost> variables(const double* x) {
  std::array<Dual<N>, Element::kMost> out;
  for (int i = 0; i < N; ++i) out[static_cast<std::size_t>(i)] = Dual<N>::variable(x[i], i);
  return out;
}
// Rows of derivatives.
template <int N, class Rows>
void set_rows(const Vec<Dual<N>>& a, Rows&& rows) {
  for (int j = 0; j < N; ++j) {
    const auto i = static_cast<std::size_t>(j);
    rows(0, j) = a.x.d[i];
    rows(1, j) = a.y.d[i];
    rows(2, j) = a.z.d[i];
  }
}

// The kinds of strain fields there are have so many coordinates.
template <class F>
void with_size(int n, F&& f) {
  switch (n) {
    case 3:
      return f(std::integral_constant<int, 3>());
    case 6:
      return f(std::integral_constant<int, 6>());
    default:
      return f(std::integral_constant<int, Element::kMost>());
  }
}

void set_motion(const SectionMotion<double>& x, Element::Motion& out) {
  const Mat<double>& E = x.turned.rotation.E;
  out.R = matrix(E);
  out.p = values(x.r);
  out.V << values(E * x.turned.w), values(x.v);
  out.A << values(E * x.turned.w_dot), values(x.a);
}

}  // namespace

Element::Element(StrainField field, double length, const SectionInertia& inertia, const Vector6d& rest_strain)
    : field_(std::move(field)),
      length_(length),
      inertia_(inertia),
      rest_(rest_strain),
      has_offset_(inertia.m_y != 0.0 || inertia.m_z != 0.0) {
  if (const int n = field_.n(); n != 3 && n != 6 && n != kMost)
    throw std::invalid_argument(fmt::format(
        "a strain field has {} coordinates; it must have {} (beam), 6 (rod) or 3 (cable)", n, kMost));
  for (std::size_t h = 0; h < kPoints; ++h) {
    points_[h] = place(kAt[h] * length);
    mass_weight_[h] = kWeight[h] * length;
  }
}

Element::Place Element::place(double x) const {
  Place out;
  out.x = x;
  for (std::size_t h = 0; h < kPoints; ++h) out.weight[h] = length_ * polynomial_integral(h, x / length_);
  return out;
}

Element::Motion Element::motion(const Place& place, const double* s, const double* s_dot,
                                const double* s_ddot) const {
  Motion out;
  with_size(n(), [&](auto size) {
    const Kernel<decltype(size)::value> kernel(*this);
    const Strains<double> q = kernel.template strains<double>(s, true);
    Strains<double> q_dot, q_ddot;
    if (s_dot) q_dot = kernel.template strains<double>(s_dot, false);
    if (s_ddot) q_ddot = kernel.template strains<double>(s_ddot, false);
    set_motion(kernel.motion(place, q, s_dot ? &q_dot : nullptr, s_ddot ? &q_ddot : nullptr), out);
  });
  return out;
}

void Element::map(const Place& place, const double* s, Columns& out) const {
  Motion at;
  motion_and_map(place, s, nullptr, nullptr, at, out);
}

void Element::motion_and_map(const Place& place, const double* s, const double* s_dot, const double* s_ddot,
                             Motion& out, Columns& map) const {
  map.resize(6, n());
  with_size(n(), [&](auto size) {
    constexpr int N = decltype(size)::value;
    const Kernel<N> kernel(*this);
    const Strains<double> q = kernel.template strains<double>(s, true);
    Strains<double> q_dot, q_ddot;
    if (s_dot) q_dot = kernel.template strains<double>(s_dot, false);
    if (s_ddot) q_ddot = kernel.template strains<double>(s_ddot, false);
    const auto *rate = s_dot ? &q_dot : nullptr, *second = s_ddot ? &q_ddot : nullptr;
    const Points<double> points = kernel.template points<double>(q, rate, second);
    SectionMotion<double> at{kernel.turn(place.x, q, rate, second), {}, {}, {}};
    kernel.add_sums(place, points, at.r, at.v, at.a);
    set_motion(at, out);
    Eigen::Map<Eigen::Matrix<double, 6, N>> to(map.data());
    to.template topRows<3>().noalias() =
        matrix(at.turned.rotation.E) * turning<N>(kernel.field, place.x, q, at.turned.rotation);
    Columns3<N> moved = Columns3<N>::Zero();
    for (std::size_t h = 0; h < kPoints; ++h) {
      const Rotation<double>& rotation = points.at[h].turned.rotation;
      const Rates<N> rates(kernel.field, points_[h].x, q, q.c[h], rotation, matrix(rotation.E));
      moved += place.weight[h] * rates.moved;
    }
    to.template bottomRows<3>() = moved;
  });
}

void Element::motion_tangents(const Place& place, const double* s, const double* s_dot, const double* s_ddot,
                              const Vector6d& wrench, MotionTangents& out) const {
  for (Columns* x : {&out.V_s, &out.A_s, &out.A_v}) x->resize(6, n());
  out.map_s.resize(n(), n());
  with_size(n(), [&](auto size) {
    constexpr int N = decltype(size)::value;
    using S = Dual<N>;
    const Kernel<N> kernel(*this);
    const auto vary = [&](const auto& x, const auto& x_dot, Columns* V, Columns& A) {
      const auto x_ddot = constants<N>(s_ddot);
      const Strains<S> q = kernel.strains(x.data(), true), q_dot = kernel.strains(x_dot.data(), false),
                       q_ddot = kernel.strains(x_ddot.data(), false);
      const SectionMotion<S> at = kernel.motion(place, q, &q_dot, &q_ddot);
      const Mat<S>& E = at.turned.rotation.E;
      if (V) {
        set_rows(E * at.turned.w, V->template topRows<3>());
        set_rows(at.v, V->template bottomRows<3>());
      }
      set_rows(E * at.turned.w_dot, A.template topRows<3>());
      set_rows(at.a, A.template bottomRows<3>());
    };
    const auto at = variables<N>(s);
    vary(at, constants<N>(s_dot), &out.V_s, out.A_s);
    vary(constants<N>(s), variables<N>(s_dot), nullptr, out.A_v);
    std::array<S, kMost> forces;
    kernel.forces_at(place, at.data(), wrench, forces.data());
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j)
        out.map_s(i, j) = forces[static_cast<std::size_t>(i)].d[static_cast<std::size_t>(j)];
  });
}

void Element::integrate(const double* s, Integrals& out) const {
  out.C_t.resize(3, n());
  out.C_r.resize(3, n());
  out.M.resize(n(), n());
  with_size(n(), [&](auto size) { integrate_in<decltype(size)::value>(s, out); });
}

template <int N>
void Element::integrate_in(const double* s, Integrals& out) const {
  const Kernel<N> kernel(*this);
  const Strains<double> q = kernel.template strains<double>(s, true);
  const Points<double> at = kernel.template points<double>(q, nullptr, nullptr);
  const Vector3d first(0.0, inertia_.m_y, inertia_.m_z);
  Matrix3d I;
  I << inertia_.m_yy + inertia_.m_zz, 0, 0, 0, inertia_.m_zz, -inertia_.m_yz, 0, -inertia_.m_yz,
      inertia_.m_yy;

  const auto rates = [&](std::size_t h) {
    const Rotation<double>& rotation = at.at[h].turned.rotation;
    return Rates<N>(kernel.field, points_[h].x, q, q.c[h], rotation, matrix(rotation.E));
  };
  const std::array<Rates<N>, kPoints> moves = {rates(0), rates(1), rates(2), rates(3)};
  Eigen::Map<Columns3<N>> C_t(out.C_t.data()), C_r(out.C_r.data());
  Eigen::Map<Eigen::Matrix<double, N, N>> M(out.M.data());
  out.d.setZero();
  out.J.setZero();
  C_t.setZero();
  C_r.setZero();
  M.setZero();
  for (std::size_t g = 0; g < kPoints; ++g) {
    Vector3d r = Vector3d::Zero();
    Columns3<N> U = Columns3<N>::Zero();
    for (std::size_t h = 0; h < kPoints; ++h) {
      r += points_[g].weight[h] * values(at.at[h].p);
      U += points_[g].weight[h] * moves[h].moved;
    }
    const Columns3<N>& turned = moves[g].turned;
    const Matrix3d E = matrix(at.at[g].turned.rotation.E), EI = mass_weight_[g] * E * I,
                   I_g = EI * E.transpose();
    const double m = mass_weight_[g] * inertia_.m;
    const Columns3<N> mU = m * U, I_turned = I_g * turned;
    out.d += m * r;
    out.J += m * (r.squaredNorm() * Matrix3d::Identity() - r * r.transpose()) + I_g;
    C_t += mU;
    C_r.noalias() += cross_matrix(r) * mU;
    C_r += I_turned;
    M.noalias() += U.transpose() * mU;
    M.noalias() += turned.transpose() * I_turned;
    if (!has_offset_) continue;
    const Vector3d S = mass_weight_[g] * (E * first);
    const Columns3<N> swung = -cross_matrix(S) * turned;  // (E w) x S
    out.d += S;
    out.J += 2.0 * r.dot(S) * Matrix3d::Identity() - r * S.transpose() - S * r.transpose();
    C_t += swung;
    C_r.noalias() += cross_matrix(S) * U;
    C_r.noalias() += cross_matrix(r) * swung;
    const Eigen::Matrix<double, N, N> mixed = U.transpose() * swung;
    M += mixed + mixed.transpose();
  }
}

Vector6d Element::inertia_force(const double* s, const double* s_dot, const double* s_ddot,
                                const Carried& start, double* need) const {
  Vec<double> torque, force;
  with_size(n(), [&](auto size) {
    Kernel<decltype(size)::value>(*this).inertia(s, s_dot, s_ddot, vec<double>(start.w),
                                                 vec<double>(start.alpha), vec<double>(start.a), torque,
                                                 force, need);
  });
  Vector6d out;
  out << values(torque), values(force);
  return out;
}

void Element::inertia_tangents(const double* s, const double* s_dot, const double* s_ddot,
                               const Carried& start, InertiaTangents& out) const {
  for (Columns* x : {&out.wrench_s, &out.wrench_v}) x->resize(6, n());
  for (MatrixXd* x : {&out.need_s, &out.need_v}) x->resize(n(), n());
  with_size(n(), [&](auto size) {
    constexpr int N = decltype(size)::value;
    using S = Dual<N>;
    const Kernel<N> kernel(*this);
    const auto vary = [&](const auto& x, const auto& x_dot, Columns& wrench, MatrixXd& need) {
      const auto x_ddot = constants<N>(s_ddot);
      Vec<S> torque, force;
      std::array<S, kMost> forces;
      kernel.inertia(x.data(), x_dot.data(), x_ddot.data(), vec<S>(start.w), vec<S>(start.alpha),
                     vec<S>(start.a), torque, force, forces.data());
      set_rows(torque, wrench.template topRows<3>());
      set_rows(force, wrench.template bottomRows<3>());
      for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j)
          need(i, j) = forces[static_cast<std::size_t>(i)].d[static_cast<std::size_t>(j)];
    };
    vary(variables<N>(s), constants<N>(s_dot), out.wrench_s, out.need_s);
    vary(constants<N>(s), variables<N>(s_dot), out.wrench_v, out.need_v);
  });
}

void Element::turning_tangents(const double* s, const double* s_dot, const Vector3d& w,
                               Eigen::Matrix<double, 6, 3>& wrench_w,
                               Eigen::Matrix<double, Eigen::Dynamic, 3>& need_w) const {
  using S = Dual<3>;
  std::array<S, kMost> x, x_dot, x_ddot, forces;
  for (int i = 0; i < n(); ++i) {
    x[static_cast<std::size_t>(i)] = S(s[i]);
    x_dot[static_cast<std::size_t>(i)] = S(s_dot[i]);
  }
  const Vec<S> turn{S::variable(w.x(), 0), S::variable(w.y(), 1), S::variable(w.z(), 2)};
  Vec<S> torque, force;
  with_size(n(), [&](auto size) {
    Kernel<decltype(size)::value>(*this).inertia(x.data(), x_dot.data(), x_ddot.data(), turn, Vec<S>{},
                                                 Vec<S>{}, torque, force, forces.data());
  });
  set_rows(torque, wrench_w.topRows<3>());
  set_rows(force, wrench_w.bottomRows<3>());
  need_w.resize(n(), 3);
  for (int i = 0; i < n(); ++i)
    for (int j = 0; j < 3; ++j)
      need_w(i, j) = forces[static_cast<std::size_t>(i)].d[static_cast<std::size_t>(j)];
}

}  // namespace flexura::beam::exact
