// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/guided_run.hpp"

#include <algorithm>
#include <stdexcept>

#include "mbs/solver/run/runner.hpp"

namespace flexura::mbs {

namespace {

// Of the largest of them: what is left of the solution of the same equations by the same steps is far less, and what is
// less changes nothing that a tolerance sees.
bool is_same(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  constexpr double kSame = 1e-12;
  if (x.size() != y.size() || x.size() == 0) return x.size() == y.size();
  return (x - y).lpNorm<Eigen::Infinity>() <=
         kSame * std::max(x.lpNorm<Eigen::Infinity>(), y.lpNorm<Eigen::Infinity>());
}

const RunCallbacks kNoCallbacks;

}  // namespace

void Runner::see(Sight& sight) {
  see_levels(sight);
  if (!keeps_book_) return;
  State s = result_.state;
  accelerations_.solve(s, sight.v_dot);
  sight.c_rate = accelerations_.c_rate();
}

bool Runner::differs(const Sight& now) const {
  return !is_same(seen_.roots, now.roots) || !is_same(seen_.g, now.g) || !is_same(seen_.v_dot, now.v_dot) ||
         !is_same(seen_.c_rate, now.c_rate);
}

void Runner::take_changes() {
  if (inputs_.size() > 0 && inputs_ != result_.state.u) {
    result_.state.u = inputs_;
    is_to_begin_anew_ = true;
  }
  Sight now;
  see(now);
  if (!is_to_begin_anew_ && !differs(now)) return;
  is_to_begin_anew_ = false;
  if (!keeps_book_) return start_integrator();  // equilibria, each for itself
  pass_jump(seen_, "a filter between what is set and the drive");
}

bool Runner::go_to(double t) {
  if (!result_.stopped_because.empty()) return false;
  goal_ = t;
  try {
    stop_where_thrown([&] {
      if (!is_open_)
        open();
      else
        take_changes();
      is_open_ = true;
      while (is_on_its_way() && step_once()) {
      }
      books_.drain();
      if (keeps_book_) books_.close(result_.state);
      see(seen_);
    });
  } catch (const std::runtime_error& e) {
    result_.stopped_because = e.what();
  }
  return result_.stopped_because.empty();
}

Instant Runner::shown() {
  Instant now{result_.state, result_.v_dot};
  if (keeps_book_) books_.close_row(now);
  books_.show(now.state, now.v_dot);
  return now;
}

GuidedRun::GuidedRun(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot,
                     const SolverOptions& options)
    : runner_(std::make_unique<Runner>(eq, start, v_dot, options, kNoCallbacks)), now_{start, v_dot} {}

GuidedRun::~GuidedRun() = default;

bool GuidedRun::go_to(double t) {
  const double begin = now_.state.t;
  const bool goes_on = runner_->go_to(t);
  if (!goes_on && runner_->time() == begin) return false;
  try {
    now_ = runner_->shown();
    energy_ = runner_->account(now_);
  } catch (const std::runtime_error&) {
    if (goes_on) throw;  // else the reason why the run has stopped is told
  }
  return goes_on;
}

void GuidedRun::set_inputs(const Eigen::VectorXd& u) {
  runner_->set_inputs(u);
}

void GuidedRun::begin_anew() {
  runner_->begin_anew();
}

const std::vector<std::string>& GuidedRun::method_changes() const {
  return runner_->method_changes();
}

const std::string& GuidedRun::stopped_because() const {
  return runner_->stopped_because();
}

}  // namespace flexura::mbs
