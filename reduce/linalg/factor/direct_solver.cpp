// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/direct_solver.hpp"

#include <fmt/format.h>

#include <random>
#include <stdexcept>
#include <string_view>

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/dense/random_numbers.hpp"
#include "reduce/linalg/factor/fronts_package.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

void ok(PetscErrorCode code) {
  petsc_check(code, "factorising the matrix");
}

bool is_type(PC pc, PCType type) {
  PetscBool same = PETSC_FALSE;
  ok(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), type, &same));
  return same;
}

bool factorises(PC pc) {
  for (PCType type : {PCCHOLESKY, PCLU, PCICC, PCILU})
    if (is_type(pc, type)) return true;
  return false;
}

// A dense matrix of PETSc on numbers that are there already.
struct DenseView {
  Mat mat = nullptr;
  DenseView(double* data, Eigen::Index rows, Eigen::Index cols, Eigen::Index stride) {
    const auto n = static_cast<PetscInt>(rows), k = static_cast<PetscInt>(cols);
    ok(MatCreateSeqDense(PETSC_COMM_SELF, n, k, data, &mat));
    ok(MatDenseSetLDA(mat, std::max(n, static_cast<PetscInt>(stride))));
  }
  ~DenseView() {
    if (petsc_is_sound()) MatDestroy(&mat);
  }
  DenseView(const DenseView&) = delete;
  DenseView& operator=(const DenseView&) = delete;
};

}  // namespace

DirectSolver::DirectSolver(const SymmetricMatrix& A, Settings settings) : n_(A.size()), numbers_(A.share()) {
  require_session();
  if (n_ == 0) return;
  try {
    create_matrix(A, settings);
    set_hints(mat_, std::move(settings.hints));
    create_solver(settings);
    set_up();
    if (!failure_.failed && !fronts_factor(factor_)) {
      UpperCsr csr = A.csr();
      if (!values_.empty()) csr.values = values_;
      test(csr, settings.definite);
    }
  } catch (...) {
    destroy();
    throw;
  }
}

DirectSolver::~DirectSolver() {
  destroy();
}

void DirectSolver::destroy() {
  if (!petsc_is_sound()) return;
  KSPDestroy(&ksp_);
  MatDestroy(&mat_);
}

// A view of A's numbers, so that what is said of it (definite, groups) is said of this one only.
void DirectSolver::create_matrix(const SymmetricMatrix& A, const Settings& settings) {
  const UpperCsr csr = A.csr();
  // PETSc does not write to the numbers of an assembled matrix.
  auto* values = const_cast<double*>(csr.values.data());
  if (!settings.doubled.empty()) {
    values_.assign(csr.values.begin(), csr.values.end());
    for (const int row : settings.doubled) values_[csr.row_begin[row]] *= 2.0;
    values = values_.data();
  }
  ok(MatCreateSeqSBAIJWithArrays(PETSC_COMM_SELF, 1, n_, n_, const_cast<int*>(csr.row_begin.data()),
                                 const_cast<int*>(csr.columns.data()), values, &mat_));
  ok(MatSetOption(mat_, MAT_SPD, settings.definite ? PETSC_TRUE : PETSC_FALSE));
  std::vector<PetscInt> sizes;
  for (std::size_t g = 1; g < settings.group_begin.size(); ++g)
    if (const int size = settings.group_begin[g] - settings.group_begin[g - 1]; size > 0)
      sizes.push_back(size);
  if (!sizes.empty()) ok(MatSetVariableBlockSizes(mat_, static_cast<PetscInt>(sizes.size()), sizes.data()));
}

void DirectSolver::create_solver(const Settings& settings) {
  ok(KSPCreate(PETSC_COMM_SELF, &ksp_));
  ok(KSPSetOperators(ksp_, mat_, mat_));
  ok(KSPSetType(ksp_, KSPPREONLY));
  // For iterative methods that the user may choose: modes are judged at 1e-9.
  ok(KSPSetTolerances(ksp_, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  PC pc = nullptr;
  ok(KSPGetPC(ksp_, &pc));
  ok(PCSetType(pc, PCCHOLESKY));
  // Of all that options may name, MUMPS and fronts count pivots.
  char named[64] = "";
  ok(PetscOptionsGetString(nullptr, nullptr, "-pc_factor_mat_solver_type", named, sizeof(named), nullptr));
  const bool mumps = std::string_view(named) == MATSOLVERMUMPS;
  ok(PCFactorSetMatSolverType(pc, settings.count_negative && mumps ? MATSOLVERMUMPS : kFronts));
  if (!settings.count_negative) ok(KSPSetFromOptions(ksp_));
  if (is_type(pc, PCCHOLESKY) && mumps) {
    ok(PCFactorSetUpMatSolverType(pc));
    Mat factor = nullptr;
    ok(PCFactorGetMatrix(pc, &factor));
    ok(MatMumpsSetIcntl(factor, 24, 1));    // zero pivots are counted
    ok(MatMumpsSetCntl(factor, 3, 1e-13));  // what zero is, of the scaled matrix: as in fronts_package.cpp
  }
}

void DirectSolver::set_up() {
  Stopwatch watch;
  const double before = processor_seconds();
  ok(KSPSetUp(ksp_));
  ok(KSPSetUpOnBlocks(ksp_));
  figures_.seconds_numeric = watch.lap();
  figures_.processor_seconds = processor_seconds() - before;
  PC pc = nullptr;
  ok(KSPGetPC(ksp_, &pc));
  if (factorises(pc)) ok(PCFactorGetMatrix(pc, &factor_));
  PCFailedReason reason = PC_NOERROR;
  ok(PCGetFailedReason(pc, &reason));
  if (reason != PC_NOERROR) {
    failure_.failed = true;
    PetscReal pivot = 0.0;
    PetscInt row = -1;
    if (fronts_factor(factor_)) ok(MatFactorGetErrorZeroPivot(factor_, &pivot, &row));
    failure_.row = row;
    if (reason == PC_FACTOR_OUTMEMORY)
      throw std::runtime_error(
          "memory does not suffice for the factor: use a coarser mesh or a machine with more memory");
    return;
  }
  ok(KSPSetErrorIfNotConverged(ksp_, PETSC_TRUE));
  if (const FrontsFactor* fronts = fronts_factor(factor_)) {
    figures_ = fronts->figures;
  } else if (factor_) {
    MatInfo info{};
    ok(MatGetInfo(factor_, MAT_LOCAL, &info));
    figures_.nonzeros = info.nz_used;
    figures_.bytes = std::max(info.memory, 8.0 * info.nz_used);
  }
}

// Other packages are not asked what they take for a zero: a factor is put to the test of inertia.hpp.
void DirectSolver::test(const UpperCsr& A, bool definite) {
  constexpr double kResidual = 0.1;
  std::mt19937_64 random(19781105);
  const Eigen::MatrixXd B = random_numbers(n_, 8, random);
  Eigen::MatrixXd X(n_, 8), AX;
  solve(B, X);
  multiply(A, X, AX);
  const bool small = (AX - B).colwise().norm().maxCoeff() < kResidual;
  const bool positive = B.cwiseProduct(X).colwise().sum().minCoeff() > 0.0;
  if (!factor_ && !small)
    throw std::invalid_argument(
        "the solver that the PETSc options choose does not solve with the stiffness matrix: a preconditioner "
        "(-pc_type) alone does not, it needs a method (-ksp_type cg) and a matrix for which that converges");
  failure_.failed = !small || (definite && !positive);
}

void DirectSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> X) const {
  if (B.rows() != n_ || X.rows() != n_ || X.cols() != B.cols())
    throw std::logic_error("solve: the right-hand sides do not have the matrix's length");
  if (B.size() == 0) return;
  if (X.outerStride() != n_) {
    // PETSc's interface to CHOLMOD takes a gap between columns for another array's, and frees it.
    Eigen::MatrixXd dense(n_, X.cols());
    solve(B, dense);
    X = dense;
    return;
  }
  // Read only: PETSc has no dense matrix of constants.
  const DenseView b(const_cast<double*>(B.data()), B.rows(), B.cols(), B.outerStride());
  const DenseView x(X.data(), X.rows(), X.cols(), X.outerStride());
  petsc_check(KSPMatSolve(ksp_, b.mat, x.mat), "solving with a factorised matrix");
}

void DirectSolver::view(PetscViewer viewer) const {
  if (ksp_) petsc_check(KSPView(ksp_, viewer), "showing a solver");
}

int DirectSolver::n_negative() const {
  if (n_ == 0) return 0;
  PetscInt negative = 0, zero = 0, positive = 0;
  petsc_check(MatGetInertia(factor_, &negative, &zero, &positive), "counting negative pivots");
  return static_cast<int>(negative);
}

const std::vector<int>& DirectSolver::order() const {
  const FrontsFactor* fronts = fronts_factor(factor_);
  return fronts ? fronts->L.order() : no_order_;
}

}  // namespace flexura::linalg
