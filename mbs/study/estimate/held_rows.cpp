// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/held_rows.hpp"

#include <algorithm>

namespace flexura::study {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// The largest entry of the difference of M + h D / 2 + h^2 K / 4 (what the trapezoidal rule solves with),
// scaled to a unit diagonal.
double change(const LinearisedRow& a, const LinearisedRow& b, double h) {
  const VectorXd diagonal = (b.M + 0.5 * h * b.D + 0.25 * h * h * b.K).diagonal().cwiseAbs();
  const double floor = 1e-12 * diagonal.maxCoeff();
  const VectorXd scale = diagonal.cwiseMax(floor).cwiseSqrt().cwiseInverse();
  const MatrixXd A = (b.M - a.M) + 0.5 * h * (b.D - a.D) + 0.25 * h * h * (b.K - a.K);
  return (scale.asDiagonal() * A * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

}  // namespace

void HeldRows::take(const mbs::State& s, const VectorXd& v_dot, double h) {
  if (last_ && left_ > 0 && s.root == switches_) {
    --left_;
    full_.constraint_matrix(s, G_);
    return;
  }
  auto now = std::make_shared<LinearisedRow>();
  full_.linearise(s, v_dot, *now);
  now->number = ++linearised_;
  if (!last_ || s.root != switches_) {
    span_ = 1;
  } else {
    const double part = change(*last_, *now, h);
    if (part < most_.small_change)
      span_ = std::min(2 * span_, most_.longest);
    else if (!(part < 2.0 * most_.small_change))
      span_ = std::max(span_ / 2, 1);
  }
  left_ = span_ - 1;
  switches_ = s.root;
  G_ = now->G;
  last_ = std::move(now);
}

}  // namespace flexura::study
