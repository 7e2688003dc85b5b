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
    const Expression* formula = tree_.d.measures[source.element]->formula();
    if (formula) {
      for (const int k : formula->reads())
        rate_of_signal(followed, k, weight * formula->derivative(signals, k));
    }
    return;
  }
  if (source.kind != Kind::control) return;
  Eigen::VectorXd weights;
  followed.output_weights(source.element, at_.motion, at_.signals, weights);
  first_state_ = states_.first_state_of_control(source.element);
  rate_weights_ = &weights;
  rate_weight_ = weight;
  tree_.d.controls[source.element]->differentiate_rates(signals, at_.motion.kin.c + first_state_, *this);
  rate_weights_ = nullptr;
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
  constraint.by_followed(at_.motion.kin, g_y, h_y, h_y_dot);
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
  for (const int place : f.reads()) rate_of_signal(followed, place, f.derivative(signals, place));
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
    add_followed_rows(h_y_dot);
    by_signal(place, one(0.25 * (up - down)));
  }
}

void ElementTangents::all_followed(const FollowedSignals& followed) {
  if (!followed.any()) return;
  for (const FollowedSignals::Follower& follower : followed.followers()) followed_rows(followed, follower);
}

}  // namespace flexura::mbs
