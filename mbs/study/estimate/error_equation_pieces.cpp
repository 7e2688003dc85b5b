// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
/// ErrorEquation: how many steps of the run are a span, and the pieces in which it is solved for.
#include <algorithm>
#include <array>
#include <cmath>

#include "mbs/solver/algebra/lobatto.hpp"
#include "mbs/study/estimate/error_equation.hpp"

namespace flexura::study {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// A path tells accelerations between its ends within this part of the greatest so far, of each coordinate, or of this part of the
// greatest of all.
constexpr double kOfAcceleration = 0.03, kOfGreatest = 1e-3;
// The error's forces below this part of the greatest one so far may be lost: modes that hardly matter took half of the time.
constexpr double kOfForce = 0.03;
// What rings is followed down to this part of the greatest force squared, and rings where it turns by more than so many radians in
// a span.  In a step of one in so many parts of the run nothing moves.
constexpr double kRings = 1e-8, kFast = 3.0, kAtOnce = 1e13;

}  // namespace

// So many of the steps that wait, as far as one polynomial tells them; its path is laid.
std::size_t ErrorEquation::choose_span() {
  std::size_t steps = std::min(count_, span_);
  const Step& first = waiting_.front();
  for (std::size_t i = 0; i < steps; ++i)
    greatest_run_ = greatest_run_.cwiseMax(waiting_[i].nodes[2].v_dot.cwiseAbs().cwiseProduct(reach_v_));
  for (;; steps = (steps + 1) / 2) {
    // The accelerations that the equations were met with there, by the step before.
    path_.lay(first.begin.state, v_dot_end_, waiting_[steps - 1].nodes[2]);
    double off = 0.0;
    const double allowed_p = std::max(tolerance_ * weights_.displacement(), kOfError * off_p_),
                 allowed_v = std::max(tolerance_ * weights_.speed(), kOfError * off_v_);
    const mbs::State& last = waiting_[steps - 1].nodes[2].state;
    for (std::size_t i = 0; i + 1 < steps; ++i) {
      const mbs::Instant& w = waiting_[i].nodes[2];
      path_.beside(w.state, dp_, dv_);
      off = std::max({off, dp_.cwiseProduct(reach_p_).lpNorm<Eigen::Infinity>() / allowed_p,
                      dv_.cwiseProduct(reach_v_).lpNorm<Eigen::Infinity>() / allowed_v});
      // What hardly moves may vibrate, and carry a force.
      path_.at((w.state.t - path_.begin()) / path_.length(), between_.state, between_.v_dot);
      a_ = (between_.v_dot - w.v_dot).cwiseAbs().cwiseProduct(reach_v_);
      off = std::max(
          off, (a_.array() /
                (kOfAcceleration * greatest_run_.cwiseMax(kOfGreatest * greatest_run_.maxCoeff()).array())
                    .max(1e-300))
                   .maxCoeff());
    }
    if (steps == 1 || off < 1.0) {
      // It goes with the length to the sixth power.
      if (steps == span_ && off < 0.03)
        span_ = std::min(span_ + 1 + span_ / 2, longest_span_);
      else if (steps < span_)
        span_ = steps;
      weights_.take(last.p, last.v);
      speed_ = std::max(speed_, last.v.cwiseProduct(reach_v_).lpNorm<Eigen::Infinity>());
      return steps;
    }
  }
}

std::size_t ErrorEquation::piece_at(double x) const {
  return std::min(e_.size() - 1, static_cast<std::size_t>(x * static_cast<double>(e_.size())));
}

// At a share x of the span.
void ErrorEquation::value_at(double x, VectorXd& y) const {
  const std::size_t piece = piece_at(x);
  x = x * static_cast<double>(e_.size()) - static_cast<double>(piece);
  const VectorXd& begin = begin_of(piece);
  y = begin;
  for (int i = 0; i < 3; ++i) y += k_.basis(i, x) * (e_[piece][static_cast<std::size_t>(i)] - begin);
}

// At a share x of a piece of h seconds.
void ErrorEquation::acceleration_at(std::size_t piece, double x, double h, VectorXd& a) const {
  const VectorXd& begin = begin_of(piece);
  a.setZero(n_.n_v);
  for (int i = 0; i < 3; ++i)
    a += k_.slope(i, x) / h * (e_[piece][static_cast<std::size_t>(i)] - begin).segment(form_.at_v(), n_.n_v);
}

// Of the last solution, in the norm of kinetic energy.
double ErrorEquation::size_of_rates(const std::vector<Piece>& e) const {
  double sum = 0.0;
  for (const Piece& piece : e)
    for (std::size_t i = 0; i < 3; ++i)
      sum += piece[i].segment(form_.at_v(), n_.n_v).cwiseAbs2().dot(form_.tangents().M.diagonal());
  return std::sqrt(sum / static_cast<double>(e.size()));
}

double ErrorEquation::distance_of_rates(const std::vector<Piece>& e) const {
  std::vector<Piece> off = e;
  for (std::size_t k = 0; k < e.size(); ++k)
    for (std::size_t i = 0; i < 3; ++i) off[k][i] -= e_[k][i];
  return size_of_rates(off);
}

// How far d half way is from the cubic of the others.
void ErrorEquation::look_half_way(double h) {
  has_middle_ = true;
  error_at(0.5, h, error_);
  look(middle_.w, middle_.gaps, error_, d_middle_);
  add_linear(error_, d_middle_);
  for (int k = 0; k < 4; ++k) d_middle_ -= mbs::lobatto::basis(k, 0.5) * d_[static_cast<std::size_t>(k)];
}

// The quartic d at a share x of the span; of dynamic states the rate of their R.
void ErrorEquation::defect_at(double x, double h, VectorXd& d) const {
  const double way = x * (1.0 - x);
  d = (has_middle_ ? 16.0 * way * (5.0 * way - 1.0) : 0.0) * d_middle_;
  for (int k = 0; k < 4; ++k) d += mbs::lobatto::basis(k, x) * d_[static_cast<std::size_t>(k)];
  auto d_c = d.segment(form_.at_c(), n_.n_dyn);
  d_c.setZero();
  for (int i = 0; i < 3; ++i)
    d_c += k_.slope(i, x) / h * R_[static_cast<std::size_t>(i)].segment(form_.at_c(), n_.n_dyn);
}

// R += int d dt up to there, of p and v.
void ErrorEquation::add_defects(double x, double h, VectorXd& R) const {
  const Index n = n_.n_p + n_.n_v;
  const double way = x * (1.0 - x);
  if (has_middle_) R.head(n) -= 8.0 * way * way * (1.0 - 2.0 * x) * h * d_middle_.head(n);
  for (int k = 0; k < 4; ++k)
    R.head(n) += h * mbs::lobatto::integral_of_basis(k, x) * d_[static_cast<std::size_t>(k)].head(n);
}

void ErrorEquation::solve(double h) {
  e_.resize(pieces_);
  solve_pieces(radau_, h, e_);
  e_end_ = e_.back()[3];
  if (is_lost_ || !e_end_.allFinite()) {
    is_lost_ = true;
    for (VectorXd* e : {&e_begin_, &e_end_}) e->setZero();
    for (Piece& piece : e_)
      for (VectorXd& e : piece) e.setZero();
  }
}

void ErrorEquation::solve_pieces(Method& method, double h, std::vector<Piece>& pieces) {
  const mbs::ThreeStages& k = method.k;
  const auto m = static_cast<double>(pieces.size());
  const double h_piece = h / m;
  if (h_piece != method.h) {
    method.h = h_piece;
    if (!method.real.factor(k.gamma / h_piece) || !method.complex.factor(k.lambda / h_piece)) is_lost_ = true;
  }
  // (1/h) sum_j B_ij F_y' (e_j - e_begin) + F_y e_i = (1/h) sum_j B_ij R_j, of rows without rates R_i
  const Index n_with = form_.at_a(), n_rest = form_.size() - n_with;
  const VectorXd* begin = &e_begin_;
  Stages rhs;
  for (std::size_t piece = 0; piece < pieces.size(); ++piece) {
    form_.multiply_rates(*begin, rates_);
    for (int i = 0; i < 3; ++i) {
      VectorXd& r = rhs[static_cast<std::size_t>(i)];
      r = k.B.row(i).sum() / h_piece * rates_;
      if (pieces.size() > 1) {
        defect_at((static_cast<double>(piece) + k.c[static_cast<std::size_t>(i)]) / m, h, d_there_);
        r += d_there_;
        continue;
      }
      for (int j = 0; j < 3; ++j)
        r.head(n_with) += k.B(i, j) / h_piece * R_[static_cast<std::size_t>(j)].head(n_with);
      r.tail(n_rest) += R_[static_cast<std::size_t>(i)].tail(n_rest);
    }
    rhs_ = k.v_left(0) * rhs[0] + k.v_left(1) * rhs[1] + k.v_left(2) * rhs[2];
    rhs_c_ = k.w_left(0) * rhs[0] + k.w_left(1) * rhs[1] + k.w_left(2) * rhs[2];
    method.real.solve(rhs_, x_);
    method.complex.solve(rhs_c_, x_c_);
    Piece& e = pieces[piece];
    for (int i = 0; i < 3; ++i) e[i] = k.v(i) * x_ + 2.0 * (k.w(i) * x_c_).real();
    e[3] = e[2];
    if (k.c[2] < 1.0) {
      e[3] = *begin;
      for (std::size_t i = 0; i < 3; ++i) e[3] += k.basis(static_cast<int>(i), 1.0) * (e[i] - *begin);
    }
    begin = &e[3];
  }
}

// What vibrates so fast that the smallest pieces of Radau IIA lose it goes on ringing: steps of Gauss turn it by too little, but
// leave it as large as it is, whatever their length.  Nor does its own damping act in them: that is v' D v / (2 v' M v).
void ErrorEquation::keep_ringing(double h) {
  gauss_e_.resize(kMostPieces);
  solve_pieces(gauss_, h, gauss_e_);
  if (!has_at_once_) has_at_once_ = at_once_.factor(kAtOnce / duration_);
  const mbs::Tangents& tangents = form_.tangents();
  double damped = 0.0, moves = 0.0, turns = 0.0;
  VectorXd forces = VectorXd::Zero(n_.n_v);
  error_.v_dot.setZero();
  for (std::size_t i = 0; i < kMostPieces; ++i) {
    VectorXd& e = error_.y;
    e = gauss_e_[i][3] - e_[i][3];
    // Gauss's ends do not meet the constraints: a step that is too short for any motion moves them there.
    form_.multiply_rates(e, rhs_);
    rhs_ *= kAtOnce / duration_;
    at_once_.solve(rhs_, e);
    e.tail(form_.size() - form_.at_a()).setZero();
    ringing_[i] = e;
    out_.setZero();
    add_linear(error_, out_);
    forces += out_.segment(form_.at_v(), n_.n_v).cwiseQuotient(reach_v_).cwiseAbs2();
    const auto v = e.segment(form_.at_v(), n_.n_v);
    damped += v.dot(tangents.z_v * v);
    moves += v.dot(tangents.M * v);
    to_rates(e, theta_);
    turns += theta_.dot(tangents.M * theta_);
  }
  forces /= static_cast<double>(kMostPieces);
  const double floor = std::max(1e-300, kOfForce * greatest_.maxCoeff());
  rings_ = has_at_once_ && !is_lost_ && moves > kFast * kFast / (h * h) * turns &&
           (forces.array() / greatest_.cwiseMax(floor).array().square()).maxCoeff() > kRings;
  if (!rings_) return;
  const double decay = std::max(0.0, 0.5 * damped / moves);
  for (std::size_t i = 0; i < kMostPieces; ++i)
    ringing_[i] *= std::exp(-decay * h * static_cast<double>(i + 1) / static_cast<double>(kMostPieces));
  e_end_ += ringing_.back();
}

// What a piece leaves of the equations of momentum at its begin, and, without accelerations, of them at its end.
void ErrorEquation::momentum_at(std::size_t piece, double x, double h, VectorXd& rest, VectorXd& force) {
  const auto m = static_cast<double>(e_.size());
  const Index n_rest = form_.size() - form_.at_a();
  const VectorXd& begin = begin_of(piece);
  error_.y = begin;
  for (int i = 0; i < 3; ++i) error_.y += k_.basis(i, x) * (e_[piece][static_cast<std::size_t>(i)] - begin);
  error_.y.tail(n_rest).setZero();
  for (std::size_t i = 0; i < 3; ++i) error_.y.tail(n_rest) += parabola(i, x) * e_[piece][i].tail(n_rest);
  error_.v_dot.setZero();
  out_.setZero();
  add_linear(error_, out_);
  force = out_.segment(form_.at_v(), n_.n_v).cwiseQuotient(reach_v_);
  acceleration_at(piece, x, h / m, a_);
  out_.segment(form_.at_v(), n_.n_v).noalias() += form_.tangents().M * a_;
  if (e_.size() > 1) {
    defect_at((static_cast<double>(piece) + x) / m, h, d_there_);
    out_.segment(form_.at_v(), n_.n_v) -= d_there_.segment(form_.at_v(), n_.n_v);
  } else {
    for (int k = 0; k < 3; ++k)
      out_.segment(form_.at_v(), n_.n_v) -=
          k_.slope(k, x) / h * R_[static_cast<std::size_t>(k)].segment(form_.at_v(), n_.n_v);
  }
  rest = out_.segment(form_.at_v(), n_.n_v).cwiseQuotient(reach_v_);
}

// Whether its steps leave the error's vibration as it is, or nothing more can be done about it; else there are more pieces now.
// A step of Radau IIA takes a part z^6 / 3600 of the energy of what turns by z in it, and leaves z^3 / 60 of its force of the
// equations at its begin.
bool ErrorEquation::keeps_vibration(double h) {
  if (lost_.size() == 0) return true;
  lost_.setZero();
  VectorXd greatest = greatest_, rest, force;
  for (std::size_t piece = 0; piece <= pieces_; ++piece) {
    // No more is lost than changes: what is left in the first steps, of 1e-12 s, is round-off of the accelerations.
    const bool is_end = piece == pieces_;
    const VectorXd rest_before = rest, force_before = force;
    momentum_at(is_end ? piece - 1 : piece, is_end ? 1.0 : 0.0, h, rest, force);
    if (piece > 0)
      lost_ += 2.0 * rest_before.cwiseAbs().cwiseMin((force - force_before).cwiseAbs()).cwiseAbs2();
    // Between its ends the path may swing, and with it the error from it.
    if (piece == 0 || is_end) greatest = greatest.cwiseMax(force.cwiseAbs());
  }
  const double floor = std::max(1e-300, kOfForce * greatest.maxCoeff()),
               lost = (lost_.array() / greatest.cwiseMax(floor).array().square()).maxCoeff(),
               allowed = kLost * h / duration_;
  next_pieces_ = pieces_;
  if (lost > allowed && pieces_ < kMostPieces) {
    pieces_ *= 2;
    return false;
  }
  // Where it turns it has no force: what has rung is looked at.
  rings_ = lost > allowed || (rang_ && pieces_ == kMostPieces);
  greatest_ = greatest;
  // Half as many lose 32 times as much.
  if (!rings_ && lost < allowed / 100.0 && pieces_ > 1) next_pieces_ = pieces_ / 2;
  return true;
}

}  // namespace flexura::study
