// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/fronts_package.hpp"

#include <fmt/format.h>
#include <petsc/private/matimpl.h>

#include <memory>
#include <numeric>
#include <stdexcept>
#include <string_view>

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/factor/refinement.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

// A pivot L_jj^2 below this fraction of A_jj is round-off of a zero: the last pivots of a slender body are
// its static stiffness over the local one, (diameter / length)^3 times a few powers of ten, far above.
constexpr double kSmallestPivot = 1e-13;

constexpr const char* kHints = "flexura_fronts_hints";  // composed with the matrix

struct Package {
  std::unique_ptr<FrontsFactor> factor;
  FactorStorage storage;
  Mat refined_with = nullptr;  // the matrix, where the factor is in single precision
};

Package& package(Mat F) {
  return *static_cast<Package*>(F->data);
}

void ok(PetscErrorCode code) {
  petsc_check(code, "factorising a matrix");
}

// The matrix' own arrays for as long as this lives.
class Csr {
 public:
  explicit Csr(Mat A) : A_(A) {
    PetscInt n = 0;
    const PetscInt *begin = nullptr, *columns = nullptr;
    PetscBool done = PETSC_FALSE;
    ok(MatGetRowIJ(A, 0, PETSC_FALSE, PETSC_FALSE, &n, &begin, &columns, &done));
    if (!done) throw std::runtime_error("fronts: the matrix does not show its rows");
    PetscScalar* values = nullptr;
    ok(MatSeqSBAIJGetArray(A, &values));
    const auto size = static_cast<std::size_t>(n), count = static_cast<std::size_t>(begin[n]);
    csr_ = {n, {begin, size + 1}, {columns, count}, {values, count}};
  }
  ~Csr() {
    PetscInt n = csr_.n;
    const PetscInt *begin = csr_.row_begin.data(), *columns = csr_.columns.data();
    auto* values = const_cast<PetscScalar*>(csr_.values.data());
    PetscBool done = PETSC_FALSE;
    MatSeqSBAIJRestoreArray(A_, &values);
    MatRestoreRowIJ(A_, 0, PETSC_FALSE, PETSC_FALSE, &n, &begin, &columns, &done);
  }
  Csr(const Csr&) = delete;
  Csr& operator=(const Csr&) = delete;
  const UpperCsr& operator*() const { return csr_; }

 private:
  Mat A_;
  UpperCsr csr_;
};

void require_diagonal_first(const UpperCsr& A) {
  for (int i = 0; i < A.n; ++i) {
    const int begin = A.row_begin[i], end = A.row_begin[i + 1];
    if (begin == end || A.columns[begin] != i)
      throw std::runtime_error(fmt::format(
          "fronts: row {} of the matrix has no diagonal entry; store it, as a zero if need be", i));
    for (int k = begin + 1; k < end; ++k)
      if (A.columns[k] <= A.columns[k - 1])
        throw std::runtime_error(fmt::format("fronts: the columns of row {} do not ascend", i));
  }
}

const FrontsHints* hints_of(Mat A) {
  PetscObject object = nullptr;
  ok(PetscObjectQuery(reinterpret_cast<PetscObject>(A), kHints, &object));
  if (!object) return nullptr;
  void* hints = nullptr;
  ok(PetscContainerGetPointer(reinterpret_cast<PetscContainer>(object), &hints));
  return static_cast<const FrontsHints*>(hints);
}

std::vector<int> order_of(Mat A, IS permutation, const UpperCsr& csr) {
  std::vector<int> order;
  if (permutation) {
    const PetscInt* rows = nullptr;
    ok(ISGetIndices(permutation, &rows));
    order.assign(rows, rows + csr.n);
    ok(ISRestoreIndices(permutation, &rows));
    return order;
  }
  if (const FrontsHints* hints = hints_of(A); hints && !hints->order.empty()) return hints->order;
  if (csr.n == 0) return order;
  PetscInt n_groups = 0;
  const PetscInt* sizes = nullptr;
  ok(MatGetVariableBlockSizes(A, &n_groups, &sizes));
  std::vector<int> begin;
  if (n_groups > 0) {
    begin.push_back(0);
    for (PetscInt g = 0; g < n_groups; ++g) begin.push_back(begin.back() + sizes[g]);
  }
  return nested_dissection(csr, begin);
}

// Sets `value` to what the word of an option stands for; without the option it stays.
template <class Value, std::size_t n>
void read_word(Mat F, const char* option, const std::pair<const char*, Value> (&words)[n], Value& value) {
  const char* prefix = nullptr;
  ok(MatGetOptionsPrefix(F, &prefix));
  char text[16] = "";
  PetscBool given = PETSC_FALSE;
  ok(PetscOptionsGetString(nullptr, prefix, option, text, sizeof(text), &given));
  if (!given) return;
  std::string list;
  for (std::size_t k = 0; k < n; ++k) {
    if (std::string_view(text) == words[k].first) {
      value = words[k].second;
      return;
    }
    list += (k == 0 ? "" : k + 1 == n ? " or " : ", ") + std::string(words[k].first);
  }
  throw std::invalid_argument(fmt::format("{} {}: is {}", option, std::string_view(text), list));
}

FactorStorage storage_of(Mat F, Mat A) {
  const FrontsHints* hints = hints_of(A);
  FactorStorage storage = hints ? hints->storage : FactorStorage{};
  using Place = FactorStorage::Place;
  read_word<Place>(F, "-mat_fronts_storage",
                   {{"automatic", Place::automatic}, {"memory", Place::memory}, {"file", Place::file}},
                   storage.place);
  read_word<bool>(F, "-mat_fronts_precision", {{"double", false}, {"single", true}}, storage.single);
  return storage;
}

PetscErrorCode solve_columns(Mat F, const PetscScalar* B, PetscInt B_stride, PetscScalar* X,
                             PetscInt X_stride, PetscInt n_cols) {
  const SupernodalFactor& L = package(F).factor->L;
  using Stride = Eigen::OuterStride<>;
  const Eigen::Map<const Eigen::MatrixXd, 0, Stride> b(B, L.size(), n_cols, Stride(B_stride));
  Eigen::Map<Eigen::MatrixXd, 0, Stride> x(X, L.size(), n_cols, Stride(X_stride));
  return guarded([&] {
    if (L.size() == 0 || n_cols == 0) return;
    if (!L.is_single()) {
      L.solve_into(b, x);
    } else {
      const Eigen::MatrixXd copy = X == B ? Eigen::MatrixXd(b) : Eigen::MatrixXd();
      L.solve_into(b, x);
      const Csr csr(package(F).refined_with);
      if (X == B)
        refine(L, *csr, copy, x);
      else
        refine(L, *csr, b, x);
    }
    ok(PetscLogFlops(4.0 * L.nonzeros() * n_cols));
  });
}

PetscErrorCode solve(Mat F, Vec b, Vec x) {
  const PetscScalar* B = nullptr;
  PetscScalar* X = nullptr;
  if (PetscErrorCode code = VecGetArrayRead(b, &B)) return code;
  if (PetscErrorCode code = VecGetArrayWrite(x, &X)) return code;
  const PetscErrorCode code = solve_columns(F, B, F->rmap->n, X, F->rmap->n, 1);
  VecRestoreArrayRead(b, &B);
  VecRestoreArrayWrite(x, &X);
  return code;
}

PetscErrorCode solve_block(Mat F, Mat b, Mat x) {
  PetscInt n_cols = 0, B_stride = 0, X_stride = 0;
  const PetscScalar* B = nullptr;
  PetscScalar* X = nullptr;
  if (PetscErrorCode code = MatGetSize(b, nullptr, &n_cols)) return code;
  if (PetscErrorCode code = MatDenseGetLDA(b, &B_stride)) return code;
  if (PetscErrorCode code = MatDenseGetLDA(x, &X_stride)) return code;
  if (PetscErrorCode code = MatDenseGetArrayRead(b, &B)) return code;
  if (PetscErrorCode code = MatDenseGetArrayWrite(x, &X)) return code;
  const PetscErrorCode code = solve_columns(F, B, B_stride, X, X_stride, n_cols);
  MatDenseRestoreArrayRead(b, &B);
  MatDenseRestoreArrayWrite(x, &X);
  return code;
}

PetscErrorCode get_inertia(Mat F, PetscInt* negative, PetscInt* zero, PetscInt* positive) {
  const SupernodalFactor& L = package(F).factor->L;
  const int n_negative = L.n_negative();
  if (negative) *negative = n_negative;
  if (zero) *zero = 0;
  if (positive) *positive = L.size() - n_negative;
  return 0;
}

void keep(Mat& place, Mat A) {
  if (A) ok(PetscObjectReference(reinterpret_cast<PetscObject>(A)));
  ok(MatDestroy(&place));
  place = A;
}

// The pivot, with its row, for which the factor is no good; row -1 where it is good.
SupernodalFactor::Pivot factorise(FrontsFactor& factor, const UpperCsr& A, bool definite,
                                  const FactorStorage& storage) {
  SupernodalFactor& L = factor.L;
  FactorFigures& figures = factor.figures;
  const SupernodalFactor::Pivot good{1.0, -1}, bad{0.0, L.factorise(A, definite, storage)};
  figures.in_file = L.is_in_file();
  figures.single = L.is_single();
  figures.bytes = L.bytes();
  if (bad.row >= 0 || A.n == 0) return bad;
  const SupernodalFactor::Pivot smallest = L.smallest_pivot(A);
  figures.smallest_pivot = definite ? smallest.ratio : 0.0;
  if (definite && !L.is_single()) return smallest.ratio > kSmallestPivot ? good : smallest;
  return stands_the_test(L, A) ? good : smallest;
}

PetscErrorCode numeric(Mat F, Mat A, const MatFactorInfo*) {
  return guarded([&] {
    FrontsFactor& factor = *package(F).factor;
    FactorFigures& figures = factor.figures;
    const Csr csr(A);
    PetscBool known = PETSC_FALSE, definite = PETSC_FALSE;
    ok(MatIsSPDKnown(A, &known, &definite));
    definite = known && definite ? PETSC_TRUE : PETSC_FALSE;
    Stopwatch watch;
    const double before = processor_seconds();
    FactorStorage storage = package(F).storage;
    SupernodalFactor::Pivot bad = factorise(factor, *csr, definite, storage);
    if (bad.row >= 0 && storage.single) {
      storage.single = false;
      bad = factorise(factor, *csr, definite, storage);
    }
    figures.seconds_numeric = watch.lap();
    figures.processor_seconds = processor_seconds() - before;
    keep(package(F).refined_with, factor.L.is_single() ? A : nullptr);
    ok(PetscLogFlops(factor.L.flops()));
    F->factorerrortype = MAT_FACTOR_NOERROR;
    if (bad.row >= 0) {
      if (A->erroriffailure)
        throw std::runtime_error(
            fmt::format("fronts: the matrix is singular to round-off at row {}", bad.row));
      F->factorerrortype = MAT_FACTOR_NUMERIC_ZEROPIVOT;
      F->factorerror_zeropivot_value = bad.ratio;
      F->factorerror_zeropivot_row = bad.row;
      return;
    }
    F->ops->solve = F->ops->solvetranspose = solve;
    F->ops->matsolve = F->ops->matsolvetranspose = solve_block;
    F->ops->getinertia = get_inertia;
    F->assembled = PETSC_TRUE;
  });
}

PetscErrorCode symbolic(Mat F, Mat A, IS permutation, const MatFactorInfo*) {
  return guarded([&] {
    PetscInt block = 1;
    ok(MatGetBlockSize(A, &block));
    if (block != 1)
      throw std::runtime_error(fmt::format("fronts: the matrix has blocks of {0} x {0}; use block size 1",
                                           static_cast<int>(block)));
    const Csr csr(A);
    require_diagonal_first(*csr);
    Package& own = package(F);
    own.factor.reset();
    own.storage = storage_of(F, A);
    Stopwatch watch;
    std::vector<int> order = order_of(A, permutation, *csr);
    const double seconds_ordering = watch.lap();
    own.factor = std::make_unique<FrontsFactor>(FrontsFactor{SupernodalFactor(*csr, std::move(order)), {}});
    FactorFigures& figures = own.factor->figures;
    figures.seconds_ordering = seconds_ordering;
    figures.seconds_symbolic = watch.lap();
    figures.nonzeros = own.factor->L.nonzeros();
    figures.flops = own.factor->L.flops();
    figures.bytes = own.factor->L.bytes();
    F->ops->choleskyfactornumeric = numeric;
  });
}

PetscErrorCode get_info(Mat F, MatInfoType, MatInfo* info) {
  *info = MatInfo{};
  info->block_size = 1.0;
  if (const FrontsFactor* factor = package(F).factor.get()) {
    info->nz_used = info->nz_allocated = factor->L.nonzeros();
    info->memory = factor->L.bytes();
  }
  return 0;
}

PetscErrorCode view(Mat F, PetscViewer viewer) {
  return guarded([&] {
    const FrontsFactor* factor = package(F).factor.get();
    PetscBool ascii = PETSC_FALSE;
    ok(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &ascii));
    if (!ascii || !factor) return;
    ok(PetscViewerASCIIPrintf(viewer, "multifrontal factor, nested dissection by METIS, %s precision, %s\n",
                              factor->figures.single ? "single" : "double",
                              factor->figures.in_file ? "kept in a file" : "in memory"));
    ok(PetscViewerASCIIPrintf(viewer, "nonzeros %.0f, operations %.3g, stored %.3g MB, negative pivots %d\n",
                              factor->L.nonzeros(), factor->L.flops(), 1e-6 * factor->L.bytes(),
                              factor->L.n_negative()));
  });
}

PetscErrorCode destroy(Mat F) {
  PetscCall(MatDestroy(&package(F).refined_with));
  delete static_cast<Package*>(F->data);
  F->data = nullptr;
  return PetscObjectComposeFunction(reinterpret_cast<PetscObject>(F), "MatFactorGetSolverType_C", nullptr);
}

PetscErrorCode get_solver_type(Mat, MatSolverType* type) {
  *type = kFronts;
  return 0;
}

PetscErrorCode get_factor(Mat A, MatFactorType kind, Mat* F) {
  return guarded([&] {
    PetscInt n = 0;
    ok(MatGetSize(A, &n, nullptr));
    Mat mat = nullptr;
    ok(MatCreate(PetscObjectComm(reinterpret_cast<PetscObject>(A)), &mat));
    ok(MatSetSizes(mat, n, n, n, n));
    ok(PetscStrallocpy(kFronts, &reinterpret_cast<PetscObject>(mat)->type_name));
    ok(MatSetUp(mat));
    mat->data = new Package;
    mat->ops->choleskyfactorsymbolic = symbolic;
    mat->ops->getinfo = get_info;
    mat->ops->view = view;
    mat->ops->destroy = destroy;
    ok(PetscObjectComposeFunction(reinterpret_cast<PetscObject>(mat), "MatFactorGetSolverType_C",
                                  get_solver_type));
    mat->factortype = kind;
    mat->canuseordering = PETSC_TRUE;
    ok(PetscStrallocpy(MATORDERINGEXTERNAL,
                       const_cast<char**>(&mat->preferredordering[MAT_FACTOR_CHOLESKY])));
    ok(PetscFree(mat->solvertype));
    ok(PetscStrallocpy(kFronts, &mat->solvertype));
    *F = mat;
  });
}

PetscErrorCode delete_hints(void* hints) {
  delete static_cast<FrontsHints*>(hints);
  return 0;
}

}  // namespace

void register_fronts() {
  // PETSc's own packages first: MatSolverTypeRegister would begin a new list before it asks for them.
  petsc_check(MatInitializePackage(), "starting");
  petsc_check(MatSolverTypeRegister(kFronts, MATSEQSBAIJ, MAT_FACTOR_CHOLESKY, get_factor),
              "registering the solver package fronts");
}

void set_hints(Mat A, FrontsHints hints) {
  PetscContainer container = nullptr;
  ok(PetscContainerCreate(PETSC_COMM_SELF, &container));
  ok(PetscContainerSetPointer(container, new FrontsHints(std::move(hints))));
  ok(PetscContainerSetUserDestroy(container, delete_hints));
  ok(PetscObjectCompose(reinterpret_cast<PetscObject>(A), kHints, reinterpret_cast<PetscObject>(container)));
  ok(PetscContainerDestroy(&container));
}

const FrontsFactor* fronts_factor(Mat F) {
  if (!F || !F->solvertype || std::string_view(F->solvertype) != kFronts) return nullptr;
  return package(F).factor.get();
}

}  // namespace flexura::linalg
