// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/constraints/expression_constraint.hpp"

#include <algorithm>
#include <numbers>

#include "mbs/constraints/pose_hessians.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of each thread: nothing is allocated in a run.
std::vector<Jet>& own_jets() {
  thread_local std::vector<Jet> jets;
  return jets;
}

Matrix6d pose_hessian(const std::function<PoseFunction(const Relative&)>& y, Relative rel) {
  return pose_hessians(
      [&](const Vector6d& V) {
        rel.V = V;
        return Eigen::Matrix<double, 1, 1>(y(rel).bias);
      },
      [&](int) { return y(rel).gradient; })[0];
}

}  // namespace

ExpressionConstraint::ExpressionConstraint(std::string name, std::vector<Argument> arguments,
                                           std::vector<Between> between,
                                           std::shared_ptr<const Expression> value, int n_signals,
                                           input::Dimension dimension)
    : Constraint(std::move(name)),
      arguments_(std::move(arguments)),
      between_(std::move(between)),
      value_(std::move(value)),
      n_signals_(static_cast<std::size_t>(n_signals)),
      dimension_(dimension),
      reads_time_(value_->reads_time() ||
                  std::ranges::any_of(between_, [](const Between& b) { return b.formula->reads_time(); })) {
  for (std::size_t i = 0; i < arguments_.size(); ++i)
    if (arguments_[i].followed) followed_.push_back(i);
}

Following ExpressionConstraint::following(int i) const {
  return {arguments_[followed_[static_cast<std::size_t>(i)]].followed.get(), DriveLevel::position};
}

GapKind ExpressionConstraint::gap_kind(int) const {
  return dimension_ == input::dim::length  ? GapKind::length
         : dimension_ == input::dim::angle ? GapKind::angle
                                           : GapKind::other;
}

std::vector<CoordinateRef> ExpressionConstraint::coordinates() const {
  std::vector<CoordinateRef> list;
  for (const Argument& y : arguments_)
    if (y.is_coordinate()) list.push_back(y.coordinate);
  return list;
}

std::vector<int> ExpressionConstraint::markers() const {
  std::vector<int> list;
  for (const Argument& y : arguments_)
    if (y.of_pose) list.insert(list.end(), {y.F, y.M});
  return list;
}

void ExpressionConstraint::move(const Kinematics& kin, Level level, std::vector<Jet>& jets) const {
  jets.assign(n_signals_, Jet{});
  jets[0] = {kin.t, level == Level::position ? 0.0 : 1.0, 0.0};
  const Jet* followed = kin.own.followed;
  for (const Argument& y : arguments_) {
    Jet& jet = jets[static_cast<std::size_t>(y.place)];
    if (y.followed) {
      jet = *followed++;
      if (level == Level::position) jet.first = 0.0;
      if (level != Level::acceleration) jet.second = 0.0;
      continue;
    }
    if (y.is_coordinate()) {
      jet.value = kin.coordinate(y.coordinate);
      if (level != Level::position) jet.first = kin.speed(y.coordinate);
      if (level == Level::acceleration) jet.second = kin.acceleration(y.coordinate);
      continue;
    }
    Relative rel;
    if (level == Level::position) rel.X_FM = kin.relative_pose(y.F, y.M);
    if (level == Level::velocity) rel = kin.relative_motion(y.F, y.M);
    if (level == Level::acceleration) rel = kin.relative_acceleration(y.F, y.M);
    const PoseFunction at = y.of_pose(rel);
    jet = {at.value, at.gradient.dot(rel.V), at.gradient.dot(rel.A) + at.bias};
  }
  count_turns(kin, jets);
}

void ExpressionConstraint::count_turns(const Kinematics& kin, std::vector<Jet>& jets) const {
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    const Argument& y = arguments_[i];
    if (!y.is_coordinate() || !is_without_turns(kin, y.coordinate)) continue;
    thread_local std::vector<Jet> trial;
    trial = jets;
    const Jet f = along(static_cast<int>(i), static_cast<int>(i), trial);
    const double turns = -std::round(f.value / (2.0 * std::numbers::pi * f.first));
    if (turns == 0.0 || !std::isfinite(turns)) continue;
    const auto place = static_cast<std::size_t>(y.place);
    trial[place].value += 2.0 * std::numbers::pi * turns;
    // Of a formula that is periodic in the angle all turns are the same.
    if (std::abs(run(trial).value) < 0.5 * std::abs(f.value)) jets[place].value = trial[place].value;
  }
}

Jet ExpressionConstraint::run(std::vector<Jet>& jets) const {
  thread_local std::vector<double> signals;  // no conditions are held: what the formulas compare is compared
  signals.assign(n_signals_, 0.0);
  for (const Between& b : between_)
    jets[static_cast<std::size_t>(b.place)] = b.formula->along(signals.data(), jets.data());
  return value_->along(signals.data(), jets.data());
}

Jet ExpressionConstraint::along(int i, int j, std::vector<Jet>& jets) const {
  const int n = static_cast<int>(arguments_.size());
  for (int k = 0; k <= n; ++k) {
    Jet& jet = jets[k == n ? 0 : static_cast<std::size_t>(arguments_[static_cast<std::size_t>(k)].place)];
    jet.first = k == i || k == j ? 1.0 : 0.0;
    jet.second = 0.0;
  }
  return run(jets);
}

void ExpressionConstraint::position(const Kinematics& kin, double* g) const {
  std::vector<Jet>& jets = own_jets();
  move(kin, Level::position, jets);
  g[0] = run(jets).value;
}

void ExpressionConstraint::velocity(const Kinematics& kin, double* g_dot) const {
  std::vector<Jet>& jets = own_jets();
  move(kin, Level::velocity, jets);
  g_dot[0] = run(jets).first;
}

void ExpressionConstraint::acceleration(const Kinematics& kin, double* g_ddot) const {
  std::vector<Jet>& jets = own_jets();
  move(kin, Level::acceleration, jets);
  g_ddot[0] = run(jets).second;
}

void ExpressionConstraint::rate(const Kinematics& kin, double* g_t) const {
  g_t[0] = 0.0;
  if (!reads_time(0)) return;
  std::vector<Jet>& jets = own_jets();
  move(kin, Level::position, jets);
  jets[0].first = 1.0;
  for (std::size_t k = 0; k < followed_.size(); ++k)
    jets[static_cast<std::size_t>(arguments_[followed_[k]].place)].first = kin.own.followed[k].first;
  g_t[0] = run(jets).first;
}

void ExpressionConstraint::apply_GT(const Kinematics& kin, const double* x, Loads& loads) const {
  std::vector<Jet>& jets = own_jets();
  move(kin, Level::position, jets);
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    const Argument& y = arguments_[i];
    if (y.followed) continue;
    const double f_i = along(static_cast<int>(i), static_cast<int>(i), jets).first;
    if (y.is_coordinate()) {
      loads.apply(y.coordinate, f_i * x[0]);
      continue;
    }
    Relative rel;
    rel.X_FM = kin.relative_pose(y.F, y.M);
    loads.apply_between(kin, y.F, y.M, f_i * x[0] * y.of_pose(rel).gradient);
  }
}

ExpressionConstraint::Tangent ExpressionConstraint::tangent(const Kinematics& kin) const {
  std::vector<Jet>& jets = own_jets();
  move(kin, Level::velocity, jets);
  const int n = static_cast<int>(arguments_.size());
  Tangent out{VectorXd(n + 1), VectorXd(n + 1), MatrixXd(n + 1, n + 1)};
  for (int i = 0; i < n; ++i)
    out.rate(i) = jets[static_cast<std::size_t>(arguments_[static_cast<std::size_t>(i)].place)].first;
  out.rate(n) = 1.0;
  MatrixXd& F = out.F;
  for (int i = 0; i <= n; ++i) {
    const Jet jet = along(i, i, jets);
    out.f(i) = jet.first;
    F(i, i) = jet.second;
  }
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < i; ++j) F(i, j) = F(j, i) = 0.5 * (along(i, j, jets).second - F(i, i) - F(j, j));
  return out;
}

void ExpressionConstraint::by_followed(const Kinematics& kin, int i, double* g_y, double* h_y,
                                       double* h_y_dot) const {
  const Tangent at = tangent(kin);
  const auto k = static_cast<Eigen::Index>(followed_[static_cast<std::size_t>(i)]);
  g_y[0] = h_y_dot[0] = at.f(k);
  h_y[0] = at.F.row(k).dot(at.rate);
}

void ExpressionConstraint::differentiate(const Kinematics& kin, const double* x, Derivatives& d) const {
  const auto [f, rate, F] = tangent(kin);
  const VectorXd f_rate = F * rate;  // of the f_i
  const auto n = arguments_.size();
  std::vector<Vector6d> grad(n, Vector6d::Zero());
  std::vector<Relative> motion(n);
  std::vector<Matrix6d> H(n, Matrix6d::Zero());
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    const Argument& y = arguments_[i];
    if (!y.of_pose) continue;
    motion[i] = kin.relative_motion(y.F, y.M);
    grad[i] = y.of_pose(motion[i]).gradient;
    H[i] = pose_hessian(y.of_pose, motion[i]);
  }
  // What is named before changes by `by` with the arguments; rows with those that they follow by by_followed().
  const auto by_arguments = [&](const auto& what, const auto& by, bool is_load) {
    for (std::size_t j = 0; j < arguments_.size(); ++j) {
      const Argument& y = arguments_[j];
      const double f_j = by(static_cast<Eigen::Index>(j));
      if (y.followed) {
        if (is_load && f_j != 0.0) d.by_signal(y.place, (what * f_j).eval());
        continue;
      }
      if (y.is_coordinate()) {
        d.by_coordinate(y.coordinate, (what * f_j).eval());
        continue;
      }
      Eigen::Matrix<double, std::remove_cvref_t<decltype(what)>::RowsAtCompileTime, 12> rows;
      rows.setZero();
      rows.template leftCols<6>() = what * (f_j * grad[j]).transpose();
      d.by_relative(y.F, y.M, rows);
    }
  };
  const Eigen::Matrix<double, 1, 1> one = Eigen::Matrix<double, 1, 1>::Ones();
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    const Argument& y = arguments_[i];
    if (y.followed) continue;
    const auto k = static_cast<Eigen::Index>(i);
    const auto f_by = [&](Eigen::Index j) { return x[0] * F(k, j); };
    if (y.is_coordinate()) {
      d.force(y.coordinate, f(k) * x[0]);
      by_arguments(one, f_by, true);
      continue;
    }
    d.between(y.F, y.M, f(k) * x[0] * grad[i]);
    Eigen::Matrix<double, 6, 12> load = Eigen::Matrix<double, 6, 12>::Zero();
    load.leftCols<6>() = f(k) * x[0] * H[i];
    d.by_relative(y.F, y.M, load);
    by_arguments(grad[i], f_by, true);
  }
  d.rows();
  by_arguments(
      one, [&](Eigen::Index j) { return f_rate(j); }, false);
  for (std::size_t i = 0; i < arguments_.size(); ++i) {
    const Argument& y = arguments_[i];
    if (y.followed) continue;
    const double f_i = f(static_cast<Eigen::Index>(i));
    if (y.is_coordinate()) {
      d.by_speed(y.coordinate, Eigen::Matrix<double, 1, 1>(f_i));
      continue;
    }
    Eigen::Matrix<double, 1, 12> row;
    row << f_i * motion[i].V.transpose() * H[i], f_i * grad[i].transpose();
    d.by_relative(y.F, y.M, row);
  }
}

std::vector<OutputInfo> ExpressionConstraint::outputs() const {
  const input::Dimension force = dimension_ == input::dim::length  ? input::dim::force
                                 : dimension_ == input::dim::angle ? input::dim::torque
                                                                   : input::dim::none;
  return {
      {"force", force,
       "generalised force along the value: on a coordinate it puts this times the value's derivative by it"}};
}

}  // namespace flexura::mbs
