// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/element_tangents.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mbs/base/math/differences.hpp"

namespace flexura::mbs {
namespace {

/// Derivatives of a coordinate (or speed) of a joint that closes a loop by its frames' relative motion:
/// central differences of the joint's own functions.
Eigen::Matrix<double, 1, 12> closure_gradient(const Kinematics& kin, const JointPlace& place, int index,
                                              bool of_speed) {
  constexpr double h = kCentralStep;
  const Relative rel = kin.relative_motion(place.marker_F, place.marker_M);
  Eigen::Matrix<double, 1, 12> gradient;
  for (int j = 0; j < (of_speed ? 12 : 6); ++j) {
    double value[2], q[7], v[6];
    for (int k = 0; k < 2; ++k) {
      Relative moved = rel;
      const double step = k == 0 ? h : -h;
      if (j < 3)
        moved.X_FM.R = rotation_exp(step * Vector3d::Unit(j)) * rel.X_FM.R;
      else if (j < 6)
        moved.X_FM.p(j - 3) += step;
      else
        moved.V(j - 6) += step;
      place.joint->coordinates_of(moved.X_FM, q);
      if (of_speed) place.joint->speeds_of(q, moved.V, v);
      value[k] = of_speed ? v[index] : q[index];
    }
    double change = value[0] - value[1];
    if (std::abs(change) > 1.0) change = std::remainder(change, 2.0 * std::numbers::pi);  // across +-pi
    gradient(j) = change / (2.0 * h);
  }
  if (!of_speed) gradient.tail<6>().setZero();
  return gradient;
}

/// S (S^T S)^-1 e of a closure: the wrench of a unit force along its coordinate, see Loads.
Vector6d closure_wrench(const Joint& joint, const Pose& X_FM, int index) {
  double q[7];
  joint.coordinates_of(X_FM, q);
  MotionMatrix S = MotionMatrix::Zero(6, joint.n_v());
  joint.motion(q, S);
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> gram = S.transpose() * S;
  return S * gram.inverse().col(index);
}

}  // namespace

Mechanism::ElementDerivatives::ElementDerivatives(const Mechanism& mechanism, TangentScope scope, Work& work,
                                                  TangentMatrices& out)
    : m_(mechanism), scope_(scope), work_(work), out_(out), e_(work.element) {
  e_.seen = {-2, -2};
  e_.signals.setZero();
}

// The body nearest to all markers on the way to ground; ground where one of them is the world (-1).
int Mechanism::ElementDerivatives::base_of(std::initializer_list<int> markers) const {
  const auto depth = [&](int body) { return work_.tangent.bodies[body].depth; };
  int base = -1;
  for (const int marker : markers) {
    if (marker < 0) return 0;
    int b = m_.d_.markers[marker].body;
    if (base < 0) base = b;
    while (base != b) {
      int& outer = depth(base) > depth(b) ? base : b;
      outer = m_.bodies_[outer].parent;
    }
  }
  return base;
}

void Mechanism::ElementDerivatives::reach(int marker, const Vector3d& point, int base, Reach& out) const {
  for (const int j : out.list) {
    out.twist.col(j).setZero();
    out.D.col(j).setZero();
    out.rigid.col(j).setZero();
  }
  out.list.clear();
  out.n_own = 0;
  if (marker < 0) return;
  const Work::Tangent& T = work_.tangent;
  bool own = true;
  for (int b = m_.d_.markers[marker].body, child = -1; b != 0; child = b, b = m_.bodies_[b].parent) {
    const TreeBody& t = m_.bodies_[b];
    const Vector3d from_origin = point - T.bodies[b].origin;
    const auto take = [&](int j) {
      const Vector6d phi = shift_twist(Spatial::from(T.phi.col(j)), from_origin).vector();
      out.twist.col(j) += phi;
      out.rigid.col(j) += phi;
      out.D.col(j) += shift_twist(Spatial::from(T.D.col(j)), from_origin).vector();
      out.list.push_back(j);
    };
    const int through = child < 0 ? marker : m_.bodies_[child].marker_in;
    for (int l = 0; l < t.m; ++l) {
      const int j = t.i_v + l;
      if (m_.is_carried_[through]) {
        const Work::MovedNode& node = T.markers[through];
        out.twist.col(j) = shift_twist(Spatial::from(node.eta.col(l)), from_origin).vector();
        out.D.col(j) = shift_twist(Spatial::from(node.D.col(l)), from_origin).vector();
        if (child >= 0) out.rigid.col(j) = out.twist.col(j);
      }
      take(j);
    }
    if (b == base) {
      own = false;
      out.n_own = out.list.size();
    }
    for (int j = m_.places_[t.joint].i_v; j < t.i_v; ++j) take(j);
  }
  if (own) out.n_own = out.list.size();
}

void Mechanism::ElementDerivatives::add(int row, int column, double value) {
  const int n_v = m_.n_v_, n_c = m_.n_dyn_;
  switch (target_) {
    case Target::signal:
      e_.signals(row, column) += value;
      break;
    case Target::h:
      if (column < n_v) work_.tangent.h_q(row, column) += value;
      break;
    case Target::z:
      if (column < n_v)
        work_.tangent.z_q(row, column) += value;
      else if (column < 2 * n_v)
        out_.z_v(row, column - n_v) += value;
      else if (column < 2 * n_v + n_c)
        out_.z_c(row, column - 2 * n_v) += value;
      else
        out_.z_a(row, column - 2 * n_v - n_c) += value;
  }
}

// The change of what is done along one column.
void Mechanism::ElementDerivatives::add_column(int column, const Vector6d& change) {
  for (std::size_t i = 0; i < e_.rows.size(); ++i)
    add(e_.rows[i], column, e_.by_row.col(static_cast<Eigen::Index>(i)).dot(change));
}

void Mechanism::ElementDerivatives::start(Target target) {
  target_ = target;
  is_lifted_ = false;
  e_.rows.clear();
}

void Mechanism::ElementDerivatives::add_row(int row, const Vector6d& by) {
  e_.by_row.col(static_cast<Eigen::Index>(e_.rows.size())) = by;
  e_.rows.push_back(row);
}

// d, brought to six rows: with zeros, or along the wrench that a force on a closure is.
Vector6d Mechanism::ElementDerivatives::six(const Eigen::Ref<const Eigen::VectorXd>& d) const {
  if (is_lifted_) return d(0) * lift_;
  Vector6d x = Vector6d::Zero();
  x.head(d.size()) = d;
  return x;
}

bool Mechanism::ElementDerivatives::skips(int j) const {
  return scope_ == TangentScope::newton && work_.tangent.is_elastic[j];
}

// What is left of a load on the marker `at`, see the header, and of its reaction.
void Mechanism::ElementDerivatives::turn_load(const Reach* reaction, const Matrix3d& R,
                                              const Vector6d& wrench) {
  const Spatial w = R * Spatial::from(wrench);
  collect({&e_.at, &e_.axes, reaction}, e_.columns);
  for (const int j : e_.columns) {
    if (skips(j)) continue;
    const auto left_on = [&](const Reach& body, double sign) {
      const Vector3d turn = e_.axes.twist.col(j).head<3>() - body.rigid.col(j).head<3>();
      const Vector3d move = e_.at.twist.col(j).tail<3>() - body.rigid.col(j).tail<3>();
      const Spatial left{turn.cross(w.angular) + move.cross(w.linear), turn.cross(w.linear)};
      for (const int i : body.list) add(i, j, sign * Spatial::from(body.twist.col(i)).dot(left));
    };
    left_on(e_.at, -factor_);
    if (reaction) left_on(*reaction, factor_);
  }
  // Rows of the components: what the load works on, less its reaction.
  const auto component = [&](int i) {
    Vector6d twist = e_.at.twist.col(i);
    if (reaction) twist -= reaction->twist.col(i);
    add_row(i, -factor_ * (R.transpose() * Spatial::from(twist)).vector());
  };
  collect({&e_.at, reaction}, e_.columns);
  for (const int i : e_.columns) component(i);
}

// The coordinates that not all of them have in common, each once.
void Mechanism::ElementDerivatives::collect(std::initializer_list<const Reach*> reaches,
                                            std::vector<int>& out) {
  out.clear();
  ++e_.marks;
  for (const Reach* reach : reaches)
    for (std::size_t k = 0; reach && k < reach->n_own; ++k) {
      const int j = reach->list[k];
      if (e_.mark[j] == e_.marks) continue;
      e_.mark[j] = e_.marks;
      out.push_back(j);
    }
}

void Mechanism::ElementDerivatives::between(int marker_F, int marker_M, const Vector6d& on_M_F) {
  start(Target::z);
  const int base = base_of({marker_F, marker_M});
  const Vector3d& point = work_.kin.markers[marker_M].X_WP.p;
  reach(marker_M, point, base, e_.at);
  reach(marker_F, point, base, e_.axes);
  turn_load(&e_.axes, work_.kin.markers[marker_F].X_WP.R, on_M_F);
}

void Mechanism::ElementDerivatives::wrench(int at, int axes, int reaction, const Vector6d& wrench) {
  start(Target::z);
  const int base = base_of({at, axes, reaction});
  const Vector3d& point = work_.kin.markers[at].X_WP.p;
  reach(at, point, base, e_.at);
  reach(axes, point, base, e_.axes);
  reach(reaction, point, base, e_.reaction);
  turn_load(reaction < 0 ? nullptr : &e_.reaction,
            axes < 0 ? Matrix3d(Matrix3d::Identity()) : work_.kin.markers[axes].X_WP.R, wrench);
}

void Mechanism::ElementDerivatives::force(CoordinateRef c, double value) {
  const JointPlace& place = m_.places_[c.joint];
  if (place.in_tree()) {
    start(Target::z);
    add_row(place.i_v + c.index, -factor_ * Vector6d::Unit(0));
    return;
  }
  constexpr double h = kCentralStep;
  const Pose X = work_.kin.relative_pose(place.marker_F, place.marker_M);
  const Vector6d unit = closure_wrench(*place.joint, X, c.index);
  Eigen::Matrix<double, 6, 12> turned = Eigen::Matrix<double, 6, 12>::Zero();
  for (int j = 0; j < 6; ++j)
    for (const double sign : {1.0, -1.0}) {
      Pose moved = X;
      if (j < 3)
        moved.R = rotation_exp(sign * h * Vector3d::Unit(j)) * X.R;
      else
        moved.p(j - 3) += sign * h;
      turned.col(j) += sign * value / (2.0 * h) * closure_wrench(*place.joint, moved, c.index);
    }
  between(place.marker_F, place.marker_M, value * unit);
  by_relative(place.marker_F, place.marker_M, turned);
  is_lifted_ = true;
  lift_ = unit;
}

void Mechanism::ElementDerivatives::modal(int body, const Eigen::VectorXd& f) {
  start(Target::z);
  const TreeBody& t = m_.bodies_[body];  // t.m = 0 where it is rigid or the deformation does not act back
  for (int l = 0; l < t.m; ++l) add_row(t.i_v + l, -factor_ * f(l) * Vector6d::Unit(0));
}

void Mechanism::ElementDerivatives::rate(int i) {
  start(Target::z);
  add_row(m_.n_v_ + first_state_ + i, Vector6d::Unit(0));
}

void Mechanism::ElementDerivatives::rows() {
  start(Target::z);
  if (signal_ >= 0) {
    target_ = Target::signal;
    add_row(signal_, Vector6d::Unit(0));
  } else if (algebraic_ >= 0) {
    add_row(m_.n_v_ + m_.n_dyn_ + algebraic_, Vector6d::Unit(0));
  } else {
    target_ = Target::h;
    for (int i = 0; i < n_rows_; ++i)
      if (const int kept = work_.tangent.kept[first_row_ + i]; kept >= 0) add_row(kept, Vector6d::Unit(i));
  }
}

void Mechanism::ElementDerivatives::see(int marker_F, int marker_M) {
  if (e_.seen == std::pair(marker_F, marker_M)) return;
  e_.seen = {marker_F, marker_M};
  const MarkerState &F = work_.kin.markers[marker_F], &M = work_.kin.markers[marker_M];
  const int base = base_of({marker_F, marker_M});
  reach(marker_M, M.X_WP.p, base, e_.seen_M);
  reach(marker_F, M.X_WP.p, base, e_.seen_F);
  collect({&e_.seen_M, &e_.seen_F}, e_.seen_columns);
  std::erase_if(e_.seen_columns, [this](int j) { return skips(j); });
  // From (1) of inertia_tangents.cpp, as F sees it at M's origin, which moves by xi there.
  const Vector3d w_rel = M.V.angular - F.V.angular;
  for (std::size_t k = 0; k < e_.seen_columns.size(); ++k) {
    const int j = e_.seen_columns[k];
    const Spatial xi = Spatial::from(e_.seen_M.twist.col(j) - e_.seen_F.twist.col(j));
    Spatial change = cross_motion(xi, M.V) + Spatial::from(e_.seen_M.D.col(j) - e_.seen_F.D.col(j));
    change.linear += w_rel.cross(xi.linear);
    auto column = e_.motion.col(static_cast<Eigen::Index>(k));
    column.head<6>() = (F.X_WP.R.transpose() * xi).vector();
    column.tail<6>() = (F.X_WP.R.transpose() * change).vector();
  }
}

void Mechanism::ElementDerivatives::by_relative(int marker_F, int marker_M, const Matrix& d) {
  see(marker_F, marker_M);
  Eigen::Matrix<double, 6, 12> six_rows;
  for (int j = 0; j < 12; ++j) six_rows.col(j) = six(d.col(j));
  for (std::size_t k = 0; k < e_.seen_columns.size(); ++k) {
    const auto motion = e_.motion.col(static_cast<Eigen::Index>(k));
    add_column(e_.seen_columns[k], six_rows * motion);
    add_column(m_.n_v_ + e_.seen_columns[k], six_rows.rightCols<6>() * motion.head<6>());
  }
}

void Mechanism::ElementDerivatives::by_coordinate(CoordinateRef c, const Matrix& d) {
  const JointPlace& place = m_.places_[c.joint];
  if (!place.in_tree()) {
    by_relative(place.marker_F, place.marker_M, d * closure_gradient(work_.kin, place, c.index, false));
    return;
  }
  double q_dot[7], w[6] = {};
  for (int j = 0; j < place.joint->n_v(); ++j) {
    w[j] = 1.0;
    place.joint->kinematic(work_.kin.p + place.i_p, w, q_dot);
    w[j] = 0.0;
    if (q_dot[c.index] != 0.0) add_column(place.i_v + j, q_dot[c.index] * six(d.col(0)));
  }
}

void Mechanism::ElementDerivatives::by_speed(CoordinateRef c, const Matrix& d) {
  const JointPlace& place = m_.places_[c.joint];
  if (place.in_tree())
    add_column(m_.n_v_ + place.i_v + c.index, six(d.col(0)));
  else
    by_relative(place.marker_F, place.marker_M, d * closure_gradient(work_.kin, place, c.index, true));
}

void Mechanism::ElementDerivatives::by_signal(int signal, const Matrix& d) {
  const Vector6d change = six(d.col(0));
  for (Eigen::Index j = 0; j < e_.signals.cols(); ++j)
    if (const double by = e_.signals(signal, j); by != 0.0) add_column(static_cast<int>(j), by * change);
}

void Mechanism::ElementDerivatives::by_deformation(int body, int i, const Vector6d& d) {
  const int column = m_.bodies_[body].i_v + i;
  if (!skips(column)) add_column(column, d);
}

void Mechanism::ElementDerivatives::by_state(int i, const Matrix& d) {
  add_column(2 * m_.n_v_ + first_state_ + i, six(d.col(0)));
}

void Mechanism::ElementDerivatives::by_algebraic(double d) {
  add_column(2 * m_.n_v_ + m_.n_dyn_ + algebraic_, d * Vector6d::Unit(0));
}

}  // namespace flexura::mbs
