// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/stabilised_index2.hpp"

#include <Eigen/KLUSupport>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <cmath>

#include "mbs/solver/finite.hpp"

namespace flexura::mbs {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

// From where on KLU is tried in place of dense factors: estimates, not yet measured against each other.
constexpr int kSparseFrom = 120;
constexpr double kSparseBelow = 0.15;  // of all entries

}  // namespace

struct StabilisedIndex2::Factor {
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;
  Eigen::KLU<Sparse> klu;
  Sparse J, z_p, h_p, G, GS;
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<int> outer, inner;  // the pattern that KLU has analysed
  bool is_sparse = false, may_be_sparse = true;
};

StabilisedIndex2::StabilisedIndex2(const Equations& eq, const State& start)
    : eq_(eq),
      n_(eq.sizes()),
      n_y_(n_.n_p + n_.n_v + n_.n_dyn + n_.n_alg + 2 * n_.n_lambda),
      scratch_(eq.make_scratch()),
      s_(start),
      kinematics_(eq, start.p),
      tangents_(eq),
      factor_(std::make_unique<Factor>()) {
  const int n_z = n_.n_v + n_.n_dyn + n_.n_alg, n_x = n_z + 2 * n_.n_lambda;
  w_.setZero(n_.n_v);
  v_dot_.setZero(n_.n_v);
  z_.setZero(n_z);
  row_scale_.setOnes(n_x);
  column_scale_.setOnes(n_x);
  rhs_.setZero(n_x);
  solution_.setZero(n_x);
  dp_.setZero(n_.n_p);
  dp_0_.setZero(n_.n_p);
  g_w_.setZero(n_.n_lambda);
  GS_.setZero(n_.n_v, n_.n_lambda);
  S_.setOnes(n_.n_v);
  for (int k = 0; k < n_.n_lambda; ++k) holonomic_.push_back(eq.is_holonomic(k));
  set_start(start);
}

StabilisedIndex2::~StabilisedIndex2() = default;

void StabilisedIndex2::set_start(const State& s) {
  s_ = s;
  forget_structure();
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
  eq_.kinematic(s_.p, w_, dp_0_);
  out.head(n_.n_p) = yp.head(n_.n_p) - dp_0_;
  out.segment(at_v(), n_.n_v) = z_.head(n_.n_v);
  out.segment(at_c(), n_.n_dyn) = yp.segment(at_c(), n_.n_dyn) - z_.segment(n_.n_v, n_.n_dyn);
  out.segment(at_a(), n_.n_alg) = z_.tail(n_.n_alg);
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!holonomic_[k]) out(at_mu() + k) = mu(k);
  if (out.allFinite()) return true;
  non_finite_ = describe_non_finite(eq_, t, z_.head(n_.n_v), z_.segment(n_.n_v, n_.n_dyn), z_.tail(n_.n_alg));
  return false;
}

void StabilisedIndex2::forget_structure() {
  tangents_.forget_structure();
  factor_->may_be_sparse = true;
}

bool StabilisedIndex2::is_sparse() const {
  return factor_->is_sparse;
}

// Momentum rows are divided by cj and the multipliers carry it, position rows are multiplied by cj: all
// blocks are then of the size of M and G.
void StabilisedIndex2::scale(double cj) {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, n_z = n_v + n_c + n_a;
  const Tangents& d = tangents_;
  for (int i = 0; i < n_v; ++i) {
    const double scale = d.M(i, i) > 0.0 ? 1.0 / std::sqrt(d.M(i, i)) : 1.0;
    row_scale_(i) = scale / cj;
    column_scale_(i) = scale;
  }
  row_scale_.segment(n_v, n_c).setConstant(1.0 / cj);
  column_scale_.segment(n_v, n_c).setOnes();
  row_scale_.segment(n_v + n_c, n_a).setOnes();
  column_scale_.segment(n_v + n_c, n_a).setOnes();
  for (int k = 0; k < n_l; ++k) {
    const double norm = (d.G.row(k).transpose().array() * column_scale_.head(n_v).array()).matrix().norm();
    const double scale = norm > 0.0 ? 1.0 / norm : 1.0;
    row_scale_(n_z + k) = scale;
    column_scale_(n_z + k) = scale * cj;
    const bool has_positions = holonomic_[k];
    row_scale_(n_z + n_l + k) = has_positions ? scale * cj : 1.0;
    column_scale_(n_z + n_l + k) = has_positions ? scale : 1.0;
  }
}

void StabilisedIndex2::assemble_dense() {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, n_z = n_v + n_c + n_a;
  const Tangents& d = tangents_;
  J_.setZero(n_z + 2 * n_l, n_z + 2 * n_l);
  J_.topLeftCorner(n_z, n_v) = z_v_ + d.z_v;
  J_.topLeftCorner(n_v, n_v) += cj_ * d.M;
  J_.block(0, n_v, n_z, n_c) = d.z_c;
  J_.block(0, n_v + n_c, n_z, n_a) = d.z_a;
  // The dynamic states' residual is c' - f_c.
  J_.block(n_v, 0, n_c, n_z) *= -1.0;
  J_.block(n_v, n_v, n_c, n_c).diagonal().array() += cj_;
  if (n_l > 0) {
    const int at_l = n_z, at_m = n_z + n_l;
    J_.block(0, at_l, n_v, n_l) = d.G.transpose();
    J_.block(0, at_m, n_z, n_l).noalias() = z_v_ * GS_;
    J_.block(n_v, at_m, n_c, n_l) *= -1.0;
    J_.block(at_l, 0, n_l, n_v) = d.G + h_v_;
    J_.block(at_l, at_m, n_l, n_l).noalias() = h_v_ * GS_;
    J_.block(at_m, 0, n_l, n_v) = g_v_;
    J_.block(at_m, at_m, n_l, n_l).noalias() = g_v_ * GS_;
    for (int k = 0; k < n_l; ++k) {
      if (holonomic_[k]) continue;
      J_.row(at_m + k).setZero();
      J_(at_m + k, at_m + k) = 1.0;
    }
  }
  J_ = row_scale_.asDiagonal() * J_ * column_scale_.asDiagonal();
  // Where rows of G depend on each other (redundant, or at a dead point) the blocks of the multipliers are
  // singular; 1e-12 of their scale keeps the factors finite and is far below Newton's need elsewhere.
  for (int k = 0; k < n_l; ++k) {
    J_(n_z + k, n_z + k) -= 1e-12;
    J_(n_z + n_l + k, n_z + n_l + k) += 1e-12;
  }
}

// The same entry by entry.
void StabilisedIndex2::assemble_sparse() {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, n_z = n_v + n_c + n_a;
  const Tangents& d = tangents_;
  Factor& f = *factor_;
  f.entries.clear();
  const auto add = [&](Eigen::Index i, Eigen::Index j, double value) {
    const bool row_of_c = i >= n_v && i < n_v + n_c, own_row = i >= n_z + n_l && !holonomic_[i - n_z - n_l];
    if (value == 0.0 || own_row) return;
    f.entries.emplace_back(i, j, (row_of_c ? -value : value) * row_scale_(i) * column_scale_(j));
  };
  const auto add_dense = [&](int at_i, int at_j, const auto& block) {
    for (Eigen::Index j = 0; j < block.cols(); ++j)
      for (Eigen::Index i = 0; i < block.rows(); ++i) add(at_i + i, at_j + j, block(i, j));
  };
  const auto add_sparse = [&](int at_i, int at_j, const Sparse& block) {
    for (int j = 0; j < block.outerSize(); ++j)
      for (Sparse::InnerIterator it(block, j); it; ++it) add(at_i + it.row(), at_j + it.col(), it.value());
  };
  add_dense(0, 0, z_v_);
  add_dense(0, 0, d.z_v);
  for (int j = 0; j < n_v; ++j)
    for (int i = 0; i < n_v; ++i) add(i, j, cj_ * d.M(i, j));
  add_dense(0, n_v, d.z_c);
  add_dense(0, n_v + n_c, d.z_a);
  for (int i = n_v; i < n_v + n_c; ++i) add(i, i, -cj_);
  if (n_l > 0) {
    const int at_l = n_z, at_m = n_z + n_l;
    f.GS = GS_.sparseView();
    f.G = d.G.sparseView();
    const Sparse z_v = z_v_.sparseView(), h_v = h_v_.sparseView(), g_v = g_v_.sparseView();
    add_sparse(0, at_l, Sparse(f.G.transpose()));
    add_sparse(0, at_m, Sparse(z_v * f.GS));
    add_sparse(at_l, 0, f.G);
    add_sparse(at_l, 0, h_v);
    add_sparse(at_l, at_m, Sparse(h_v * f.GS));
    add_sparse(at_m, 0, g_v);
    add_sparse(at_m, at_m, Sparse(g_v * f.GS));
    for (int k = 0; k < n_l; ++k) {
      if (!holonomic_[k]) f.entries.emplace_back(at_m + k, at_m + k, 1.0);
      f.entries.emplace_back(at_l + k, at_l + k, -1e-12);
      f.entries.emplace_back(at_m + k, at_m + k, 1e-12);
    }
  }
  f.J.resize(n_z + 2 * n_l, n_z + 2 * n_l);
  f.J.setFromTriplets(f.entries.begin(), f.entries.end());
  f.z_p = d.z_p.sparseView();
  f.h_p = d.h_p.sparseView();
}

bool StabilisedIndex2::factor(double t, double cj, ConstVectorRef y, ConstVectorRef yp, TangentScope scope) {
  const int n_l = n_.n_lambda;
  unpack(t, y, s_);
  v_dot_ = yp.segment(at_v(), n_.n_v);
  cj_ = cj;
  tangents_.evaluate(s_, v_dot_, scope);
  kinematics_.update(s_.p, s_.v);
  kinematics_.invert(cj);
  const Tangents& d = tangents_;
  kinematics_.multiply_ET(d.z_p, z_v_);
  if (n_l > 0) {
    kinematics_.multiply_ET(d.h_p, h_v_);
    kinematics_.multiply_TET(d.G, g_v_);
    GS_.noalias() = S_.asDiagonal() * d.G.transpose();
  }
  scale(cj);
  Factor& f = *factor_;
  const auto n_x = row_scale_.size();
  f.is_sparse = false;
  if (n_x >= kSparseFrom && f.may_be_sparse) {
    assemble_sparse();
    f.is_sparse = f.may_be_sparse =
        static_cast<double>(f.J.nonZeros()) < kSparseBelow * static_cast<double>(n_x * n_x);
  }
  if (!f.is_sparse) {
    assemble_dense();
    if (!J_.allFinite()) return false;
    f.lu.compute(J_);
    return true;
  }
  if (!Eigen::Map<const Eigen::VectorXd>(f.J.valuePtr(), f.J.nonZeros()).allFinite()) return false;
  const std::vector<int> outer(f.J.outerIndexPtr(), f.J.outerIndexPtr() + n_x + 1),
      inner(f.J.innerIndexPtr(), f.J.innerIndexPtr() + f.J.nonZeros());
  if (outer != f.outer || inner != f.inner) {
    f.klu.analyzePattern(f.J);
    f.outer = outer;
    f.inner = inner;
  }
  f.klu.factorize(f.J);
  return f.klu.info() == Eigen::Success;
}

void StabilisedIndex2::solve(ConstVectorRef rhs, VectorRef x) {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, n_z = n_v + n_c + n_a;
  // Positions: dp = E (r_p + T (dv + S G^T dmu)); what E r_p does to the other rows goes to the right.
  kinematics_.apply_E(rhs.head(n_.n_p), dp_0_);
  const Tangents& d = tangents_;
  if (factor_->is_sparse)
    z_.noalias() = factor_->z_p * dp_0_;
  else
    z_.noalias() = d.z_p * dp_0_;
  rhs_.head(n_z) = rhs.segment(at_v(), n_z);
  rhs_.head(n_v) -= z_.head(n_v);
  rhs_.segment(n_v, n_c) += z_.segment(n_v, n_c);
  rhs_.segment(n_v + n_c, n_a) -= z_.tail(n_a);
  if (n_l > 0) {
    rhs_.segment(n_z, n_l) = rhs.segment(at_lambda(), n_l);
    if (factor_->is_sparse)
      rhs_.segment(n_z, n_l) -= factor_->h_p * dp_0_;
    else
      rhs_.segment(n_z, n_l).noalias() -= d.h_p * dp_0_;
    rhs_.tail(n_l) = rhs.tail(n_l);
    kinematics_.apply_T_inverse(dp_0_, w_);
    if (factor_->is_sparse)
      g_w_.noalias() = factor_->G * w_;
    else
      g_w_.noalias() = d.G * w_;
    for (int k = 0; k < n_l; ++k)
      if (holonomic_[k]) rhs_(n_z + n_l + k) -= g_w_(k);
  }
  rhs_.array() *= row_scale_.array();
  if (factor_->is_sparse)
    solution_ = factor_->klu.solve(rhs_);
  else
    solution_ = factor_->lu.solve(rhs_);
  rhs_ = solution_.cwiseProduct(column_scale_);
  w_ = rhs_.head(n_v);
  if (n_l > 0 && factor_->is_sparse) w_ += factor_->GS * rhs_.tail(n_l);
  if (n_l > 0 && !factor_->is_sparse) w_.noalias() += GS_ * rhs_.tail(n_l);
  dp_ = dp_0_;
  kinematics_.add_ET(w_, dp_);
  x.head(n_.n_p) = dp_;
  x.segment(at_v(), n_z) = rhs_.head(n_z);
  x.segment(at_lambda(), 2 * n_l) = rhs_.tail(2 * n_l);
}

}  // namespace flexura::mbs
