// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/rules.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

namespace flexura::mesh {
namespace {

struct Line {
  std::vector<double> x, w;
};

/// Gauss-Legendre on [-1, 1].
Line gauss(int n) {
  switch (n) {
    case 1:
      return {{0}, {2}};
    case 2:
      return {{-1 / std::sqrt(3), 1 / std::sqrt(3)}, {1, 1}};
    case 3:
      return {{-std::sqrt(0.6), 0, std::sqrt(0.6)}, {5. / 9, 8. / 9, 5. / 9}};
    case 4: {
      const double inner = std::sqrt(3. / 7 - 2. / 7 * std::sqrt(1.2)),
                   outer = std::sqrt(3. / 7 + 2. / 7 * std::sqrt(1.2));
      const double wi = (18 + std::sqrt(30.)) / 36, wo = (18 - std::sqrt(30.)) / 36;
      return {{-outer, -inner, inner, outer}, {wo, wi, wi, wo}};
    }
    case 5: {
      const double inner = std::sqrt(5 - 2 * std::sqrt(10. / 7)) / 3,
                   outer = std::sqrt(5 + 2 * std::sqrt(10. / 7)) / 3;
      const double wi = (322 + 13 * std::sqrt(70.)) / 900, wo = (322 - 13 * std::sqrt(70.)) / 900;
      return {{-outer, -inner, 0, inner, outer}, {wo, wi, 128. / 225, wi, wo}};
    }
    default:
      throw std::invalid_argument("no Gauss rule of " + std::to_string(n) + " points");
  }
}

}  // namespace

Quadrature Rule::finish() const {
  Quadrature q;
  q.points.resize(static_cast<Eigen::Index>(x.size()), 3);
  for (std::size_t k = 0; k < x.size(); ++k) q.points.row(static_cast<Eigen::Index>(k)) = x[k].transpose();
  q.weights = Eigen::Map<const Eigen::VectorXd>(w.data(), static_cast<Eigen::Index>(w.size()));
  return q;
}

Rule tensor(int dimension, int n) {
  const Line g = gauss(n);
  Rule rule;
  for (int k = 0; k < (dimension > 2 ? n : 1); ++k)
    for (int j = 0; j < (dimension > 1 ? n : 1); ++j)
      for (int i = 0; i < n; ++i)
        rule.add(g.x[i], dimension > 1 ? g.x[j] : 0, dimension > 2 ? g.x[k] : 0,
                 g.w[i] * (dimension > 1 ? g.w[j] : 1) * (dimension > 2 ? g.w[k] : 1));
  return rule;
}

Rule triangle_symmetric(int n) {
  Rule rule;
  const auto orbit = [&](double a, double w) {
    rule.add(a, a, 0, w);
    rule.add(1 - 2 * a, a, 0, w);
    rule.add(a, 1 - 2 * a, 0, w);
  };
  if (n == 1) rule.add(1. / 3, 1. / 3, 0, 0.5);
  if (n == 3) orbit(1. / 6, 1. / 6);
  if (n == 7) {
    const double root = std::sqrt(15.);
    rule.add(1. / 3, 1. / 3, 0, 9. / 80);
    orbit((6 - root) / 21, (155 - root) / 2400);
    orbit((6 + root) / 21, (155 + root) / 2400);
  }
  return rule;
}

Rule triangle_collapsed(int n) {
  const Line g = gauss(n);
  Rule rule;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double s = 0.5 * (1 + g.x[j]), r = 0.5 * (1 + g.x[i]) * (1 - s);
      rule.add(r, s, 0, 0.25 * g.w[i] * g.w[j] * (1 - s));
    }
  return rule;
}

Rule triangle_times_line(const Rule& triangle, int n) {
  const Line g = gauss(n);
  Rule rule;
  for (int k = 0; k < n; ++k)
    for (std::size_t i = 0; i < triangle.x.size(); ++i)
      rule.add(triangle.x[i].x(), triangle.x[i].y(), g.x[k], triangle.w[i] * g.w[k]);
  return rule;
}

Rule pyramid_rule(int n_base, int n_height) {
  const Line g = gauss(n_base), h = gauss(n_height);
  Rule rule;
  for (int k = 0; k < n_height; ++k) {
    const double t = 0.5 * (1 + h.x[k]), scale = 1 - t;
    for (int j = 0; j < n_base; ++j)
      for (int i = 0; i < n_base; ++i)
        rule.add(scale * g.x[i], scale * g.x[j], t, 0.5 * h.w[k] * g.w[i] * g.w[j] * scale * scale);
  }
  return rule;
}

void tetrahedron_corner_orbit(Rule& rule, double a, double w) {
  rule.add(a, a, a, w);
  rule.add(1 - 3 * a, a, a, w);
  rule.add(a, 1 - 3 * a, a, w);
  rule.add(a, a, 1 - 3 * a, w);
}

Rule tetrahedron14() {
  Rule rule;
  tetrahedron_corner_orbit(rule, 0.31088591926330060980, 0.11268792571801585080 / 6);
  tetrahedron_corner_orbit(rule, 0.092735250310891226402, 0.073493043116361949544 / 6);
  const double a = 0.045503704125649649492, b = 0.5 - a, w = 0.042546020777081466438 / 6;
  for (const auto& p : {Eigen::Vector3d(a, a, b), Eigen::Vector3d(a, b, a), Eigen::Vector3d(b, a, a),
                        Eigen::Vector3d(a, b, b), Eigen::Vector3d(b, a, b), Eigen::Vector3d(b, b, a)})
    rule.add(p.x(), p.y(), p.z(), w);
  return rule;
}

}  // namespace flexura::mesh
