// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/distributed_factor.hpp"

#include <fmt/format.h>
#include <petscmat.h>

#include <algorithm>
#include <stdexcept>

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

constexpr int kColumns = 32;  // of right-hand sides together

struct Matrix {
  Mat mat = nullptr;
  ~Matrix() {
    if (mat) MatDestroy(&mat);
  }
};

}  // namespace

struct DistributedFactor::Impl {
  const Team& team;
  const RowShares& rows;
  Matrix L;
  int n_negative = 0, n_zero = 0;
  FactorFigures figures;

  int n_own() const { return rows.begin[team.rank() + 1] - rows.begin[team.rank()]; }
  void assemble(const UpperCsr& part, const std::vector<std::pair<int, double>>& diagonal, Mat& A) const;
  void factorise(Mat A);
};

// Each rank says which entries it has, both triangles of them; PETSc sends each to its row's owner.
void DistributedFactor::Impl::assemble(const UpperCsr& part,
                                       const std::vector<std::pair<int, double>>& diagonal, Mat& A) const {
  std::vector<PetscInt> i, j;
  std::vector<PetscScalar> values;
  const auto add = [&](int row, int column, double value) {
    if (value == 0.0) return;
    i.push_back(rows.number[row]);
    j.push_back(rows.number[column]);
    values.push_back(value);
  };
  for (int r = 0; r < part.n; ++r)
    for (int k = part.row_begin[r]; k < part.row_begin[r + 1]; ++k) {
      add(r, part.columns[k], part.values[k]);
      if (part.columns[k] != r) add(part.columns[k], r, part.values[k]);
    }
  for (const auto& [row, value] : diagonal) add(row, row, value);
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "assembling a matrix over all processes"); };
  ok(MatCreate(PETSC_COMM_WORLD, &A));
  ok(MatSetSizes(A, n_own(), n_own(), part.n, part.n));
  ok(MatSetType(A, MATAIJ));
  ok(MatSetPreallocationCOO(A, static_cast<PetscCount>(i.size()), i.data(), j.data()));
  ok(MatSetValuesCOO(A, values.data(), INSERT_VALUES));
  ok(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE));
}

void DistributedFactor::Impl::factorise(Mat A) {
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "factorising a matrix over all processes"); };
  Stopwatch watch;
  MatFactorInfo info;
  ok(MatFactorInfoInitialize(&info));
  ok(MatGetFactor(A, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, &L.mat));
  ok(MatMumpsSetIcntl(L.mat, 13, 1));    // the root, too, by LDL^T: its pivots are counted
  ok(MatMumpsSetIcntl(L.mat, 14, 60));   // per cent of memory beyond its estimate
  ok(MatMumpsSetIcntl(L.mat, 24, 1));    // zero pivots are counted
  ok(MatMumpsSetCntl(L.mat, 3, 1e-13));  // what zero is, of the scaled matrix: as in cholesky.cpp
  ok(MatCholeskyFactorSymbolic(L.mat, A, nullptr, &info));
  figures.seconds_ordering = watch.lap();
  ok(MatCholeskyFactorNumeric(L.mat, A, &info));
  figures.seconds_numeric = watch.lap();
  MatFactorError error = MAT_FACTOR_NOERROR;
  ok(MatFactorGetError(L.mat, &error));
  PetscInt negative = 0, zero = 0, positive = 0, status = 0, nulls = 0;
  ok(MatMumpsGetInfog(L.mat, 1, &status));
  if (error != MAT_FACTOR_NOERROR || status < 0)
    throw std::runtime_error(
        fmt::format("MUMPS could not factorise the matrix (INFOG(1) = {}): more processes bring more memory",
                    static_cast<int>(status)));
  ok(MatGetInertia(L.mat, &negative, &zero, &positive));
  ok(MatMumpsGetInfog(L.mat, 28, &nulls));
  n_negative = static_cast<int>(negative);
  n_zero = static_cast<int>(nulls);
  PetscInt entries = 0;
  ok(MatMumpsGetInfog(L.mat, 29, &entries));  // in millions where negative
  figures.nonzeros = entries < 0 ? -1e6 * entries : entries;
  figures.bytes = sizeof(double) * figures.nonzeros;
}

DistributedFactor::DistributedFactor(const Team& team, const UpperCsr& part, const RowShares& rows,
                                     const std::vector<std::pair<int, double>>& diagonal)
    : impl_(new Impl{team, rows, {}, 0, 0, {}}) {
  team.together([&] {
    Matrix A;
    impl_->assemble(part, diagonal, A.mat);
    impl_->factorise(A.mat);
  });
}

DistributedFactor::~DistributedFactor() = default;

Eigen::MatrixXd DistributedFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  const Team& team = impl_->team;
  const RowShares& rows = impl_->rows;
  const bool leads = team.rank() == 0;
  const auto n = static_cast<Eigen::Index>(rows.number.size());
  Eigen::MatrixXd X(leads ? n : 0, leads ? B.cols() : 0);
  team.together([&] {
    const auto ok = [](PetscErrorCode code) { petsc_check(code, "solving over all processes"); };
    int n_cols = static_cast<int>(B.cols());
    team.share(n_cols);
    for (int first = 0; first < n_cols; first += kColumns) {
      const int width = std::min(kColumns, n_cols - first), n_own = impl_->n_own();
      // By ranks, and the rows of a rank by columns.
      std::vector<int> counts(team.size());
      for (int r = 0; r < team.size(); ++r) counts[r] = (rows.begin[r + 1] - rows.begin[r]) * width;
      std::vector<double> all(leads ? static_cast<std::size_t>(n) * width : 0);
      const auto each = [&](const auto& visit) {
        std::vector<int> owner(n);
        for (int r = 0; r < team.size(); ++r)
          std::fill(owner.begin() + rows.begin[r], owner.begin() + rows.begin[r + 1], r);
        for (Eigen::Index row = 0; row < n; ++row) {
          const int number = rows.number[row], r = owner[number], height = rows.begin[r + 1] - rows.begin[r];
          const std::size_t place =
              static_cast<std::size_t>(rows.begin[r]) * width + (number - rows.begin[r]);
          for (int c = 0; c < width; ++c)
            visit(row, first + c, all[place + static_cast<std::size_t>(c) * height]);
        }
      };
      if (leads) each([&](Eigen::Index row, Eigen::Index c, double& value) { value = B(row, c); });
      Matrix b, x;
      ok(MatCreateDense(PETSC_COMM_WORLD, n_own, PETSC_DECIDE, static_cast<PetscInt>(n), width, nullptr,
                        &b.mat));
      ok(MatCreateDense(PETSC_COMM_WORLD, n_own, PETSC_DECIDE, static_cast<PetscInt>(n), width, nullptr,
                        &x.mat));
      PetscScalar* values = nullptr;
      ok(MatDenseGetArray(b.mat, &values));
      team.scatter(all.data(), counts, values);
      ok(MatDenseRestoreArray(b.mat, &values));
      for (Mat mat : {b.mat, x.mat}) {
        ok(MatAssemblyBegin(mat, MAT_FINAL_ASSEMBLY));
        ok(MatAssemblyEnd(mat, MAT_FINAL_ASSEMBLY));
      }
      ok(MatMatSolve(impl_->L.mat, b.mat, x.mat));
      ok(MatDenseGetArray(x.mat, &values));
      team.gather(values, counts, all.data());
      ok(MatDenseRestoreArray(x.mat, &values));
      if (leads) each([&](Eigen::Index row, Eigen::Index c, const double& value) { X(row, c) = value; });
    }
  });
  return X;
}

int DistributedFactor::n_negative() const {
  return impl_->n_negative;
}
int DistributedFactor::n_zero() const {
  return impl_->n_zero;
}
const FactorFigures& DistributedFactor::figures() const {
  return impl_->figures;
}

}  // namespace flexura::linalg
