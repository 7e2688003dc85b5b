// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/screening.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "mbs/study/estimate/spectrum.hpp"

namespace flexura::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::array kLadder = {0, 1, 2, 4, 8, 16, 32, 64, 128};
// Above this part of a body's deformations the shadows of those left out cost more than their modes would.
constexpr double kWorthLeavingOut = 0.5;
bool is_worth_it(Index kept, Index all) {
  return static_cast<double>(kept) <= kWorthLeavingOut * static_cast<double>(all);
}
// A candidate is judged on about so many rows (on every second one a static arm seemed three times as wrong),
// spin and stiffness on fewer.
constexpr double kMostMemory = 256e6;  // [B] of linearised rows
constexpr std::size_t kRowsForCandidates = 801, kRowsCompared = 200, kRowsForSpin = 100,
                      kRowsForStiffness = 8;

double hz(double omega2) {
  return std::sqrt(std::max(omega2, 0.0)) / (2.0 * std::numbers::pi);
}

// Response modes beside the lowest n free modes, as Ritz vectors of what is left of them.
MatrixXd beside(Index n, const MatrixXd& responses, const VectorXd& omega2) {
  MatrixXd A = responses;
  A.topRows(std::min(n, A.rows())).setZero();
  Index kept = 0;
  for (Index k = 0; k < A.cols(); ++k)
    if (const double length = A.col(k).norm(); length > 1e-9 * responses.col(k).norm())
      A.col(kept++) = A.col(k) / length;
  A.conservativeResize(Eigen::NoChange, kept);
  if (kept == 0) return A;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(A.transpose() * A);
  Index dropped = 0;
  while (gram.eigenvalues()(dropped) < 1e-12 * gram.eigenvalues()(kept - 1)) ++dropped;
  const MatrixXd Q = A * gram.eigenvectors().rightCols(kept - dropped) *
                     gram.eigenvalues().tail(kept - dropped).cwiseSqrt().cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(Q.transpose() * omega2.asDiagonal() * Q);
  return Q * ritz.eigenvectors();
}

}  // namespace

Screening::Screening(const mbs::PreparedMechanism& run, FullModel& full)
    : run_(run),
      full_(full),
      shadows_(Shadows::make(run, full, HeldRows::kOfChoice, kRowsCompared)),
      range_(full.mechanism(), run.options.end_time - run.options.start_time) {}

void Screening::ask_for_looks(mbs::RunCallbacks& callbacks) {
  if (!shadows_) return;
  shadows_->ask_for_looks(callbacks, [this](const mbs::State& s, const VectorXd& v_dot) {
    if (shadows_->look(s, v_dot)) keep(true);
  });
}

void Screening::take(const mbs::State& s, const VectorXd& v_dot) {
  if (shadows_ && shadows_->take(s, v_dot)) keep(false);
}

// What the shadows have just followed.
void Screening::keep(bool is_look) {
  rows_.push_back({shadows_->embedded(), shadows_->embedded_v_dot(), shadows_->residual(),
                   shadows_->linearised().G(), shadows_->corrected_outputs(), nullptr, shadows_->jumped(),
                   is_look});
  if (!is_look) ++n_rows_;
  // What superelements of files bend by is for the run itself to tell: nothing else can be chosen for them.
  if (std::ranges::any_of(full_.mechanism().description().bodies,
                          [](const mbs::BodyDescription& body) { return body.of_beam != nullptr; })) {
    VectorXd v_dot;
    range_.observe(shadows_->corrected(v_dot));
  }
  // What does not fit is taken anew where it is wanted.
  const auto& row = shadows_->linearised().row();
  if (row->number != last_number_)
    memory_ += 8.0 * static_cast<double>(row->M.size() + row->D.size() + row->K.size() + row->G.size() +
                                         3 * row->Z_c.size());
  last_number_ = row->number;
  if (memory_ < kMostMemory) rows_.back().linearised = row;
}

bool Screening::leaves_linear_range(const std::string& body) const {
  return range_.is_left(block_of(body).body);
}

TruncationEstimate Screening::estimate() const {
  return shadows_->estimate();
}

// Of the rows kept one in so many judges candidates; shadows take no more than twice as many.
std::size_t Screening::rows_between() const {
  return std::max<std::size_t>(1, n_rows_ / kRowsForCandidates);
}

// The time [s] for which a row stands, of one in `every`: rows lie closer where there is more to see.
double Screening::time_of(std::size_t row, std::size_t every) const {
  const std::size_t last = (rows_.size() - 1) / every * every;
  return 0.5 * (rows_[std::min(row + every, last)].s.t - rows_[row < every ? 0 : row - every].s.t);
}

const ModalBlock& Screening::block_of(const std::string& body) const {
  return *std::ranges::find(full_.blocks(), body, &ModalBlock::name);
}

std::optional<Screening::Basis> Screening::basis_of(const std::string& body,
                                                    const mbs::BodyModel& model) const {
  const ModalBlock& block = block_of(body);
  try {
    mbs::MechanismFile file = run_.source->read(run_.choice.with({.bodies = {{body, model}}}), *run_.cache);
    const mbs::Mechanism mechanism(std::move(file.description));
    const auto index = static_cast<std::size_t>(&block - full_.blocks().data());
    const mbs::FlexibleBody* const deforms = mechanism.deforming(block.body);
    if (!deforms || !deforms->modal()) return std::nullopt;
    return Basis{Embedding(mechanism, full_).deformations(index), deforms->modal()->damping_matrix()};
  } catch (const input::InputError&) {
    return std::nullopt;  // nothing acts on its interfaces, or no joint holds it
  }
}

const MatrixXd& Screening::responses_of(const std::string& body) {
  const auto [found, is_new] = responses_.try_emplace(body);
  if (is_new) {
    const auto basis = basis_of(body, {.fidelity = "static", .coupling = "full"});
    found->second = basis ? basis->S : MatrixXd(block_of(body).m, 0);
  }
  return found->second;
}

// As many of them as any candidate has.
const std::optional<Screening::Basis>& Screening::held_of(const std::string& body) {
  const auto [found, is_new] = held_.try_emplace(body);
  if (is_new) {
    const ModalBlock& block = block_of(body);
    const std::vector<int> ladder = ladder_alone(block, 0, static_cast<int>(block.m));
    found->second = basis_of(body, {.fidelity = "modal",
                                    .modes = ladder.back(),
                                    .responses = false,
                                    .boundary = "joint",
                                    .coupling = "full"});
  }
  return found->second;
}

// Of those again one in so many is compared: outputs cost more than the correction.  Where the shadows have followed the
// same rows they have compared the same ones.
std::size_t Screening::rows_compared() const {
  if (rows_between() == 1) return shadows_->rows_compared();
  return std::max<std::size_t>(1, rows_.size() / rows_between() / kRowsCompared);
}

// The same in all deformations of the body.
WholeBody Screening::whole_of(const ModalBlock& block) {
  // Where no other body deforms the shadows have followed just these.
  const bool is_known = full_.blocks().size() == 1 && rows_between() == 1;
  return {rows_, rows_compared(),
          is_known ? nullptr
                   : std::make_unique<Follower>(full_, rows_, rows_between(), shadows_->outputs(), block,
                                                MatrixXd::Identity(block.m, block.m), MatrixXd(),
                                                transients(block), asks_next_order())};
}

// Where forces answer deformations otherwise than in proportion, by more than a little of what is asked.
bool Screening::asks_next_order() const {
  constexpr double kLittle = 0.1;
  return shadows_->next_order_error() > kLittle * least_share_;
}

const Transients& Screening::transients(const ModalBlock& block) {
  const auto found = transients_.find(block.name);
  return found != transients_.end()
             ? found->second
             : transients_.emplace(block.name, transients_of(full_, rows_, block)).first->second;
}

// How far a candidate is from the whole: relative rms of the worst output over all rows.  Squares only add up, so that it is
// given up at the row where they are too many: it is then above `share` and not told.
double Screening::loss_of(const ModalBlock& block, const MatrixXd& S, const MatrixXd& extra_damping,
                          Goal& goal) {
  Follower candidate(full_, rows_, rows_between(), shadows_->outputs(), block, S, extra_damping,
                     transients(block), asks_next_order());
  ++effort_.candidates;
  VectorXd sum, y;
  const double time = goal.time;
  const std::size_t compared = rows_compared(), every = compared * rows_between();
  double loss = 0.0;
  for (std::size_t i = 0; loss <= goal.share && candidate.next(i % compared == 0 ? &y : nullptr);
       ++i, ++effort_.rows) {
    if (i % compared != 0) continue;
    if (i == 0) sum = VectorXd::Zero(y.size());
    sum += time_of(i * rows_between(), every) * (y - goal.whole.at(i)).cwiseAbs2();
    loss = worst_output(sum, time, goal.outputs).first;
  }
  return loss;
}

Candidate Screening::judge(const ModalBlock& block, int modes, const MatrixXd& responses, Goal& goal) {
  const VectorXd& omega2 = stiffness_of(full_, block);
  const MatrixXd A = beside(modes, responses, omega2);
  Candidate out;
  out.modes = modes;
  out.responses = static_cast<int>(A.cols());
  out.all = modes > 0 && modes + A.cols() >= block.m;
  out.highest_hz = modes > 0 ? hz(omega2(modes - 1)) : 0.0;
  if (out.all) {
    out.modes = static_cast<int>(block.m);
    out.responses = 0;
    return out;
  }
  MatrixXd S(block.m, modes + A.cols());
  S.leftCols(modes) = MatrixXd::Identity(block.m, modes);
  S.rightCols(A.cols()) = A;
  // Response modes alone are damped critically (fidelities.cpp).
  MatrixXd extra_damping;
  if (modes == 0) {
    const VectorXd omega = (S.transpose() * omega2.asDiagonal() * S).diagonal().cwiseMax(0.0).cwiseSqrt();
    extra_damping = -(S.transpose() * damping_of(full_, block) * S);
    extra_damping.diagonal() += 2.0 * omega;
  }
  out.loss = loss_of(block, S, extra_damping, goal);
  return out;
}

// The fewest eigenmodes of the body as its joint holds it that do: two of them may do what twenty free ones do, for a bar
// that a wall holds.  Their damping is that of the run, by their own ratios.
std::optional<Candidate> Screening::fewest_held(const std::string& body, const std::vector<int>& ladder,
                                                Goal& goal) {
  if (ladder.empty()) return std::nullopt;
  const ModalBlock& block = block_of(body);
  // A rigid link is held together in a frame of its own.
  for (const mbs::BlindSpot& spot : run_.file.blind_spots)
    if (spot.has_own_frame && spot.name.starts_with(body + '.')) return std::nullopt;
  const std::optional<Basis>& held = held_of(body);
  if (!held || held->S.cols() < 1) return std::nullopt;
  std::optional<Candidate> found;
  std::size_t low = 0, high = ladder.size();
  for (bool is_first = true; low < high; is_first = false) {
    const std::size_t middle = is_first ? high - 1 : (low + high) / 2;
    const Index n = std::min<Index>(ladder[middle], held->S.cols());
    const MatrixXd S = held->S.leftCols(n);
    const MatrixXd own = S.transpose() * damping_of(full_, block) * S;
    Candidate candidate;
    candidate.modes = static_cast<int>(n);
    candidate.plain = candidate.held = true;
    candidate.loss = loss_of(block, S, held->damping.topLeftCorner(n, n) - own, goal);
    candidate.highest_hz = hz((S.transpose() * stiffness_of(full_, block).asDiagonal() * S)(n - 1, n - 1) /
                              S.col(n - 1).squaredNorm());
    if (candidate.loss <= goal.share) {
      found = candidate;
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return found;
}

// The fewest of `ladder`: more modes lose less.  Where the most of them are too few, which is soon seen, no other one is
// asked; else by bisection.
std::optional<Candidate> Screening::fewest(const ModalBlock& block, const std::vector<int>& ladder,
                                           const MatrixXd& responses, Goal& goal) {
  std::optional<Candidate> found;
  std::size_t low = 0, high = ladder.size();
  for (bool is_first = true; low < high; is_first = false) {
    const std::size_t middle = is_first ? high - 1 : (low + high) / 2;
    const Candidate candidate = judge(block, ladder[middle], responses, goal);
    if (candidate.loss <= goal.share) {
      found = candidate;
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return found;
}

// Numbers of eigenmodes beside the response modes.
std::vector<int> Screening::ladder_beside(const ModalBlock& block, const MatrixXd& responses) const {
  std::vector<int> ladder;
  for (const int modes : kLadder)
    // Without eigenmodes as many responses as deformations are less work, too: nothing of them vibrates.
    if (modes > 0 ? is_worth_it(modes + responses.cols(), block.m) : responses.cols() > 0)
      ladder.push_back(modes);
  return ladder;
}

// Numbers of eigenmodes alone.
std::vector<int> Screening::ladder_alone(const ModalBlock& block, int more_than, int fewer_than) const {
  std::vector<int> ladder;
  for (const int modes : kLadder)
    if (modes > more_than && modes < fewer_than && is_worth_it(modes, block.m)) ladder.push_back(modes);
  return ladder;
}

double Screening::least_loss(const std::string& body, double share, double whole) {
  least_share_ = share;
  if (n_rows_ < 2) return 0.0;
  const ModalBlock& block = block_of(body);
  const MatrixXd& responses = responses_of(body);
  Goal goal{whole_of(block), shadows_->estimate().outputs, share, whole};
  double least = std::numeric_limits<double>::infinity();
  const auto ask = [&](const std::vector<int>& ladder, const auto& fewest_of) {
    if (ladder.empty()) return;
    if (const auto found = fewest_of(std::vector<int>{ladder.back()})) least = std::min(least, found->loss);
  };
  const auto alone = ladder_alone(block, 0, static_cast<int>(block.m));
  ask(ladder_beside(block, responses),
      [&](const auto& most) { return fewest(block, most, responses, goal); });
  ask(alone, [&](const auto& most) { return fewest(block, most, MatrixXd(block.m, 0), goal); });
  ask(alone, [&](const auto& most) { return fewest_held(body, most, goal); });
  return least;
}

Candidate Screening::cheapest(const std::string& body, double share) {
  least_share_ = share;
  const ModalBlock& block = block_of(body);
  const MatrixXd& responses = responses_of(body);
  Candidate best;
  best.modes = static_cast<int>(block.m);
  best.all = true;
  best.highest_hz = hz(stiffness_of(full_, block)(block.m - 1));
  const std::vector<int> ladder = ladder_beside(block, responses);
  Goal goal{whole_of(block), shadows_->estimate().outputs, share, span()};
  int lost = ladder.empty() ? 0 : ladder.back();  // modes that are too few
  if (const auto found = fewest(block, ladder, responses, goal)) {
    best = *found;
    lost = found->modes - 1;
  }
  // Eigenmodes alone where fewer coordinates do as well; nothing beats response modes alone.  What is too few with response
  // modes is so without them.
  if (best.modes == 0) return best;
  if (auto found =
          fewest(block, ladder_alone(block, lost, best.modes + best.responses), MatrixXd(block.m, 0), goal)) {
    found->plain = true;
    best = *found;
  }
  if (const auto found = fewest_held(body, ladder_alone(block, 0, best.modes + best.responses), goal))
    best = *found;
  return best;
}

// Of the rows, which lie evenly; where looks between them hold more than a thousandth of the power, by their distances.
double Screening::excitation(const ModalBlock& block) {
  const VectorXd& omega2 = stiffness_of(full_, block);
  MatrixXd loads(static_cast<Index>(n_rows_), block.m);
  Index n = 0;
  double all = 0.0, beside = 0.0, shortest = span();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const VectorXd load = rows_[i].residual.segment(block.v, block.m).cwiseQuotient(omega2.cwiseSqrt());
    const double power = time_of(i, rows_between()) * load.squaredNorm();
    all += power;
    if (!rows_[i].is_look) {
      loads.row(n++) = load.transpose();
      continue;
    }
    beside += power;
    if (power > 0.0 && i > 0 && rows_[i - 1].is_look)
      shortest = std::min(shortest, rows_[i].s.t - rows_[i - 1].s.t);
  }
  const double by_rows = reach(loads, span() / static_cast<double>(n - 1), 0.999);
  constexpr double kLooksAPeriod = 4.0;  // see KnownTimes::looks
  return beside > 1e-3 * all ? std::max(by_rows, 1.0 / (kLooksAPeriod * shortest)) : by_rows;
}

void Screening::change_of_stiffness(const ModalBlock& block, Screened& out) {
  const auto& body = full_.mechanism().description().bodies[static_cast<std::size_t>(block.body)];
  out.has_stiffening_terms = has_stiffening_terms(body);
  if (!out.has_stiffening_terms) return;
  const auto stiffened = FullModel::make(run_, {.stiffened = {block.name}, .rigid = {}, .own_frames = true});
  const VectorXd scale = stiffness_of(full_, block).cwiseSqrt().cwiseInverse();
  LinearisedRow with, without;
  const std::size_t every = std::max<std::size_t>(1, rows_.size() / kRowsForStiffness);
  for (std::size_t i = every / 2; i < rows_.size(); i += every) {
    stiffened->linearise(rows_[i].s, rows_[i].v_dot, with);
    full_.linearise(rows_[i].s, rows_[i].v_dot, without);
    const MatrixXd change = scale.asDiagonal() *
                            (with.K - without.K).block(block.v, block.v, block.m, block.m) *
                            scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (change + change.transpose()),
                                                         Eigen::EigenvaluesOnly);
    out.stiffness_change = std::max(out.stiffness_change, solver.eigenvalues().cwiseAbs().maxCoeff());
    out.most_negative_change = std::min(out.most_negative_change, solver.eigenvalues()(0));
  }
}

std::vector<Screened> Screening::bodies(const std::vector<std::string>& for_bodies) {
  std::vector<Screened> out;
  if (!shadows_) return out;
  const auto infos = full_.mechanism().quantities();
  for (const SourceEstimate& source : shadows_->estimate().by_body) {
    Screened screened;
    screened.body = source.body;
    screened.available = source.available;
    screened.rigid_error = source.error;
    screened.output = source.output;
    if (std::ranges::find(for_bodies, source.body) == for_bodies.end() || n_rows_ < 2) {
      out.push_back(std::move(screened));
      continue;
    }
    const ModalBlock& block = block_of(source.body);
    std::vector<int> spin;
    for (std::size_t i = 0; i < infos.size(); ++i)
      if (infos[i].name.starts_with(source.body + ".angular_velocity_")) spin.push_back(static_cast<int>(i));
    VectorXd omega;
    const std::size_t every = std::max<std::size_t>(1, rows_.size() / kRowsForSpin);
    for (std::size_t i = 0; i < rows_.size(); i += every) {
      full_.evaluate(spin, rows_[i].s, rows_[i].v_dot, omega);
      screened.spin = std::max(screened.spin, omega.norm());
    }
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> held(
        stiffness_of(full_, block).asDiagonal().toDenseMatrix(),
        rows_.front().linearised->M.block(block.v, block.v, block.m, block.m),
        Eigen::EigenvaluesOnly | Eigen::Ax_lBx);
    screened.first_hz = hz(held.eigenvalues()(0));
    // By the ratio of the lowest free mode.
    const double damping = damping_of(full_, block)(0, 0);
    screened.ringing_time = damping > 0.0
                                ? 2.0 / damping * hz(stiffness_of(full_, block)(0)) / screened.first_hz
                                : std::numeric_limits<double>::infinity();
    screened.excitation_hz = excitation(block);
    screened.highest_hz = hz(stiffness_of(full_, block)(block.m - 1));
    change_of_stiffness(block, screened);
    out.push_back(std::move(screened));
  }
  return out;
}

}  // namespace flexura::study
