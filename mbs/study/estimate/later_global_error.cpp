// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/later_global_error.hpp"

#include <utility>

namespace flexura::study {
namespace {

using Eigen::VectorXd;

double bytes_of(const mbs::State& s, const VectorXd& v_dot) {
  return 8.0 * static_cast<double>(s.p.size() + s.v.size() + s.c.size() + s.a.size() + s.lambda.size() +
                                   v_dot.size()) +
         static_cast<double>(sizeof(mbs::Instant));
}

}  // namespace

LaterGlobalError::LaterGlobalError(std::unique_ptr<GlobalError> tells, double most_memory)
    : tells_(std::move(tells)), most_memory_(most_memory) {}

std::unique_ptr<LaterGlobalError> LaterGlobalError::make(const mbs::PreparedMechanism& run,
                                                         double most_memory) {
  auto tells = GlobalError::make(run);
  if (!tells) return nullptr;
  return std::unique_ptr<LaterGlobalError>(new LaterGlobalError(std::move(tells), most_memory));
}

void LaterGlobalError::watch(mbs::RunCallbacks& callbacks) {
  callbacks.restart = [this](const mbs::State& s, const VectorXd& v_dot, const mbs::IntegratorKind& kind) {
    happens([s, v_dot, kind](GlobalError& e) { e.restart(s, v_dot, kind); }, bytes_of(s, v_dot));
  };
  callbacks.step = [this](const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes) {
    happens([begin, nodes](GlobalError& e) { e.step(begin, nodes); },
            4.0 * bytes_of(begin.state, begin.v_dot));
  };
  callbacks.row = [this, then = callbacks.row](const mbs::State& s, const VectorXd& v_dot,
                                               const mbs::EnergyAccount& energy) {
    happens([s, v_dot](GlobalError& e) { e.row(s, v_dot); }, bytes_of(s, v_dot));
    if (then) then(s, v_dot, energy);
  };
}

// What no longer fits is told at once from there on.
void LaterGlobalError::happens(Happening what, double bytes) {
  waiting_.push_back(std::move(what));
  memory_ += bytes;
  if (memory_ > most_memory_) tell();
}

void LaterGlobalError::tell() {
  for (const Happening& what : waiting_) what(*tells_);
  waiting_.clear();
}

IntegratorEstimate LaterGlobalError::estimate() {
  tell();
  return tells_->estimate();
}

}  // namespace flexura::study
