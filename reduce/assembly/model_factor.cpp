// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/model_factor.hpp"

#include <stdexcept>

#include "reduce/linalg/factor/cholesky.hpp"
#include "reduce/linalg/factor/distributed_factor.hpp"
#include "reduce/linalg/factor/inertia.hpp"

namespace flexura::reduce {
namespace {

using Eigen::MatrixXd;
using Eigen::Ref;
using linalg::DistributedFactor;

}  // namespace

struct ModelFactor::Impl {
  virtual ~Impl() = default;
  virtual MatrixXd solve(const Ref<const MatrixXd>& B) const = 0;
  virtual void view(_p_PetscViewer*) const {}
  virtual int n_negative() const = 0;
  virtual const std::vector<int>& order() const = 0;
  virtual const linalg::FactorFigures& figures() const = 0;
};

namespace {

struct Definite : ModelFactor::Impl {
  linalg::CholeskyFactor L;
  explicit Definite(linalg::CholeskyFactor factor) : L(std::move(factor)) {}
  MatrixXd solve(const Ref<const MatrixXd>& B) const override { return L.solve(B); }
  void view(_p_PetscViewer* viewer) const override { L.view(viewer); }
  int n_negative() const override { return 0; }
  const std::vector<int>& order() const override { return L.order(); }
  const linalg::FactorFigures& figures() const override { return L.figures(); }
};

struct Indefinite : ModelFactor::Impl {
  linalg::IndefiniteFactor L;
  std::vector<int> no_order;
  explicit Indefinite(linalg::IndefiniteFactor factor) : L(std::move(factor)) {}
  MatrixXd solve(const Ref<const MatrixXd>& B) const override { return L.solve(B); }
  int n_negative() const override { return L.n_negative(); }
  const std::vector<int>& order() const override { return no_order; }
  const linalg::FactorFigures& figures() const override { return L.figures(); }
};

// Every rank brings its share of K_ii + shift M_ii.
struct Shared : ModelFactor::Impl {
  std::unique_ptr<DistributedFactor> L;
  std::vector<int> no_order;

  Shared(const TiedModel& model, DistributedFactor::Terms terms, DistributedFactor::Use use)
      : L(std::make_unique<DistributedFactor>(*model.share()->team, std::move(terms), model.share()->rows,
                                              use)) {}
  MatrixXd solve(const Ref<const MatrixXd>& B) const override { return L->solve(B); }
  void view(_p_PetscViewer* viewer) const override { L->view(viewer); }
  int n_negative() const override { return L->n_negative(); }
  const std::vector<int>& order() const override { return no_order; }
  const linalg::FactorFigures& figures() const override { return L->figures(); }
};

}  // namespace

ModelFactor ModelFactor::stiffness(const TiedModel& model, const Eigen::VectorXd& springs,
                                   const linalg::FactorStorage& storage) {
  if (!model.share())
    return ModelFactor(std::make_unique<Definite>(
        linalg::CholeskyFactor(model.K_ii(), model.numbering().group_begin(), model.pins(), storage)));
  std::vector<std::pair<int, double>> diagonal;
  for (std::size_t p = 0; model.leads() && p < model.pins().size(); ++p)
    diagonal.emplace_back(model.share()->pins[p], springs(static_cast<Eigen::Index>(p)));
  auto shared = std::make_unique<Shared>(
      model, DistributedFactor::Terms{.matrix = model.K_ii().csr(), .diagonal = std::move(diagonal)},
      DistributedFactor::Use::solve);
  if (shared->L->n_negative() + shared->L->n_zero() > 0) {
    shared.reset();  // all ranks are here
    throw linalg::SingularMatrix(-1, "the matrix is not positive definite to round-off");
  }
  return ModelFactor(std::move(shared));
}

ModelFactor ModelFactor::shifted(const TiedModel& model, double shift, std::vector<int> order,
                                 const linalg::FactorStorage& storage) {
  if (!model.share())
    return ModelFactor(std::make_unique<Indefinite>(
        linalg::IndefiniteFactor(model.matrices().shifted_stiffness(shift), std::move(order), storage)));
  DistributedFactor::Terms terms;
  {
    const linalg::SymmetricMatrix K = model.matrices().shifted_stiffness(shift);
    terms = {.matrix = K.csr(), .held_by = K.share()};
  }
  auto shared = std::make_unique<Shared>(
      model, std::move(terms),
      storage.to_count ? DistributedFactor::Use::count : DistributedFactor::Use::solve);
  if (shared->L->n_zero() > 0) {
    shared.reset();
    throw std::runtime_error(
        "counting eigenvalues: the limit is too close to an eigenvalue of the structure; move it a little");
  }
  return ModelFactor(std::move(shared));
}

ModelFactor::ModelFactor(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ModelFactor::~ModelFactor() = default;
ModelFactor::ModelFactor(ModelFactor&&) noexcept = default;
ModelFactor& ModelFactor::operator=(ModelFactor&&) noexcept = default;

MatrixXd ModelFactor::solve(const Ref<const MatrixXd>& B) const {
  return impl_->solve(B);
}
void ModelFactor::view(_p_PetscViewer* viewer) const {
  impl_->view(viewer);
}
int ModelFactor::n_negative() const {
  return impl_->n_negative();
}
const std::vector<int>& ModelFactor::order() const {
  return impl_->order();
}
const linalg::FactorFigures& ModelFactor::figures() const {
  return impl_->figures();
}

}  // namespace flexura::reduce
