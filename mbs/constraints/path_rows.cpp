// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/constraints/path_rows.hpp"

namespace flexura::mbs::path_rows {

Vectors see(const BodyPath& path, const Kinematics& kin, int marker_M, double s, Level level) {
  const BodyPath::Weights w = path.weights(s);
  Vectors x;
  for (Sum* sum : {&x.to_point, &x.tangent, &x.side, &x.up, &x.y_M, &x.z_M})
    for (Weights& weights : *sum) weights.setZero();
  const int F = path.marker(w.first);
  const auto add_marker = [&](int marker) {
    x.markers[static_cast<std::size_t>(x.n_markers)] = marker;
    return x.n_markers++;
  };
  const auto add = [&](int of, const Relative& rel, const Vector3d* direction) {
    const auto at = static_cast<std::size_t>(x.n);
    x.of[at] = of;
    x.is_position[at] = direction == nullptr;
    if (direction) {
      const Vector3d y = rel.X_FM.R * *direction, turn = rel.V.head<3>();
      x.y.col(x.n) = y;
      x.y_t.col(x.n) = turn.cross(y);
      x.y_tt.col(x.n) = Vector3d(rel.A.head<3>()).cross(y) + turn.cross(turn.cross(y));
    } else {
      x.y.col(x.n) = rel.X_FM.p;
      x.y_t.col(x.n) = rel.V.tail<3>();
      x.y_tt.col(x.n) = rel.A.tail<3>();
    }
    return x.n++;
  };
  const auto relative = [&](int marker) {
    if (marker == F) return Relative{};
    if (level == Level::acceleration) return kin.relative_acceleration(F, marker);
    if (level == Level::velocity) return kin.relative_motion(F, marker);
    Relative rel;
    rel.X_FM = kin.relative_pose(F, marker);
    return rel;
  };
  for (int k = 0; k < w.n; ++k) {
    const int j = w.first + k, of = add_marker(path.marker(j));
    const Relative rel = relative(path.marker(j));
    x.w[static_cast<std::size_t>(of)] = rel.V.head<3>();
    const int position = add(of, rel, nullptr), side = add(of, rel, &path.side(j)),
              up = add(of, rel, &path.up(j));
    for (int order = 0; order < 3; ++order) {
      const auto i = static_cast<std::size_t>(order);
      x.to_point[i](position) = -w.b(order, k);
      x.tangent[i](position) = w.b(order + 1, k);
      x.side[i](side) = x.up[i](up) = w.b(order, k);
    }
  }
  const int M = add_marker(marker_M);
  const Relative rel = relative(marker_M);
  x.w[static_cast<std::size_t>(M)] = rel.V.head<3>();
  const Vector3d y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  x.to_point[0](add(M, rel, nullptr)) = 1.0;
  x.y_M[0](add(M, rel, &y)) = 1.0;
  x.z_M[0](add(M, rel, &z)) = 1.0;
  return x;
}

Row row(const Vectors& x, const Sum& a, const Sum& b) {
  const auto sum = [](const Columns& y, const Weights& weights) -> Vector3d { return y * weights; };
  const Vector3d A = sum(x.y, a[0]), A_s = sum(x.y, a[1]), A_ss = sum(x.y, a[2]), A_t = sum(x.y_t, a[0]),
                 A_st = sum(x.y_t, a[1]), A_tt = sum(x.y_tt, a[0]);
  const Vector3d B = sum(x.y, b[0]), B_s = sum(x.y, b[1]), B_ss = sum(x.y, b[2]), B_t = sum(x.y_t, b[0]),
                 B_st = sum(x.y_t, b[1]), B_tt = sum(x.y_tt, b[0]);
  Row r;
  r.h = A.dot(B);
  r.h_s = A_s.dot(B) + A.dot(B_s);
  r.h_ss = A_ss.dot(B) + 2.0 * A_s.dot(B_s) + A.dot(B_ss);
  r.h_t = A_t.dot(B) + A.dot(B_t);
  r.h_st = A_st.dot(B) + A_s.dot(B_t) + A_t.dot(B_s) + A.dot(B_st);
  r.h_tt = A_tt.dot(B) + 2.0 * A_t.dot(B_t) + A.dot(B_tt);
  r.by = B * a[0].transpose() + A * b[0].transpose();
  r.by_s = B * a[1].transpose() + B_s * a[0].transpose() + A * b[1].transpose() + A_s * b[0].transpose();
  r.by_t = B_t * a[0].transpose() + A_t * b[0].transpose();
  return r;
}

void Row::add(double factor, const Row& other) {
  h += factor * other.h;
  h_s += factor * other.h_s;
  h_ss += factor * other.h_ss;
  h_t += factor * other.h_t;
  h_st += factor * other.h_st;
  h_tt += factor * other.h_tt;
  by += factor * other.by;
  by_s += factor * other.by_s;
  by_t += factor * other.by_t;
}

Eigen::Matrix<double, 3, 6> motion_of(const Vectors& x, int j) {
  Eigen::Matrix<double, 3, 6> moves = Eigen::Matrix<double, 3, 6>::Zero();
  if (x.is_position[static_cast<std::size_t>(j)])
    moves.rightCols<3>().setIdentity();
  else
    moves.leftCols<3>() = -skew(x.y.col(j));
  return moves;
}

Vector6d wrench_on(const Vectors& x, int k, const Columns& f) {
  Vector6d wrench = Vector6d::Zero();
  for (int j = 0; j < x.n; ++j)
    if (x.of[static_cast<std::size_t>(j)] == k) wrench += motion_of(x, j).transpose() * f.col(j);
  return wrench;
}

}  // namespace flexura::mbs::path_rows
