// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/problem.hpp"

#include <fmt/format.h>

#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "beam/ancf/element/strain.hpp"

namespace flexura::beam::ancf {

int Problem::n_lambda() const {
  int n = 0;
  for (const auto& constraint : constraints) n += constraint->rows();
  return n;
}

std::vector<char> Problem::free_coordinates() const {
  std::vector<char> free(body->n_q(), 1);
  const auto take = [&](int coordinate) {
    if (coordinate < 0 || coordinate >= body->n_q())
      throw std::invalid_argument(fmt::format("coordinate {} is fixed or driven, but the body has 0 to {}.",
                                              coordinate, body->n_q() - 1));
    if (!free[coordinate])
      throw std::invalid_argument(fmt::format("coordinate {} is fixed or driven twice.", coordinate));
    free[coordinate] = 0;
  };
  for (const int coordinate : fixed) take(coordinate);
  for (const Drive& drive : drives) take(drive.coordinate);
  return free;
}

Load proportional_load(Eigen::VectorXd load) {
  return
      [load = std::move(load)](double t, const Eigen::VectorXd&, VectorRef f, Triplets*) { f += t * load; };
}

Load constant_load(Eigen::VectorXd load) {
  return [load = std::move(load)](double, const Eigen::VectorXd&, VectorRef f, Triplets*) { f += load; };
}

ProblemScratch::ProblemScratch(const Problem& problem)
    : element(problem.body->make_scratch()),
      K(problem.body->n_nodes(), problem.body->node_coordinates()),
      D(K) {
  if (problem.spin.isZero(0.0)) return;
  const int d = problem.body->dim();
  if (d == 2 && (problem.spin[0] != 0.0 || problem.spin[1] != 0.0))
    throw std::invalid_argument("a planar line can spin about z only.");
  const Eigen::Matrix3d w = cross_matrix(problem.spin), w2 = w * w;
  centrifugal = problem.body->mass_times(w2.topLeftCorner(d, d));
  coriolis = problem.body->mass_times(2 * w.topLeftCorner(d, d));
}

void evaluate(const Problem& problem, double t, const Eigen::VectorXd& q, const Eigen::VectorXd* v,
              const Eigen::VectorXd& lambda, ProblemScratch& scratch, Evaluation& out,
              const Eigen::VectorXd* q_before) {
  const AncfBody& body = *problem.body;
  out.r.resize(body.n_q());
  out.K.clear();
  out.D.clear();
  out.G.clear();
  body.force_and_tangents(q, v, scratch.element, out.r, scratch.K, scratch.D, q_before);
  scratch.K.append_to(out.K);
  scratch.D.append_to(out.D);
  if (!problem.spin.isZero(0.0)) {
    scratch.centrifugal.multiply_add(1.0, q, out.r);
    scratch.centrifugal.append_to(out.K);
    if (v) scratch.coriolis.multiply_add(1.0, *v, out.r);
    scratch.coriolis.append_to(out.D);
  }
  Eigen::VectorXd F = Eigen::VectorXd::Zero(body.n_q());
  const std::size_t before = out.K.size();
  for (const Load& load : problem.loads) load(t, q, F, &out.K);
  // A load stands on the right-hand side: its derivative enters with a minus.
  for (std::size_t i = before; i < out.K.size(); ++i)
    out.K[i] = {out.K[i].row(), out.K[i].col(), -out.K[i].value()};
  out.r -= F;

  out.g.resize(problem.n_lambda());
  int row = 0;
  for (const auto& constraint : problem.constraints) {
    const std::size_t first = out.G.size();
    constraint->evaluate(t, q, out.g.segment(row, constraint->rows()), &out.G);
    for (std::size_t i = first; i < out.G.size(); ++i) {
      auto& entry = out.G[i];
      entry = {entry.row() + row, entry.col(), entry.value()};
      out.r[entry.col()] += entry.value() * lambda[entry.row()];
    }
    constraint->add_hessian(t, q, lambda.segment(row, constraint->rows()), out.K);
    row += constraint->rows();
  }
}

struct SaddleSolver::Factor {
  std::vector<int> column;  // of a coordinate in the reduced matrix, or -1
  int n_free = 0, n_lambda = 0;
  Eigen::VectorXd scale;  // symmetric equilibration: stretch and bending differ by many orders
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu;
};

SaddleSolver::SaddleSolver(std::vector<char> free, int n_lambda) : factor_(std::make_unique<Factor>()) {
  factor_->n_lambda = n_lambda;
  for (const char is_free : free) factor_->column.push_back(is_free ? factor_->n_free++ : -1);
}
SaddleSolver::~SaddleSolver() = default;

bool SaddleSolver::factor(const Triplets& S, const Triplets& G) {
  const int n = factor_->n_free, size = n + factor_->n_lambda;
  Triplets reduced;
  reduced.reserve(S.size() + 2 * G.size());
  for (const auto& entry : S) {
    const int i = factor_->column[entry.row()], j = factor_->column[entry.col()];
    if (i >= 0 && j >= 0) reduced.emplace_back(i, j, entry.value());
  }
  for (const auto& entry : G) {
    const int j = factor_->column[entry.col()];
    if (j < 0) continue;
    reduced.emplace_back(n + entry.row(), j, entry.value());
    reduced.emplace_back(j, n + entry.row(), entry.value());
  }
  Eigen::SparseMatrix<double> A(size, size);
  A.setFromTriplets(reduced.begin(), reduced.end());
  // Rows of S by their diagonal, then constraint rows by what is left of them.
  Eigen::VectorXd& scale = factor_->scale;
  scale.setOnes(size);
  for (int i = 0; i < n; ++i)
    if (const double d = std::abs(A.coeff(i, i)); d > 0.0) scale[i] = 1 / std::sqrt(d);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(size);
  for (int j = 0; j < n; ++j)
    for (Eigen::SparseMatrix<double>::InnerIterator it(A, j); it; ++it)
      if (it.row() >= n) largest[it.row()] = std::max(largest[it.row()], std::abs(it.value()) * scale[j]);
  for (int i = n; i < size; ++i)
    if (largest[i] > 0.0) scale[i] = 1 / largest[i];
  A = scale.asDiagonal() * A * scale.asDiagonal();
  A.makeCompressed();
  factor_->lu.compute(A);
  return factor_->lu.info() == Eigen::Success;
}

void SaddleSolver::solve(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::VectorXd& dq,
                         Eigen::VectorXd& dlambda) const {
  const int n = factor_->n_free;
  Eigen::VectorXd x(n + factor_->n_lambda);
  for (std::size_t i = 0; i < factor_->column.size(); ++i)
    if (factor_->column[i] >= 0) x[factor_->column[i]] = a[i];
  x.tail(factor_->n_lambda) = b;
  x = factor_->lu.solve(x.cwiseProduct(factor_->scale)).cwiseProduct(factor_->scale).eval();
  dq.setZero(a.size());
  for (std::size_t i = 0; i < factor_->column.size(); ++i)
    if (factor_->column[i] >= 0) dq[i] = x[factor_->column[i]];
  dlambda = x.tail(factor_->n_lambda);
}

}  // namespace flexura::beam::ancf
