// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/reports/svg_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/view/html/html.hpp"

namespace flexura::view {

namespace {

// Of the picture and of the frame inside it, user units.
constexpr double width = 760.0, height = 330.0;
constexpr double left = 78.0, right = 746.0, top = 12.0, bottom = 282.0;

/// From values to the picture.
class Scale {
 public:
  Scale(double low, double high, bool logarithmic, double from, double to)
      : low_(low), high_(high), logarithmic_(logarithmic), from_(from), to_(to) {}

  bool takes(double value) const { return std::isfinite(value) && (!logarithmic_ || value > 0.0); }
  double operator()(double value) const {
    const auto map = [&](double x) { return logarithmic_ ? std::log10(x) : x; };
    return from_ + (map(value) - map(low_)) / (map(high_) - map(low_)) * (to_ - from_);
  }
  double low() const { return low_; }
  double high() const { return high_; }

 private:
  double low_, high_;
  bool logarithmic_;
  double from_, to_;
};

/// The range of an axis over all curves, a little wider than the values.
Scale make_scale(const ReportPlot& plot, bool is_x, double from, double to) {
  const bool logarithmic = (is_x ? plot.x : plot.y).logarithmic;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const ReportCurve& curve : plot.curves) {
    for (const double value : is_x ? curve.x : curve.y) {
      if (!std::isfinite(value) || (logarithmic && value <= 0.0)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (!(low <= high)) low = logarithmic ? 0.1 : 0.0, high = 1.0;
  if (logarithmic) {
    const double room = std::max(1.1, std::pow(high / low, is_x ? 0.03 : 0.06));
    return {low / room, high * room, true, from, to};
  }
  // A constant gets a range of its own size around it, so that round-off does not fill the picture.
  const double size = std::max(std::abs(low), std::abs(high));
  if (high - low < 1e-9 * size || high == low) {
    const double half = size > 0.0 ? 0.5 * size : 0.5;
    return {low - half, high + half, false, from, to};
  }
  const bool points = std::any_of(plot.curves.begin(), plot.curves.end(),
                                  [](const ReportCurve& c) { return c.style != CurveStyle::line; });
  const double room = (high - low) * (is_x ? (points ? 0.03 : 0.0) : 0.06);
  return {low - room, high + room, false, from, to};
}

std::string tick_text(double value, double step) {
  // Digits down to the step: 0.98, 1.00, 1.02.
  const int digits = value == 0.0 ? 1
                                  : 1 + static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9) -
                                                         std::floor(std::log10(step) + 1e-9));
  return figure_text(value, std::max(1, digits));
}

void draw_axis(std::string& svg, const ReportAxis& axis, const Scale& scale, bool is_x) {
  const std::vector<double> ticks = axis_ticks(scale.low(), scale.high(), axis.logarithmic);
  // A logarithmic axis of less than a factor of two has even steps as well.
  bool is_even = ticks.size() >= 2;
  for (std::size_t i = 2; i < ticks.size(); ++i)
    is_even =
        is_even && std::abs(ticks[i] - 2.0 * ticks[i - 1] + ticks[i - 2]) < 1e-6 * (ticks[1] - ticks[0]);
  for (const double tick : ticks) {
    const double at = scale(tick);
    const double step = is_even ? ticks[1] - ticks[0] : std::abs(tick);
    if (is_x) {
      svg += fmt::format(
          "<path class=\"grid\" d=\"M{0:.1f} {1}V{2}\"/><text x=\"{0:.1f}\" y=\"{3}\" "
          "class=\"tick x\">{4}</text>",
          at, top, bottom, bottom + 17, tick_text(tick, step));
    } else {
      svg += fmt::format(
          "<path class=\"grid\" d=\"M{1} {0:.1f}H{2}\"/><text x=\"{3}\" y=\"{4:.1f}\" "
          "class=\"tick y\">{5}</text>",
          at, left, right, left - 8, at + 4, tick_text(tick, step));
    }
  }
  const std::string unit = axis.unit.empty() ? "" : fmt::format(" [{}]", unit_text(axis.unit));
  if (is_x) {
    svg += fmt::format("<text x=\"{}\" y=\"{}\" class=\"axis x\">{}{}</text>", (left + right) / 2, height - 8,
                       escape_html(axis.name), unit);
  } else {
    svg += fmt::format("<text transform=\"translate(15 {}) rotate(-90)\" class=\"axis x\">{}{}</text>",
                       (top + bottom) / 2, escape_html(axis.name), unit);
  }
}

/// The places of a line's points, thinned to the least and greatest of each column where there are too many.
std::vector<std::size_t> drawn_points(const ReportCurve& curve, const Scale& x) {
  std::vector<std::size_t> places;
  constexpr std::size_t most = 4 * static_cast<std::size_t>(right - left);
  if (curve.x.size() <= most) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) places.push_back(i);
    return places;
  }
  for (std::size_t i = 0; i < curve.x.size();) {
    const auto column = [&](std::size_t k) {
      return x.takes(curve.x[k]) ? std::floor(2 * x(curve.x[k])) : -1.0;
    };
    std::size_t end = i, least = i, greatest = i;
    for (; end < curve.x.size() && column(end) == column(i); ++end) {
      if (curve.y[end] < curve.y[least]) least = end;
      if (curve.y[end] > curve.y[greatest]) greatest = end;
    }
    places.push_back(i);
    const auto [first, second] = std::minmax({least, greatest});
    if (first > i) places.push_back(first);
    if (second > first) places.push_back(second);
    if (end - 1 > second) places.push_back(end - 1);
    i = end;
  }
  return places;
}

/// Labels beside their points: none over another or over a mark, and off the curves where there is room;
/// where there is none the point's title has to do.
class Labels {
 public:
  void add_mark(double px, double py) { marks_.push_back({px - 4, py - 4, 8, 8}); }
  void add_segment(double x1, double y1, double x2, double y2) { segments_.push_back({x1, y1, x2, y2}); }
  void add_label(const std::string& text, double px, double py) { wanted_.push_back({text, px, py}); }

  /// Once all marks and curves are known, so that labels lie on top of them.
  void draw(std::string& svg) {
    for (const Wanted& label : wanted_) {
      if (!place(svg, label, true)) place(svg, label, false);
    }
  }

 private:
  struct Box {
    double x, y, w, h;
  };
  struct Segment {
    double x1, y1, x2, y2;
  };
  struct Wanted {
    std::string text;
    double x, y;
  };

  bool place(std::string& svg, const Wanted& label, bool off_curves) {
    // Letters of this size are 6.1 wide on the average, with some room 6.5; 13 is their height without the
    // room between lines.
    const double w = 6.5 * static_cast<double>(label.text.size()), h = 13.0;
    // At the right edge the left of the point comes first.
    const bool turned = label.x > right - 130;
    for (const double below : {-6.0, 16.0}) {
      for (const bool to_left : {turned, !turned}) {
        const double at = to_left ? label.x - 8 : label.x + 8;
        const Box box{to_left ? at - w : at, label.y + below - 11, w, h};
        if (box.x < left || box.x + w > width || box.y < 0.0 || box.y + h > bottom) continue;
        if (hits(placed_, box) || hits(marks_, box) || (off_curves && crossed(box))) continue;
        placed_.push_back(box);
        svg += fmt::format("<text class=\"label\" x=\"{:.1f}\" y=\"{:.1f}\"{}>{}</text>", at, label.y + below,
                           to_left ? " text-anchor=\"end\"" : "", escape_html(label.text));
        return true;
      }
    }
    return false;
  }

  static bool hits(const std::vector<Box>& boxes, const Box& a) {
    return std::any_of(boxes.begin(), boxes.end(), [&](const Box& b) {
      return a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;
    });
  }
  /// Liang and Barsky: the part of a segment inside the box, as a range of its parameter, is not empty.
  bool crossed(const Box& box) const {
    return std::any_of(segments_.begin(), segments_.end(), [&](const Segment& s) {
      double from = 0.0, to = 1.0;
      const auto clip = [&](double start, double change, double low, double high) {
        if (change == 0.0) return low < start && start < high;
        const auto [first, last] = std::minmax({(low - start) / change, (high - start) / change});
        from = std::max(from, first);
        to = std::min(to, last);
        return from < to;
      };
      return clip(s.x1, s.x2 - s.x1, box.x, box.x + box.w) && clip(s.y1, s.y2 - s.y1, box.y, box.y + box.h);
    });
  }

  std::vector<Box> marks_, placed_;
  std::vector<Segment> segments_;
  std::vector<Wanted> wanted_;
};

/// Four marks, so that curves are told apart without colour; `inside` stands between the tags.
std::string mark_svg(std::size_t number, double px, double py, const std::string& inside) {
  const char* const tags[] = {"circle", "rect", "path", "path"};
  std::string shape;
  switch (number % 4) {
    case 0:
      shape = fmt::format("cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\"", px, py);
      break;
    case 1:
      shape = fmt::format("x=\"{:.1f}\" y=\"{:.1f}\" width=\"7\" height=\"7\"", px - 3.5, py - 3.5);
      break;
    case 2:
      shape = fmt::format("d=\"M{:.1f} {:.1f}l4.5 8h-9z\"", px, py - 5);
      break;
    default:
      shape = fmt::format("d=\"M{:.1f} {:.1f}l5 5l-5 5l-5-5z\"", px, py - 5);
  }
  return fmt::format("<{0} {1} class=\"mark c{2}\">{3}</{0}>", tags[number % 4], shape, number % 6, inside);
}

void draw_curve(std::string& svg, const ReportCurve& curve, std::size_t number, const Scale& x,
                const Scale& y, Labels& labels) {
  const auto visible = [&](std::size_t i) { return x.takes(curve.x[i]) && y.takes(curve.y[i]); };
  if (curve.style != CurveStyle::points) {
    std::string path;
    bool pen_down = false;
    double before_x = 0.0, before_y = 0.0;
    for (const std::size_t i : drawn_points(curve, x)) {
      if (!visible(i)) {
        pen_down = false;
        continue;
      }
      const double px = x(curve.x[i]), py = y(curve.y[i]);
      path += fmt::format("{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', px, py);
      if (pen_down) labels.add_segment(before_x, before_y, px, py);
      before_x = px, before_y = py;
      pen_down = true;
    }
    svg += fmt::format("<path class=\"curve c{} d{}\" d=\"{}\"/>", number % 6, number % 4, path);
  }
  if (curve.style == CurveStyle::line) return;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!visible(i)) continue;
    const double px = x(curve.x[i]), py = y(curve.y[i]);
    std::string name =
        fmt::format("{}: {}, {}", curve.name, figure_text(curve.x[i], 4), figure_text(curve.y[i], 4));
    if (i < curve.labels.size()) name = curve.labels[i] + " · " + name;
    svg += mark_svg(number, px, py, fmt::format("<title>{}</title>", escape_html(name)));
    labels.add_mark(px, py);
    if (i < curve.labels.size() && !curve.labels[i].empty() && curve.x.size() <= 14)
      labels.add_label(curve.labels[i], px, py);
  }
}

/// What a screen reader says for the picture.
std::string spoken(const ReportPlot& plot, const Scale& x, const Scale& y) {
  std::string names;
  for (const ReportCurve& curve : plot.curves) names += (names.empty() ? "" : ", ") + curve.name;
  return fmt::format("{}: {} over {}; curves {}; {} from {} to {}, {} from {} to {}", plot.title, plot.y.name,
                     plot.x.name, names, plot.x.name, figure_text(x.low(), 3), figure_text(x.high(), 3),
                     plot.y.name, figure_text(y.low(), 3), figure_text(y.high(), 3));
}

}  // namespace

std::vector<double> axis_ticks(double low, double high, bool logarithmic, int most) {
  std::vector<double> ticks;
  if (logarithmic) {
    const int first = static_cast<int>(std::ceil(std::log10(low) - 1e-9));
    const int last = static_cast<int>(std::floor(std::log10(high) + 1e-9));
    const int every = std::max(1, (last - first) / most + 1);
    for (int e = first; e <= last; e += every) ticks.push_back(std::pow(10.0, e));
    if (ticks.size() >= 3) return ticks;
    ticks.clear();
    for (int e = first - 1; e <= last; ++e) {
      for (const double m : {1.0, 2.0, 5.0}) {
        const double tick = m * std::pow(10.0, e);
        if (tick >= low && tick <= high) ticks.push_back(tick);
      }
    }
    if (ticks.size() >= 2) return ticks;
    ticks.clear();  // less than a factor of two: even steps are as good
  }
  const double rough = (high - low) / most;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double m : {5.0, 2.0, 1.0}) {
    if (m * power >= rough) step = m * power;
  }
  const double first = std::ceil(low / step - 1e-9);
  for (double k = first; k * step <= high + 1e-9 * step; ++k) ticks.push_back(k * step);
  return ticks;
}

std::string svg_plot(const ReportPlot& plot) {
  const Scale x = make_scale(plot, true, left, right), y = make_scale(plot, false, bottom, top);
  std::string svg = fmt::format(
      "<svg class=\"report-plot\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" data-frame=\"{} {} {} "
      "{}\" data-x=\"{} {} {}\" data-y=\"{} {} {}\">",
      width, height, escape_html(spoken(plot, x, y)), left, top, right, bottom, x.low(), x.high(),
      plot.x.logarithmic ? "log" : "linear", y.low(), y.high(), plot.y.logarithmic ? "log" : "linear");
  draw_axis(svg, plot.x, x, true);
  draw_axis(svg, plot.y, y, false);
  svg += fmt::format("<path class=\"frame\" d=\"M{} {}V{}H{}\"/>", left, top, bottom, right);
  Labels labels;
  for (std::size_t i = 0; i < plot.curves.size(); ++i) draw_curve(svg, plot.curves[i], i, x, y, labels);
  labels.draw(svg);
  svg += fmt::format("<path class=\"pointer\" d=\"M0 {}V{}\"/></svg>", top, bottom);
  return svg;
}

std::string svg_key(const ReportCurve& curve, std::size_t number) {
  std::string svg = "<svg viewBox=\"0 0 30 12\" width=\"30\" height=\"12\" aria-hidden=\"true\">";
  if (curve.style != CurveStyle::points)
    svg += fmt::format("<path class=\"curve c{} d{}\" d=\"M1 6H29\"/>", number % 6, number % 4);
  if (curve.style != CurveStyle::line) svg += mark_svg(number, 15, 6, "");
  return svg + "</svg>";
}

}  // namespace flexura::view
