// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/inertia.hpp"

#include <petscmat.h>

#include <stdexcept>

#include "reduce/linalg/petsc_check.hpp"

namespace flexura::linalg {

struct IndefiniteFactor::Impl {
  Mat A = nullptr, factor = nullptr;
  Vec b = nullptr, x = nullptr;
  IS order = nullptr;
  PetscInt n_negative = 0;

  ~Impl() {
    if (order) ISDestroy(&order);
    if (b) VecDestroy(&b);
    if (x) VecDestroy(&x);
    if (factor) MatDestroy(&factor);
    if (A) MatDestroy(&A);
  }
};

IndefiniteFactor::IndefiniteFactor(const SymmetricMatrix& matrix) : impl_(std::make_unique<Impl>()) {
  require_session();
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "counting eigenvalues by a factorisation"); };
  const UpperCsr csr = matrix.csr();
  Impl& o = *impl_;
  // A second view of the matrix's own arrays; PETSc only reads them.
  ok(MatCreateSeqSBAIJWithArrays(PETSC_COMM_SELF, 1, csr.n, csr.n, const_cast<int*>(csr.row_begin.data()),
                                 const_cast<int*>(csr.columns.data()), const_cast<double*>(csr.values.data()),
                                 &o.A));
  ok(MatGetFactor(o.A, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, &o.factor));
  ok(MatMumpsSetIcntl(o.factor, 24, 1));  // detect null pivots: MUMPS counts the inertia only then
  ok(ISCreateStride(PETSC_COMM_SELF, csr.n, 0, 1, &o.order));
  MatFactorInfo info;
  ok(MatFactorInfoInitialize(&info));
  ok(MatCholeskyFactorSymbolic(o.factor, o.A, o.order, &info));
  ok(MatCholeskyFactorNumeric(o.factor, o.A, &info));
  PetscInt n_zero = 0, n_positive = 0;
  ok(MatGetInertia(o.factor, &o.n_negative, &n_zero, &n_positive));
  if (n_zero > 0)
    throw std::runtime_error(
        "counting eigenvalues: a pivot is zero, the limit lies on an eigenvalue; move it a little");
  ok(MatCreateVecs(o.A, &o.x, &o.b));
}

IndefiniteFactor::~IndefiniteFactor() = default;

int IndefiniteFactor::n_negative() const {
  return static_cast<int>(impl_->n_negative);
}

Eigen::MatrixXd IndefiniteFactor::solve(const Eigen::MatrixXd& B) const {
  const auto ok = [](PetscErrorCode code) { petsc_check(code, "solving with an indefinite factor"); };
  Eigen::MatrixXd X(B.rows(), B.cols());
  for (Eigen::Index c = 0; c < B.cols(); ++c) {
    PetscScalar* in = nullptr;
    ok(VecGetArray(impl_->b, &in));
    Eigen::Map<Eigen::VectorXd>(in, B.rows()) = B.col(c);
    ok(VecRestoreArray(impl_->b, &in));
    ok(MatSolve(impl_->factor, impl_->b, impl_->x));
    const PetscScalar* out = nullptr;
    ok(VecGetArrayRead(impl_->x, &out));
    X.col(c) = Eigen::Map<const Eigen::VectorXd>(out, B.rows());
    ok(VecRestoreArrayRead(impl_->x, &out));
  }
  return X;
}

}  // namespace flexura::linalg
