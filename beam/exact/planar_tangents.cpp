// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <cmath>

#include "beam/exact/planar_beyond.hpp"

/// Derivatives of a planar chain.  With the start in its plane a mass point's force is
///
///     F = m (a_0 + (alpha i - w^2) r + 2 w i v + a)
///
/// and by (the header) a coordinate s_j that moves all beyond B by u and t changes
///
///     F by m E_j + t i F,     E_j = da_B - t i (a_B + a_0) + (alpha i - w^2) q_j + 2 w i (dv_B - t i v_B),   q_j = u - t i r_B
///
/// so that of two coordinates the outer one needs of the inner one E_j alone, and the inner one of the outer one the change
/// of the wrench at the start: with R_i = int dr/ds_i dm
///
///     i beyond j:   R_i . E_j          j beyond i:   q_i . dF_j + t_i dM_j
namespace flexura::beam::exact {
namespace {

Matrix3d skew(const Vector3d& a) {
  Matrix3d s;
  s << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return s;
}

}  // namespace

bool PlanarChain::stays_in_plane(const Element::Carried& start) const {
  // Of what a frame that is turned to the plane leaves: derivatives err by this part.
  constexpr double kRoundOff = 1e-10;
  const double w = start.w.norm(),
               acceleration = start.a.norm() + length() * (start.alpha.norm() + w * w);  // of the far end
  return start.w.head<2>().norm() <= kRoundOff * w &&
         length() * start.alpha.head<2>().norm() <= kRoundOff * acceleration &&
         std::abs(start.a.z()) <= kRoundOff * acceleration;
}

void PlanarChain::inertia_tangents(const Pass& pass, const Element::Carried& start,
                                   Element::InertiaTangents& out) const {
  const int m = field_.n(), all = n();
  for (Columns* x : {&out.wrench_s, &out.wrench_v}) x->setZero(6, all);
  for (Eigen::MatrixXd* x : {&out.need_s, &out.need_v}) x->resize(all, all);
  const Vec2 a_0{start.a.x(), start.a.y()};
  const double w = start.w.z(), alpha = start.alpha.z();
  const auto carried = [&](const Vec2& x) { return alpha * i(x) - w * w * x; };
  // Of the coordinates beyond: R, Z (by s' instead of R . E, what turns with the piece), and the wrench's changes.
  Eigen::Matrix<double, Eigen::Dynamic, 3> rows(all, 3);
  Beyond beyond;
  Vec2 force;  // of all beyond
  for (int k = elements_; k-- > 0;) {
    const Pass::Point* const points = points_of(pass, k);
    const Pass::End& B = pass.ends[static_cast<std::size_t>(k) + 1];
    const Moved end = moved(points, end_weight_, true);
    const std::array<Moved, kPoints> own = {moved_mass(points, 0, true), moved_mass(points, 1, true),
                                            moved_mass(points, 2, true), moved_mass(points, 3, true)};
    std::array<Vec2, kPoints> F, Q;
    for (std::size_t h = 0; h < kPoints; ++h) Q[h] = end_weight_[h] * force;
    for (std::size_t g = 0; g < kPoints; ++g) {
      const Pass::Point& at = points[g];
      F[g] = mass_weight_[g] * inertia_.m * (a_0 + carried(at.r) + 2.0 * w * i(at.v) + at.a);
      for (std::size_t h = 0; h < kPoints; ++h) Q[h] += weight_[g][h] * F[g];
    }
    const Vec2 S_B = beyond.S - beyond.m * B.r;
    const Vec2 turns_v = 2.0 * i(beyond.V) - 2.0 * w * beyond.S;  // int 2 i v - 2 w r dm
    const double moves_v = 2.0 * (beyond.P - dot(B.r, beyond.V)) + 2.0 * w * cross(B.r, beyond.S);
    for (int b = 0; b < m; ++b) {
      const auto j = static_cast<std::size_t>(b);
      const int column = k * m + b;
      const double t = end_angle_[j];
      const Vec2 q = end.r[j] - t * i(B.r);
      const Vec2 dv = end.v[j] - t * i(B.v);
      const Vec2 E = end.a[j] - t * i(B.a + a_0) + carried(q) + 2.0 * w * i(dv);
      const Vec2 E_v = 2.0 * dv + 2.0 * w * i(q);
      // Beyond the element, then its own points.
      const Vec2 dF_beyond = beyond.m * E + t * i(force), dF_beyond_v = beyond.m * E_v + t * turns_v;
      Vec2 dF = dF_beyond, dF_v = dF_beyond_v, R = beyond.m * end.r[j] + t * i(S_B);
      double dM = cross(q, force) + cross(beyond.S, E), dM_v = cross(beyond.S, E_v) + 2.0 * t * beyond.P;
      double Z = dot(end.r[j], turns_v) + t * moves_v;
      std::array<Vec2, kPoints> dF_own, dF_own_v;
      for (std::size_t g = 0; g < kPoints; ++g) {
        const double dm = mass_weight_[g] * inertia_.m;
        const Vec2 &dr = own[g].r[j], &dv_g = own[g].v[j];
        dF_own[g] = dm * (own[g].a[j] + carried(dr) + 2.0 * w * i(dv_g));
        dF_own_v[g] = dm * (2.0 * dv_g + 2.0 * w * i(dr));
        dF += dF_own[g];
        dF_v += dF_own_v[g];
        dM += cross(dr, F[g]) + cross(points[g].r, dF_own[g]);
        dM_v += cross(points[g].r, dF_own_v[g]);
        R += dm * dr;
        Z += dm * dot(dr, 2.0 * i(points[g].v) - 2.0 * w * points[g].r);
      }
      out.wrench_s.col(column) << 0.0, 0.0, dM, dF.x, dF.y, 0.0;
      out.wrench_v.col(column) << 0.0, 0.0, dM_v, dF_v.x, dF_v.y, 0.0;
      rows.row(column) << R.x, R.y, Z;

      for (int row = (k + 1) * m; row < all; ++row) {
        out.need_s(row, column) = rows(row, 0) * E.x + rows(row, 1) * E.y;
        out.need_v(row, column) = rows(row, 0) * E_v.x + rows(row, 1) * E_v.y + t * rows(row, 2);
        const auto along = [&](const Columns& wrench) {
          return q.x * wrench(3, row) + q.y * wrench(4, row) + t * wrench(2, row);
        };
        out.need_s(column, row) = along(out.wrench_s);
        out.need_v(column, row) = along(out.wrench_v);
      }
      for (int a = 0; a < m; ++a) {
        const auto of = static_cast<std::size_t>(a);
        const double t_a = end_angle_[of];
        double by_s = dot(end.r[of], dF_beyond) + t_a * cross(S_B, E);
        double by_v = dot(end.r[of], dF_beyond_v) + t_a * (cross(S_B, E_v) + t * moves_v);
        for (std::size_t h = 0; h < kPoints; ++h) {
          const Pass::Point& at = points[h];
          const Vec2 turns = turned(at.e, {angle_[h][of] * stretch_[h][j] + angle_[h][j] * stretch_[h][of],
                                           angle_[h][of] * shear_[h][j] + angle_[h][j] * shear_[h][of]});
          const double both = angle_[h][of] * angle_[h][j];
          by_s += dot(i(turns) - both * at.p, Q[h]) - both * offset_ * dot(i(at.e), F[h]) +
                  dot(own[h].r[of], dF_own[h]);
          by_v += dot(own[h].r[of], dF_own_v[h]);
        }
        out.need_s(k * m + a, column) = by_s;
        out.need_v(k * m + a, column) = by_v;
      }
    }
    for (std::size_t g = 0; g < kPoints; ++g) {
      const double dm = mass_weight_[g] * inertia_.m;
      beyond.add(dm, points[g], 0.0);
      beyond.add_motion(dm, points[g]);
      force += F[g];
    }
  }
}

void PlanarChain::turning_tangents(const Pass& pass, const Vector3d& w, Eigen::Matrix<double, 6, 3>& wrench_w,
                                   Modal3& need_w) const {
  const int m = field_.n();
  need_w.setZero(n(), 3);
  Beyond beyond;
  Matrix3d I = Matrix3d::Zero(), turning = Matrix3d::Zero();  // of the sections, and times their speed
  for (int k = elements_; k-- > 0;) {
    const Pass::Point* const points = points_of(pass, k);
    const Vec2& B = pass.ends[static_cast<std::size_t>(k) + 1].r;
    const Moved end = moved(points, end_weight_, false);
    const std::array<Moved, kPoints> own = {moved_mass(points, 0, false), moved_mass(points, 1, false),
                                            moved_mass(points, 2, false), moved_mass(points, 3, false)};
    const Vec2 turns_v = 2.0 * i(beyond.V) - 2.0 * w.z() * beyond.S;
    const double moves_v = 2.0 * (beyond.P - dot(B, beyond.V)) + 2.0 * w.z() * cross(B, beyond.S);
    for (int a = 0; a < m; ++a) {
      const auto of = static_cast<std::size_t>(a);
      double Z = dot(end.r[of], turns_v) + end_angle_[of] * moves_v;
      for (std::size_t g = 0; g < kPoints; ++g)
        Z += mass_weight_[g] * inertia_.m *
             dot(own[g].r[of], 2.0 * i(points[g].v) - 2.0 * w.z() * points[g].r);
      need_w(k * m + a, 2) = Z;
    }
    for (std::size_t g = 0; g < kPoints; ++g) {
      const double dm = mass_weight_[g] * inertia_.m;
      beyond.add(dm, points[g], 0.0);
      beyond.add_motion(dm, points[g]);
      const Matrix3d I_g = mass_weight_[g] * rotary(points[g].e);
      I += I_g;
      turning += points[g].w * I_g;
    }
  }
  const Vector3d d(beyond.S.x, beyond.S.y, 0.0), V(beyond.V.x, beyond.V.y, 0.0), e = Vector3d::UnitZ();
  const Matrix3d J = beyond.point_inertia();
  Matrix3d v_r = Matrix3d::Zero();
  v_r.topLeftCorner<2, 2>() << beyond.vx, beyond.vxy, beyond.vyx, beyond.vy;
  wrench_w.bottomRows<3>() = -skew(w.cross(d)) - skew(w) * skew(d) - 2.0 * skew(V);
  // w x (J w) + 2 int r x (w x v) dm of the points; Omega x I Omega + I (w x theta' e) of the sections.
  wrench_w.topRows<3>() = -skew(J * w) + skew(w) * J + 2.0 * (beyond.P * Matrix3d::Identity() - v_r) -
                          skew(I * w + turning * e) + skew(w) * I + skew(e) * turning - turning * skew(e);
}

void PlanarChain::motion_tangents(const Place& place, const Vec2& r, const Vec2& v, const Vec2& a,
                                  const Vector6d& wrench, const Pass& pass,
                                  Element::MotionTangents& out) const {
  const int m = field_.n();
  for (Columns* x : {&out.V_s, &out.A_s, &out.A_v}) x->setZero(6, n());
  out.map_s.setZero(n(), n());
  const Vec2 f{wrench(3), wrench(4)};
  Eigen::Matrix2Xd moves(2, n());  // dr
  for (int k = place.element; k >= 0; --k) {
    const bool is_own = k == place.element;
    const Pass::Point* const points = points_of(pass, k);
    const Pass::End& B = pass.ends[static_cast<std::size_t>(k) + 1];
    const auto& weight = is_own ? place.weight : end_weight_;
    const auto& angle = is_own ? place.angle : end_angle_;
    const Moved by = moved(points, weight, true);
    for (int b = 0; b < m; ++b) {
      const auto j = static_cast<std::size_t>(b);
      const int column = k * m + b;
      const double t = is_own ? 0.0 : angle[j];
      const Vec2 dr = by.r[j] + t * i(r - B.r), dv = by.v[j] + t * i(v - B.v), da = by.a[j] + t * i(a - B.a);
      out.V_s.col(column) << 0.0, 0.0, 0.0, dv.x, dv.y, 0.0;
      out.A_s.col(column) << 0.0, 0.0, 0.0, da.x, da.y, 0.0;
      out.A_v.col(column) = 2.0 * out.V_s.col(column);
      moves.col(column) << dr.x, dr.y;
      for (int row = (k + 1) * m; row < (place.element + 1) * m; ++row)
        out.map_s(row, column) = out.map_s(column, row) = t * dot(i({moves(0, row), moves(1, row)}), f);
      for (int c = 0; c < m; ++c) {
        const auto of = static_cast<std::size_t>(c);
        double sum = is_own ? 0.0 : -angle[of] * angle[j] * dot(r - B.r, f);
        for (std::size_t h = 0; h < kPoints; ++h) {
          const Pass::Point& at = points[h];
          const Vec2 turns = turned(at.e, {angle_[h][of] * stretch_[h][j] + angle_[h][j] * stretch_[h][of],
                                           angle_[h][of] * shear_[h][j] + angle_[h][j] * shear_[h][of]});
          sum += weight[h] * dot(i(turns) - angle_[h][of] * angle_[h][j] * at.p, f);
        }
        out.map_s(k * m + c, column) = sum;
      }
    }
  }
}

}  // namespace flexura::beam::exact
