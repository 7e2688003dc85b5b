// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/output_rows.hpp"

#include <cmath>

namespace flexura::study {

using Eigen::VectorXd;

OutputRows::OutputRows(const mbs::Mechanism& mechanism, std::vector<int> which, long every)
    : mechanism_(&mechanism), which_(std::move(which)), scratch_(mechanism.make_scratch()), every_(every) {}

void OutputRows::take(const mbs::State& s, const VectorXd& v_dot) {
  if (rows_++ % every_ != 0) return;
  times_.push_back(s.t);
  VectorXd& y = values_.emplace_back(static_cast<Eigen::Index>(which_.size()));
  mechanism_->evaluate(which_, s, v_dot, *scratch_, y);
}

void OutputRows::forget_mechanism() {
  mechanism_ = nullptr;
  scratch_.reset();
}

OutputRows::Difference OutputRows::against(const OutputRows& other, double span) const {
  Difference d;
  d.squares = d.sizes = VectorXd::Zero(static_cast<Eigen::Index>(which_.size()));
  for (std::size_t i = 0, k = 0; i < size() && k < other.size();) {
    const double apart = times_[i] - other.times_[k];
    if (std::abs(apart) > 1e-9 * std::abs(span)) {
      ++(apart < 0.0 ? i : k);
      continue;
    }
    d.squares += (values_[i] - other.values_[k]).cwiseAbs2();
    d.sizes += values_[i].cwiseAbs2();
    ++d.rows, ++i, ++k;
  }
  return d;
}

}  // namespace flexura::study
