// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/view/reports/report.hpp"

namespace flexura::view {

/// Round numbers inside [low, high] for an axis: steps of 1, 2 or 5 times a power of ten, at least 3 and at
/// most `most` of them; on a logarithmic axis powers of ten (with 2 and 5 between them when there are fewer
/// than three).  low < high.
std::vector<double> axis_ticks(double low, double high, bool logarithmic, int most = 7);

/// The plot as an SVG element that takes its colours from the page: curve i has the class "c0" ... "c5" and
/// its own dash, so it is known without its colour.  Its frame, in user units, and the ranges of its axes
/// stand in data attributes for the page's script.  A curve of more points than the picture has columns is
/// drawn by the least and greatest value of each column.
std::string svg_plot(const ReportPlot& plot);

/// A small drawing of curve i's line and mark for the legend.
std::string svg_key(const ReportCurve& curve, std::size_t number);

}  // namespace flexura::view
