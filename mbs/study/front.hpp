// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

/// The trade: of many measured choices those that nothing beats.
namespace flexura::study {

struct TradePoint {
  double cost = 0.0;   ///< wall time [s]
  double error = 0.0;  ///< relative; infinite or NaN where the choice did not run through
};

/// True for each point that no other beats: none is at most as costly and at most as wrong and better in one
/// of the two.
std::vector<bool> pareto_front(const std::vector<TradePoint>& points);

/// The cheapest point whose error is at most `accuracy`.
std::optional<std::size_t> cheapest_within(const std::vector<TradePoint>& points, double accuracy);

/// The most accurate point whose cost is at most `time`.
std::optional<std::size_t> most_accurate_within(const std::vector<TradePoint>& points, double time);

}  // namespace flexura::study
