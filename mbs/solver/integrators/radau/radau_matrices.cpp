// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau_matrices.hpp"

#include <algorithm>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

namespace {

constexpr int kLongestFullSpan = 32;

TangentScope scope(bool is_cheap) {
  return is_cheap ? TangentScope::newton : TangentScope::everything;
}

}  // namespace

RadauMatrices::RadauMatrices(const Equations& eq, const RadauTableau& tableau, const State& start)
    : k_(tableau), form_(eq, start), real_(form_), complex_(form_) {
  for (Eigen::VectorXd* x : {&rhs_, &x_}) x->setZero(form_.size());
  for (Eigen::VectorXcd* x : {&rhs_c_, &x_c_}) x->setZero(form_.size());
  y_tangents_.setZero(form_.size());
  yp_tangents_.setZero(form_.size());
}

void RadauMatrices::forget() {
  h_ = 0.0;
  has_tangents_ = false;
}

void RadauMatrices::linearise(double t_step, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& yp) {
  is_cheap_ = form_.has_elastic_coordinates() && full_left_ == 0;
  if (full_left_ > 0) --full_left_;
  forget();
  t_step_ = t_step;
  t_tangents_ = t;
  y_tangents_ = y;
  yp_tangents_ = yp;
  ++linearised_;
  form_.linearise(t, y, yp, scope(is_cheap_));
  has_tangents_ = true;
}

bool RadauMatrices::factor(double h) {
  if (h_ == h) return true;
  h_ = h;
  return real_.factor(k_.gamma / h) && complex_.factor(k_.lambda / h);
}

void RadauMatrices::solve(std::array<Eigen::VectorXd, 3>& R) {
  rhs_ = k_.v_left(0) * R[0] + k_.v_left(1) * R[1] + k_.v_left(2) * R[2];
  rhs_c_ = k_.w_left(0) * R[0] + k_.w_left(1) * R[1] + k_.w_left(2) * R[2];
  real_.solve(rhs_, x_);
  complex_.solve(rhs_c_, x_c_);
  for (int i = 0; i < 3; ++i) R[i] = -k_.v(i) * x_ - 2.0 * (k_.w(i) * x_c_).real();
}

bool RadauMatrices::ask_for_more() {
  if (!is_cheap_) return false;
  full_left_ = full_span_;
  full_span_ = std::min(2 * full_span_, kLongestFullSpan);
  return true;
}

void RadauMatrices::count_accepted_step() {
  if (is_cheap_ && ++cheap_steps_ % kLongestFullSpan == 0) full_span_ = std::max(1, full_span_ / 2);
}

void RadauMatrices::remember(History& history) {
  history(has_tangents_);
  history(is_cheap_);
  for (double* x : {&t_tangents_, &t_step_, &h_}) history(*x);
  for (Eigen::VectorXd* x : {&y_tangents_, &yp_tangents_}) history(*x);
  for (int* k : {&full_left_, &full_span_, &cheap_steps_}) history(*k);
  if (!history.reads() || !has_tangents_) return;
  for (const Eigen::VectorXd* x : {&y_tangents_, &yp_tangents_}) require_size(x->size(), form_.size());
  form_.linearise(t_tangents_, y_tangents_, yp_tangents_, scope(is_cheap_));
  const double h = h_;
  h_ = 0.0;
  if (h > 0.0) factor(h);
}

}  // namespace flexura::mbs
