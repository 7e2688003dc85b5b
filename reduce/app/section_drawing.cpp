// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "reduce/app/section_report.hpp"

namespace flexura::reduce {
namespace {

using Point = Eigen::Vector2d;

/// Lines of SVG on a plane with y to the right and z up.
class Drawing {
 public:
  Drawing(const Point& low, const Point& high, double scale, double margin)
      : low_(low), high_(high), scale_(scale), margin_(margin) {}

  double X(double y) const { return margin_ + scale_ * (y - low_.x()); }
  double Y(double z) const { return margin_ + scale_ * (high_.y() - z); }
  double width() const { return 2 * margin_ + scale_ * (high_.x() - low_.x()); }
  double bottom() const { return 2 * margin_ + scale_ * (high_.y() - low_.y()); }

  template <typename... Values>
  void put(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  void line(const Point& from, const Point& to, const char* style) {
    put("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" {}/>\n", X(from.x()), Y(from.y()),
        X(to.x()), Y(to.y()), style);
  }
  void label(const Point& at, double right, double down, const char* style, const std::string& text) {
    put("<text x=\"{:.2f}\" y=\"{:.2f}\" {}>{}</text>\n", X(at.x()) + right, Y(at.y()) + down, style, text);
  }

  std::string text_;

 private:
  Point low_, high_;
  double scale_, margin_;
};

/// Loops without the points that lie on the line between their neighbours.
void outline(const beam::Section& section, Drawing& drawing) {
  drawing.put("<path class=\"material\" fill-rule=\"evenodd\" d=\"");
  for (const beam::Loop& loop : section.outline) {
    const Eigen::Index n = loop.rows();
    bool first = true;
    for (Eigen::Index k = 0; k < n; ++k) {
      const Point p = loop.row(k).transpose(), before = loop.row((k + n - 1) % n).transpose(),
                  after = loop.row((k + 1) % n).transpose();
      const Point a = p - before, b = after - p;
      if (std::abs(a.x() * b.y() - a.y() * b.x()) < 1e-9 * a.norm() * b.norm() && a.dot(b) > 0.0) continue;
      drawing.put("{}{:.2f} {:.2f} ", first ? "M" : "L", drawing.X(p.x()), drawing.Y(p.y()));
      first = false;
    }
    if (!first) drawing.put("Z ");
  }
  drawing.put("\"/>\n");
}

std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) text += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return text;
}

/// "150" and "89.95", in millimetres.
std::string mm(double length) {
  return fmt::format("{:.4g}", 1e3 * length);
}

}  // namespace

std::string section_svg(const beam::SectionProperties& exact) {
  const beam::SectionProperties s = without_round_off(exact);
  Point low = s.tension_centre, high = low;
  for (const beam::Loop& loop : s.section.outline) {
    low = low.cwiseMin(loop.colwise().minCoeff().transpose());
    high = high.cwiseMax(loop.colwise().maxCoeff().transpose());
  }
  const Point shape_low = low, shape_high = high;
  const double size = (high - low).maxCoeff();
  // The principal axes end a little outside; the frame holds them, every centre and the section's own axes.
  const double reach = 0.62 * size, tick = 0.2 * size;
  const Point phi_1(std::cos(s.principal_angle), std::sin(s.principal_angle)), phi_2(-phi_1.y(), phi_1.x());
  for (const Point& p : {Point(s.tension_centre + reach * phi_1), Point(s.tension_centre - reach * phi_1),
                         Point(s.tension_centre + reach * phi_2), Point(s.tension_centre - reach * phi_2),
                         s.shear_centre, s.mass_centre, Point(0, 0), Point(tick, 0), Point(0, tick)}) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr double margin = 56.0, drawn = 560.0, row = 23.0;
  Drawing d(low, high, drawn / (high - low).maxCoeff(), margin);
  const double width = std::max(d.width(), 560.0), height = d.bottom() + 6.6 * row;
  d.put(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" "
      "role=\"img\" font-family=\"system-ui, 'DejaVu Sans', sans-serif\" font-size=\"14\">\n"
      "<title>Section {2}</title>\n"
      "<style>.material {{ fill: #c3cfdd; stroke: #2b3f57; }} .principal {{ stroke: #a33; stroke-dasharray: "
      "6 4; }} .own {{ stroke: #15202b; stroke-width: 1.6; }} .size {{ stroke: #7c8a99; }} .quiet {{ fill: "
      "#556372; }}</style>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
      "<text x=\"{3:.0f}\" y=\"30\" font-size=\"17\" font-weight=\"600\">{2}</text>\n",
      width, height, escaped(s.section.name), margin);
  outline(s.section, d);

  // Width below and height at the left, between the section and the ends of its axes.
  const Point w_1(shape_low.x(), shape_low.y() - 0.07 * size), w_2(shape_high.x(), w_1.y());
  const Point h_1(shape_low.x() - 0.07 * size, shape_low.y()), h_2(h_1.x(), shape_high.y());
  const Point along(0.012 * size, 0), up(0, 0.012 * size);
  d.line(w_1, w_2, "class=\"size\"");
  d.line(h_1, h_2, "class=\"size\"");
  for (const Point& p : {w_1, w_2}) d.line(p - up, p + up, "class=\"size\"");
  for (const Point& p : {h_1, h_2}) d.line(p - along, p + along, "class=\"size\"");
  d.label(0.5 * (w_1 + w_2) + 0.22 * (w_2 - w_1), 0, 18, "class=\"quiet\" text-anchor=\"middle\"",
          mm(shape_high.x() - shape_low.x()) + " mm");
  d.put(
      "<text class=\"quiet\" text-anchor=\"middle\" transform=\"translate({:.2f} {:.2f}) rotate(-90)\">{} "
      "mm</text>\n",
      d.X(h_1.x()) - 7, d.Y(0.5 * (h_1.y() + h_2.y()) + 0.22 * (h_2.y() - h_1.y())),
      mm(shape_high.y() - shape_low.y()));

  d.line(s.tension_centre - reach * phi_1, s.tension_centre + reach * phi_1, "class=\"principal\"");
  d.line(s.tension_centre - reach * phi_2, s.tension_centre + reach * phi_2, "class=\"principal\"");
  d.label(s.tension_centre + reach * phi_1, 6, 5, "fill=\"#a33\"", "1");
  d.label(s.tension_centre + reach * phi_2, 6, -2, "fill=\"#a33\"", "2");

  // The section's own axes at its origin, where members put their axis.
  const Point O(0, 0), head(0.022 * size, 0.012 * size);
  for (int axis = 0; axis < 2; ++axis) {
    const Point end = axis == 0 ? Point(tick, 0) : Point(0, tick);
    d.line(O, end, "class=\"own\"");
    for (const double side : {-1.0, 1.0})
      d.line(
          end,
          axis == 0 ? Point(end.x() - head.x(), side * head.y()) : Point(side * head.y(), end.y() - head.x()),
          "class=\"own\"");
    d.label(end, axis == 0 ? 2 : 7, axis == 0 ? -8 : 4, "", axis == 0 ? "y" : "z");
  }

  // Rings of three sizes: centres that coincide are all seen.
  double y = d.bottom() + 0.2 * row;
  const auto mark = [&](const Point& p, const char* name, const char* colour, double radius) {
    for (const Point& at : {Point(d.X(p.x()), d.Y(p.y())), Point(margin + 2, y - 5)})
      d.put(
          "<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.1f}\" fill=\"none\" stroke=\"{}\" "
          "stroke-width=\"2.4\"/>\n",
          at.x(), at.y(), radius, colour);
    d.put("<text x=\"{:.0f}\" y=\"{:.0f}\">{} ({}, {}) mm</text>\n", margin + 18, y, name, mm(p.x()),
          mm(p.y()));
    y += row;
  };
  mark(s.tension_centre, "tension centre", "#a33", 9.5);
  mark(s.shear_centre, "shear centre", "#1a7a3c", 6.0);
  mark(s.mass_centre, "centre of mass", "#2255aa", 2.5);
  d.put(
      "<text x=\"{:.0f}\" y=\"{:.0f}\">principal axes: 1 at {:.2f} deg from y, I_1 = {:.5g} mm⁴, I_2 = "
      "{:.5g} mm⁴</text>\n",
      margin - 4, y, s.principal_angle * 180.0 / std::numbers::pi, 1e12 * s.I_1, 1e12 * s.I_2);
  d.put("<text x=\"{:.0f}\" y=\"{:.0f}\">area {:.5g} mm², torsion I_t = {:.5g} mm⁴</text>\n", margin - 4,
        y + row, 1e6 * s.area, 1e12 * s.I_t);
  return d.text_ + "</svg>\n";
}

}  // namespace flexura::reduce
