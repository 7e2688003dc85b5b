// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/row_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/solver/position/assemble.hpp"

namespace flexura::mbs {

namespace {

using Eigen::VectorXd;

/// Of the mechanism's size. Rows count as dependent where they are so but for 1e-7 (redundancy.cpp), and parts
/// as fitting where they do but for 1e-6 (assemble.cpp): what is open by less than that is no contradiction.
constexpr double kOpen = 1e-6;
/// [m, rad] What is closed anyway of rows that a coordinate changes one to one: 1e-11 (LoopCloser), twice.
constexpr double kClosedAnyway = 2e-11;

std::string list_of(std::vector<std::string> names) {
  std::string text;
  // Two drives of one joint have one name.
  names.erase(std::unique(names.begin() + 1, names.end()), names.end());
  if (names.size() > 6) {  // a message is read, not studied
    const std::size_t more = names.size() - 5;
    names.resize(5);
    for (const std::string& name : names) text += fmt::format("{}\"{}\"", text.empty() ? "" : ", ", name);
    return fmt::format("{} and {} more", text, more);
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    text += fmt::format("{}\"{}\"", i == 0 ? "" : i + 1 == names.size() ? " and " : ", ", names[i]);
  return text;
}

std::string disagreement(const std::vector<std::string>& names) {
  return names.size() > 1 ? fmt::format("the constraints {} contradict each other", list_of(names))
                          : fmt::format("the constraint {} cannot be met: nothing can move that changes it,",
                                        list_of(names));
}

constexpr const char* kRemedy =
    "take one of them away, make the drives agree, or give the loop the joint that it lacks";

}  // namespace

RowWatch::RowWatch(const Equations& eq)
    : eq_(eq), n_(eq.n_left_out()), n_kept_(eq.sizes().n_lambda), scratch_(eq.make_scratch()) {
  for (VectorXd* x : {&g_, &g_dot_, &g_ddot_}) x->setZero(n_);
  g_kept_.setZero(n_kept_);
  scale_.resize(eq.sizes().n_v);
  for (int i = 0; i < scale_.size(); ++i) scale_(i) = eq.velocity_scale(i);
}

void RowWatch::begin(const State& s) {
  misfit_ = 0.0;
  const auto size_up = [&](ConstraintSizes& sizes, const VectorXd& g) {
    sizes.size = sizes.size.cwiseMax(1e-300);
    if (g.size() > 0) misfit_ = std::max(misfit_, g.cwiseQuotient(sizes.size).lpNorm<Eigen::Infinity>());
  };
  if (n_kept_ > 0) {
    kept_sizes_ = eq_.constraint_sizes(s, s.p, *scratch_);
    eq_.position_constraints(s, s.p, *scratch_, g_kept_);
    size_up(kept_sizes_, g_kept_);
  }
  if (n_ > 0) {
    sizes_ = eq_.left_out_sizes(s, s.p, *scratch_);
    eq_.left_out_constraints(s, s.p, s.v, none_, *scratch_, g_, g_dot_, g_ddot_);
    size_up(sizes_, g_);
  }
  // What counts as fast: 1 rad/s, and of coordinates that move rows by lengths one length of the mechanism in a second (in
  // those of more than 1 m). A wheel beside gears that runs at 100 m/s excuses nothing of them in one 500 m across.
  double length = 1.0;
  for (const ConstraintSizes* sizes : {&kept_sizes_, &sizes_})
    for (Eigen::Index k = 0; k < sizes->size.size(); ++k)
      if (sizes->is_length[static_cast<std::size_t>(k)]) length = std::max(length, sizes->size(k));
  constexpr Eigen::Index kMost = 600;  // coordinates of a dense matrix that costs nothing
  if (length > 1.0 && n_kept_ > 0 && scale_.size() <= kMost) {
    Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n_kept_, scale_.size());
    eq_.constraint_matrix(s, s.p, *scratch_, G);
    for (int i = 0; i < scale_.size(); ++i) {
      const double unit = eq_.velocity_scale(i);
      const double moves = unit * G.col(i).cwiseAbs().cwiseQuotient(kept_sizes_.size).maxCoeff();
      scale_(i) = unit * std::max(1.0, moves * length > 1.0 ? 1.0 / moves : length);
    }
  }
  // Parts that do not fit exactly open and close as they move, one row by what the others make of it.
  open_ = kOpen + 10.0 * misfit_;
}

void RowWatch::change_rows(const State& s) {
  const double misfit = misfit_, open = open_;
  begin(s);
  misfit_ = misfit;
  open_ = open;
}

void RowWatch::begin(const State& s, const VectorXd& v_dot, bool at_dead_point) {
  begin(s);
  if (n_ > 0) require_agreement(s, v_dot, at_dead_point);
}

void RowWatch::require_agreement(const State& s, const VectorXd& v_dot, bool at_dead_point) {
  // What the row's terms are: the largest share of one coordinate, and what the drives ask for.  The first are
  // right to round-off of the positions, 1e-9 and better, and to what rows may lack of being dependent.
  VectorXd g(n_), g_t(n_), gamma(n_);
  const VectorXd at_rest = VectorXd::Zero(s.v.size());
  eq_.left_out_constraints(s, s.p, at_rest, at_rest, *scratch_, g, g_t, gamma);
  eq_.left_out_constraints(s, s.p, s.v, at_rest, *scratch_, g, g_dot_, gamma);
  eq_.left_out_constraints(s, s.p, s.v, v_dot, *scratch_, g, g_dot_, g_ddot_);
  double speed = 0.0, acceleration = 0.0;
  for (int i = 0; i < scale_.size(); ++i) {
    speed = std::max(speed, std::abs(s.v(i)) / scale_(i));
    acceleration = std::max(acceleration, std::abs(v_dot(i)) / scale_(i));
  }
  int worst = -1;
  double worst_part = 1.0;
  bool of_speed = true;
  for (int i = 0; i < n_; ++i) {
    const double size = sizes_.size(i);
    const double rate = std::max({speed * size, std::abs(g_t(i)), std::abs(g_dot_(i) - g_t(i))});
    if (const double part = std::abs(g_dot_(i)) / (open_ * rate + 1e-12 * size); part > worst_part)
      worst = i, worst_part = part, of_speed = true;
  }
  if (worst < 0)
    for (int i = 0; i < n_; ++i) {
      const double size = sizes_.size(i);
      const double rate = std::max({acceleration * size, speed * speed * size, std::abs(gamma(i))});
      if (const double part = std::abs(g_ddot_(i)) / (open_ * rate + 1e-9 * size); part > worst_part)
        worst = i, worst_part = part, of_speed = false;
    }
  if (worst < 0) return;
  const std::vector<std::string> names = eq_.names_of_left_out(worst);
  const char* unit = sizes_.is_length[worst] ? "m" : "rad";
  // The rows agree beside it; it is the speeds that do not.
  if (at_dead_point && !of_speed)
    throw AssemblyError(
        fmt::format("the mechanism starts at a dead point: at t = {:.6g} s motions cross, and the speeds "
                    "given lie on no one of them: "
                    "\"{}\" opens by {:.6g} {}/s^2 where the other constraints hold; give speeds of one "
                    "branch of the motion for all "
                    "that can move there, or start beside it",
                    s.t, names.front(), g_ddot_(worst), unit));
  throw AssemblyError(fmt::format("{} from t = {:.6g} s on: {}\"{}\" opens by {:.6g} {}/s{}; {}",
                                  disagreement(names), s.t, names.size() > 1 ? "where the others hold, " : "",
                                  names.front(), of_speed ? g_dot_(worst) : g_ddot_(worst), unit,
                                  of_speed ? "" : "^2", kRemedy));
}

const RowWatch::Opening& RowWatch::look(const State& s, Judge judge) {
  opening_ = {};
  if (n_kept_ > 0) {
    eq_.position_constraints(s, s.p, *scratch_, g_kept_);
    for (int k = 0; k < n_kept_; ++k) {
      // Rows of a mechanism that starts in one point are not closed further (LoopCloser).
      const double allowed =
          std::max(open_ * kept_sizes_.size(k) + 1e2 * kept_sizes_.round_off(k), kClosedAnyway);
      if (const double part = std::abs(g_kept_(k)) / allowed; part > opening_.kept) {
        opening_.kept = part;
        opening_.kept_row = k;
        opening_.kept_value = g_kept_(k);
      }
    }
  }
  if (n_ == 0) return opening_;
  eq_.left_out_constraints(s, s.p, s.v, none_, *scratch_, g_, g_dot_, g_ddot_);
  const double speed =
      std::max(1.0, s.v.size() > 0 ? s.v.cwiseQuotient(scale_).lpNorm<Eigen::Infinity>() : 0.0);
  for (int i = 0; i < n_; ++i) {
    opening_.drift = std::max(opening_.drift, std::abs(g_(i)));
    opening_.drift_rate = std::max(opening_.drift_rate, std::abs(g_dot_(i)));
    const double allowed = open_ * sizes_.size(i) + 1e2 * sizes_.round_off(i);
    const double position = std::abs(g_(i)) / allowed;
    const double rate = std::abs(g_dot_(i)) / (10.0 * speed * allowed);
    for (const bool of_speed : {false, true}) {
      if (of_speed && judge == Judge::positions) continue;
      const double part = of_speed ? rate : position;
      if (!(part > opening_.left_out)) continue;
      opening_.left_out = part;
      opening_.row = i;
      opening_.of_speed = of_speed;
      opening_.value = of_speed ? g_dot_(i) : g_(i);
    }
  }
  return opening_;
}

double RowWatch::allowed(double tolerance) {
  return std::max(1.0, 10.0 * tolerance / kOpen);
}

std::string RowWatch::complaint(double t, double since, double allowed) const {
  if (opening_.kept > allowed)
    return fmt::format(
        "the constraint \"{}\" is open by {:.6g} {} at t = {:.6g} s and cannot be closed from there",
        eq_.name_of_constraint(opening_.kept_row), opening_.kept_value,
        kept_sizes_.is_length[opening_.kept_row] ? "m" : "rad", t);
  const std::vector<std::string> names = eq_.names_of_left_out(opening_.row);
  return fmt::format("{} from t = {:.6g} s on: {}\"{}\" is open by {:.6g} {}{} at t = {:.6g} s; {}",
                     disagreement(names), since, names.size() > 1 ? "where the others hold, " : "",
                     names.front(), opening_.value, sizes_.is_length[opening_.row] ? "m" : "rad",
                     opening_.of_speed ? "/s" : "", t, kRemedy);
}

}  // namespace flexura::mbs
