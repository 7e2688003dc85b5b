// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/time_integral.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace flexura::mbs {

namespace {

struct Rule {
  double integral = 0.0, disagreement = 0.0, size = 0.0;
};

Rule gauss_kronrod(const TimeFunction& f, double a, double b) {
  constexpr std::array<double, 8> x = {0.991455371120812639206854697526, 0.949107912342758524526189684048,
                                       0.864864423359769072789712788641, 0.741531185599394439863864773281,
                                       0.586087235467691130294144691694, 0.405845151377397166906606412077,
                                       0.207784955007898467600689403773, 0.0};
  constexpr std::array<double, 8> w_k = {0.022935322010529224963732008059, 0.063092092629978553290700663189,
                                         0.104790010322250183839876322542, 0.140653259715525918745189590510,
                                         0.169004726639267902826583426599, 0.190350578064785409913256402421,
                                         0.204432940075298892414161999235, 0.209482141084727828012999174892};
  constexpr std::array<double, 4> w_g = {0.129484966168869693270611432679, 0.279705391489276667901467771424,
                                         0.381830050505118944950369775489, 0.417959183673469387755102040816};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  double kronrod = 0.0, gauss = 0.0, size = 0.0;
  for (std::size_t i = 0; i < 8; ++i)
    for (const double sign : {-1.0, 1.0}) {
      if (i == 7 && sign > 0.0) continue;
      const double y = f.at(middle + sign * half * x[i]).jet.value;
      kronrod += w_k[i] * y;
      size += w_k[i] * std::abs(y);
      if (i % 2 == 1) gauss += w_g[i / 2] * y;
    }
  return {half * kronrod, std::abs(half * (kronrod - gauss)), std::abs(half) * size};
}

}  // namespace

// Of a panel that holds no jump and no bend that its points do not see: what the two rules disagree in is soon round-off of
// the function's own terms (1 - cos t near 0), and no reason to go on.
double TimeIntegral::over(double a, double b, int halvings) const {
  const Rule rule = gauss_kronrod(f_, a, b);
  if (halvings == 0 || rule.disagreement <= 1e-14 * rule.size) return rule.integral;
  const double middle = 0.5 * (a + b);
  return over(a, middle, halvings - 1) + over(middle, b, halvings - 1);
}

void TimeIntegral::extend(Side& side, double sign, double until) const {
  constexpr int kMostParts = 1 << 18;  // as KnownTimes
  constexpr double kShortest = 1e-12;  // of the stretch: beside a pole parts never agree
  constexpr double kQuiet = 1e-16;     // of its range times its length
  constexpr int kHalvings = 3;
  struct Part {
    double begin, end, bends;
  };
  const double from = side.reached, span = until - from;
  const auto bounds = [&](double a, double b) { return sign > 0.0 ? f_.over(a, b) : f_.over(-b, -a); };
  const double range = bounds(from, until).value.width();
  const double quiet = std::isfinite(range) ? kQuiet * range * span : 0.0;
  std::vector<Part> parts = {{from, until, 0.0}};
  for (int n = 0; !parts.empty(); ++n) {
    const Part part = parts.back();
    parts.pop_back();
    const double h = part.end - part.begin, middle = 0.5 * (part.begin + part.end);
    const auto halve = [&](double bends) {
      parts.push_back({middle, part.end, bends});
      parts.push_back({part.begin, middle, bends});
    };
    if (n == kMostParts)
      throw std::runtime_error(
          fmt::format("{} cannot be integrated beyond t = {:.9g} s: it jumps or bends more often there than "
                      "parts can be made; "
                      "correct the formula, or give the drive as a position or a speed",
                      f_.where(), sign * part.begin));
    const TimeFunction::Bounds f = bounds(part.begin, part.end);
    const bool can_halve = h > 4.0 * std::numeric_limits<double>::epsilon() * part.end && middle > part.begin;
    if (!f.is_decided && can_halve) {
      halve(part.bends);
      continue;
    }
    if (f.is_decided && !(h * f.value.width() <= quiet) && h > kShortest * span) {
      double bends = 0.0;
      for (int i = 0; i <= 4; ++i)
        bends = std::max(bends, std::abs(f_.at(sign * (part.begin + 0.25 * i * h)).jet.second));
      if (!(f.second.width() <= 1.5 * std::max(bends, part.bends))) {
        halve(bends);
        continue;
      }
    }
    side.panels.push_back({part.end, side.total});
    side.total += over(sign * part.begin, sign * part.end, f.is_decided ? kHalvings : 0);
    side.reached = part.end;
  }
}

double TimeIntegral::operator()(double t) const {
  if (t == 0.0) return 0.0;
  const std::lock_guard lock(guard_);
  const double sign = t > 0.0 ? 1.0 : -1.0, at = std::abs(t);
  Side& side = t > 0.0 ? forward_ : backward_;
  // Stretches of doubling length: few of them, and never far beyond what is asked.
  if (at > side.reached) extend(side, sign, std::max(at, 1.25 * side.reached));
  const auto panel = std::lower_bound(side.panels.begin(), side.panels.end(), at,
                                      [](const Panel& p, double x) { return p.end < x; });
  const double begin = panel == side.panels.begin() ? 0.0 : std::prev(panel)->end;
  return panel->before + over(sign * begin, t, 0);
}

}  // namespace flexura::mbs
