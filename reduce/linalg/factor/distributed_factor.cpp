// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/distributed_factor.hpp"

#include <fmt/format.h>
#include <petscmat.h>

#include <algorithm>
#include <exception>
#include <iterator>
#include <stdexcept>

#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/factor/mumps_workspace.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

// Right-hand sides together: as many as the eigensolver brings.  MUMPS, PETSc and their caller have a copy of them each.
constexpr int kColumns = 16;

// To destroy it takes all ranks: on the way of an exception, which may be this rank's alone, it is left.
struct Matrix {
  int exceptions = std::uncaught_exceptions();
  Mat mat = nullptr;
  ~Matrix() {
    if (mat && std::uncaught_exceptions() == exceptions) MatDestroy(&mat);
  }
};

}  // namespace

struct DistributedFactor::Impl {
  const Team& team;
  const RowShares& rows;
  MumpsWorkspace workspace;  // of L, which it outlives
  Matrix L;
  int n_negative = 0, n_zero = 0;
  FactorFigures figures;

  int n_own() const { return rows.n_own(team); }
  void assemble(const Terms& terms, Mat& A) const;
  void factorise(Mat A, Use use);
  int factorise(Mat A, Use use, PetscInt beyond_estimate);
};

// Each rank says which entries it has; PETSc sends each to its row's owner.  The upper triangle by the ranks' numbers is
// all that PETSc hands to MUMPS of a symmetric matrix, and half the memory.
void DistributedFactor::Impl::assemble(const Terms& terms, Mat& A) const {
  const auto& [part, held_by, diagonal] = terms;
  std::vector<PetscInt> i, j;
  std::vector<PetscScalar> values;
  for (std::vector<PetscInt>* numbers : {&i, &j}) numbers->reserve(part.values.size() + diagonal.size());
  values.reserve(part.values.size() + diagonal.size());
  const auto add = [&](int row, int column, double value) {
    if (value == 0.0) return;
    i.push_back(std::min(row, column));
    j.push_back(std::max(row, column));
    values.push_back(value);
  };
  for (int r = 0; r < part.n; ++r)
    for (int k = part.row_begin[r]; k < part.row_begin[r + 1]; ++k)
      add(rows.number[r], rows.number[part.columns[k]], part.values[k]);
  for (const auto& [row, value] : diagonal) add(row, row, value);
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "assembling a matrix over all processes"); };
  Matrix sum;
  ok(MatCreate(PETSC_COMM_WORLD, &sum.mat));
  ok(MatSetSizes(sum.mat, n_own(), n_own(), rows.n(), rows.n()));
  ok(MatSetType(sum.mat, MATAIJ));
  ok(MatSetPreallocationCOO(sum.mat, static_cast<PetscCount>(i.size()), i.data(), j.data()));
  ok(MatSetValuesCOO(sum.mat, values.data(), INSERT_VALUES));
  ok(MatSetOption(sum.mat, MAT_SYMMETRIC, PETSC_TRUE));
  // A copy does not know where each entry has come from, which takes more than the entries themselves.
  for (std::vector<PetscInt>* numbers : {&i, &j}) std::vector<PetscInt>().swap(*numbers);
  std::vector<PetscScalar>().swap(values);
  ok(MatDuplicate(sum.mat, MAT_COPY_VALUES, &A));
}

// MUMPS lets its workspace stand as large as it was made: what is beyond its estimate is given in small steps, from its own
// default on.
void DistributedFactor::Impl::factorise(Mat A, Use use) {
  constexpr PetscInt kBeyondEstimate[] = {20, 60, 150};  // per cent
  for (const PetscInt beyond : kBeyondEstimate) {
    const int status = factorise(A, use, beyond);
    if (status >= 0) return;
    const bool too_small = status == -8 || status == -9 || status == -11 || status == -12 || status == -14 ||
                           status == -15 || status == -18 || status == -19;
    if (!too_small || beyond == std::end(kBeyondEstimate)[-1])
      throw std::runtime_error(fmt::format(
          "MUMPS could not factorise the matrix (INFOG(1) = {}): more processes bring more memory", status));
    petsc_check(MatDestroy(&L.mat), "factorising a matrix over all processes");
  }
}

// What MUMPS says of it, INFOG(1).
int DistributedFactor::Impl::factorise(Mat A, Use use, PetscInt beyond_estimate) {
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "factorising a matrix over all processes"); };
  Stopwatch watch;
  MatFactorInfo info;
  ok(MatFactorInfoInitialize(&info));
  ok(MatGetFactor(A, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, &L.mat));
  ok(MatMumpsSetIcntl(L.mat, 13, 1));  // the root, too, by LDL^T: its pivots are counted
  ok(MatMumpsSetIcntl(L.mat, 14, beyond_estimate));
  ok(MatMumpsSetIcntl(L.mat, 24, 1));                         // zero pivots are counted
  if (use == Use::count) ok(MatMumpsSetIcntl(L.mat, 31, 1));  // L is dropped as it comes
  ok(MatMumpsSetCntl(L.mat, 3, 1e-13));  // what zero is, of the scaled matrix: as in cholesky.cpp
  ok(MatCholeskyFactorSymbolic(L.mat, A, nullptr, &info));
  figures.seconds_ordering += watch.lap();
  {
    const MumpsWorkspace::Lent lent(workspace);
    ok(MatCholeskyFactorNumeric(L.mat, A, &info));
  }
  figures.seconds_numeric += watch.lap();
  MatFactorError error = MAT_FACTOR_NOERROR;
  ok(MatFactorGetError(L.mat, &error));
  PetscInt negative = 0, zero = 0, positive = 0, status = 0, nulls = 0;
  ok(MatMumpsGetInfog(L.mat, 1, &status));
  if (status < 0) return static_cast<int>(status);
  if (error != MAT_FACTOR_NOERROR)
    throw std::runtime_error(fmt::format("MUMPS could not factorise the matrix (PETSc's MatFactorError {})",
                                         static_cast<int>(error)));
  ok(MatGetInertia(L.mat, &negative, &zero, &positive));
  ok(MatMumpsGetInfog(L.mat, 28, &nulls));
  n_negative = static_cast<int>(negative);
  n_zero = static_cast<int>(nulls);
  PetscInt entries = 0;
  ok(MatMumpsGetInfog(L.mat, 29, &entries));  // in millions where negative
  figures.nonzeros = entries < 0 ? -1e6 * entries : entries;
  figures.bytes = sizeof(double) * figures.nonzeros;
  ok(MatMumpsGetRinfog(L.mat, 3, &figures.flops));
  return 0;
}

DistributedFactor::DistributedFactor(const Team& team, Terms terms, const RowShares& rows, Use use)
    : impl_(new Impl{team, rows, {}, {}, 0, 0, {}}) {
  if (rows.n() == 0) return;  // all dofs are the interfaces'
  const SomeCores cores(team.cores_each());
  Matrix A;
  impl_->assemble(terms, A.mat);
  terms = {};
  impl_->factorise(A.mat, use);
}

DistributedFactor::~DistributedFactor() = default;

Eigen::MatrixXd DistributedFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "solving over all processes"); };
  const PetscInt n = impl_->rows.n();
  const int n_own = impl_->n_own();
  if (n == 0) return Eigen::MatrixXd(0, B.cols());
  const SomeCores cores(impl_->team.cores_each());
  Eigen::MatrixXd X(n_own, B.cols());
  for (Eigen::Index first = 0; first < B.cols(); first += kColumns) {
    const auto width = static_cast<PetscInt>(std::min<Eigen::Index>(kColumns, B.cols() - first));
    Matrix b, x;
    for (Mat* mat : {&b.mat, &x.mat})
      ok(MatCreateDense(PETSC_COMM_WORLD, n_own, PETSC_DECIDE, n, width, nullptr, mat));
    PetscScalar* values = nullptr;
    ok(MatDenseGetArray(b.mat, &values));
    Eigen::Map<Eigen::MatrixXd>(values, n_own, width) = B.middleCols(first, width);
    ok(MatDenseRestoreArray(b.mat, &values));
    for (Mat mat : {b.mat, x.mat}) {
      ok(MatAssemblyBegin(mat, MAT_FINAL_ASSEMBLY));
      ok(MatAssemblyEnd(mat, MAT_FINAL_ASSEMBLY));
    }
    ok(MatMatSolve(impl_->L.mat, b.mat, x.mat));
    ok(MatDenseGetArray(x.mat, &values));
    X.middleCols(first, width) = Eigen::Map<const Eigen::MatrixXd>(values, n_own, width);
    ok(MatDenseRestoreArray(x.mat, &values));
  }
  return X;
}

void DistributedFactor::view(_p_PetscViewer* viewer) const {
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "showing a factor"); };
  if (!impl_->L.mat) return;
  ok(PetscViewerPushFormat(viewer, PETSC_VIEWER_ASCII_INFO));
  ok(MatView(impl_->L.mat, viewer));
  ok(PetscViewerPopFormat(viewer));
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
