// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/beyond_first_order.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace flexura::study {

using Eigen::Index;
using Eigen::VectorXd;

namespace {
// Derivatives may be a tenth off, and the steps of the correction weigh its terms at several times.
constexpr double kAsLarge = 0.3;
// Beside the largest of its kind: nothing.
constexpr double kNothing = 1e-4;
}  // namespace

BeyondFirstOrder::BeyondFirstOrder(const FullModel& full, std::size_t sources)
    : mechanism_(full.mechanism()), scratch_(full.mechanism().make_scratch()), sources_(sources) {
  const mbs::Sizes n = mechanism_.sizes();
  for (int i = 0; i < n.n_v; ++i)
    if (std::ranges::none_of(full.blocks(), [&](const ModalBlock& b) { return i >= b.v && i < b.v + b.m; }))
      rigid_.push_back(i);
  const auto n_rigid = static_cast<Index>(rigid_.size());
  own_ = VectorXd::Zero(n_rigid + n.n_dyn);
  for (Sums& sums : sources_) sums.rest = sums.first = own_;
  r_.resize(n.n_v);
  r_moved_.resize(n.n_v);
  c_rate_.resize(n.n_dyn);
  c_moved_.resize(n.n_dyn);
  b_.resize(n.n_alg);
  roots_.resize(n.n_root);
  roots_moved_.resize(n.n_root);
  has_changed_.resize(static_cast<std::size_t>(n.n_root));
}

void BeyondFirstOrder::begin(const mbs::State& s, const VectorXd& v_dot, const LinearisedRow& row) {
  row_ = &row;
  a_ = v_dot;
  mechanism_.momentum(s, v_dot, *scratch_, r_, c_rate_, b_);
  const auto n_rigid = static_cast<Index>(rigid_.size());
  for (Index i = 0; i < n_rigid; ++i)
    own_(i) += std::pow(row.M.row(rigid_[static_cast<std::size_t>(i)]).dot(v_dot), 2);
  own_.tail(c_rate_.size()) += c_rate_.cwiseAbs2();
  if (roots_.size() == 0) return;
  mechanism_.roots(s, *scratch_, roots_);
  if (first_positions_.empty()) first_positions_ = s.root;
  for (std::size_t k = 0; k < has_changed_.size(); ++k)
    has_changed_[k] = has_changed_[k] || s.root[k] != first_positions_[k];
}

const VectorXd& BeyondFirstOrder::take(std::size_t source, const FullModel::Correction& by,
                                       const VectorXd& acceleration, const mbs::State& moved,
                                       const VectorXd& load) {
  Sums& sums = sources_[source];
  ++sums.taken;
  mechanism_.momentum(moved, a_ + acceleration, *scratch_, r_moved_, c_moved_, b_);
  left_ = r_moved_ - r_ - load;
  const auto n_rigid = static_cast<Index>(rigid_.size());
  for (Index i = 0; i < n_rigid; ++i) {
    const Index at = rigid_[static_cast<std::size_t>(i)];
    const double states = by.states.size() > 0 ? row_->Z_c.row(at).dot(by.states) : 0.0,
                 parts[] = {row_->M.row(at).dot(acceleration), row_->K.row(at).dot(by.delta),
                            row_->D.row(at).dot(by.rate), states};
    double first = 0.0;
    for (const double part : parts) first += std::abs(part);
    sums.first(i) += first * first;
    sums.rest(i) += left_(at) * left_(at);
  }
  for (Index k = 0; k < c_rate_.size(); ++k) {
    const double first =
        row_->C_p.row(k).dot(by.delta) + row_->C_v.row(k).dot(by.rate) + row_->C_c.row(k).dot(by.states);
    sums.first(n_rigid + k) += first * first;
    sums.rest(n_rigid + k) += std::pow(c_moved_(k) - c_rate_(k) - first, 2);
  }
  if (roots_.size() == 0) return left_;
  mechanism_.roots(moved, *scratch_, roots_moved_);
  for (Index k = 0; k < roots_.size(); ++k)
    if (roots_(k) >= 0.0 && roots_moved_(k) < 0.0) sums.thrown.insert(static_cast<int>(k));
  return left_;
}

VectorXd BeyondFirstOrder::rests() const {
  // The next order has that of the row before: where it vibrates from row to row both may add up.
  constexpr double kOfBoth = 2.0;
  VectorXd out = VectorXd::Zero(mechanism_.sizes().n_v);
  for (const Sums& sums : sources_)
    for (std::size_t i = 0; i < rigid_.size() && sums.taken > 0; ++i)
      out(rigid_[i]) += kOfBoth * std::sqrt(sums.rest(static_cast<Index>(i)) / sums.taken);
  return out;
}

std::string BeyondFirstOrder::why(std::size_t source) const {
  const Sums& sums = sources_[source];
  // Of a switch that the run throws, too, the first order tells how much sooner or later.
  for (const int k : sums.thrown)
    if (!has_changed_[static_cast<std::size_t>(k)])
      return fmt::format("its deformation would throw \"{}\", which nothing in the run does",
                         mechanism_.name_of_root(k));
  const auto n_rigid = static_cast<Index>(rigid_.size());
  const double largest =
      n_rigid > 0 ? std::sqrt((own_.head(n_rigid) + sums.first.head(n_rigid)).maxCoeff()) : 0.0;
  for (Index i = 0; i < own_.size(); ++i) {
    const double rest = std::sqrt(sums.rest(i)), there = std::sqrt(own_(i)) + std::sqrt(sums.first(i));
    if (rest > kAsLarge * there && (i >= n_rigid || rest > kNothing * largest))
      return "a force or a control answers its deformation to the second order alone (a square, a dead "
             "band), "
             "which is not followed";
  }
  return "";
}

}  // namespace flexura::study
