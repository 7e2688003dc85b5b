// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/reports/part_drawing.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "mbs/view/html/encode.hpp"
#include "mbs/view/html/html.hpp"

namespace flexura::view {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kWidth = 720, kHeight = 420;  // of the drawing, user units
constexpr int kFine = 2;  // pixels a unit: averaged by the browser, so that edges are smooth
constexpr int kMargin = 46;

/// Where points stand on the drawing; the third component is the distance from the viewer.
struct Projection {
  Eigen::Matrix3d axes;  // rows: right, down, away
  Vector3d middle;
  double scale;

  Vector3d operator()(const Vector3d& p) const {
    const Vector3d at = axes * (p - middle);
    return {kWidth / 2.0 + scale * at.x(), kHeight / 2.0 + scale * at.y(), scale * at.z()};
  }
};

Projection projection_of(const superelement::Superelement& se) {
  Projection view;
  const Vector3d away = Vector3d(-1, 1, -0.9).normalized();  // from the front left above
  const Vector3d right = away.cross(Vector3d::UnitZ()).normalized();
  view.axes << right.transpose(), away.cross(right).transpose(), away.transpose();
  Eigen::AlignedBox2d box;
  Eigen::AlignedBox3d body;
  const auto extend = [&](const Vector3d& p) {
    box.extend((view.axes * p).head<2>());
    body.extend(p);
  };
  for (Eigen::Index i = 0; i < se.surface.vertices.rows(); ++i)
    extend(se.surface.vertices.row(i).transpose().cast<double>());
  for (const auto& interface : se.interfaces) extend(interface.p_BoN_B);
  const Vector2d size = box.sizes().cwiseMax(1e-12);
  view.scale = std::min((kWidth - 2.0 * kMargin) / size.x(), (kHeight - 2.0 * kMargin) / size.y());
  view.middle =
      view.axes.transpose() * Vector3d(box.center().x(), box.center().y(), (view.axes * body.center()).z());
  return view;
}

class Canvas {
 public:
  static constexpr int width = kFine * kWidth, height = kFine * kHeight;
  Canvas()
      : depth_(static_cast<std::size_t>(width) * height, std::numeric_limits<float>::infinity()),
        rgba_(4 * depth_.size(), '\0') {}

  void triangle(const std::array<Vector3d, 3>& p, const Vector3d& colour) {
    const auto edge = [](const Vector3d& a, const Vector3d& b, double x, double y) {
      return (b.x() - a.x()) * (y - a.y()) - (b.y() - a.y()) * (x - a.x());
    };
    const double area = edge(p[0], p[1], p[2].x(), p[2].y());
    if (std::abs(area) < 1e-12) return;
    const auto first = [](double v) { return static_cast<int>(std::floor(kFine * v)); };
    const int x0 = std::max(0, first(std::min({p[0].x(), p[1].x(), p[2].x()}))),
              x1 = std::min(width - 1, first(std::max({p[0].x(), p[1].x(), p[2].x()}))),
              y0 = std::max(0, first(std::min({p[0].y(), p[1].y(), p[2].y()}))),
              y1 = std::min(height - 1, first(std::max({p[0].y(), p[1].y(), p[2].y()})));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const double cx = (x + 0.5) / kFine, cy = (y + 0.5) / kFine;
        const double a = edge(p[1], p[2], cx, cy) / area, b = edge(p[2], p[0], cx, cy) / area,
                     c = 1.0 - a - b;
        if (a < 0.0 || b < 0.0 || c < 0.0) continue;
        put(x, y, static_cast<float>(a * p[0].z() + b * p[1].z() + c * p[2].z()), colour);
      }
  }

  /// A line that lies on faces: a little nearer than they are.
  void line(const Vector3d& a, const Vector3d& b, const Vector3d& colour, double lift) {
    const int steps = std::max(1, static_cast<int>(std::ceil(kFine * (b - a).head<2>().norm())));
    for (int i = 0; i <= steps; ++i) {
      const Vector3d p = a + (b - a) * i / steps;
      const int x = static_cast<int>(kFine * p.x()), y = static_cast<int>(kFine * p.y());
      if (x >= 0 && x < width && y >= 0 && y < height) put(x, y, static_cast<float>(p.z() - lift), colour);
    }
  }

  const std::string& rgba() const { return rgba_; }

 private:
  void put(int x, int y, float depth, const Vector3d& colour) {
    const std::size_t at = static_cast<std::size_t>(y) * width + x;
    if (depth >= depth_[at]) return;
    depth_[at] = depth;
    for (int i = 0; i < 3; ++i)
      rgba_[4 * at + i] = static_cast<char>(std::lround(255 * std::clamp(colour[i], 0.0, 1.0)));
    rgba_[4 * at + 3] = static_cast<char>(255);
  }

  std::vector<float> depth_;
  std::string rgba_;
};

void put_number(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
}

void put_chunk(std::string& png, const std::string& type, const std::string& data) {
  put_number(png, static_cast<std::uint32_t>(data.size()));
  const std::string body = type + data;
  png += body;
  put_number(png, static_cast<std::uint32_t>(::crc32(0, reinterpret_cast<const Bytef*>(body.data()),
                                                     static_cast<uInt>(body.size()))));
}

}  // namespace

// PNG, ISO/IEC 15948: signature, header, one chunk of zlib's stream (each row behind a filter byte 0), end.
std::string png_of(const std::string& rgba, int width, int height) {
  std::string rows;
  for (int y = 0; y < height; ++y)
    rows += '\0' + rgba.substr(4 * static_cast<std::size_t>(y) * width, 4 * static_cast<std::size_t>(width));
  std::string packed(::compressBound(rows.size()), '\0');
  uLongf size = packed.size();
  if (::compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()),
                  rows.size(), 9) != Z_OK)
    throw std::runtime_error("a picture could not be compressed: out of memory; leave the page out");
  packed.resize(size);
  std::string header;
  put_number(header, static_cast<std::uint32_t>(width));
  put_number(header, static_cast<std::uint32_t>(height));
  header += std::string("\x08\x06\0\0\0", 5);  // 8 bits, colour with opacity
  std::string png = "\x89PNG\r\n\x1a\n";
  put_chunk(png, "IHDR", header);
  put_chunk(png, "IDAT", packed);
  put_chunk(png, "IEND", "");
  return png;
}

std::string part_drawing(const superelement::Superelement& se) {
  const auto& surface = se.surface;
  if (surface.vertices.rows() == 0) return {};
  const Projection view = projection_of(se);
  std::vector<Vector3d> at(static_cast<std::size_t>(surface.vertices.rows()));
  for (std::size_t i = 0; i < at.size(); ++i)
    at[i] = view(surface.vertices.row(static_cast<Eigen::Index>(i)).transpose().cast<double>());
  Canvas canvas;
  const Vector3d light = Vector3d(-0.35, -0.75, -0.55).normalized();  // towards the lamp: above, left, before
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const std::array<Vector3d, 3> p = {at[surface.triangles(t, 0)], at[surface.triangles(t, 1)],
                                       at[surface.triangles(t, 2)]};
    Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]);
    if (!(n.norm() > 0.0)) continue;
    n.normalize();
    if (n.z() > 0.0) n = -n;  // the side that is seen
    canvas.triangle(p, (0.42 + 0.5 * std::max(0.0, n.dot(light))) * Vector3d(0.70, 0.80, 0.94));
  }
  for (Eigen::Index e = 0; e < surface.edges.rows(); ++e)
    canvas.line(at[surface.edges(e, 0)], at[surface.edges(e, 1)], Vector3d(0.10, 0.15, 0.22), 0.8);

  const std::string png = png_of(canvas.rgba(), Canvas::width, Canvas::height);
  std::string svg = fmt::format(
      "<svg class=\"part-drawing\" viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2} from the front left "
      "above, with its interfaces\">"
      "<image width=\"{0}\" height=\"{1}\" href=\"data:image/png;base64,{3}\"/>",
      kWidth, kHeight, escape_html(se.name),
      base64({reinterpret_cast<const unsigned char*>(png.data()), png.size()}));
  // Names to the side with more room.
  for (const auto& interface : se.interfaces) {
    const Vector3d p = view(interface.p_BoN_B);
    const bool left = p.x() > 0.7 * kWidth;
    svg += fmt::format(
        "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"5\" class=\"interface\"/><text x=\"{:.1f}\" y=\"{:.1f}\" "
        "text-anchor=\"{}\">{}</text>",
        p.x(), p.y(), p.x() + (left ? -9 : 9), p.y() + 4.5, left ? "end" : "start",
        escape_html(interface.name));
  }
  // Axes of the body, at the lower left.
  static constexpr const char* names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const Vector3d d = view.axes.col(i) * 26.0;
    svg += fmt::format(
        "<line x1=\"34\" y1=\"{0}\" x2=\"{1:.1f}\" y2=\"{2:.1f}\" class=\"axis\"/><text x=\"{3:.1f}\" "
        "y=\"{4:.1f}\" "
        "text-anchor=\"middle\" class=\"axis\">{5}</text>",
        kHeight - 40, 34 + d.x(), kHeight - 40 + d.y(), 34 + 1.35 * d.x(), kHeight - 40 + 1.35 * d.y() + 4,
        names[i]);
  }
  return svg + "</svg>";
}

}  // namespace flexura::view
