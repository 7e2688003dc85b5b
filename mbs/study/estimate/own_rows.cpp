// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/own_rows.hpp"

#include "mbs/solver/run/watch/standstill.hpp"

namespace flexura::study {

using Eigen::VectorXd;

namespace {

// As the run does.
constexpr double kNear = 0.03, kGain = 1.5;

}  // namespace

OwnRows::OwnRows(const mbs::Mechanism& mechanism, const mbs::SolverOptions& options)
    : mechanism_(mechanism),
      own_(mechanism.copy_for_rows()),
      scratch_(equations().make_scratch()),
      here_(equations(), options),
      there_(mechanism, options) {}

bool OwnRows::hold_little(const std::array<mbs::Instant, 3>& nodes) {
  if (!own_) return false;
  hold_ = 1.0;
  for (const mbs::Instant& node : nodes)
    if (const double hold = mbs::hold_of_rows(*own_, node.state, *scratch_); hold < hold_) {
      hold_ = hold;
      weakest_ = node.state;
    }
  if (hold_ > kNear) {
    tried_at_ = 1.0;
    return false;
  }
  // Beside a dead point of all rows there is nothing to choose, and a look at each step would be one too many.
  return hold_ < 0.5 * tried_at_;
}

bool OwnRows::choose() {
  const auto is_better = [&] { return mbs::hold_of_rows(*own_, weakest_, *scratch_) > kGain * hold_; };
  if (!own_->choose_rows(weakest_, is_better)) {
    tried_at_ = hold_;
    return false;
  }
  tried_at_ = 1.0;
  has_other_rows_ = true;
  here_.forget_factors();
  return true;
}

void OwnRows::translate(mbs::LoopCloser& to, mbs::State& s, const VectorXd& v_dot) const {
  if (!has_other_rows_) return;
  VectorXd same = v_dot;
  to.accelerate(s, same);
}

}  // namespace flexura::study
