// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/stop_limit.hpp"

#include <fmt/format.h>

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

void StopLimit::count(double t) {
  constexpr long kEnough = 20000;
  if (++n_ != kEnough) return;
  const double rate = static_cast<double>(n_) / (t - since_);
  if (!(rate * (t_end_ - t) > most_)) return;
  throw IntegrationError(
      fmt::format("what is a function of time alone {} {:.2g} times a second ({} times until t = {:.6g} s), "
                  "{:.1g} times until the end, and a "
                  "step can pass none of them: write its mean over such short times, or shorten the run",
                  what_, rate, n_, t, rate * (t_end_ - t)));
}

}  // namespace flexura::mbs
