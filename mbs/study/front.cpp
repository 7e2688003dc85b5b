// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/front.hpp"

#include <cmath>

namespace flexura::study {
namespace {

bool beats(const TradePoint& a, const TradePoint& b) {
  return a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error);
}

bool ran(const TradePoint& p) {
  return std::isfinite(p.error) && std::isfinite(p.cost);
}

}  // namespace

std::vector<bool> pareto_front(const std::vector<TradePoint>& points) {
  std::vector<bool> front(points.size(), false);
  for (std::size_t i = 0; i < points.size(); ++i) {
    front[i] = ran(points[i]);
    for (std::size_t j = 0; front[i] && j < points.size(); ++j)
      if (ran(points[j]) && beats(points[j], points[i])) front[i] = false;
  }
  return front;
}

std::optional<std::size_t> cheapest_within(const std::vector<TradePoint>& points, double accuracy) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (ran(points[i]) && points[i].error <= accuracy && (!best || points[i].cost < points[*best].cost))
      best = i;
  return best;
}

std::optional<std::size_t> most_accurate_within(const std::vector<TradePoint>& points, double time) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (ran(points[i]) && points[i].cost <= time && (!best || points[i].error < points[*best].error))
      best = i;
  return best;
}

}  // namespace flexura::study
