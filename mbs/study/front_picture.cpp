// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/front_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/base/terminal/terminal.hpp"

namespace flexura::study {
namespace {

constexpr double kLeft = 78, kRight = 700, kTop = 46, kBottom = 400, kWidth = 860, kHeight = 455;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

struct LogAxis {
  double low, high, at_low, at_high;
  double operator()(double value) const {
    return at_low + (at_high - at_low) * (std::log10(value) - low) / (high - low);
  }
};

LogAxis axis_of(double least, double most, double at_low, double at_high) {
  const double low = std::log10(least), high = std::log10(most);
  const double room = std::max(0.06 * (high - low), 0.1);
  return {low - room, high + room, at_low, at_high};
}

// Powers of ten, with 2 and 5 between where they are few.
std::vector<double> ticks(const LogAxis& axis) {
  std::vector<double> out;
  const bool few = axis.high - axis.low < 2.5;
  for (int k = static_cast<int>(std::floor(axis.low)); k <= static_cast<int>(std::ceil(axis.high)); ++k)
    for (const double m : {1.0, 2.0, 5.0}) {
      const double value = m * std::pow(10.0, k);
      if ((m == 1.0 || few) && std::log10(value) >= axis.low && std::log10(value) <= axis.high)
        out.push_back(value);
    }
  return out;
}

}  // namespace

std::string front_picture(const FrontPicture& picture) {
  const double uncertainty = picture.uncertainty;
  std::vector<PicturePoint> points;
  for (const PicturePoint& p : picture.points)
    if (p.cost > 0.0 && p.error > 0.0 && std::isfinite(p.error)) points.push_back(p);
  std::ranges::sort(points, {}, &PicturePoint::cost);
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n"
      "<text x=\"{2}\" y=\"24\" font-size=\"15\" font-weight=\"bold\" fill=\"#1c2733\">{3}</text>\n",
      kWidth, kHeight, kLeft, escaped(picture.title));
  if (points.empty())
    return svg + "<text x=\"78\" y=\"60\">no choice has an error above zero</text>\n</svg>\n";
  double least = points.front().error, most = least;
  for (const PicturePoint& p : points) {
    least = std::min(least, p.error);
    most = std::max(most, p.error);
  }
  const LogAxis x = axis_of(points.front().cost, points.back().cost, kLeft, kRight);
  const LogAxis y = axis_of(least, most, kBottom, kTop);
  if (uncertainty > 0.0 && std::log10(uncertainty) > y.low) {
    const double top = std::max(kTop, y(uncertainty));
    svg += fmt::format(
        "<rect x=\"{0}\" y=\"{1:.1f}\" width=\"{2}\" height=\"{3:.1f}\" fill=\"#e8ebee\"/>\n<text x=\"{4}\" "
        "y=\"{5:.1f}\" fill=\"#5b6773\" font-size=\"11\">below the reference's own uncertainty</text>\n",
        kLeft, top, kRight - kLeft, kBottom - top, kLeft + 6, std::min(kBottom - 6, top + 14));
  }
  for (const double value : ticks(x))
    svg += fmt::format(
        "<line x1=\"{0:.1f}\" y1=\"{1}\" x2=\"{0:.1f}\" y2=\"{2}\" stroke=\"#d5dbe1\"/>\n<text x=\"{0:.1f}\" "
        "y=\"{3}\" text-anchor=\"middle\" fill=\"#35424e\">{4} s</text>\n",
        x(value), kTop, kBottom, kBottom + 18, terminal::number(value, 3));
  for (const double value : ticks(y))
    svg += fmt::format(
        "<line x1=\"{0}\" y1=\"{1:.1f}\" x2=\"{2}\" y2=\"{1:.1f}\" stroke=\"#d5dbe1\"/>\n<text x=\"{3}\" "
        "y=\"{4:.1f}\" text-anchor=\"end\" fill=\"#35424e\">{5} %</text>\n",
        kLeft, y(value), kRight, kLeft - 6, y(value) + 4, terminal::number(100.0 * value, 3));
  svg += fmt::format(
      "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#8a96a1\"/>\n<text x=\"{}\" "
      "y=\"{}\" text-anchor=\"middle\" fill=\"#35424e\">{}</text>\n",
      kLeft, kTop, kRight - kLeft, kBottom - kTop, 0.5 * (kLeft + kRight), kBottom + 40,
      escaped(picture.cost_name));
  std::string line;
  for (const PicturePoint& p : points)
    if (p.on_front) line += fmt::format("{:.1f},{:.1f} ", x(p.cost), y(p.error));
  svg +=
      fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"#b3541e\" stroke-width=\"1.5\"/>\n", line);
  double last_label = -1e9;
  for (const PicturePoint& p : points) {
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\" fill=\"{}\"><title>{}: {} s, {} %</title></circle>\n",
        x(p.cost), y(p.error), p.on_front ? 4.5 : 3.2, p.on_front ? "#b3541e" : "#8fa3b5", escaped(p.label),
        terminal::number(p.cost, 3), terminal::number(100.0 * p.error, 3));
    if (!p.on_front) continue;
    // The front falls to the right, so names to the upper right stay clear of it; too close ones give way.
    const double at = y(p.error) - 6;
    if (std::abs(at - last_label) < 13) continue;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"#7a3510\">{}</text>\n", x(p.cost) + 7, at,
                       escaped(p.label));
    last_label = at;
  }
  return svg + "</svg>\n";
}

}  // namespace flexura::study
