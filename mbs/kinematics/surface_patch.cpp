// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/kinematics/surface_patch.hpp"

#include <numeric>
#include <stdexcept>
#include <utility>

namespace flexura::mbs {

SurfacePatch::SurfacePatch(const Eigen::Matrix3Xd& x, const Eigen::VectorXd& area, std::vector<int> numbers)
    : order_(static_cast<std::size_t>(x.cols())), numbers_(std::move(numbers)) {
  std::iota(order_.begin(), order_.end(), 0);
  if (!order_.empty()) build(0, static_cast<int>(order_.size()), x);
  x_.resize(3, x.cols());
  area_.resize(x.cols());
  for (int j = 0; j < size(); ++j) {
    x_.col(j) = x.col(given(j));
    area_(j) = area(given(j));
  }
}

// Halves along the longest side of the box around.
int SurfacePatch::build(int begin, int end, const Eigen::Matrix3Xd& x) {
  const int group = static_cast<int>(groups_.size());
  groups_.emplace_back();
  Group g{.begin = begin, .end = end, .c = Vector3d::Zero()};
  Vector3d low = x.col(given(begin)), high = low;
  for (int j = begin; j < end; ++j) {
    const Vector3d p = x.col(given(j));
    g.c += p / (end - begin);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  for (int j = begin; j < end; ++j) g.r = std::max(g.r, (x.col(given(j)) - g.c).norm());
  if (end - begin > kLeaf) {
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = (begin + end) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](int a, int b) { return x(axis, a) < x(axis, b); });
    g.left = build(begin, middle, x);
    g.right = build(middle, end, x);
  }
  groups_[static_cast<std::size_t>(group)] = g;
  return group;
}

void SurfacePatch::set_shapes(const Eigen::MatrixXd& Phi) {
  if (Phi.rows() != 3 * size())
    throw std::invalid_argument("the shapes of a surface need three rows for each of its nodes");
  Phi_.resize(Phi.rows(), Phi.cols());
  for (int j = 0; j < size(); ++j) Phi_.middleRows<3>(3 * j) = Phi.middleRows<3>(3 * given(j));
  const auto n = static_cast<Eigen::Index>(groups_.size());
  mean_.setZero(3 * n, Phi.cols());
  spread_.setZero(n, Phi.cols());
  for (Eigen::Index k = 0; k < n; ++k) {
    const Group& g = groups_[static_cast<std::size_t>(k)];
    auto mean = mean_.middleRows<3>(3 * k);
    for (int j = g.begin; j < g.end; ++j) mean += shapes(j) / (g.end - g.begin);
    for (int j = g.begin; j < g.end; ++j)
      spread_.row(k) = spread_.row(k).cwiseMax((shapes(j) - mean).colwise().norm());
  }
}

}  // namespace flexura::mbs
