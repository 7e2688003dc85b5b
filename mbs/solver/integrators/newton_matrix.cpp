// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/newton_matrix.hpp"

#include <Eigen/KLUSupport>
#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <cmath>
#include <complex>
#include <type_traits>
#include <vector>

#include "mbs/solver/algebra/complex_factors.hpp"
#include "mbs/solver/algebra/sparse_tangents.hpp"

namespace flexura::mbs {

namespace {

// Dense factors are faster below so many unknowns, and with more than so many of the entries.  Measured,
// dense / KLU for one factorisation: closed loops (fill 0.14) 59 / 56 us at 61 unknowns, 125 / 66 us at
// 91, 7.0 / 0.84 ms at 361; separate chains (fill 0.12 to 0.5) dense up to 160 unknowns; flexible bodies on
// one another (fill 0.2) 30 / 7.5 ms for a whole step at 345.
constexpr int kSparseFrom = 60, kLarge = 160;
constexpr double kSparseBelow = 0.10, kSparseBelowIfLarge = 0.25;

// Where rows of G depend on each other (redundant, or at a dead point) the blocks of the multipliers are
// singular; this part of their scale keeps the factors finite and is far below Newton's need elsewhere.
constexpr double kOfRedundantRows = 1e-12;

}  // namespace

template <class Scalar>
struct NewtonMatrix<Scalar>::Factors {
  using Sparse = Eigen::SparseMatrix<Scalar>;

  Matrix J;
  std::conditional_t<std::is_same_v<Scalar, double>, Eigen::PartialPivLU<Matrix>, ComplexFactors> lu;
  Sparse J_sparse, z_p, h_p, G, GS, ET, TET;
  Eigen::KLU<Sparse> klu;
  std::vector<Eigen::Triplet<Scalar>> entries, of_blocks;
  std::vector<int> outer, inner;  // the pattern that KLU has analysed
  bool is_sparse = false, may_be_sparse = true;
  long structure = -1;  // of the form, for which may_be_sparse was found
};

template <class Scalar>
NewtonMatrix<Scalar>::NewtonMatrix(const StabilisedIndex2& form)
    : form_(form),
      n_(form.sizes()),
      n_z_(n_.n_v + n_.n_dyn + n_.n_alg),
      factors_(std::make_unique<Factors>()) {
  const int n_x = n_z_ + 2 * n_.n_lambda;
  row_scale_.setOnes(n_x);
  column_scale_.setOnes(n_x);
  rhs_.setZero(n_x);
  solution_.setZero(n_x);
  GS_.setZero(n_.n_v, n_.n_lambda);
  y_p_.setZero(n_.n_p);
  dp_.setZero(n_.n_p);
  dp_0_.setZero(n_.n_p);
  w_.setZero(n_.n_v);
  z_.setZero(n_z_);
  g_w_.setZero(n_.n_lambda);
}

template <class Scalar>
NewtonMatrix<Scalar>::~NewtonMatrix() = default;

// Momentum rows are divided by |cj| and the multipliers carry it, position rows are multiplied by it: all
// blocks are then of the size of M and G.
template <class Scalar>
void NewtonMatrix<Scalar>::scale(double size) {
  const Tangents& d = form_.tangents();
  const int n_v = n_.n_v, n_l = n_.n_lambda, at_l = n_z_, at_m = n_z_ + n_l;
  for (int i = 0; i < n_v; ++i) {
    const double scale = d.M(i, i) > 0.0 ? 1.0 / std::sqrt(d.M(i, i)) : 1.0;
    row_scale_(i) = scale / size;
    column_scale_(i) = scale;
  }
  row_scale_.segment(n_v, n_.n_dyn).setConstant(1.0 / size);
  length_.setZero(n_l);
  if (factors_->may_be_sparse) {
    const SparseTangents::Sparse& G = form_.sparse_tangents().G;
    for (int j = 0; j < G.outerSize(); ++j)
      for (SparseTangents::Sparse::InnerIterator it(G, j); it; ++it)
        length_(it.row()) += std::pow(it.value() * column_scale_(j), 2);
    length_ = length_.cwiseSqrt().eval();
  } else {
    for (int k = 0; k < n_l; ++k)
      length_(k) = (d.G.row(k).transpose().array() * column_scale_.head(n_v).array()).matrix().norm();
  }
  for (int k = 0; k < n_l; ++k) {
    const double scale = length_(k) > 0.0 ? 1.0 / length_(k) : 1.0;
    row_scale_(at_l + k) = scale;
    column_scale_(at_l + k) = scale * size;
    row_scale_(at_m + k) = form_.is_holonomic(k) ? scale * size : 1.0;
    column_scale_(at_m + k) = form_.is_holonomic(k) ? scale : 1.0;
  }
}

template <class Scalar>
void NewtonMatrix<Scalar>::assemble_dense(Scalar cj) {
  const Tangents& d = form_.tangents();
  inverse_.multiply_ET(d.z_p, z_v_);
  if (n_.n_lambda > 0) {
    inverse_.multiply_ET(d.h_p, h_v_);
    inverse_.multiply_TET(d.G, g_v_);
    GS_ = (form_.S().asDiagonal() * d.G.transpose()).template cast<Scalar>();
  }
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, at_l = n_z_, at_m = n_z_ + n_l;
  Matrix& J = factors_->J;
  J.setZero(n_z_ + 2 * n_l, n_z_ + 2 * n_l);
  J.topLeftCorner(n_z_, n_v) = z_v_ + d.z_v.template cast<Scalar>();
  J.topLeftCorner(n_v, n_v) += cj * d.M.template cast<Scalar>();
  J.block(0, n_v, n_z_, n_c) = d.z_c.template cast<Scalar>();
  J.block(0, n_v + n_c, n_z_, n_a) = d.z_a.template cast<Scalar>();
  // The dynamic states' residual is c' - f_c.
  if (d.c_v_dot.size() > 0) J.block(n_v, 0, n_c, n_v) += cj * d.c_v_dot.template cast<Scalar>();
  if (d.b_v_dot.size() > 0) J.block(n_v + n_c, 0, n_a, n_v) += cj * d.b_v_dot.template cast<Scalar>();
  J.block(n_v, 0, n_c, n_z_) *= -1.0;
  J.block(n_v, n_v, n_c, n_c).diagonal().array() += cj;
  if (n_l > 0) {
    J.block(0, at_l, n_v, n_l) = d.G.transpose().template cast<Scalar>();
    if (d.c_lambda.size() > 0) J.block(n_v, at_l, n_c, n_l) = -d.c_lambda.template cast<Scalar>();
    if (d.b_lambda.size() > 0) J.block(n_v + n_c, at_l, n_a, n_l) = d.b_lambda.template cast<Scalar>();
    J.block(0, at_m, n_z_, n_l).noalias() = z_v_ * GS_;
    J.block(n_v, at_m, n_c, n_l) *= -1.0;
    J.block(at_l, 0, n_l, n_v) = d.G.template cast<Scalar>() + h_v_;
    J.block(at_l, at_m, n_l, n_l).noalias() = h_v_ * GS_;
    J.block(at_m, 0, n_l, n_v) = g_v_;
    J.block(at_m, at_m, n_l, n_l).noalias() = g_v_ * GS_;
    if (d.g_c.size() > 0) {
      J.block(at_l, n_v, n_l, n_c) = d.h_c.template cast<Scalar>();
      J.block(at_m, n_v, n_l, n_c) = d.g_c.template cast<Scalar>();
    }
    for (int k = 0; k < n_l; ++k) {
      if (form_.is_holonomic(k)) continue;
      J.row(at_m + k).setZero();
      J(at_m + k, at_m + k) = 1.0;
    }
  }
  for (Eigen::Index j = 0; j < J.cols(); ++j) J.col(j).array() *= row_scale_.array() * column_scale_(j);
  for (int k = 0; k < n_l; ++k) {
    J(at_l + k, at_l + k) -= kOfRedundantRows;
    J(at_m + k, at_m + k) += kOfRedundantRows;
  }
}

// The same from what is not zero.
template <class Scalar>
void NewtonMatrix<Scalar>::assemble_sparse(Scalar cj) {
  using Sparse = typename Factors::Sparse;
  const Tangents& d = form_.tangents();
  const SparseTangents& sparse = form_.sparse_tangents();
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_l = n_.n_lambda, at_l = n_z_, at_m = n_z_ + n_l;
  Factors& f = *factors_;
  f.entries.clear();
  const auto add = [&](Eigen::Index i, Eigen::Index j, Scalar value) {
    const bool row_of_c = i >= n_v && i < n_v + n_c,
               own_row = i >= at_m && !form_.is_holonomic(static_cast<int>(i - at_m));
    if (value == Scalar(0.0) || own_row) return;
    f.entries.emplace_back(i, j, (row_of_c ? -value : value) * row_scale_(i) * column_scale_(j));
  };
  const auto add_dense = [&](int at_i, int at_j, const auto& block) {
    for (Eigen::Index j = 0; j < block.cols(); ++j)
      for (Eigen::Index i = 0; i < block.rows(); ++i) add(at_i + i, at_j + j, block(i, j));
  };
  const auto add_sparse = [&](int at_i, int at_j, const auto& block, Scalar factor) {
    for (int j = 0; j < block.outerSize(); ++j)
      for (typename std::decay_t<decltype(block)>::InnerIterator it(block, j); it; ++it)
        add(at_i + it.row(), at_j + it.col(), factor * it.value());
  };
  const auto take_blocks = [&](int rows, Sparse& out, const auto& list) {
    f.of_blocks.clear();
    list([&](int i, int j, Scalar value) { f.of_blocks.emplace_back(i, j, value); });
    out.resize(rows, n_v);
    out.setFromTriplets(f.of_blocks.begin(), f.of_blocks.end());
  };
  take_blocks(n_.n_p, f.ET, [&](auto&& to) { inverse_.entries_of_ET(to); });
  f.z_p = sparse.z_p.template cast<Scalar>();
  const Sparse z_v = f.z_p * f.ET;
  add_sparse(0, 0, z_v, 1.0);
  add_sparse(0, 0, sparse.z_v, 1.0);
  add_sparse(0, 0, sparse.M, cj);
  add_dense(0, n_v, d.z_c);
  add_dense(0, n_v + n_c, d.z_a);
  add_dense(n_v, 0, cj * d.c_v_dot.template cast<Scalar>());
  add_dense(n_v, at_l, d.c_lambda);
  add_dense(n_v + n_c, 0, cj * d.b_v_dot.template cast<Scalar>());
  add_dense(n_v + n_c, at_l, d.b_lambda);
  for (int i = n_v; i < n_v + n_c; ++i) add(i, i, -cj);
  if (n_l > 0) {
    take_blocks(n_v, f.TET, [&](auto&& to) { inverse_.entries_of_TET(to); });
    f.G = sparse.G.template cast<Scalar>();
    f.h_p = sparse.h_p.template cast<Scalar>();
    const Sparse G_T = f.G.transpose();
    f.GS = form_.S().template cast<Scalar>().asDiagonal() * G_T;
    const Sparse h_v = f.h_p * f.ET, g_v = f.G * f.TET;
    add_sparse(0, at_l, G_T, 1.0);
    add_sparse(0, at_m, Sparse(z_v * f.GS), 1.0);
    add_sparse(at_l, 0, f.G, 1.0);
    add_sparse(at_l, 0, h_v, 1.0);
    add_sparse(at_l, at_m, Sparse(h_v * f.GS), 1.0);
    add_sparse(at_m, 0, g_v, 1.0);
    add_sparse(at_m, at_m, Sparse(g_v * f.GS), 1.0);
    add_dense(at_l, n_v, d.h_c);
    add_dense(at_m, n_v, d.g_c);
    for (int k = 0; k < n_l; ++k) {
      if (!form_.is_holonomic(k)) f.entries.emplace_back(at_m + k, at_m + k, 1.0);
      f.entries.emplace_back(at_l + k, at_l + k, -kOfRedundantRows);
      f.entries.emplace_back(at_m + k, at_m + k, kOfRedundantRows);
    }
  }
  f.J_sparse.resize(n_z_ + 2 * n_l, n_z_ + 2 * n_l);
  f.J_sparse.setFromTriplets(f.entries.begin(), f.entries.end());
}

template <class Scalar>
bool NewtonMatrix<Scalar>::factor_dense() {
  Factors& f = *factors_;
  if (!f.J.allFinite()) return false;
  f.lu.compute(f.J);
  return true;
}

template <class Scalar>
bool NewtonMatrix<Scalar>::factor_sparse() {
  Factors& f = *factors_;
  const auto& J = f.J_sparse;
  if (!Eigen::Map<const Vector>(J.valuePtr(), J.nonZeros()).allFinite()) return false;
  const std::vector<int> outer(J.outerIndexPtr(), J.outerIndexPtr() + J.cols() + 1),
      inner(J.innerIndexPtr(), J.innerIndexPtr() + J.nonZeros());
  if (outer != f.outer || inner != f.inner) {
    f.klu.analyzePattern(J);
    f.outer = outer;
    f.inner = inner;
  }
  f.klu.factorize(J);
  return f.klu.info() == Eigen::Success;
}

template <class Scalar>
bool NewtonMatrix<Scalar>::factor(Scalar cj) {
  inverse_.compute(form_.kinematics(), cj);
  Factors& f = *factors_;
  if (f.structure != form_.structure()) {
    f.structure = form_.structure();
    f.may_be_sparse = row_scale_.size() >= kSparseFrom;
  }
  scale(std::abs(cj));
  f.is_sparse = false;
  if (f.may_be_sparse) {
    assemble_sparse(cj);
    const double all = static_cast<double>(f.J_sparse.rows()) * static_cast<double>(f.J_sparse.cols());
    const double below = f.J_sparse.rows() > kLarge ? kSparseBelowIfLarge : kSparseBelow;
    f.is_sparse = f.may_be_sparse = static_cast<double>(f.J_sparse.nonZeros()) < below * all;
  }
  if (f.is_sparse) return factor_sparse();
  assemble_dense(cj);
  return factor_dense();
}

template <class Scalar>
void NewtonMatrix<Scalar>::solve(const Eigen::Ref<const Vector>& rhs, Eigen::Ref<Vector> x) {
  const Tangents& d = form_.tangents();
  Factors& f = *factors_;
  const int n_p = n_.n_p, n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda;
  const auto multiply = [&](const auto& sparse, const Eigen::MatrixXd& dense, const Vector& by, Vector& out) {
    if (f.is_sparse)
      out.noalias() = sparse * by;
    else
      out.noalias() = dense * by;
  };
  // Positions: dp = E (r_p + T (dv + S G^T dmu)); what E r_p does to the other rows goes to the right.
  y_p_ = rhs.head(n_p);
  inverse_.apply_E(y_p_, dp_0_);
  multiply(f.z_p, d.z_p, dp_0_, z_);
  rhs_.head(n_z_) = rhs.segment(n_p, n_z_);
  rhs_.head(n_v) -= z_.head(n_v);
  rhs_.segment(n_v, n_c) += z_.segment(n_v, n_c);
  rhs_.segment(n_v + n_c, n_a) -= z_.tail(n_a);
  if (n_l > 0) {
    multiply(f.h_p, d.h_p, dp_0_, g_w_);
    rhs_.segment(n_z_, n_l) = rhs.segment(n_p + n_z_, n_l) - g_w_;
    rhs_.tail(n_l) = rhs.tail(n_l);
    inverse_.apply_T_inverse(dp_0_, w_);
    multiply(f.G, d.G, w_, g_w_);
    for (int k = 0; k < n_l; ++k)
      if (form_.is_holonomic(k)) rhs_(n_z_ + n_l + k) -= g_w_(k);
  }
  rhs_.array() *= row_scale_.array();
  if (f.is_sparse) {
    solution_ = f.klu.solve(rhs_);
  } else if constexpr (std::is_same_v<Scalar, double>) {
    solution_ = f.lu.solve(rhs_);
  } else {
    solution_ = rhs_;
    f.lu.solve_in_place(solution_);
  }
  solution_.array() *= column_scale_.array();
  w_ = solution_.head(n_v);
  if (n_l > 0 && f.is_sparse) w_ += f.GS * solution_.tail(n_l);
  if (n_l > 0 && !f.is_sparse) w_.noalias() += GS_ * solution_.tail(n_l);
  dp_ = dp_0_;
  inverse_.add_ET(w_, dp_);
  x.head(n_p) = dp_;
  x.segment(n_p, n_z_) = solution_.head(n_z_);
  x.tail(2 * n_l) = solution_.tail(2 * n_l);
}

template class NewtonMatrix<double>;
template class NewtonMatrix<std::complex<double>>;

}  // namespace flexura::mbs
