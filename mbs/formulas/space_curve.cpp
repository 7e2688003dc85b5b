// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/space_curve.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace flexura::mbs {
namespace {

constexpr int kSamplesPerPiece = 8;

/// e = m / |m| with its first two derivatives, from those of m.
struct Unit {
  Unit(const Vector3d& m, const Vector3d& m_1, const Vector3d& m_2) {
    const double size = m.norm();
    e = m / size;
    e_1 = (m_1 - e * e.dot(m_1)) / size;
    const double size_1 = e.dot(m_1);
    e_2 = (m_2 - e_1 * size_1 - e * (e_1.dot(m_1) + e.dot(m_2)) - e_1 * size_1) / size;
  }
  Vector3d e, e_1, e_2;
};

}  // namespace

SpaceCurve::SpaceCurve(const std::vector<Vector3d>& given, bool closed) : closed_(closed) {
  std::vector<Vector3d> points = given;
  if (points.size() < (closed ? 3u : 2u))
    throw std::invalid_argument(fmt::format("has {} points; {} needs {}", points.size(),
                                            closed ? "a closed curve" : "a curve", closed ? 3 : 2));
  if (closed && points.front() != points.back()) points.push_back(points.front());
  std::vector<double> s{0.0}, x[3];
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) {
      const double chord = (points[i] - points[i - 1]).norm();
      if (!(chord > 0.0))
        throw std::invalid_argument(fmt::format("has the same point twice, number {} and {}", i, i + 1));
      s.push_back(s.back() + chord);
    }
    for (int k = 0; k < 3; ++k) x[k].push_back(points[i](k));
  }
  length_ = s.back();
  for (const auto& component : x)
    components_.emplace_back(s, component, Curve::Interpolation::cubic,
                             closed ? Curve::Outside::repeat : Curve::Outside::extend);
  for (std::size_t i = 0; i + 1 < s.size(); ++i)
    for (int k = 0; k < kSamplesPerPiece; ++k)
      samples_s_.push_back(s[i] + (s[i + 1] - s[i]) * k / kSamplesPerPiece);
  if (!closed) samples_s_.push_back(length_);
  for (const double u : samples_s_) samples_.push_back(at(u).r);
  choose_up();
}

SpaceCurve::Point SpaceCurve::at(double s) const {
  Point point;
  for (int k = 0; k < 3; ++k) {
    const Curve::Value c = components_[k].at(s);
    point.r(k) = c.value;
    point.r_1(k) = c.first;
    point.r_2(k) = c.second;
    point.r_3(k) = c.third;
  }
  return point;
}

void SpaceCurve::choose_up() {
  // Of a plane curve the plane's normal, else the direction of a fine net that stays farthest from all
  // tangents.
  std::vector<Vector3d> tangents;
  for (const double s : samples_s_) tangents.push_back(at(s).r_1.normalized());
  const auto clearance = [&](const Vector3d& e) {
    double least = 2.0;
    for (const Vector3d& t : tangents) least = std::min(least, e.cross(t).norm());
    return least;
  };
  double best = 0.0;
  const auto consider = [&](const Vector3d& e) {
    const double c = clearance(e);
    if (c > best * (1.0 + 1e-9)) {
      best = c;
      up_ = e;
    }
  };
  for (int k : {2, 1, 0}) consider(Vector3d::Unit(k));
  for (const Vector3d& t : tangents)
    if (const Vector3d n = tangents.front().cross(t); n.norm() > 1e-3) consider(n.normalized());
  constexpr int kNet = 200;
  for (int i = 0; i < kNet; ++i) {
    // Fibonacci's half sphere.
    const double z = (i + 0.5) / kNet, phi = i * M_PI * (3.0 - std::sqrt(5.0)), r = std::sqrt(1.0 - z * z);
    consider({r * std::cos(phi), r * std::sin(phi), z});
  }
  if (best < 0.05)
    throw std::invalid_argument(
        "runs into every direction of space; split it, since its normals cannot follow it without a turn");
}

SpaceCurve::Frame SpaceCurve::frame(const Point& point) const {
  const Unit left(up_.cross(point.r_1), up_.cross(point.r_2), up_.cross(point.r_3));
  const Unit t(point.r_1, point.r_2, point.r_3);
  Frame f;
  f.n[0] = left.e;
  f.n_1[0] = left.e_1;
  f.n_2[0] = left.e_2;
  f.n[1] = t.e.cross(left.e);
  f.n_1[1] = t.e_1.cross(left.e) + t.e.cross(left.e_1);
  f.n_2[1] = t.e_2.cross(left.e) + 2.0 * t.e_1.cross(left.e_1) + t.e.cross(left.e_2);
  return f;
}

bool SpaceCurve::refine(const Vector3d& P, double& s) const {
  const double longest = length_ / static_cast<double>(samples_s_.size());
  double last = std::numeric_limits<double>::infinity();
  double u = s;
  for (int i = 0; i < 50; ++i) {
    const Point c = at(u);
    const Vector3d d = P - c.r;
    const double D = c.r_1.squaredNorm() - d.dot(c.r_2);
    if (!(D > 0.0)) return false;
    const double step = std::clamp(d.dot(c.r_1) / D, -longest, longest);
    u += step;
    // Until the steps are round-off, or no longer shrink from near there.
    const double size = std::abs(step), small = 1e-13 * (length_ + std::abs(u));
    if (size <= 1e-3 * small || (size <= small && size >= last)) {
      s = u;
      return true;
    }
    last = size;
  }
  return false;
}

double SpaceCurve::nearest(const Vector3d& P) const {
  double best = std::numeric_limits<double>::infinity(), s = 0.0;
  for (std::size_t i = 0; i < samples_.size(); ++i)
    if (const double d = (P - samples_[i]).squaredNorm(); d < best) {
      best = d;
      s = samples_s_[i];
    }
  refine(P, s);
  return s;
}

double SpaceCurve::foot(const Vector3d& P, double s) const {
  return std::isfinite(s) && refine(P, s) ? s : nearest(P);
}

}  // namespace flexura::mbs
