// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/block_lanczos_type.hpp"

#include <slepc/private/epsimpl.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "reduce/linalg/eigen/block_lanczos.hpp"
#include "reduce/linalg/eigen/dense_pairs.hpp"
#include "reduce/linalg/eigen/spectrum_slices.hpp"
#include "reduce/linalg/factor/factor_store.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

struct Data {
  PetscInt block = PETSC_DECIDE;
  PetscInt slice = PETSC_DECIDE;       // modes of a slice; 0: one basis
  int used_slice = 0, used_block = 0;  // what has been taken, for a report
  BlockLanczosContext* context = nullptr;
};

Data& data(EPS eps) {
  return *static_cast<Data*>(eps->data);
}

void ok(PetscErrorCode code) {
  petsc_check(code, "computing eigenpairs by block Lanczos");
}

// A dense matrix of PETSc on numbers that are there already: this process's rows.
class Block {
 public:
  Block(MPI_Comm comm, const double* values, Index rows, Index cols) {
    ok(MatCreateDense(comm, static_cast<PetscInt>(rows), PETSC_DECIDE, PETSC_DETERMINE,
                      static_cast<PetscInt>(cols), const_cast<double*>(values), &mat_));
  }
  ~Block() { MatDestroy(&mat_); }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  Mat get() const { return mat_; }

 private:
  Mat mat_ = nullptr;
};

// Y = A X by PETSc.
void multiply(Mat A, const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
  const MatrixXd x = X;
  const Block block(PetscObjectComm(reinterpret_cast<PetscObject>(A)), x.data(), x.rows(), x.cols());
  Mat product = nullptr;
  const PetscScalar* values = nullptr;
  ok(MatMatMult(A, block.get(), MAT_INITIAL_MATRIX, PETSC_DEFAULT, &product));
  ok(MatDenseGetArrayRead(product, &values));
  Y = Eigen::Map<const MatrixXd>(values, x.rows(), x.cols());
  ok(MatDenseRestoreArrayRead(product, &values));
  ok(MatDestroy(&product));
}

// The problem that an EPS states.
EigenProblem problem_of(EPS eps) {
  EigenProblem problem;
  const Data& own = data(eps);
  if (own.context) problem = *own.context->problem;
  problem.n = static_cast<int>(eps->nloc);
  PetscScalar sigma = 0.0;
  ok(STGetShift(eps->st, &sigma));
  problem.shift = -sigma;
  KSP ksp = nullptr;
  ok(STGetKSP(eps->st, &ksp));
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(eps));
  problem.solve = [ksp, comm](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    Y.resize(X.rows(), X.cols());
    const bool dense = X.outerStride() == X.rows();
    const MatrixXd copy = dense ? MatrixXd() : MatrixXd(X);
    const Block x(comm, dense ? X.data() : copy.data(), X.rows(), X.cols()),
        y(comm, Y.data(), Y.rows(), Y.cols());
    ok(KSPMatSolve(ksp, x.get(), y.get()));
  };
  if (own.context) return problem;
  problem.n_free = static_cast<int>(eps->n);
  Mat K = nullptr, M = nullptr;
  ok(STGetMatrix(eps->st, 0, &K));
  if (eps->isgeneralized) ok(STGetMatrix(eps->st, 1, &M));
  problem.multiply_K = [K](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { multiply(K, X, Y); };
  problem.multiply_M = [M](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    if (M)
      multiply(M, X, Y);
    else
      Y = X;
  };
  int size = 1;
  MPI_Comm_size(comm, &size);
  MPI_Comm_rank(comm, &problem.rank);
  if (size > 1)
    problem.sum = [comm](double* numbers, Index count) {
      if (MPI_Allreduce(MPI_IN_PLACE, numbers, static_cast<int>(count), MPI_DOUBLE, MPI_SUM, comm) !=
          MPI_SUCCESS)
        throw std::runtime_error("block Lanczos: the processes cannot add up their numbers");
    };
  return problem;
}

// The residual of K x = lambda M x is measured in a norm that stresses short waves: two digits are lost to it.
constexpr double kShortWaves = 1e2;

// Of the memory that is left a half, on the process that has least of it: the pairs found stand beside the basis.
double room_for_vectors(EPS eps) {
  const double vectors = 0.5 * available_memory() / (sizeof(double) * std::max<double>(eps->nloc, 1.0));
  double least = vectors;
  if (MPI_Allreduce(&vectors, &least, 1, MPI_DOUBLE, MPI_MIN,
                    PetscObjectComm(reinterpret_cast<PetscObject>(eps))) != MPI_SUCCESS)
    throw std::runtime_error("block Lanczos: the processes cannot compare their memory");
  return least;
}

int width_of_blocks(EPS eps) {
  return data(eps).block > 0 ? static_cast<int>(data(eps).block)
                             : block_lanczos_width(static_cast<int>(eps->nev));
}

int width_in_slices(EPS eps) {
  return data(eps).block > 0 ? static_cast<int>(data(eps).block) : kSliceBlock;
}

// Modes of a slice, 0 for one basis: the user's choice, or what is faster.
int modes_of_slice(EPS eps) {
  const Data& own = data(eps);
  if (!own.context) {
    if (own.slice > 0)
      throw std::invalid_argument(
          "-eps_blocklanczos_slice: slices are for reductions, which give block Lanczos their shifts; leave "
          "the option out");
    return 0;
  }
  if (!own.context->problem->shifted) return 0;
  if (own.slice >= 0)  // of all that there are at most
    return static_cast<int>(std::min(
        own.slice, own.context->request.omega2_max > 0.0 ? eps->n : std::max<PetscInt>(eps->nev, 1)));
  return modes_per_slice(*own.context->problem, static_cast<double>(eps->n), static_cast<int>(eps->nev),
                         width_in_slices(eps));
}

// Thrown out of a search up to a frequency in one basis when it is seen that there are many modes.
struct ManyModes {
  int slice = 0;  // modes of a slice
};

void abandon_if_many(EPS eps, const EigenProblem& problem, const EigenRequest& request,
                     const Eigen::VectorXd& omega2, Index known) {
  constexpr Index kEnoughToTell = 60;
  if (!(request.omega2_max > 0.0) || known < kEnoughToTell || data(eps).slice >= 0) return;
  const double count = expected_below(omega2.head(known), request.omega2_max);
  if (count < 3.0 * static_cast<double>(known)) return;  // it has come too far
  const int slice = modes_per_slice(problem, static_cast<double>(eps->n),
                                    static_cast<int>(std::min(count, 1e6)), width_in_slices(eps));
  if (slice > 0) throw ManyModes{slice};
}

PetscInt vectors_of_basis(EPS eps, double room) {
  const int count = static_cast<int>(eps->nev), slice = modes_of_slice(eps);
  return static_cast<PetscInt>(
      slice == 0 ? block_lanczos_vectors(count, width_of_blocks(eps), room)
                 : slice_vectors(slice, width_in_slices(eps), room - static_cast<double>(count)));
}

PetscErrorCode set_up(EPS eps) {
  EPSCheckHermitianDefinite(eps);
  EPSCheckSinvert(eps);
  EPSCheckUnsupported(eps, EPS_FEATURE_BALANCE | EPS_FEATURE_ARBITRARY | EPS_FEATURE_REGION |
                               EPS_FEATURE_EXTRACTION | EPS_FEATURE_CONVERGENCE | EPS_FEATURE_STOPPING |
                               EPS_FEATURE_TWOSIDED);
  return guarded([eps] {
    if (!eps->which) eps->which = EPS_TARGET_MAGNITUDE;
    const EPSWhich lowest[] = {EPS_TARGET_MAGNITUDE, EPS_TARGET_REAL, EPS_SMALLEST_REAL,
                               EPS_SMALLEST_MAGNITUDE};
    if (std::find(std::begin(lowest), std::end(lowest), eps->which) == std::end(lowest))
      throw std::invalid_argument(
          "block Lanczos finds the lowest eigenvalues above its shift (target), no others");
    if (eps->nds > 0) throw std::invalid_argument("block Lanczos knows no deflation space");
    if (eps->tol == PETSC_DEFAULT) eps->tol = SLEPC_DEFAULT_TOL;
    if (eps->max_it == PETSC_DEFAULT) eps->max_it = 2000;
    const auto most = static_cast<PetscInt>(eps->n + 2 * width_of_blocks(eps));
    if (eps->ncv == PETSC_DEFAULT) eps->ncv = std::min(most, vectors_of_basis(eps, room_for_vectors(eps)));
    eps->mpd = eps->ncv;
    ok(EPSAllocateSolution(eps, 0));
    ok(EPS_SetInnerProduct(eps));
  });
}

PetscErrorCode set_up_sort(EPS eps) {
  eps->sc->comparison = SlepcCompareSmallestReal;  // of eigenvalues, as they are when SLEPc sorts them
  eps->sc->comparisonctx = nullptr;
  eps->sc->map = nullptr;
  eps->sc->mapobj = nullptr;
  return 0;
}

// Tells SLEPc of pairs: eigr holds what the ST makes of the eigenvalues.
void show(EPS eps, const EigenProblem& problem, const Eigen::VectorXd& omega2,
          const Eigen::VectorXd& estimate) {
  const Index count = std::min<Index>(omega2.size(), eps->ncv);
  for (Index k = 0; k < count; ++k) {
    eps->eigr[k] = 1.0 / (omega2(k) + problem.shift);
    eps->eigi[k] = 0.0;
    eps->errest[k] = estimate(k);
  }
}

// Whether SLEPc itself will read the eigenvectors: with a context they are taken from there, and a second copy of many of them
// is memory that they need.
bool vectors_are_shown() {
  for (const char* name :
       {"-eps_view_vectors", "-eps_error_absolute", "-eps_error_relative", "-eps_error_backward"}) {
    PetscBool given = PETSC_FALSE;
    ok(PetscOptionsHasName(nullptr, nullptr, name, &given));
    if (given) return true;
  }
  return false;
}

PetscErrorCode solve(EPS eps) {
  return guarded([eps] {
    const Data& own = data(eps);
    const EigenProblem problem = problem_of(eps);
    EigenRequest request{static_cast<int>(eps->nev), 0.0, kShortWaves * eps->tol};
    Progress progress;
    if (own.context) {
      request = own.context->request;
      progress = own.context->progress;
    }
    BlockLanczosSettings settings;
    settings.block = width_of_blocks(eps);
    settings.most_vectors = static_cast<int>(eps->ncv);
    settings.most_blocks = static_cast<int>(eps->max_it);
    settings.none_below = !own.context;
    PetscScalar* basis = nullptr;
    settings.storage = [&](Index columns) {
      if (basis) ok(BVRestoreArray(eps->V, &basis));
      PetscInt has = 0;
      ok(BVGetSizes(eps->V, nullptr, nullptr, &has));
      if (columns > has) ok(BVResize(eps->V, static_cast<PetscInt>(columns), PETSC_TRUE));
      ok(BVSetActiveColumns(eps->V, 0, static_cast<PetscInt>(columns)));
      ok(BVGetArray(eps->V, &basis));
      return basis;
    };
    bool in_slices = false;
    settings.look = [&](const Eigen::VectorXd& omega2, const Eigen::VectorXd& estimate, Index known,
                        int n_blocks) {
      show(eps, problem, omega2, estimate);
      eps->its = n_blocks;
      const auto shown = static_cast<PetscInt>(std::min<Index>(omega2.size(), eps->ncv));
      ok(EPSMonitor(eps, eps->its, std::min(static_cast<PetscInt>(known), shown), eps->eigr, eps->eigi,
                    eps->errest, shown));
      if (!in_slices) abandon_if_many(eps, problem, request, omega2, known);
    };
    EigenPairs pairs;
    try {
      int slice = modes_of_slice(eps);
      if (slice == 0 && own.context && is_dense(problem, request)) {
        pairs = dense_pairs(problem, request);
      } else if (slice == 0) {
        try {
          pairs = iterate_block_lanczos(problem, request, settings, progress);
        } catch (const ManyModes& many) {
          slice = many.slice;
          settings.most_vectors = std::max(settings.most_vectors,
                                           slice_vectors(slice, width_in_slices(eps), room_for_vectors(eps)));
        } catch (
            const std::runtime_error&) {  // modes as many as rounding spoils, or as the basis has room for
          if (!own.context || !may_be_dense(problem)) throw;
          pairs = dense_pairs(problem, request);
        }
      }
      in_slices = slice > 0;
      if (in_slices) settings.block = width_in_slices(eps);
      data(eps).used_slice = slice;
      data(eps).used_block = settings.block;
      if (in_slices) pairs = iterate_slices(problem, request, {slice, settings}, progress);
    } catch (...) {
      if (basis) BVRestoreArray(eps->V, &basis);
      throw;
    }
    ok(BVRestoreArray(eps->V, &basis));
    // Pairs beyond nev (clusters, all up to a limit) may be more than there was room for.
    const Index count = pairs.Phi.cols();
    eps->ncv = std::max(eps->ncv, static_cast<PetscInt>(count));
    ok(EPSAllocateSolution(eps, 0));
    ok(BVSetActiveColumns(eps->V, 0, eps->ncv));
    if (!own.context || vectors_are_shown()) {
      ok(BVGetArray(eps->V, &basis));
      Eigen::Map<MatrixXd>(basis, problem.n, count) = pairs.Phi;
      ok(BVRestoreArray(eps->V, &basis));
    }
    std::iota(eps->perm, eps->perm + eps->ncv, 0);  // SLEPc sorts it
    show(eps, problem, pairs.omega2, pairs.residual);
    eps->nconv = static_cast<PetscInt>(count);
    eps->its = pairs.n_blocks;
    eps->reason = EPS_CONVERGED_TOL;
    if (own.context) own.context->pairs = std::move(pairs);
  });
}

PetscErrorCode transform_back(EPS eps) {
  return STBackTransform(eps->st, eps->nconv, eps->eigr, eps->eigi);
}

// The basis holds eigenvectors already.
PetscErrorCode compute_vectors(EPS) {
  return 0;
}

PetscErrorCode set_from_options(EPS eps, PetscOptionItems* PetscOptionsObject) {
  PetscOptionsHeadBegin(PetscOptionsObject, "EPS block Lanczos options");
  PetscInt block = data(eps).block > 0 ? data(eps).block : block_lanczos_width(1);
  PetscBool given = PETSC_FALSE;
  PetscCall(PetscOptionsBoundedInt(
      "-eps_blocklanczos_block", "right-hand sides solved for together; 8, or 16 for many modes in one basis",
      "", block, &block, &given, 1));
  if (given) data(eps).block = block;
  PetscInt slice = std::max<PetscInt>(data(eps).slice, 0);
  PetscCall(PetscOptionsBoundedInt("-eps_blocklanczos_slice",
                                   "modes of a slice of the spectrum; 0: one basis for all", "", slice,
                                   &slice, &given, 0));
  if (given) data(eps).slice = slice;
  PetscOptionsHeadEnd();
  return 0;
}

PetscErrorCode view(EPS eps, PetscViewer viewer) {
  PetscBool ascii = PETSC_FALSE;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &ascii));
  if (!ascii) return 0;
  const Data& own = data(eps);
  PetscCall(PetscViewerASCIIPrintf(
      viewer, "  blocks of %d right-hand sides, full reorthogonalisation, thick restarts\n",
      own.used_block > 0 ? own.used_block : width_of_blocks(eps)));
  if (own.used_slice > 0)
    PetscCall(PetscViewerASCIIPrintf(
        viewer, "  slices of %d modes of the spectrum, each from a shift of its own\n", own.used_slice));
  return 0;
}

PetscErrorCode set_default_st(EPS eps) {
  if (!reinterpret_cast<PetscObject>(eps->st)->type_name) return STSetType(eps->st, STSINVERT);
  return 0;
}

PetscErrorCode destroy(EPS eps) {
  delete static_cast<Data*>(eps->data);
  eps->data = nullptr;
  return 0;
}

PetscErrorCode create(EPS eps) {
  eps->data = new Data;
  eps->useds = PETSC_FALSE;
  eps->categ = EPS_CATEGORY_KRYLOV;
  eps->ops->setup = set_up;
  eps->ops->setupsort = set_up_sort;
  eps->ops->solve = solve;
  eps->ops->setfromoptions = set_from_options;
  eps->ops->view = view;
  eps->ops->destroy = destroy;
  eps->ops->backtransform = transform_back;
  eps->ops->computevectors = compute_vectors;
  eps->ops->setdefaultst = set_default_st;
  return 0;
}

}  // namespace

void register_block_lanczos() {
  petsc_check(EPSInitializePackage(), "starting");
  petsc_check(EPSRegister(kBlockLanczos, create), "registering the eigensolver type blocklanczos");
}

void set_context(EPS eps, BlockLanczosContext& context) {
  data(eps).context = &context;
}

}  // namespace flexura::linalg
