// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <vector>

#include "mbs/base/math/spatial.hpp"

namespace flexura::mbs {

/// Nodes of a body's surface, each with a share of the area, as the body's modes move them: node j stands at
///
///     rho_j = x_j + Phi_j s     in B.
///
/// A tree of balls over the nodes finds those near something without a look at all of them.  The ball of a group moves with
/// the group's mean and grows by no more than its nodes leave that mean,
///
///     c = mean x + (mean Phi) s,     |rho_j - c| <= r + sum_i b_i |s_i|,     b_i = max_j |Phi_j,i - mean Phi_i|,
///
/// so that nothing is refitted: a ball costs as much as a node, and only balls that are looked at cost anything.
class SurfacePatch {
 public:
  using Shapes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// `x` undeformed in B [m], `area` of each [m^2], and what others call them: their places in x, unless `numbers` are given.  Rigid
  /// until set_shapes().
  SurfacePatch(const Eigen::Matrix3Xd& x, const Eigen::VectorXd& area, std::vector<int> numbers = {});

  /// Rows 3 j ... 3 j + 2: node j as it was given to the constructor.  Throws std::invalid_argument for another number of rows.
  void set_shapes(const Eigen::MatrixXd& Phi);

  int size() const { return static_cast<int>(x_.cols()); }
  int m() const { return static_cast<int>(Phi_.cols()); }
  double total_area() const { return area_.sum(); }
  /// Of the nodes in the order of the tree, by which visit() names them.
  double area(int j) const { return area_(j); }
  const Eigen::VectorXd& areas() const { return area_; }
  auto shapes(int j) const { return Phi_.middleRows<3>(3 * j); }
  /// Where node j was given to the constructor.
  int given(int j) const { return order_[static_cast<std::size_t>(j)]; }
  /// What others call the node that was given to the constructor as its k-th.
  int number_of_given(int k) const { return numbers_.empty() ? k : numbers_[static_cast<std::size_t>(k)]; }
  const Eigen::Matrix3Xd& undeformed() const { return x_; }

  /// rho_j; s (m) may be null: undeformed.
  Vector3d position(int j, const double* s) const {
    Vector3d rho = x_.col(j);
    if (s && m() > 0) rho += shapes(j) * Eigen::Map<const Eigen::VectorXd>(s, m());
    return rho;
  }
  /// Phi_j s'.
  Vector3d velocity(int j, const double* s_dot) const {
    if (!s_dot || m() == 0) return Vector3d::Zero();
    return shapes(j) * Eigen::Map<const Eigen::VectorXd>(s_dot, m());
  }

  /// node(j, rho_j) of all nodes in balls that enter(centre, radius) lets in.
  template <class Enter, class Node>
  void visit(const double* s, const Enter& enter, const Node& node) const {
    if (size() > 0) visit(0, s, enter, node);
  }

  struct Least {
    double value = std::numeric_limits<double>::infinity();
    int node = -1;
    Vector3d rho = Vector3d::Zero();
  };
  /// The least value(rho_j), of a function that changes by no more than the way that its point goes.
  template <class Value>
  Least least(const double* s, const Value& value) const {
    return least(
        s, [&](const Vector3d& c, double) { return value(c); }, value);
  }
  /// Of any function that is nowhere within r of a point c below bound(c, enough) - r; the bound may be any number above
  /// `enough` where it is above that.
  template <class Bound, class Value>
  Least least(const double* s, const Bound& bound, const Value& value) const {
    Least best;
    if (size() > 0) least(0, s, bound, value, best);
    return best;
  }

 private:
  static constexpr int kLeaf = 6;
  struct Ball {
    Vector3d c;
    double r;
  };
  struct Group {
    int begin = 0, end = 0;     ///< nodes
    int left = -1, right = -1;  ///< of an inner one
    Vector3d c;                 ///< mean x
    double r = 0.0;
  };
  int build(int begin, int end, const Eigen::Matrix3Xd& x);
  Ball ball(int group, const double* s) const {
    const Group& g = groups_[static_cast<std::size_t>(group)];
    if (!s || m() == 0) return {g.c, g.r};
    const Eigen::Map<const Eigen::VectorXd> s_m(s, m());
    return {g.c + mean_.middleRows<3>(3 * group) * s_m, g.r + spread_.row(group).dot(s_m.cwiseAbs())};
  }
  template <class Enter, class Node>
  void visit(int group, const double* s, const Enter& enter, const Node& node) const {
    const Group& g = groups_[static_cast<std::size_t>(group)];
    const Ball b = ball(group, s);
    if (!enter(b.c, b.r)) return;
    if (g.left >= 0) {
      visit(g.left, s, enter, node);
      visit(g.right, s, enter, node);
      return;
    }
    for (int j = g.begin; j < g.end; ++j) node(j, position(j, s));
  }
  template <class Bound, class Value>
  void least(int group, const double* s, const Bound& bound, const Value& value, Least& best) const {
    const Group& g = groups_[static_cast<std::size_t>(group)];
    if (g.left < 0) {
      for (int j = g.begin; j < g.end; ++j) {
        const Vector3d rho = position(j, s);
        if (const double v = value(rho); v < best.value) best = {v, j, rho};
      }
      return;
    }
    const Ball one = ball(g.left, s), other = ball(g.right, s);
    const double at_one = bound(one.c, best.value + one.r) - one.r,
                 at_other = bound(other.c, best.value + other.r) - other.r;
    const bool turned = at_other < at_one;
    if (std::min(at_one, at_other) < best.value) least(turned ? g.right : g.left, s, bound, value, best);
    if (std::max(at_one, at_other) < best.value) least(turned ? g.left : g.right, s, bound, value, best);
  }

  Eigen::Matrix3Xd x_;
  Eigen::VectorXd area_;
  Shapes Phi_;
  std::vector<int> order_, numbers_;
  std::vector<Group> groups_;
  Shapes mean_, spread_;  ///< of each group: 3 rows, 1 row
};

}  // namespace flexura::mbs
