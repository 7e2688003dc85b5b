// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/mechanism/tangents/element_tangents.hpp"

/// Derivatives of rows that follow a formula y of signals: by g_y dy, h_y dy and h_y' dy', where
///
///     dy' = sum_i y_i d(s_i') + sum_ij y_ij s_i' ds_j
///
/// and the rate s_i' of a control's output is a sum of the rates of its states.
namespace flexura::mbs {

// All rows of the constraint, of which the following derivatives are one number.
void ElementTangents::add_followed_rows(const double* by) {
  for (int i = 0; i < n_rows_; ++i)
    if (const int kept = e_.kept[first_row_ + i]; kept >= 0 && by[i] != 0.0)
      add_row(kept, by[i] * Vector6d::Unit(0));
}

// weight d(s'), on the rows that have been named by followed_by_.
void ElementTangents::rate_of_signal(const FollowedSignals& followed, int place, double weight) {
  if (weight == 0.0) return;
  const double* signals = at_.signals.values.data();
  const auto& source = states_.sources()[place];
  using Kind = ElementStates::SignalSource::Kind;
  if (source.kind == Kind::measure) {
    if (const Expression* formula = tree_.d.measures[source.element]->formula())
      rate_of_formula(followed, *formula, weight, -1);
    return;
  }
  if (source.kind != Kind::control) return;
  const Control& control = *tree_.d.controls[source.element];
  if (control.is_algebraic()) {
    const Expression& b = *control.equation();
    rate_of_formula(followed, b, -weight / b.derivative(signals, place), place);
    return;
  }
  Eigen::VectorXd weights;
  followed.output_weights(source.element, at_.motion, at_.signals, weights);
  first_state_ = states_.first_state_of_control(source.element);
  rate_weights_ = &weights;
  rate_weight_ = weight;
  control.differentiate_rates(signals, at_.motion.kin.c + first_state_, *this);
  rate_weights_ = nullptr;
}

// weight d(f'), but for the change of the rate of one signal, `own`.
void ElementTangents::rate_of_formula(const FollowedSignals& followed, const Expression& f, double weight,
                                      int own) {
  const double* signals = at_.signals.values.data();
  for (const int place : f.reads())
    if (place != own) rate_of_signal(followed, place, weight * f.derivative(signals, place));
  // y_ij s_i' ds_j: the second derivative along s' + e_j less that along s' - e_j is four times this.
  std::vector<Jet> along = at_.rows.followed.signals;
  for (Jet& jet : along) jet.second = 0.0;
  for (const int place : f.reads()) {
    Jet& jet = along[static_cast<std::size_t>(place)];
    const double rate = jet.first;
    jet.first = rate + 1.0;
    const double up = f.along(signals, along.data()).second;
    jet.first = rate - 1.0;
    const double down = f.along(signals, along.data()).second;
    jet.first = rate;
    if (up == down) continue;
    start(Target::h);
    add_followed_rows(followed_by_);
    by_signal(place, one(0.25 * weight * (up - down)));
  }
}

// An algebraic state that rows follow is a function of what its equation reads.
void ElementTangents::by_eliminated(int algebraic, const Vector6d& change) {
  const Control& control = *tree_.d.controls[states_.algebraic()[static_cast<std::size_t>(algebraic)]];
  const int own = tree_.d.signals.find(control.name());
  const double* signals = at_.signals.values.data();
  const Expression& b = *control.equation();
  const double by_own = b.derivative(signals, own);
  for (const int place : b.reads())
    if (place != own) add_signal(place, -b.derivative(signals, place) / by_own * change);
}

void ElementTangents::followed_rows(const FollowedSignals& followed,
                                    const FollowedSignals::Follower& follower) {
  const Constraint& constraint = *rows_of_.constraints()[follower.constraint];
  const Expression& f = *follower.what.formula;
  const double* signals = at_.signals.values.data();
  rows_of_.own_contact(follower.constraint, at_.motion, at_.rows);
  first_row_ = rows_of_.first_row(follower.constraint);
  n_rows_ = constraint.n_rows();
  double g_y[6], h_y[6], h_y_dot[6];
  const std::size_t i = follower.place - rows_of_.first_followed(follower.constraint);
  constraint.by_followed(at_.motion.kin, static_cast<int>(i), g_y, h_y, h_y_dot);
  start(Target::g);
  add_followed_rows(g_y);
  Derivatives::by_formula(f, signals, 1.0);
  // Of one that is differenced the rest comes with the differences.
  if (!constraint.has_derivatives()) return;
  start(Target::h);
  add_followed_rows(h_y);
  Derivatives::by_formula(f, signals, 1.0);
  if (follower.what.level != DriveLevel::position) return;
  followed_by_ = h_y_dot;
  rate_of_formula(followed, f, 1.0, -1);
}

void ElementTangents::all_followed(const FollowedSignals& followed) {
  if (!followed.any()) return;
  eliminates_ = true;
  for (const FollowedSignals::Follower& follower : followed.followers()) followed_rows(followed, follower);
  eliminates_ = false;
}

}  // namespace flexura::mbs
