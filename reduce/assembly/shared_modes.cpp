// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/shared_modes.hpp"

#include <Eigen/LU>
#include <memory>
#include <stdexcept>

#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/factor/row_exchange.hpp"

namespace flexura::reduce {
namespace {

using Eigen::MatrixXd;
using Eigen::Ref;
using linalg::DistributedFactor;
using linalg::EigenPairs;
using linalg::EigenRequest;
using linalg::RowExchange;
using linalg::RowShares;
using linalg::Team;

void share(const Team& team, MatrixXd& small) {
  int rows = static_cast<int>(small.rows()), cols = static_cast<int>(small.cols());
  team.share(rows);
  team.share(cols);
  small.resize(rows, cols);
  team.share({small.data(), static_cast<std::size_t>(small.size())});
}

MatrixXd sum_of(const Team& team, MatrixXd terms) {
  team.sum({terms.data(), static_cast<std::size_t>(terms.size())});
  return terms;
}

// This rank's rows of the border that tied_solver.hpp puts around the factorised matrix.
struct Border {
  MatrixXd V, Z, At;  // n_own x (n_a + n_p), likewise, n_own x n_a
  Eigen::PartialPivLU<MatrixXd> small, AAt;

  // Rank 0 has the whole of it.
  Border(const Team& team, const RowShares& rows, const TiedSolver* solver) {
    const TiedSolver::Border whole = solver ? solver->border() : TiedSolver::Border{};
    MatrixXd S = whole.small;
    share(team, S);
    if (S.size() == 0) return;
    V = scatter_rows(team, rows, whole.V);
    Z = scatter_rows(team, rows, whole.Z);
    At = scatter_rows(team, rows, whole.V.leftCols(whole.n_averages));
    small.compute(S);
    if (At.cols() > 0) AAt.compute(sum_of(team, At.transpose() * At));
  }
  bool empty() const { return V.cols() == 0; }
};

// The rows that a rank's elements, masses and links meet.
std::vector<int> touched_rows(const TiedMatrices& share) {
  const linalg::SymmetricMatrix both = share.shifted_stiffness(1.0);
  const linalg::UpperCsr csr = both.csr();
  std::vector<bool> met(static_cast<std::size_t>(csr.n), false);
  for (int i = 0; i < csr.n; ++i)
    for (int k = csr.row_begin[i]; k < csr.row_begin[i + 1]; ++k)
      if (csr.values[k] != 0.0) met[i] = met[csr.columns[k]] = true;
  std::vector<int> rows;
  for (int i = 0; i < csr.n; ++i)
    if (met[i]) rows.push_back(i);
  return rows;
}

// Products of a rank's share with vectors of which it owns some rows.
template <class Product>
linalg::EigenProblem::Operator shared(const RowExchange& exchange, Product product) {
  return [&exchange, product](const Ref<const MatrixXd>& X, MatrixXd& Y) {
    MatrixXd parts;
    product(exchange.spread(X), parts);
    Y = exchange.collect(parts);
  };
}

// This rank's rows of what shifted_solver.hpp does for one process; all ranks make it together.
struct SharedShift {
  std::unique_ptr<DistributedFactor> L;
  MatrixXd Z;
  Eigen::PartialPivLU<MatrixXd> small;
  int n_below = 0;

  SharedShift(const Team& team, const TiedMatrices& own, const RowShares& rows, const MatrixXd& At,
              double sigma)
      : L(std::make_unique<DistributedFactor>(team, own.shifted_stiffness(-sigma).csr(), rows)),
        n_below(L->n_negative()) {
    if (L->n_zero() > 0) throw std::runtime_error("the shift is too close to an eigenvalue of the structure");
    if (At.cols() == 0) return;
    L->solve_own(At, Z);
    const MatrixXd S = sum_of(team, At.transpose() * Z);
    small.compute(S);
    const Eigen::VectorXd values = linalg::symmetric_eigen(-0.5 * (S + S.transpose())).values;
    n_below += static_cast<int>((values.array() < 0.0).count()) - static_cast<int>(At.cols());
  }
};

// Collective: what all ranks do together.  Rank 0 gives `solver`, the request and `krylov_schur`.
EigenPairs find(const Team& team, const TiedMatrices& own, const RowShares& rows,
                const DistributedFactor& factor, const TiedSolver* solver, EigenRequest request,
                bool krylov_schur, const linalg::Progress& progress) {
  const linalg::SomeCores cores(team.cores_each());
  double numbers[] = {static_cast<double>(request.count), request.omega2_max, request.tolerance,
                      krylov_schur ? 1.0 : 0.0};
  team.share(numbers);
  request = {static_cast<int>(numbers[0]), numbers[1], numbers[2]};
  const Border border(team, rows, solver);
  const RowExchange exchange(team, rows, touched_rows(own));
  linalg::EigenProblem problem;
  problem.n = rows.n_own(team);
  problem.n_free = static_cast<int>(rows.number.size()) - static_cast<int>(border.At.cols());
  problem.rank = team.rank();
  problem.sum = [&team](double* values, Eigen::Index count) {
    team.sum({values, static_cast<std::size_t>(count)});
  };
  problem.solve = [&](const Ref<const MatrixXd>& X, MatrixXd& Y) {
    factor.solve_own(X, Y);
    if (!border.empty()) Y -= border.Z * border.small.solve(sum_of(team, border.V.transpose() * Y));
  };
  problem.multiply_K = shared(exchange, [&](const MatrixXd& X, MatrixXd& Y) { own.K_ii().multiply(X, Y); });
  problem.multiply_magnitudes =
      shared(exchange, [&](const MatrixXd& X, MatrixXd& Y) { own.K_ii().multiply_magnitudes(X, Y); });
  problem.multiply_M = shared(exchange, [&](const MatrixXd& X, MatrixXd& Y) { own.multiply_M_ii(X, Y); });
  if (border.At.cols() > 0)
    problem.project = [&](MatrixXd& R) {
      R -= border.At * border.AAt.solve(sum_of(team, border.At.transpose() * R));
    };
  problem.shifted = [&](double sigma) {
    auto shift = std::make_shared<const SharedShift>(team, own, rows, border.At, sigma);
    return linalg::EigenProblem::Shifted{[shift, &team, &border](const Ref<const MatrixXd>& X, MatrixXd& Y) {
                                           shift->L->solve_own(X, Y);
                                           if (shift->Z.cols() > 0)
                                             Y -= shift->Z *
                                                  shift->small.solve(sum_of(team, border.At.transpose() * Y));
                                         },
                                         shift->n_below};
  };
  problem.factor_operations = factor.figures().flops;
  problem.solve_operations = 4.0 * factor.figures().nonzeros;
  problem.view = [&factor](_p_PetscViewer* viewer) { factor.view(viewer); };
  EigenPairs pairs = numbers[3] != 0.0 ? linalg::krylov_schur(problem, request, progress)
                                       : linalg::block_lanczos(problem, request, progress);
  pairs.Phi = gather_rows(team, rows, pairs.Phi);
  return pairs;
}

}  // namespace

EigenPairs find_shared_modes(const TiedSolver& solver, const EigenRequest& request, bool krylov_schur,
                             const linalg::Progress& progress) {
  const ModelShares& shares = solver.model().shares();
  const DistributedFactor* factor = solver.factor().distributed();
  if (!shares.team || !factor) throw std::logic_error("find_shared_modes: no team shares this model");
  EigenPairs pairs;
  shares.team->call(Team::Task::find_modes);
  shares.team->together([&] {
    pairs = find(*shares.team, shares.own->matrices(), shares.rows, *factor, &solver, request, krylov_schur,
                 progress);
  });
  return pairs;
}

void join_shared_modes(const Team& team, const TiedMatrices& share, const RowShares& rows,
                       const DistributedFactor& factor) {
  team.together([&] { find(team, share, rows, factor, nullptr, {}, false, {}); });
}

}  // namespace flexura::reduce
