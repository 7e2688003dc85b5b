// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/peak_watch.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {
namespace {

// Between its points a function may be so much of their range beside the cubic through them.
constexpr double kOfRange = 0.5;
// What is smaller beside the largest value in the step, and so far, is no peak.
constexpr double kNothing = 1e-6;
// States so near each other are the same: far below kNothing.
constexpr double kSame = 1e-9;
// Parts looked at for one function in one step; where more are wanted bounds are too wide to say anything.
constexpr int kMostParts = 400;
// The place at which a peak begins, in parts of the step.
constexpr double kFinest = 1e-9;

using Cubic = std::array<double, 4>;

// Through values at 0, 1/3, 2/3, 1.
Cubic through(double a, double b, double c, double d) {
  return {a, -5.5 * a + 9.0 * b - 4.5 * c + d, 9.0 * a - 22.5 * b + 18.0 * c - 4.5 * d,
          -4.5 * a + 13.5 * b - 13.5 * c + 4.5 * d};
}

// Over [m - w, m + w], about its middle.
IntervalJet over(const Cubic& c, double m, double w) {
  const double f = c[0] + m * (c[1] + m * (c[2] + m * c[3])),
               first = c[1] + m * (2.0 * c[2] + m * 3.0 * c[3]), second = 2.0 * c[2] + 6.0 * m * c[3],
               third = 6.0 * c[3];
  const double bend = w * std::abs(third), slope = w * (std::abs(second) + 0.5 * bend),
               rise = w * (std::abs(first) + 0.5 * w * (std::abs(second) + bend / 3.0));
  return {{f - rise, f + rise}, {first - slope, first + slope}, {second - bend, second + bend}};
}

}  // namespace

PeakWatch::PeakWatch(const Equations& eq)
    : eq_(eq),
      functions_(eq.functions_of_motion()),
      scratch_(functions_.empty() ? nullptr : eq.make_scratch()),
      largest_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(functions_.size()))) {
  for (const auto& f : functions_) reads_.insert(reads_.end(), f->reads().begin(), f->reads().end());
  std::ranges::sort(reads_);
  reads_.erase(std::unique(reads_.begin(), reads_.end()), reads_.end());
  if (reads_.empty()) return;
  place_.setZero(reads_.back() + 1);
  paths_.resize(static_cast<std::size_t>(reads_.back()) + 1);
  jets_.resize(paths_.size());
}

IntervalJet PeakWatch::over_part(const MotionFunction& f, double begin, double end) {
  const double m = 0.5 * (begin + end), w = 0.5 * (end - begin);
  for (const int place : f.reads())
    jets_[static_cast<std::size_t>(place)] = over(paths_[static_cast<std::size_t>(place)], m, w);
  return f.over(jets_.data());
}

double PeakWatch::at(const MotionFunction& f, double place) {
  for (const int k : f.reads()) place_(k) = over(paths_[static_cast<std::size_t>(k)], place, 0.0).value.lo;
  return f.at(place_.data());
}

std::optional<double> PeakWatch::first_peak(const MotionFunction& f, double& largest_so_far) {
  std::array<double, 4> seen;
  for (int i = 0; i < 4; ++i) {
    // By the cubics as between the nodes: at the foot of a bump, where a switch ends steps, f is the round-off of its arguments.
    const double value = at(f, i / 3.0);
    if (!std::isfinite(value)) return std::nullopt;
    seen[static_cast<std::size_t>(i)] = value;
  }
  const auto [low, high] = std::ranges::minmax(seen);
  largest_so_far = std::max({largest_so_far, std::abs(low), std::abs(high)});
  const Cubic P = through(seen[0], seen[1], seen[2], seen[3]);
  const IntervalJet whole = over_part(f, 0.0, 1.0);
  const double largest =
      whole.value.is_finite() ? whole.value.magnitude() : std::max(std::abs(low), std::abs(high));
  const double room = kOfRange * (high - low) + kNothing * std::max(largest, largest_so_far);
  // The earliest parts last.
  struct Part {
    double begin, end;
  };
  std::vector<Part> parts = {{0.0, 1.0}};
  for (int n = 0; !parts.empty() && n < kMostParts; ++n) {
    const Part part = parts.back();
    parts.pop_back();
    const double m = 0.5 * (part.begin + part.end), w = 0.5 * (part.end - part.begin);
    const IntervalJet bounds = n == 0 ? whole : over_part(f, part.begin, part.end), expected = over(P, m, w);
    Interval off = bounds.value - expected.value;
    if (off.lo >= -room && off.hi <= room) continue;
    const double here = at(f, m) - over(P, m, 0.0).value.lo;
    const Interval rate = bounds.first - expected.first;
    if (rate.is_finite() && std::isfinite(here)) {
      const Interval by_slope = Interval(here) + rate * Interval(-w, w);
      if (by_slope.lo >= -room && by_slope.hi <= room) continue;
    }
    if (2.0 * w > kFinest) {
      parts.push_back({m, part.end});
      parts.push_back({part.begin, m});
    } else if (std::isfinite(here) && std::abs(here) > room) {
      return part.begin;
    }
  }
  return std::nullopt;
}

bool PeakWatch::is_end_of_last_step(const State& s) const {
  const auto same = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return a.size() == b.size() && a.isApprox(b, kSame);
  };
  return nodes_.back().size() > 0 && s.t == end_.t && s.root == end_.root && same(s.p, end_.p) &&
         same(s.v, end_.v) && same(s.c, end_.c) && same(s.lambda, end_.lambda) && same(s.a, end_.a);
}

std::optional<double> PeakWatch::look(double t_begin, double t_end, const StateAt& state_at) {
  for (int i = 0; i < 4; ++i) {
    state_at(t_begin + (t_end - t_begin) * i / 3.0, state_);
    // Where the step before ended this one begins, but for an event.
    if (i == 0 && is_end_of_last_step(state_))
      std::swap(nodes_.front(), nodes_.back());
    else
      eq_.arguments_of_motion(state_, *scratch_, nodes_[static_cast<std::size_t>(i)]);
  }
  for (const int k : reads_)
    paths_[static_cast<std::size_t>(k)] = through(nodes_[0](k), nodes_[1](k), nodes_[2](k), nodes_[3](k));
  std::swap(end_, state_);
  std::optional<double> first;
  for (std::size_t i = 0; i < functions_.size(); ++i) {
    const auto peak = first_peak(*functions_[i], largest_(static_cast<Eigen::Index>(i)));
    if (peak && (!first || *peak < *first)) first = peak;
  }
  return first;
}

void PeakWatch::remember(History& history) {
  const Eigen::Index n = largest_.size();
  history(largest_);
  require_size(largest_.size(), n);
}

}  // namespace flexura::mbs
