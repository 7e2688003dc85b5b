// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/exact/planar_chain.hpp"

#include <cmath>

#include "beam/exact/gauss.hpp"
#include "beam/exact/planar_beyond.hpp"

namespace flexura::beam::exact {
namespace {

// Cosine and sine.  An element turns by a small angle: the terms left out are below 1e-17.
Vec2 direction(double angle) {
  if (std::abs(angle) > 0.5) return {std::cos(angle), std::sin(angle)};
  // (-1)^k / (2k)! and / (2k + 1)!
  constexpr double kCosine[] = {1.0,           -1.0 / 2.0,       1.0 / 24.0,        -1.0 / 720.0,
                                1.0 / 40320.0, -1.0 / 3628800.0, 1.0 / 479001600.0, -1.0 / 87178291200.0};
  constexpr double kSine[] = {1.0,
                              -1.0 / 6.0,
                              1.0 / 120.0,
                              -1.0 / 5040.0,
                              1.0 / 362880.0,
                              -1.0 / 39916800.0,
                              1.0 / 6227020800.0,
                              -1.0 / 1307674368000.0};
  const double t = angle * angle;
  double cosine = kCosine[7], sine = kSine[7];
  for (int k = 6; k >= 0; --k) {
    cosine = kCosine[k] + t * cosine;
    sine = kSine[k] + t * sine;
  }
  return {cosine, angle * sine};
}

Vector3d in_space(const Vec2& a) {
  return {a.x, a.y, 0.0};
}

}  // namespace

PlanarChain::PlanarChain(PlanarField field, int elements, double element_length,
                         const SectionInertia& inertia, double curvature)
    : field_(std::move(field)),
      elements_(elements),
      l_(element_length),
      inertia_(inertia),
      curvature_(curvature),
      offset_(inertia.m_y / inertia.m),
      I_x_(inertia.m_yy + inertia.m_zz - inertia.m_y * offset_),
      I_y_(inertia.m_zz),
      I_z_(inertia.m_yy - inertia.m_y * offset_),
      angle_{},
      stretch_{},
      shear_{},
      end_angle_{} {
  const auto angle_at = [&](double x, int j) {
    return x * field_.first(2, j) + 0.5 * x * x * field_.slope(2, j);
  };
  for (std::size_t h = 0; h < kPoints; ++h) {
    x_[h] = gauss::kAt[h] * l_;
    mass_weight_[h] = gauss::kWeight[h] * l_;
    end_weight_[h] = l_ * gauss::polynomial_integral(h, 1.0);
    for (std::size_t g = 0; g < kPoints; ++g)
      weight_[g][h] = l_ * gauss::polynomial_integral(h, gauss::kAt[g]);
    for (int j = 0; j < field_.n(); ++j) {
      const auto of = static_cast<std::size_t>(j);
      angle_[h][of] = angle_at(x_[h], j);
      stretch_[h][of] = field_.first(0, j) + x_[h] * field_.slope(0, j);
      shear_[h][of] = field_.first(1, j) + x_[h] * field_.slope(1, j);
    }
  }
  for (int j = 0; j < field_.n(); ++j) end_angle_[static_cast<std::size_t>(j)] = angle_at(l_, j);
}

PlanarChain::Place PlanarChain::place(int element, double x) const {
  Place out{element, x, {}, {}};
  for (std::size_t h = 0; h < kPoints; ++h) out.weight[h] = l_ * gauss::polynomial_integral(h, x / l_);
  for (int j = 0; j < field_.n(); ++j)
    out.angle[static_cast<std::size_t>(j)] = x * field_.first(2, j) + 0.5 * x * x * field_.slope(2, j);
  return out;
}

PlanarChain::Pass PlanarChain::make_pass() const {
  Pass out;
  out.points.resize(static_cast<std::size_t>(kPoints * elements_));
  out.ends.resize(static_cast<std::size_t>(elements_ + 1));
  return out;
}

void PlanarChain::move(const double* s, const double* s_dot, const double* s_ddot, Pass& out, int end) const {
  const int n = field_.n();
  const auto sum = [n](const PerCoordinate& by, const double* x) {
    if (n == 2) return by[0] * x[0] + by[1] * x[1];
    double total = 0.0;
    for (int j = 0; j < n; ++j) total += by[static_cast<std::size_t>(j)] * x[j];
    return total;
  };
  out.ends[0] = {};
  for (int k = 0; k < end; ++k) {
    const Pass::End& from = out.ends[static_cast<std::size_t>(k)];
    Pass::End& to = out.ends[static_cast<std::size_t>(k) + 1];
    Pass::Point* const points = out.points.data() + static_cast<std::size_t>(kPoints * k);
    to = from;
    const auto own = [&](const double* x) { return x + k * n; };
    for (std::size_t h = 0; h < kPoints; ++h) {
      Pass::Point& at = points[h];
      at.e = turned(from.e, direction(curvature_ * x_[h] + sum(angle_[h], own(s))));
      at.p = turned(at.e, {1.0 + sum(stretch_[h], own(s)), sum(shear_[h], own(s))});
      to.r += end_weight_[h] * at.p;
      if (!s_dot) continue;
      const Vec2 c_v = turned(at.e, {sum(stretch_[h], own(s_dot)), sum(shear_[h], own(s_dot))});
      at.w = from.w + sum(angle_[h], own(s_dot));
      at.p_v = at.w * i(at.p) + c_v;
      to.v += end_weight_[h] * at.p_v;
      if (!s_ddot) continue;
      const Vec2 c_a = turned(at.e, {sum(stretch_[h], own(s_ddot)), sum(shear_[h], own(s_ddot))});
      at.w_dot = from.w_dot + sum(angle_[h], own(s_ddot));
      at.p_a = at.w_dot * i(at.p) - at.w * at.w * at.p + 2.0 * at.w * i(c_v) + c_a;
      to.a += end_weight_[h] * at.p_a;
    }
    to.e = turned(from.e, direction(curvature_ * l_ + sum(end_angle_, own(s))));
    if (s_dot) to.w += sum(end_angle_, own(s_dot));
    if (s_ddot) to.w_dot += sum(end_angle_, own(s_ddot));
    for (std::size_t g = 0; g < kPoints; ++g) {
      Pass::Point& at = points[g];
      at.r = from.r + offset_ * i(at.e);
      at.v = from.v - offset_ * at.w * at.e;
      at.a = from.a - offset_ * (at.w_dot * at.e + at.w * at.w * i(at.e));
      for (std::size_t h = 0; h < kPoints; ++h) {
        at.r += weight_[g][h] * points[h].p;
        if (s_dot) at.v += weight_[g][h] * points[h].p_v;
        if (s_ddot) at.a += weight_[g][h] * points[h].p_a;
      }
    }
  }
}

Element::Motion PlanarChain::motion(const Place& place, const double* s, const double* s_dot,
                                    const double* s_ddot, const Pass& pass) const {
  const Pass::End& from = pass.ends[static_cast<std::size_t>(place.element)];
  const Pass::Point* const points = points_of(pass, place.element);
  const int first = place.element * field_.n();
  double angle = curvature_ * place.x, w = from.w, w_dot = from.w_dot;
  for (int j = 0; j < field_.n(); ++j) {
    const double by = place.angle[static_cast<std::size_t>(j)];
    angle += by * s[first + j];
    if (s_dot) w += by * s_dot[first + j];
    if (s_ddot) w_dot += by * s_ddot[first + j];
  }
  Vec2 r = from.r, v = from.v, a = from.a;
  for (std::size_t h = 0; h < kPoints; ++h) {
    r += place.weight[h] * points[h].p;
    if (s_dot) v += place.weight[h] * points[h].p_v;
    if (s_ddot) a += place.weight[h] * points[h].p_a;
  }
  Element::Motion out;
  const Vec2 e = turned(from.e, direction(angle));
  out.R.topLeftCorner<2, 2>() << e.x, -e.y, e.y, e.x;
  out.p = in_space(r);
  if (s_dot) out.V << 0.0, 0.0, w, in_space(v);
  if (s_ddot) out.A << 0.0, 0.0, w_dot, in_space(a);
  return out;
}

PlanarChain::Moved PlanarChain::moved(const Pass::Point* points, const std::array<double, kPoints>& weight,
                                      bool with_motion) const {
  Moved out;
  for (std::size_t h = 0; h < kPoints; ++h) {
    const Pass::Point& at = points[h];
    for (std::size_t j = 0; j < static_cast<std::size_t>(field_.n()); ++j) {
      const double t = weight[h] * angle_[h][j];
      const Vec2 c = weight[h] * turned(at.e, {stretch_[h][j], shear_[h][j]});
      out.r[j] += t * i(at.p) + c;
      if (!with_motion) continue;
      out.v[j] += t * i(at.p_v) + at.w * i(c);
      out.a[j] += t * i(at.p_a) + at.w_dot * i(c) - at.w * at.w * c;
    }
  }
  return out;
}

PlanarChain::Moved PlanarChain::moved_mass(const Pass::Point* points, std::size_t g, bool with_motion) const {
  Moved out = moved(points, weight_[g], with_motion);
  const Pass::Point& at = points[g];
  for (std::size_t j = 0; offset_ != 0.0 && j < static_cast<std::size_t>(field_.n()); ++j) {
    const double t = offset_ * angle_[g][j];
    out.r[j] -= t * at.e;
    out.v[j] -= t * at.w * i(at.e);
    out.a[j] -= t * (at.w_dot * i(at.e) - at.w * at.w * at.e);
  }
  return out;
}

void PlanarChain::map(const Place& place, const Vec2& r, const Pass& pass, Columns& out) const {
  out.setZero(6, n());
  for (int k = 0; k <= place.element; ++k) {
    const bool is_own = k == place.element;
    const Moved by = moved(points_of(pass, k), is_own ? place.weight : end_weight_, false);
    for (int j = 0; j < field_.n(); ++j) {
      const auto of = static_cast<std::size_t>(j);
      const double t = is_own ? place.angle[of] : end_angle_[of];
      Vec2 u = by.r[of];
      if (!is_own) u += t * i(r - pass.ends[static_cast<std::size_t>(k) + 1].r);
      out.col(k * field_.n() + j) << 0.0, 0.0, t, u.x, u.y, 0.0;
    }
  }
}

void PlanarChain::integrate(const Pass& pass, Element::Integrals& out) const {
  const int m = field_.n(), all = n();
  out.C_t.setZero(3, all);
  out.C_r.setZero(3, all);
  out.M.resize(all, all);
  Beyond beyond;
  Matrix3d I = Matrix3d::Zero();
  for (int k = elements_; k-- > 0;) {
    const Pass::Point* const points = points_of(pass, k);
    const Vec2& B = pass.ends[static_cast<std::size_t>(k) + 1].r;
    const Moved end = moved(points, end_weight_, false);
    const std::array<Moved, kPoints> own = {moved_mass(points, 0, false), moved_mass(points, 1, false),
                                            moved_mass(points, 2, false), moved_mass(points, 3, false)};
    const Vec2 from_B = beyond.S - beyond.m * B;
    const double J_B = beyond.J - 2.0 * dot(B, beyond.S) + beyond.m * dot(B, B);
    for (int a = 0; a < m; ++a) {
      const auto i_a = static_cast<std::size_t>(a);
      const double t = end_angle_[i_a];
      const Vec2 u = end.r[i_a];
      Vec2 R = beyond.m * u + t * i(from_B);
      double turn = cross(beyond.S, u) + t * (beyond.J - dot(B, beyond.S));
      for (std::size_t g = 0; g < kPoints; ++g) {
        R += mass_weight_[g] * inertia_.m * own[g].r[i_a];
        turn += mass_weight_[g] * (inertia_.m * cross(points[g].r, own[g].r[i_a]) + I_z_ * angle_[g][i_a]);
      }
      const int row = k * m + a;
      out.C_t.col(row) << R.x, R.y, 0.0;
      out.C_r(2, row) = turn;
      for (int b = 0; b <= a; ++b) {
        const auto i_b = static_cast<std::size_t>(b);
        const double t_b = end_angle_[i_b];
        double sum = beyond.m * dot(u, end.r[i_b]) + t_b * dot(u, i(from_B)) +
                     t * dot(end.r[i_b], i(from_B)) + t * t_b * J_B;
        for (std::size_t g = 0; g < kPoints; ++g)
          sum += mass_weight_[g] *
                 (inertia_.m * dot(own[g].r[i_a], own[g].r[i_b]) + I_z_ * angle_[g][i_a] * angle_[g][i_b]);
        out.M(row, k * m + b) = out.M(k * m + b, row) = sum;
      }
      // What lies beyond this element moves by this coordinate as one piece.
      const Vec2 q = u - t * i(B);
      for (int j = (k + 1) * m; j < all; ++j)
        out.M(row, j) = out.M(j, row) = q.x * out.C_t(0, j) + q.y * out.C_t(1, j) + t * out.C_r(2, j);
    }
    for (std::size_t g = 0; g < kPoints; ++g) {
      const Pass::Point& at = points[g];
      beyond.add(mass_weight_[g] * inertia_.m, at, mass_weight_[g] * I_z_);
      I += mass_weight_[g] * rotary(at.e);
    }
  }
  out.d = in_space(beyond.S);
  out.J = beyond.point_inertia() + I;
}

Matrix3d PlanarChain::rotary(const Vec2& e) const {
  Matrix3d I = Matrix3d::Zero();
  I(0, 0) = e.x * e.x * I_x_ + e.y * e.y * I_y_;
  I(1, 1) = e.y * e.y * I_x_ + e.x * e.x * I_y_;
  I(0, 1) = I(1, 0) = e.x * e.y * (I_x_ - I_y_);
  I(2, 2) = I_z_;
  return I;
}

Vector6d PlanarChain::inertia_force(const Pass& pass, const Element::Carried& start, double* need) const {
  const Vec2 w_xy{start.w.x(), start.w.y()}, alpha_xy{start.alpha.x(), start.alpha.y()},
      a_xy{start.a.x(), start.a.y()};
  const double w = start.w.z(), alpha = start.alpha.z(), w2 = start.w.squaredNorm();
  const bool in_plane =
      w_xy.x == 0.0 && w_xy.y == 0.0 && alpha_xy.x == 0.0 && alpha_xy.y == 0.0 && start.a.z() == 0.0;
  Vec2 force, across_moment;  // of all beyond; moments about x and y
  double moment = 0.0, across = 0.0;
  std::array<Vec2, kPoints> F, Q;
  std::array<double, kPoints> T;
  for (int k = elements_; k-- > 0;) {
    const Pass::Point* const points = points_of(pass, k);
    for (std::size_t h = 0; h < kPoints; ++h) Q[h] = end_weight_[h] * force;
    const double beyond = moment;
    for (std::size_t g = 0; g < kPoints; ++g) {
      const Pass::Point& at = points[g];
      const double m = mass_weight_[g] * inertia_.m;
      Vec2 A = a_xy + alpha * i(at.r) - w2 * at.r + 2.0 * w * i(at.v) + at.a;
      T[g] = mass_weight_[g] * I_z_ * (alpha + at.w_dot);
      if (!in_plane) {
        const double along = dot(w_xy, at.r);
        A += along * w_xy;
        const double F_z = m * (start.a.z() + cross(alpha_xy, at.r) + w * along + 2.0 * cross(w_xy, at.v));
        across += F_z;
        const Vec2 turns = turned_back(at.e, w_xy),
                   turns_faster = turned_back(at.e, alpha_xy - at.w * i(w_xy));
        T[g] += mass_weight_[g] * turns.x * turns.y * (I_y_ - I_x_);
        across_moment += F_z * Vec2{at.r.y, -at.r.x};
        across_moment +=
            mass_weight_[g] * turned(at.e, {I_x_ * turns_faster.x + turns.y * (w + at.w) * (I_z_ - I_y_),
                                            I_y_ * turns_faster.y + turns.x * (w + at.w) * (I_x_ - I_z_)});
      }
      F[g] = m * A;
      force += F[g];
      for (std::size_t h = 0; h < kPoints; ++h) Q[h] += weight_[g][h] * F[g];
      T[g] -= offset_ * dot(at.e, F[g]);  // (i offset e) x F
      moment += T[g];
    }
    std::array<Vec2, kPoints> f;
    for (std::size_t h = 0; h < kPoints; ++h) {
      const double turn = cross(points[h].p, Q[h]);
      T[h] += turn;
      moment += turn;
      f[h] = turned_back(points[h].e, Q[h]);
    }
    for (int j = 0; j < field_.n(); ++j) {
      const auto of = static_cast<std::size_t>(j);
      double sum = end_angle_[of] * beyond;
      for (std::size_t h = 0; h < kPoints; ++h)
        sum += angle_[h][of] * T[h] + stretch_[h][of] * f[h].x + shear_[h][of] * f[h].y;
      need[k * field_.n() + j] = sum;
    }
  }
  Vector6d out;
  out << across_moment.x, across_moment.y, moment, force.x, force.y, across;
  return out;
}

}  // namespace flexura::beam::exact
