// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/follower.hpp"

#include <utility>

namespace flexura::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const mbs::ModalData& modal_of(const FullModel& full, const ModalBlock& block) {
  return *full.mechanism().description().bodies[static_cast<std::size_t>(block.body)].flexible->modal();
}

}  // namespace

const VectorXd& stiffness_of(const FullModel& full, const ModalBlock& block) {
  return modal_of(full, block).stiffness;
}

MatrixXd damping_of(const FullModel& full, const ModalBlock& block) {
  return modal_of(full, block).damping_matrix();
}

Follower::Follower(FullModel& full, const std::vector<ScreenedRow>& rows, std::size_t every,
                   const std::vector<int>& outputs, const ModalBlock& block, const MatrixXd& S,
                   const MatrixXd& extra_damping, Transients transients, bool next_order)
    : full_(full),
      rows_(rows),
      every_(every),
      outputs_(outputs),
      alone_(full, block, S, extra_damping),
      correction_(alone_.n(), next_order ? 2 : 1),
      transients_(std::move(transients)),
      has_next_order_(next_order),
      next_order_(VectorXd::Zero(next_order ? alone_.n() : 0)) {}

Transients transients_of(FullModel& full, const std::vector<ScreenedRow>& rows, const ModalBlock& block) {
  Transients out;
  const ScreenedRow& first = rows.front();
  LinearisedRow own, small;
  if (!first.linearised) full.linearise(first.s, first.v_dot, own);
  const BodyAlone alone(full, block, MatrixXd::Identity(block.m, block.m), MatrixXd());
  alone.project(first.linearised ? *first.linearised : own, small);
  MatrixXd G;
  alone.project(first.G, G);
  if (!out.add(small, G)) out.add(stiffness_of(full, block), damping_of(full, block).diagonal());
  return out;
}

bool Follower::next(VectorXd* y) {
  if (at_ >= rows_.size()) return false;
  const std::size_t i = at_;
  at_ += every_;
  const ScreenedRow& at = rows_[i];
  if (!at.linearised) full_.linearise(at.s, at.v_dot, own_);
  const LinearisedRow& row = at.linearised ? *at.linearised : own_;
  if (row.number == 0 || row.number != small_.number) alone_.project(row, small_);
  alone_.project(at.G, G_);
  // A jump in the rows that are passed over counts, too.
  bool jumped = false;
  for (std::size_t k = i; k > 0 && k + every_ > i; --k) jumped = jumped || rows_[k].jumped;
  if (jumped) transients_.begin();
  const VectorXd first = alone_.load(at.residual);
  MatrixXd load(first.size(), has_next_order_ ? 2 : 1);
  load.col(0) = first;
  if (has_next_order_) load.col(1) = next_order_;
  correction_.step(i == 0 ? 0.0 : at.s.t - rows_[i - every_].s.t, small_, G_, load, &transients_, jumped);
  // The state moved by these columns of the correction, and its accelerations.
  const auto move = [&](Index columns) -> VectorXd {
    const auto sum = [&](const MatrixXd& of) { return VectorXd(of.leftCols(columns).rowwise().sum()); };
    full_.move(at.s, row,
               {alone_.spread(sum(correction_.delta())), alone_.spread(sum(correction_.rate())),
                sum(correction_.dlambda()), sum(correction_.states())},
               moved_);
    return at.v_dot + alone_.spread(sum(correction_.acceleration()));
  };
  if (has_next_order_) {
    const VectorXd v_dot = move(1);
    full_.residual(moved_, v_dot, r_);
    next_order_ = first - alone_.gather(r_ - at.residual);
  }
  if (!y) return true;
  const VectorXd v_dot = move(load.cols());
  full_.evaluate(outputs_, moved_, v_dot, *y);
  return true;
}

WholeBody::WholeBody(const std::vector<ScreenedRow>& rows, std::size_t compared,
                     std::unique_ptr<Follower> follower)
    : rows_(rows), compared_(compared), follower_(std::move(follower)) {}

const VectorXd& WholeBody::at(std::size_t i) {
  if (!follower_) return rows_[i].corrected;
  for (; followed_ <= i; ++followed_)
    follower_->next(followed_ % compared_ == 0 ? &known_.emplace_back() : nullptr);
  return known_[i / compared_];
}

}  // namespace flexura::study
