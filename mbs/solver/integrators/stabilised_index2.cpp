// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/stabilised_index2.hpp"

#include "mbs/solver/algebra/finite.hpp"
#include "mbs/solver/algebra/sparse_tangents.hpp"

namespace flexura::mbs {

StabilisedIndex2::StabilisedIndex2(const Equations& eq, const State& start)
    : eq_(eq),
      n_(eq.sizes()),
      n_y_(n_.n_p + n_.n_v + n_.n_dyn + n_.n_alg + 2 * n_.n_lambda),
      scratch_(eq.make_scratch()),
      s_(start),
      kinematics_(eq, start.p),
      tangents_(eq) {
  w_.setZero(n_.n_v);
  v_dot_.setZero(n_.n_v);
  z_.setZero(n_.n_v + n_.n_dyn + n_.n_alg);
  p_dot_.setZero(n_.n_p);
  S_.setOnes(n_.n_v);
  set_start(start);
}

StabilisedIndex2::~StabilisedIndex2() = default;

void StabilisedIndex2::set_start(const State& s) {
  s_ = s;
  forget_structure();
  holonomic_.clear();
  for (int k = 0; k < n_.n_lambda; ++k) holonomic_.push_back(eq_.is_holonomic(k));
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n_.n_v, n_.n_v);
  eq_.mass_matrix(s.p, *scratch_, M);
  for (int i = 0; i < n_.n_v; ++i) S_(i) = M(i, i) > 0.0 ? 1.0 / M(i, i) : 1.0;
}

void StabilisedIndex2::pack(const State& s, const Eigen::VectorXd& v_dot, VectorRef y, VectorRef yp) {
  y << s.p, s.v, s.c, s.a, s.lambda, Eigen::VectorXd::Zero(n_.n_lambda);
  yp.setZero();
  eq_.kinematic(s.p, s.v, yp.head(n_.n_p));
  yp.segment(at_v(), n_.n_v) = v_dot;
  eq_.momentum(s, v_dot, *scratch_, w_, z_.segment(n_.n_v, n_.n_dyn), z_.tail(n_.n_alg));
  yp.segment(at_c(), n_.n_dyn) = z_.segment(n_.n_v, n_.n_dyn);
}

void StabilisedIndex2::unpack(double t, ConstVectorRef y, State& s) const {
  s.t = t;
  s.p = y.head(n_.n_p);
  s.v = y.segment(at_v(), n_.n_v);
  s.c = y.segment(at_c(), n_.n_dyn);
  s.a = y.segment(at_a(), n_.n_alg);
  s.lambda = y.segment(at_lambda(), n_.n_lambda);
  s.root = s_.root;
  s.u = s_.u;
}

bool StabilisedIndex2::residual(double t, ConstVectorRef y, ConstVectorRef yp, VectorRef out) {
  unpack(t, y, s_);
  const auto mu = y.tail(n_.n_lambda);
  v_dot_ = yp.segment(at_v(), n_.n_v);
  eq_.residuals(s_, v_dot_, mu, *scratch_, z_.head(n_.n_v), z_.segment(n_.n_v, n_.n_dyn), z_.tail(n_.n_alg),
                out.segment(at_lambda(), n_.n_lambda), out.tail(n_.n_lambda), w_);
  ++evaluations_;
  if (n_.n_lambda > 0)
    w_ = s_.v + S_.cwiseProduct(w_);
  else
    w_ = s_.v;
  eq_.kinematic(s_.p, w_, p_dot_);
  out.head(n_.n_p) = yp.head(n_.n_p) - p_dot_;
  out.segment(at_v(), n_.n_v) = z_.head(n_.n_v);
  out.segment(at_c(), n_.n_dyn) = yp.segment(at_c(), n_.n_dyn) - z_.segment(n_.n_v, n_.n_dyn);
  out.segment(at_a(), n_.n_alg) = z_.tail(n_.n_alg);
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!holonomic_[k]) out(at_mu() + k) = mu(k);
  if (out.allFinite()) return true;
  non_finite_ = describe_non_finite(eq_, t, z_.head(n_.n_v), z_.segment(n_.n_v, n_.n_dyn), z_.tail(n_.n_alg));
  return false;
}

void StabilisedIndex2::linearise(double t, ConstVectorRef y, ConstVectorRef yp, TangentScope scope) {
  unpack(t, y, s_);
  v_dot_ = yp.segment(at_v(), n_.n_v);
  tangents_.evaluate(s_, v_dot_, scope);
  sparse_.reset();
  kinematics_.update(s_.p, s_.v);
}

void StabilisedIndex2::carry_along() {
  kinematics_.carry_along(s_.p, s_.v);
}

const SparseTangents& StabilisedIndex2::sparse_tangents() const {
  if (!sparse_) sparse_ = std::make_unique<SparseTangents>(tangents_);
  return *sparse_;
}

void StabilisedIndex2::multiply_M(ConstVectorRef x, VectorRef out) const {
  if (sparse_)
    out.noalias() = sparse_->M * x;
  else
    out.noalias() = tangents_.M * x;
}

void StabilisedIndex2::multiply_rates(const Eigen::VectorXd& x, Eigen::VectorXd& out) const {
  out = x;
  multiply_M(x.segment(at_v(), n_.n_v), out.segment(at_v(), n_.n_v));
  if (const Eigen::MatrixXd& c_v_dot = tangents_.c_v_dot; c_v_dot.size() > 0)
    out.segment(at_c(), c_v_dot.rows()).noalias() -= c_v_dot * x.segment(at_v(), n_.n_v);
  out.tail(n_y_ - at_a()).setZero();
  if (const Eigen::MatrixXd& b_v_dot = tangents_.b_v_dot; b_v_dot.size() > 0)
    out.segment(at_a(), n_.n_alg).noalias() = b_v_dot * x.segment(at_v(), n_.n_v);
}

void StabilisedIndex2::forget_structure() {
  ++structure_;
}

}  // namespace flexura::mbs
