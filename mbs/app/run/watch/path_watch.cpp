// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/watch/path_watch.hpp"

#include <fmt/format.h>

#include <cmath>

namespace flexura::app {

PathWatch::PathWatch(const mbs::Mechanism& mechanism)
    : mechanism_(mechanism), scratch_(mechanism.make_scratch()) {
  for (const auto& constraint : mechanism.description().constraints)
    if (std::isfinite(constraint->path_length())) watched_.push_back(constraint.get());
  if (watched_.empty()) return;
  const std::vector<mbs::OutputInfo> quantities = mechanism.quantities();
  for (const mbs::Constraint* path : watched_)
    for (const char* what : {".place", ".speed"})
      for (std::size_t i = 0; i < quantities.size(); ++i)
        if (quantities[i].name == path->name() + what) which_.push_back(static_cast<int>(i));
  now_.resize(static_cast<Eigen::Index>(which_.size()));
}

void PathWatch::observe(const mbs::State& s, const Eigen::VectorXd& v_dot) {
  if (which_.empty() || !reason_.empty()) return;
  mechanism_.evaluate(which_, s, v_dot, *scratch_, now_);
  for (std::size_t i = 0; i < watched_.size(); ++i) {
    const mbs::Constraint& path = *watched_[i];
    const double length = path.path_length(), slack = 1e-9 * length,
                 place = now_(static_cast<Eigen::Index>(2 * i)),
                 speed = now_(static_cast<Eigen::Index>(2 * i + 1));
    if (place >= -slack && place <= length + slack) continue;
    // It moved evenly since, unless it comes back.
    const double beyond = place < 0.0 ? place : place - length, since = speed != 0.0 ? beyond / speed : 0.0;
    reason_ = fmt::format(
        "constraint \"{}\": its marker passed the {} of the path, which goes from 0 to {:.6g} m, {} t = "
        "{:.6g} s ({:.6g} "
        "m/s): end the run before, make the path longer, or let it go on with ends = \"straight\"",
        path.name(), place < 0.0 ? "begin" : "end", length, since > 0.0 ? "at about" : "before",
        since > 0.0 ? s.t - since : s.t, speed);
    return;
  }
}

}  // namespace flexura::app
