// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/full_model.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>

#include "mbs/superelement/contents.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::map<std::string, int> by_name(int n, const auto& name_of) {
  std::map<std::string, int> names;
  for (int i = 0; i < n; ++i) names.emplace(name_of(i), i);
  return names;
}

// Indices of the run's entries in the full model; -1 for entries that only the full one has.
std::vector<int> find_all(int n, const auto& name_of, const std::map<std::string, int>& in_run) {
  std::vector<int> from(static_cast<std::size_t>(n), -1);
  for (int i = 0; i < n; ++i)
    if (const auto found = in_run.find(name_of(i)); found != in_run.end())
      from[static_cast<std::size_t>(i)] = found->second;
  return from;
}

void gather(const std::vector<int>& from, const VectorXd& x, VectorXd& out) {
  for (std::size_t i = 0; i < from.size(); ++i) out(static_cast<Index>(i)) = from[i] >= 0 ? x(from[i]) : 0.0;
}

void scatter(const std::vector<int>& from, const VectorXd& full, VectorXd& x) {
  for (std::size_t i = 0; i < from.size(); ++i)
    if (from[i] >= 0) x(from[i]) = full(static_cast<Index>(i));
}

MatrixXd deformations_of(const superelement::Superelement& se, const MatrixXd& Y_full,
                         const MatrixXd& Y_run) {
  // Displacements and rotations weigh by their inertia.
  const VectorXd scale = se.M_se.diagonal().cwiseSqrt();
  MatrixXd basis(Y_full.rows(), Y_full.cols() + 6);
  basis << Y_full, superelement::rigid_motions(se);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(scale.asDiagonal() * basis);
  const MatrixXd scaled = scale.asDiagonal() * Y_run;
  return qr.solve(scaled).topRows(Y_full.cols());
}

}  // namespace

int deformations_of(const mbs::BodyDescription& body) {
  if (!body.is_reduced()) return 0;
  return (body.of_beam ? body.of_beam->n() : superelement::contents(body.superelement).header.n()) - 6;
}

bool can_deform(const mbs::BodyDescription& body) {
  return deformations_of(body) > 0;
}

bool has_stiffening_terms(const mbs::BodyDescription& body) {
  if (body.of_beam) return !body.follows_surface && !body.is_loaded_by_case;
  const superelement::Contents file = superelement::contents(body.superelement);
  return !body.follows_surface && file.bytes.stiffening > 0.0 &&
         (!body.is_loaded_by_case || file.stiffening_of_loads);
}

FullModel::FullModel(std::unique_ptr<mbs::Mechanism> mechanism) : mechanism_(std::move(mechanism)) {
  const auto& bodies = mechanism_->description().bodies;
  const mbs::State zero = mechanism_->initial_state();
  const auto v_names =
      by_name(mechanism_->sizes().n_v, [&](int i) { return mechanism_->name_of_velocity(i); });
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (mechanism_->modal_position(static_cast<int>(b)) < 0 || !bodies[b].is_reduced()) continue;
    ModalBlock block;
    block.body = static_cast<int>(b);
    block.name = bodies[b].name;
    block.p = mechanism_->modal_coordinates(block.body, zero) - zero.p.data();
    block.v = v_names.at(bodies[b].name + ".mode_1_rate");
    block.m = bodies[b].flexible->m();
    blocks_.push_back(std::move(block));
  }
}

std::unique_ptr<FullModel> FullModel::make(const mbs::PreparedMechanism& run, const FullScope& scope) {
  mbs::ModelChoice full;
  bool any = false;
  for (const mbs::BodyDescription& body : run.mechanism->description().bodies) {
    if (!can_deform(body) || scope.as_given.contains(body.name)) continue;
    mbs::BodyModel& model = full.bodies[body.name];
    model.coupling = "full";
    model.modes = mbs::BodyModel::kAllModes;
    if (!scope.own_frames) {
      model.frame = "mean_axis";
      model.boundary = "free";
    }
    if (scope.rigid.contains(body.name)) {
      model.fidelity = "rigid";
      continue;
    }
    any = true;
    model.fidelity =
        std::ranges::find(scope.stiffened, body.name) != scope.stiffened.end() ? "modal-stiffened" : "modal";
    if (scope.modes > 0 && scope.modes < deformations_of(body)) model.modes = scope.modes;
  }
  if (!any) return nullptr;
  auto cache = run.cache ? run.cache : std::make_shared<mbs::PreparationCache>();
  mbs::MechanismFile all = run.source->read(run.choice.with(scope.besides).with(full), *cache);
  std::vector<std::pair<int, std::string>> samples;
  int first = 0;  // controls' states are the first
  for (auto& control : all.description.controls) {
    if (auto average = control->on_the_average()) {
      samples.emplace_back(first, control->name());
      control = std::move(average);
    }
    first += control->n_states();
  }
  std::unique_ptr<FullModel> out(new FullModel(std::make_unique<mbs::Mechanism>(std::move(all.description))));
  out->samples_ = std::move(samples);
  out->cache_ = std::move(cache);
  out->take_start(run);
  return out;
}

mbs::State FullModel::state_of(const mbs::PreparedMechanism& run) const {
  mbs::State s = mechanism_->initial_state();
  const auto p_run =
      by_name(run.mechanism->sizes().n_p, [&](int i) { return run.mechanism->name_of_position(i); });
  gather(find_all(
             mechanism_->sizes().n_p, [&](int i) { return mechanism_->name_of_position(i); }, p_run),
         run.state.p, s.p);
  for (const ModalBlock& block : blocks_) s.p.segment(block.p, block.m).setZero();
  s.t = run.state.t;
  s.lambda = VectorXd::Zero(mechanism_->sizes().n_lambda);
  return s;
}

void FullModel::take_start(const mbs::PreparedMechanism& run) {
  // Only positions matter to redundancy.
  const mbs::State s = state_of(run);
  mechanism_->drop_redundant(s, s.p);
  scratch_ = mechanism_->make_scratch();
  tangents_ = std::make_unique<mbs::Tangents>(*mechanism_);
  kinematics_ = std::make_unique<mbs::KinematicBlocks>(*mechanism_, s.p);
  const mbs::Sizes n = mechanism_->sizes();
  c_rate_.resize(n.n_dyn);
  b_.resize(n.n_alg);
}

void FullModel::residual(const mbs::State& s, const VectorXd& v_dot, VectorXd& r) {
  r.resize(v_dot.size());
  mechanism_->momentum(s, v_dot, *scratch_, r, c_rate_, b_);
}

void FullModel::constraint_matrix(const mbs::State& s, MatrixXd& G) {
  const mbs::Sizes n = mechanism_->sizes();
  G.setZero(n.n_lambda, n.n_v);
  if (n.n_lambda > 0) mechanism_->constraint_matrix(s, s.p, *scratch_, G);
}

void FullModel::linearise(const mbs::State& s, const VectorXd& v_dot, LinearisedRow& row) {
  tangents_->evaluate(s, v_dot);
  kinematics_->update(s.p, s.v);
  row.M = tangents_->M;
  row.G = tangents_->G;
  row.D = tangents_->z_v.topRows(mechanism_->sizes().n_v);
  kinematics_->multiply_T(tangents_->z_p.topRows(mechanism_->sizes().n_v), row.K);
  take_states(row);
}

void FullModel::take_states(LinearisedRow& row) {
  const mbs::Sizes n = mechanism_->sizes();
  const mbs::TangentMatrices& z = *tangents_;
  row.Z_c = z.z_c.topRows(n.n_v);
  row.C_v = z.z_v.middleRows(n.n_v, n.n_dyn);
  row.C_c = z.z_c.middleRows(n.n_v, n.n_dyn);
  row.C_p.setZero(n.n_dyn, n.n_v);
  if (n.n_dyn > 0) kinematics_->multiply_T(z.z_p.middleRows(n.n_v, n.n_dyn), row.C_p);
  row.A_p.resize(0, n.n_v);
  row.A_v.resize(0, n.n_v);
  row.A_c.resize(0, n.n_dyn);
  if (n.n_alg > 0) {
    // 0 = b: A alpha + ... = 0, for which A must be regular.
    const Eigen::FullPivLU<MatrixXd> lu(z.z_a.bottomRows(n.n_alg));
    if (lu.isInvertible()) {
      MatrixXd b_p;
      kinematics_->multiply_T(z.z_p.bottomRows(n.n_alg), b_p);
      row.A_p = -lu.solve(b_p);
      row.A_v = -lu.solve(z.z_v.bottomRows(n.n_alg));
      row.A_c = -lu.solve(z.z_c.bottomRows(n.n_alg));
      const MatrixXd Z_a = z.z_a.topRows(n.n_v), C_a = z.z_a.middleRows(n.n_v, n.n_dyn);
      row.K += Z_a * row.A_p;
      row.D += Z_a * row.A_v;
      row.Z_c += Z_a * row.A_c;
      row.C_p += C_a * row.A_p;
      row.C_v += C_a * row.A_v;
      row.C_c += C_a * row.A_c;
    } else if (followed_roughly_.empty()) {
      followed_roughly_ = "algebraic states that no equation holds are taken to be those of the run";
    }
  }
  // What is like the run alone, where deformations have a way into it.
  std::vector<bool> moves(static_cast<std::size_t>(n.n_dyn));
  for (int round = 0; round <= n.n_dyn; ++round)
    for (Index k = 0; k < n.n_dyn; ++k) {
      bool any = !row.C_p.row(k).isZero(0.0) || !row.C_v.row(k).isZero(0.0);
      for (Index l = 0; l < n.n_dyn; ++l)
        any = any || (row.C_c(k, l) != 0.0 && moves[static_cast<std::size_t>(l)]);
      moves[static_cast<std::size_t>(k)] = any;
    }
  if (!followed_roughly_.empty()) return;
  for (const auto& [state, name] : samples_)
    if (moves[static_cast<std::size_t>(state)])
      followed_roughly_ =
          fmt::format("what the jumps of the sampled control {} make ring is not followed", name);
  if (mechanism_->follows_states() && std::ranges::find(moves, true) != moves.end())
    followed_roughly_ = "drives that follow controls are taken to move as they do in the run";
  if (mechanism_->algebraic_is_coupled())
    followed_roughly_ = "accelerations and reactions in formulas are taken to be those of the run";
}

void FullModel::evaluate(const std::vector<int>& which, const mbs::State& s, const VectorXd& v_dot,
                         VectorXd& y) {
  y.resize(static_cast<Index>(which.size()));
  mechanism_->evaluate(which, s, v_dot, *scratch_, y);
}

void FullModel::move(const mbs::State& s, const LinearisedRow& row, const Correction& by,
                     mbs::State& moved) const {
  moved = s;
  mechanism_->retract(s.p, by.delta, moved.p);
  moved.v += by.rate;
  if (by.dlambda.size() > 0) moved.lambda += by.dlambda;
  if (by.states.size() > 0) moved.c += by.states;
  if (row.A_p.rows() == 0) return;
  moved.a += row.A_p * by.delta + row.A_v * by.rate;
  if (by.states.size() > 0) moved.a += row.A_c * by.states;
}

namespace {

// Static bodies may have as many deformations as the full model, damped otherwise.
bool is_the_same(const mbs::ModalData& whole, const mbs::ModalData& run, const MatrixXd& S) {
  if (S.rows() != S.cols() || whole.coupling != run.coupling ||
      whole.second.has_value() != run.second.has_value())
    return false;
  const MatrixXd of_run = run.damping_matrix(), damping = S.transpose() * whole.damping_matrix() * S;
  // S is right to round-off times the condition of the basis.
  return (damping - of_run).norm() <= 1e-6 * of_run.norm();
}

}  // namespace

Embedding::Embedding(const mbs::Mechanism& run, const FullModel& full)
    : run_(run), full_(full), scratch_(run.make_scratch()) {
  const mbs::Mechanism& all = full.mechanism();
  const mbs::Sizes n = all.sizes(), n_run = run.sizes();
  const auto take = [](int size, int size_run, const auto& name, const auto& name_run) {
    return find_all(size, name, by_name(size_run, name_run));
  };
  p_from_ = take(
      n.n_p, n_run.n_p, [&](int i) { return all.name_of_position(i); },
      [&](int i) { return run.name_of_position(i); });
  v_from_ = take(
      n.n_v, n_run.n_v, [&](int i) { return all.name_of_velocity(i); },
      [&](int i) { return run.name_of_velocity(i); });
  c_from_ = take(
      n.n_dyn, n_run.n_dyn, [&](int i) { return all.name_of_dynamic(i); },
      [&](int i) { return run.name_of_dynamic(i); });
  lambda_from_ = take(
      n.n_lambda, n_run.n_lambda, [&](int i) { return all.name_of_constraint(i); },
      [&](int i) { return run.name_of_constraint(i); });
  r_.resize(n_run.n_v);
  c_rate_.resize(n_run.n_dyn);
  b_.resize(n_run.n_alg);
  const mbs::State zero = run.initial_state();
  const auto v_run = by_name(n_run.n_v, [&](int i) { return run.name_of_velocity(i); });
  for (const ModalBlock& block : full.blocks()) {
    // Modal coordinates go by their shapes, not by their numbers.
    std::fill_n(p_from_.begin() + block.p, block.m, -1);
    std::fill_n(v_from_.begin() + block.v, block.m, -1);
    Block mine;
    mine.S.resize(block.m, 0);
    if (const mbs::FlexibleBody* deforms = run.deforming(block.body)) {
      mine.one_way = !deforms->acts_back();
      const double* const at = run.modal_coordinates(block.body, zero);
      mine.at = at - (mine.one_way ? zero.c.data() : zero.p.data());
      mine.rate_at = mine.one_way ? mine.at + deforms->m() : v_run.at(block.name + ".mode_1_rate");
      const auto& whole = all.description().bodies[static_cast<std::size_t>(block.body)];
      const auto se = whole.of_beam ? whole.of_beam : full.cache_->read(whole.superelement, {});
      mine.S = deformations_of(*se, whole.flexible->modal()->Y, deforms->modal()->Y);
      mine.complete = !mine.one_way && is_the_same(*whole.flexible->modal(), *deforms->modal(), mine.S);
    }
    blocks_.push_back(std::move(mine));
  }
}

void Embedding::embed(const mbs::State& run, const VectorXd& run_v_dot, mbs::State& full,
                      VectorXd& full_v_dot) {
  const mbs::Sizes n = full_.mechanism().sizes();
  full.t = run.t;
  full.p.resize(n.n_p);
  full.v.resize(n.n_v);
  full.c.resize(n.n_dyn);
  full.lambda.resize(n.n_lambda);
  full_v_dot.resize(n.n_v);
  gather(p_from_, run.p, full.p);
  gather(v_from_, run.v, full.v);
  gather(v_from_, run_v_dot, full_v_dot);
  gather(c_from_, run.c, full.c);
  gather(lambda_from_, run.lambda, full.lambda);
  full.a = run.a;
  full.root = run.root;
  bool rates_known = false;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const ModalBlock& block = full_.blocks()[i];
    const Block& mine = blocks_[i];
    const Index m = mine.S.cols();
    if (m == 0) continue;
    if (mine.one_way && !rates_known) {
      run_.momentum(run, run_v_dot, *scratch_, r_, c_rate_, b_);
      rates_known = true;
    }
    const VectorXd &position = mine.one_way ? run.c : run.p, &rate = mine.one_way ? run.c : run.v;
    full.p.segment(block.p, block.m).noalias() = mine.S * position.segment(mine.at, m);
    full.v.segment(block.v, block.m).noalias() = mine.S * rate.segment(mine.rate_at, m);
    full_v_dot.segment(block.v, block.m).noalias() =
        mine.S * (mine.one_way ? c_rate_ : run_v_dot).segment(mine.rate_at, m);
  }
}

void Embedding::project(const mbs::State& full, const VectorXd& full_v_dot, mbs::State& run,
                        VectorXd& run_v_dot) const {
  run.t = full.t;
  run_v_dot = VectorXd::Zero(run_.sizes().n_v);
  scatter(p_from_, full.p, run.p);
  scatter(v_from_, full.v, run.v);
  scatter(v_from_, full_v_dot, run_v_dot);
  scatter(c_from_, full.c, run.c);
  scatter(lambda_from_, full.lambda, run.lambda);
  run.a = full.a;
  run.root = full.root;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const ModalBlock& block = full_.blocks()[i];
    const Block& mine = blocks_[i];
    const Index m = mine.S.cols();
    if (m == 0) continue;
    // Both bases are orthonormal in the body's mass, so that the columns of S are, too (but for the rigid
    // part of a joint-fixed frame).
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(mine.S);
    VectorXd &position = mine.one_way ? run.c : run.p, &rate = mine.one_way ? run.c : run.v;
    position.segment(mine.at, m) = qr.solve(full.p.segment(block.p, block.m));
    rate.segment(mine.rate_at, m) = qr.solve(full.v.segment(block.v, block.m));
    if (!mine.one_way) run_v_dot.segment(mine.rate_at, m) = qr.solve(full_v_dot.segment(block.v, block.m));
  }
}

}  // namespace flexura::study
