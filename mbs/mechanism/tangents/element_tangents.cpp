// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/tangents/element_tangents.hpp"

#include <algorithm>

#include "mbs/mechanism/tangents/closure_tangents.hpp"

namespace flexura::mbs {
void ElementVariations::size(const Topology& tree, const ElementStates& states, const ConstraintRows& rows_of,
                             int n_algebraic) {
  const int n_v = tree.n_v;
  for (MarkerReach* reach : {&at, &axes, &reaction, &seen_F, &seen_M}) reach->size(n_v);
  marks.size(n_v);
  columns.reserve(n_v);
  seen_columns.reserve(n_v);
  rows.reserve(n_v + 6);
  by_row.setZero(6, n_v + 6);
  motion.setZero(12, n_v);
  if (!states.used_signals().empty())
    signals.setZero(tree.d.signals.size(), 2 * n_v + tree.n_dyn + n_algebraic);
  is_elastic.assign(n_v, false);
  for (int b : tree.order)
    for (int l = 0; l < tree.bodies[b].m; ++l) is_elastic[tree.bodies[b].i_v + l] = true;
  z_q.setZero(n_v + tree.n_dyn + n_algebraic, n_v);
  h_q.setZero(static_cast<Eigen::Index>(rows_of.kept().size()), n_v);
}

ElementTangents::ElementTangents(const Topology& tree, const ElementStates& states,
                                 const ConstraintRows& rows_of, TangentScope scope, const Instant& at,
                                 TangentMatrices& out)
    : tree_(tree),
      states_(states),
      rows_of_(rows_of),
      scope_(scope),
      at_(at),
      out_(out),
      e_(at.elements),
      reaches_(tree, at.inertia) {
  e_.seen = {-2, -2};
  e_.signals.setZero();
  // Runs may choose others on their way.
  e_.kept.assign(static_cast<std::size_t>(rows_of.n_all()), -1);
  for (std::size_t i = 0; i < rows_of.kept().size(); ++i) e_.kept[rows_of.kept()[i]] = static_cast<int>(i);
}

void ElementTangents::add(int row, int column, double value) {
  const int n_v = tree_.n_v, n_c = tree_.n_dyn;
  switch (target_) {
    case Target::signal:
      e_.signals(row, column) += value;
      break;
    case Target::h:
      if (column < n_v)
        e_.h_q(row, column) += value;
      else if (column >= 2 * n_v && column < 2 * n_v + n_c && out_.h_c.size() > 0)
        out_.h_c(row, column - 2 * n_v) += value;
      break;
    case Target::g:
      if (column >= 2 * n_v && column < 2 * n_v + n_c) out_.g_c(row, column - 2 * n_v) += value;
      break;
    case Target::z:
      if (column < n_v)
        e_.z_q(row, column) += value;
      else if (column < 2 * n_v)
        out_.z_v(row, column - n_v) += value;
      else if (column < 2 * n_v + n_c)
        out_.z_c(row, column - 2 * n_v) += value;
      else
        out_.z_a(row, column - 2 * n_v - n_c) += value;
  }
}

// The change of what is done along one column.
void ElementTangents::add_column(int column, const Vector6d& change) {
  for (std::size_t i = 0; i < e_.rows.size(); ++i)
    add(e_.rows[i], column, e_.by_row.col(static_cast<Eigen::Index>(i)).dot(change));
}

void ElementTangents::start(Target target) {
  target_ = target;
  is_lifted_ = false;
  e_.rows.clear();
}

void ElementTangents::add_row(int row, const Vector6d& by) {
  e_.by_row.col(static_cast<Eigen::Index>(e_.rows.size())) = by;
  e_.rows.push_back(row);
}

// d, brought to six rows: with zeros, or along the wrench that a force on a closure is.
Vector6d ElementTangents::six(const Eigen::Ref<const Eigen::VectorXd>& d) const {
  if (is_lifted_) return d(0) * lift_;
  Vector6d x = Vector6d::Zero();
  x.head(d.size()) = d;
  return x;
}

bool ElementTangents::skips(int j) const {
  return scope_ == TangentScope::newton && e_.is_elastic[j];
}

// What is left of a load on the marker `at`, see the header, and of its reaction.
void ElementTangents::turn_load(const MarkerReach* reaction, const Matrix3d& R, const Vector6d& wrench) {
  const Spatial w = R * Spatial::from(wrench);
  e_.marks.collect({&e_.at, &e_.axes, reaction}, e_.columns);
  for (const int j : e_.columns) {
    if (skips(j)) continue;
    const auto left_on = [&](const MarkerReach& body, double sign) {
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
  e_.marks.collect({&e_.at, reaction}, e_.columns);
  for (const int i : e_.columns) component(i);
}

void ElementTangents::between(int marker_F, int marker_M, const Vector6d& on_M_F) {
  start(Target::z);
  const int base = reaches_.base_of({marker_F, marker_M});
  const Vector3d& point = at_.motion.kin.markers[marker_M].X_WP.p;
  reaches_.reach(marker_M, point, base, e_.at);
  reaches_.reach(marker_F, point, base, e_.axes);
  turn_load(&e_.axes, at_.motion.kin.markers[marker_F].X_WP.R, on_M_F);
}

void ElementTangents::wrench(int at, int axes, int reaction, const Vector6d& wrench) {
  start(Target::z);
  const int base = reaches_.base_of({at, axes, reaction});
  const Vector3d& point = at_.motion.kin.markers[at].X_WP.p;
  reaches_.reach(at, point, base, e_.at);
  reaches_.reach(axes, point, base, e_.axes);
  reaches_.reach(reaction, point, base, e_.reaction);
  turn_load(reaction < 0 ? nullptr : &e_.reaction,
            axes < 0 ? Matrix3d(Matrix3d::Identity()) : at_.motion.kin.markers[axes].X_WP.R, wrench);
}

void ElementTangents::force(CoordinateRef c, double value) {
  const JointPlace& place = tree_.places[c.joint];
  if (place.in_tree()) {
    start(Target::z);
    add_row(place.i_v + c.index, -factor_ * Vector6d::Unit(0));
    return;
  }
  const Pose X = at_.motion.kin.relative_pose(place.marker_F, place.marker_M);
  const Vector6d unit = closure_wrench(*place.joint, X, c.index);
  between(place.marker_F, place.marker_M, value * unit);
  by_relative(place.marker_F, place.marker_M, value * closure_wrench_gradient(*place.joint, X, c.index));
  is_lifted_ = true;
  lift_ = unit;
}

void ElementTangents::modal(int body, const Eigen::VectorXd& f) {
  start(Target::z);
  const TreeBody& t = tree_.bodies[body];  // t.m = 0 where it is rigid or the deformation does not act back
  for (int l = 0; l < t.m; ++l) add_row(t.i_v + l, -factor_ * f(l) * Vector6d::Unit(0));
}

void ElementTangents::rate(int i) {
  if (rate_weights_) {
    start(Target::h);
    if (const double weight = rate_weight_ * (*rate_weights_)(i); weight != 0.0)
      for (int row = 0; row < n_rows_; ++row)
        if (const int kept = e_.kept[first_row_ + row]; kept >= 0)
          add_row(kept, weight * followed_by_[row] * Vector6d::Unit(0));
    return;
  }
  start(Target::z);
  add_row(tree_.n_v + first_state_ + i, Vector6d::Unit(0));
}

void ElementTangents::rows() {
  start(Target::z);
  if (signal_ >= 0) {
    target_ = Target::signal;
    add_row(signal_, Vector6d::Unit(0));
  } else if (algebraic_ >= 0) {
    add_row(tree_.n_v + tree_.n_dyn + algebraic_, Vector6d::Unit(0));
  } else {
    target_ = Target::h;
    for (int i = 0; i < n_rows_; ++i)
      if (const int kept = e_.kept[first_row_ + i]; kept >= 0) add_row(kept, Vector6d::Unit(i));
  }
}

void ElementTangents::see(int marker_F, int marker_M) {
  if (e_.seen == std::pair(marker_F, marker_M)) return;
  e_.seen = {marker_F, marker_M};
  const MarkerState &F = at_.motion.kin.markers[marker_F], &M = at_.motion.kin.markers[marker_M];
  const int base = reaches_.base_of({marker_F, marker_M});
  reaches_.reach(marker_M, M.X_WP.p, base, e_.seen_M);
  reaches_.reach(marker_F, M.X_WP.p, base, e_.seen_F);
  e_.marks.collect({&e_.seen_M, &e_.seen_F}, e_.seen_columns);
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

void ElementTangents::by_relative(int marker_F, int marker_M, const Matrix& d) {
  see(marker_F, marker_M);
  Eigen::Matrix<double, 6, 12> six_rows;
  for (int j = 0; j < 12; ++j) six_rows.col(j) = six(d.col(j));
  for (std::size_t k = 0; k < e_.seen_columns.size(); ++k) {
    const auto motion = e_.motion.col(static_cast<Eigen::Index>(k));
    add_column(e_.seen_columns[k], six_rows * motion);
    add_column(tree_.n_v + e_.seen_columns[k], six_rows.rightCols<6>() * motion.head<6>());
  }
}

void ElementTangents::by_coordinate(CoordinateRef c, const Matrix& d) {
  const JointPlace& place = tree_.places[c.joint];
  if (!place.in_tree()) {
    by_relative(place.marker_F, place.marker_M, d * closure_gradient(at_.motion.kin, place, c.index, false));
    return;
  }
  double q_dot[7], w[6] = {};
  for (int j = 0; j < place.joint->n_v(); ++j) {
    w[j] = 1.0;
    place.joint->kinematic(at_.motion.kin.p + place.i_p, w, q_dot);
    w[j] = 0.0;
    if (q_dot[c.index] != 0.0) add_column(place.i_v + j, q_dot[c.index] * six(d.col(0)));
  }
}

void ElementTangents::by_speed(CoordinateRef c, const Matrix& d) {
  const JointPlace& place = tree_.places[c.joint];
  if (place.in_tree())
    add_column(tree_.n_v + place.i_v + c.index, six(d.col(0)));
  else
    by_relative(place.marker_F, place.marker_M, d * closure_gradient(at_.motion.kin, place, c.index, true));
}

void ElementTangents::by_signal(int signal, const Matrix& d) {
  add_signal(signal, six(d.col(0)));
}

void ElementTangents::add_signal(int signal, const Vector6d& change) {
  const Eigen::Index of_algebraic = 2 * tree_.n_v + tree_.n_dyn;
  const auto n_eliminated = static_cast<Eigen::Index>(eliminates_ ? states_.algebraic().size() : 0);
  for (Eigen::Index j = 0; j < e_.signals.cols(); ++j) {
    const double by = e_.signals(signal, j);
    if (by == 0.0) continue;
    if (j >= of_algebraic && j < of_algebraic + n_eliminated)
      by_eliminated(static_cast<int>(j - of_algebraic), by * change);
    else
      add_column(static_cast<int>(j), by * change);
  }
}

void ElementTangents::by_deformation(int body, int i, const Vector6d& d) {
  const int column = tree_.bodies[body].i_v + i;
  if (!skips(column)) add_column(column, d);
}

void ElementTangents::by_state(int i, const Matrix& d) {
  add_column(2 * tree_.n_v + first_state_ + i, six(d.col(0)));
}

void ElementTangents::by_algebraic(double d) {
  add_column(2 * tree_.n_v + tree_.n_dyn + algebraic_, d * Vector6d::Unit(0));
}

void ElementTangents::by_deformation_rate(int body, int i, const Vector6d& d) {
  const int column = tree_.bodies[body].i_v + i;
  if (!skips(column)) add_column(tree_.n_v + column, d);
}

void ElementTangents::modal_forces(int body, int marker_F, int marker_M, const Rows& by_relative) {
  start(Target::z);
  const TreeBody& t = tree_.bodies[body];  // t.m = 0 where it is rigid or the deformation does not act back
  if (t.m == 0) return;
  see(marker_F, marker_M);
  for (std::size_t k = 0; k < e_.seen_columns.size(); ++k) {
    const int j = e_.seen_columns[k];
    const auto motion = e_.motion.col(static_cast<Eigen::Index>(k));
    for (int l = 0; l < t.m; ++l) {
      add(t.i_v + l, j, -factor_ * by_relative.row(l).dot(motion));
      add(t.i_v + l, tree_.n_v + j, -factor_ * by_relative.row(l).tail<6>().dot(motion.head<6>()));
    }
  }
}

void ElementTangents::modal_forces_by(int body, int by, const Rows& by_s, const Rows& by_s_dot) {
  start(Target::z);
  const TreeBody &t = tree_.bodies[body], &other = tree_.bodies[by];
  if (t.m == 0) return;
  for (int i = 0; i < other.m; ++i) {
    const int j = other.i_v + i;
    if (skips(j)) continue;
    for (int l = 0; l < t.m; ++l) {
      add(t.i_v + l, j, -factor_ * by_s(l, i));
      add(t.i_v + l, tree_.n_v + j, -factor_ * by_s_dot(l, i));
    }
  }
}

// What each signal depends on, in the order in which they are evaluated.
void ElementTangents::all_signals() {
  const double* signals = at_.signals.values.data();
  for (const int k : states_.used_signals()) {
    const ElementStates::SignalSource& source = states_.sources()[k];
    signal_ = k;
    switch (source.kind) {
      case ElementStates::SignalSource::Kind::time:
      case ElementStates::SignalSource::Kind::input:
        break;
      case ElementStates::SignalSource::Kind::coordinate:
        rows();
        Derivatives::by_coordinate(source.coordinate, 1.0);
        break;
      case ElementStates::SignalSource::Kind::speed:
        rows();
        Derivatives::by_speed(source.coordinate, 1.0);
        break;
      case ElementStates::SignalSource::Kind::measure:
        if (const int i = states_.coupled_measure(source.element); i >= 0) {
          rows();
          algebraic_ = static_cast<int>(states_.algebraic().size()) + i;
          by_algebraic(1.0);
          algebraic_ = -1;
          break;
        }
        tree_.d.measures[source.element]->differentiate(at_.motion.kin, signals, *this);
        break;
      case ElementStates::SignalSource::Kind::control: {
        const Control& control = *tree_.d.controls[source.element];
        first_state_ = states_.first_state_of_control(source.element);
        if (!control.is_algebraic()) {
          control.differentiate(signals, at_.motion.kin.c + first_state_, *this);
          break;
        }
        rows();
        algebraic_ = static_cast<int>(std::ranges::find(states_.algebraic(), source.element) -
                                      states_.algebraic().begin());
        by_algebraic(1.0);
        algebraic_ = -1;
      }
    }
  }
  signal_ = -1;
}

void ElementTangents::all_elements() {
  const double* signals = at_.signals.values.data();
  for (std::size_t i = 0; i < tree_.d.controls.size(); ++i) {
    first_state_ = states_.first_state_of_control(i);
    tree_.d.controls[i]->differentiate_rates(signals, at_.motion.kin.c + first_state_, *this);
  }
  for (std::size_t i = 0; i < tree_.d.forces.size(); ++i) {
    if (!tree_.d.forces[i]->has_derivatives()) continue;
    states_.own_states(i, at_.motion, at_.signals);
    first_state_ = states_.first_state_of_force(i);
    tree_.d.forces[i]->differentiate(at_.motion.kin, signals, *this);
  }
  for (std::size_t k = 0; k < states_.algebraic().size(); ++k) {
    algebraic_ = static_cast<int>(k);
    tree_.d.controls[states_.algebraic()[k]]->differentiate(signals, nullptr, *this);
  }
  for (std::size_t k = 0; k < rows_of_.contacts().size(); ++k) {
    algebraic_ = states_.n_algebraic() + static_cast<int>(k);
    rows_of_.constraints()[rows_of_.contacts()[k]]->differentiate_contact(
        at_.motion.kin, at_.signals.algebraic(algebraic_), *this);
  }
  algebraic_ = -1;
  factor_ = -1.0;
  for (std::size_t k = 0; k < rows_of_.constraints().size(); ++k) {
    const Constraint& constraint = *rows_of_.constraints()[k];
    if (!constraint.has_derivatives()) continue;
    rows_of_.own_contact(k, at_.motion, at_.rows);
    first_row_ = rows_of_.first_row(k);
    n_rows_ = constraint.n_rows();
    eliminates_ = constraint.n_followed() > 0;
    constraint.differentiate(at_.motion.kin, at_.rows.x.data() + first_row_, *this);
    eliminates_ = false;
  }
}

}  // namespace flexura::mbs
