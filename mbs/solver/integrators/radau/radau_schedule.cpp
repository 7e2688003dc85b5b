// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau_schedule.hpp"

#include <algorithm>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

namespace {

constexpr int kMostSteps = 64, kSoonAgain = 4, kLongestWait = 1024, kFirstSpan = 8;
// Tried from one failure in five attempts on: a contact that closes fails now and then.
constexpr double kTroubled = 0.2;

}  // namespace

StageSchedule::StageSchedule() : span_(kFirstSpan), plain_steps_(kSoonAgain) {}

bool StageSchedule::wants_stages(bool is_at_its_best) const {
  if (steps_ > 0) return true;
  return wait_ == 0 && (trouble_rate_ > kTroubled || plain_steps_ < kSoonAgain) && is_at_its_best;
}

void StageSchedule::take_plain(bool converged) {
  trouble_rate_ += 0.1 * ((converged ? 0.0 : 1.0) - trouble_rate_);
}

void StageSchedule::take_stages(bool converged) {
  if (!converged) {
    steps_ = 0;
    wait_ = span_;
    span_ = std::min(2 * span_, kLongestWait);
  } else if (steps_ == 0) {
    run_ = plain_steps_ < kSoonAgain ? std::min(2 * run_, kMostSteps) : 1;
    steps_ = run_;
  }
}

void StageSchedule::count_accepted_step() {
  if (wait_ > 0) --wait_;
  plain_steps_ = steps_ > 0 ? 0 : std::min(plain_steps_ + 1, kSoonAgain);
  if (steps_ > 0 && --steps_ == 0) span_ = kFirstSpan;
}

void StageSchedule::remember(History& history) {
  history(trouble_rate_);
  for (int* k : {&steps_, &wait_, &run_, &span_, &plain_steps_}) {
    history(*k);
    if (history.reads()) require_between(*k, 0, kLongestWait);
  }
}

}  // namespace flexura::mbs
