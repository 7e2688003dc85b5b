// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/kinematics/body_path.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mbs/formulas/space_curve.hpp"

namespace flexura::mbs {
namespace {

constexpr int kStencil = 5;

/// The nearest markers to one of them, all where there are fewer.
struct Stencil {
  int first, n;
  Stencil(int at, int size)
      : first(std::clamp(at - kStencil / 2, 0, std::max(0, size - kStencil))), n(std::min(kStencil, size)) {}
};

/// Rows: how f' and f'' at `at` follow from f at the markers of its stencil, times h and h^2: exact for 1, x, ..., x^(n-1).
Eigen::MatrixXd difference_weights(const std::vector<double>& places, int at, const Stencil& stencil,
                                   double h) {
  const int n = stencil.n;
  Eigen::MatrixXd powers(n, n), wanted = Eigen::MatrixXd::Zero(n, 2);
  for (int j = 0; j < n; ++j) {
    const int node = stencil.first + j;
    const double x = (places[static_cast<std::size_t>(node)] - places[static_cast<std::size_t>(at)]) / h;
    double power = 1.0;
    for (int k = 0; k < n; ++k, power *= x) powers(k, j) = power;
  }
  wanted(1, 0) = 1.0;
  if (n > 2) wanted(2, 1) = 2.0;
  return powers.fullPivLu().solve(wanted).transpose();
}

/// Coefficients of u^0 ... u^5 (rows) of what has f, h f', h^2 f'' at u = 0 and then at u = 1 (columns).
Eigen::Matrix<double, 6, 6> quintic() {
  Eigen::Matrix<double, 6, 6> H;
  H << 1, 0, 0, 0, 0, 0,           //
      0, 1, 0, 0, 0, 0,            //
      0, 0, 0.5, 0, 0, 0,          //
      -10, -6, -1.5, 10, -4, 0.5,  //
      15, 8, 1.5, -15, 7, -1,      //
      -6, -3, -0.5, 6, -3, 0.5;
  return H;
}

}  // namespace

BodyPath::BodyPath(std::vector<int> markers, const std::vector<Pose>& undeformed)
    : markers_(std::move(markers)) {
  std::vector<Vector3d> points;
  for (const Pose& X : undeformed) points.push_back(X.p);
  const SpaceCurve line(points, false);  // refuses what is no line
  places_.push_back(0.0);
  for (std::size_t j = 1; j < points.size(); ++j)
    places_.push_back(places_.back() + (points[j] - points[j - 1]).norm());
  for (std::size_t j = 0; j < points.size(); ++j) {
    const SpaceCurve::Frame frame = line.frame(line.at(places_[j]));
    const Matrix3d R = undeformed[j].R.transpose();
    normals_.emplace_back(R * frame.n[0], R * frame.n[1]);
  }
  const Eigen::Matrix<double, 6, 6> H = quintic();
  for (int k = 0; k + 1 < size(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double h = places_[i + 1] - places_[i];
    const Stencil ends[2] = {{k, size()}, {k + 1, size()}};
    const int first = ends[0].first;
    Piece given = Piece::Zero();  // what H multiplies, by the values at the active markers
    for (int end = 0; end < 2; ++end) {
      given(3 * end, k + end - first) = 1.0;
      given.block(3 * end + 1, ends[end].first - first, 2, ends[end].n) =
          difference_weights(places_, k + end, ends[end], h);
    }
    pieces_.push_back(H * given);
    first_.push_back(first);
    active_.push_back(ends[1].first + ends[1].n - first);
  }
}

bool BodyPath::holds(double s) const {
  const double slack = 1e-9 * length();
  return s >= -slack && s <= length() + slack;
}

BodyPath::Weights BodyPath::weights(double s) const {
  const double inside = std::clamp(s, 0.0, length());
  const auto above = std::upper_bound(places_.begin(), places_.end(), inside);
  const std::size_t k = std::min(
      static_cast<std::size_t>(std::max<std::ptrdiff_t>(above - places_.begin(), 1)) - 1, pieces_.size() - 1);
  const double h = places_[k + 1] - places_[k], u = (inside - places_[k]) / h;
  Weights out{first_[k], active_[k]};
  double scale = 1.0;
  for (int order = 0; order < 4; ++order, scale /= h) {
    // The derivative of u^p of this order is p (p - 1) ... u^(p - order).
    double power = scale;
    for (int p = order; p < 6; ++p, power *= u) {
      double factor = power;
      for (int i = 0; i < order; ++i) factor *= p - i;
      out.b.row(order) += factor * pieces_[k].row(p);
    }
  }
  if (s != inside) {
    out.b.row(0) += (s - inside) * out.b.row(1);
    out.b.bottomRows<2>().setZero();
  }
  return out;
}

bool BodyPath::refine(const Kinematics& kin, const Vector3d& point_W, double& s) const {
  const double longest = length() / static_cast<double>(size());
  double last = std::numeric_limits<double>::infinity(), at = s;
  for (int i = 0; i < 50; ++i) {
    const Weights w = weights(at);
    Eigen::Matrix<double, 3, 3> r = Eigen::Matrix<double, 3, 3>::Zero();  // r, r', r''
    for (int k = 0; k < w.n; ++k)
      r += (kin.markers[marker(w.first + k)].X_WP.p - point_W) * w.b.col(k).head<3>().transpose();
    // The weights add up to 1, their derivatives to 0: r.col(0) is already relative to the point.
    const Vector3d d = -r.col(0);
    const double D = r.col(1).squaredNorm() - d.dot(r.col(2));
    if (!(D > 0.0)) return false;
    const double step = std::clamp(d.dot(r.col(1)) / D, -longest, longest);
    at += step;
    // Until the steps are round-off, or no longer shrink from near there.
    const double by = std::abs(step), small = 1e-13 * (length() + std::abs(at));
    if (by <= 1e-3 * small || (by <= small && by >= last)) {
      s = at;
      return true;
    }
    last = by;
  }
  return false;
}

double BodyPath::foot(const Kinematics& kin, const Vector3d& point_W, double from) const {
  double s = from;
  if (std::isfinite(s) && refine(kin, point_W, s)) return s;
  constexpr int kSamples = 4;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k + 1 < places_.size(); ++k)
    for (int i = 0; i <= kSamples; ++i) {
      const double at = places_[k] + (places_[k + 1] - places_[k]) * i / kSamples;
      const Weights w = weights(at);
      Vector3d r = Vector3d::Zero();
      for (int j = 0; j < w.n; ++j) r += w.b(0, j) * (kin.markers[marker(w.first + j)].X_WP.p - point_W);
      if (r.squaredNorm() < best) {
        best = r.squaredNorm();
        s = at;
      }
    }
  refine(kin, point_W, s);
  return s;
}

}  // namespace flexura::mbs
