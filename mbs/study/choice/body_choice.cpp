// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/body_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {

using terminal::number;

mbs::BodyModel BodyChoice::model() const {
  if (exact) return {.fidelity = "beam", .elements = elements};
  mbs::BodyModel out{.modes = mbs::BodyModel::kAllModes, .responses = !candidate.plain};
  if (rigid) {
    out.fidelity = "rigid";
  } else if (candidate.modes == 0 && !stiffened) {
    out.fidelity = "static";
  } else {
    out.fidelity = stiffened ? "modal-stiffened" : "modal";
    // With stiffening one eigenmode at least: response modes alone are quasi-static.
    if (!candidate.all) out.modes = std::max(candidate.modes, 1);
    if (candidate.held) out.boundary = "joint";
  }
  return out;
}

std::string BodyChoice::what(const std::string& body) const {
  if (exact)
    return fmt::format("{}: beam{}", body, elements > 0 ? fmt::format(", {} elements", elements) : "");
  if (rigid) return body + ": rigid";
  if (candidate.modes == 0 && !stiffened)
    return fmt::format("{}: static, {} response modes", body, candidate.responses);
  const char* const fidelity = stiffened ? "modal-stiffened" : "modal";
  if (candidate.all) return fmt::format("{}: {}, all {} modes", body, fidelity, available);
  return fmt::format("{}: {}, {} of {} modes{}", body, fidelity, std::max(candidate.modes, 1), available,
                     candidate.held ? ", held as its joint holds it" : "");
}

std::string BodyChoice::text(const std::string& body) const {
  return what(body) + ": " + reason;
}

void BodyChoice::refine() {
  if (!can_be_refined()) return;
  if (rigid) {
    rigid = false;
    candidate.modes = 1;
    return;
  }
  // What the modes cost the screening has told; what stiffening does to a phase it has not.
  if (stiffening_counts && !stiffened) {
    stiffened = true;
    return;
  }
  // A screening that was wrong once is not asked how much more would do.
  constexpr int kMore = 4, kLeast = 8;
  candidate.modes = std::max(kLeast, kMore * candidate.modes);
  if (2 * (candidate.modes + candidate.responses) >= available) {
    candidate.all = true;
    candidate.held = false;
    candidate.modes = available;
  }
}

void BodyChoice::make_exact(const std::string& why) {
  rigid = stiffened = stiffening_counts = false;
  exact = true;
  candidate = {};
  reason = why;
}

void BodyChoice::explain(const Screened& s, double share) {
  const double first = 2.0 * std::numbers::pi * s.first_hz;
  const Candidate& c = candidate;
  // Of a load that jumps the spectrum has no end.
  reason = fmt::format(
      "rigid, {} would be off by {}; excitation reaches {}", s.output, percent(s.rigid_error),
      s.excitation_hz > s.highest_hz ? "beyond all its modes" : number(s.excitation_hz, 2) + " Hz");
  if (c.all)
    reason += fmt::format("; no smaller number keeps outputs within {}", percent(share));
  else if (c.modes == 0)
    reason += fmt::format(", its first mode has {} Hz: it follows its loads statically (loss {})",
                          number(s.first_hz, 2), percent(c.loss));
  else if (c.plain)
    reason += fmt::format(", modes above {} Hz are not needed, nor response modes (loss {})",
                          number(c.highest_hz, 2), percent(c.loss));
  else
    reason += fmt::format(", modes above {} Hz respond statically, kept as {} response modes (loss {})",
                          number(c.highest_hz, 2), c.responses, percent(c.loss));
  if (s.spin > 0.1 * first)
    reason += fmt::format("; spin {} rad/s is {} of its first frequency", number(s.spin, 2),
                          percent(s.spin / first));
  if (stiffened)
    reason += fmt::format("; spin and loads change its stiffness by {}{}", percent(s.stiffness_change),
                          s.most_negative_change < -0.3
                              ? fmt::format(", {} of what buckles it", percent(-s.most_negative_change))
                              : "");
  else if (!s.has_stiffening_terms && s.spin * s.spin > share * first * first)
    reason +=
        "; its superelement has no stiffening terms (reduce it with stiffening = true to have that judged)";
}

}  // namespace flexura::study
