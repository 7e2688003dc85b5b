// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/model_factor.hpp"

#include <stdexcept>

#include "reduce/assembly/shared_modes.hpp"
#include "reduce/linalg/factor/cholesky.hpp"
#include "reduce/linalg/factor/inertia.hpp"
#include "reduce/linalg/session/user_options.hpp"

namespace flexura::reduce {
namespace {

using Eigen::MatrixXd;
using Eigen::Ref;
using linalg::DistributedFactor;
using Task = linalg::Team::Task;

}  // namespace

struct ModelFactor::Impl {
  virtual ~Impl() = default;
  virtual MatrixXd solve(const Ref<const MatrixXd>& B) const = 0;
  virtual void view(_p_PetscViewer*) const {}
  virtual const DistributedFactor* distributed() const { return nullptr; }
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

// Collective: every rank brings its share of K_ii + shift M_ii.
std::unique_ptr<DistributedFactor> factorise(const linalg::Team& team, const TiedMatrices& own, double shift,
                                             const linalg::RowShares& rows,
                                             const std::vector<std::pair<int, double>>& diagonal = {}) {
  std::unique_ptr<DistributedFactor> L;
  team.together([&] {
    if (shift == 0.0)
      L = std::make_unique<DistributedFactor>(team, own.K_ii().csr(), rows, diagonal);
    else
      L = std::make_unique<DistributedFactor>(team, own.shifted_stiffness(shift).csr(), rows, diagonal);
  });
  return L;
}

// Rank 0's hand on what all ranks do.
struct Shared : ModelFactor::Impl {
  const linalg::Team& team;
  std::unique_ptr<DistributedFactor> L;
  std::vector<int> no_order;

  Shared(const TiedModel& model, double shift, const std::vector<std::pair<int, double>>& diagonal)
      : team(*model.shares().team) {
    team.call(Task::factorise);
    team.share(shift);
    L = factorise(team, model.shares().own->matrices(), shift, model.shares().rows, diagonal);
  }
  ~Shared() override {
    team.call(Task::forget);
    L.reset();  // MPI's objects go on all ranks together
  }
  MatrixXd solve(const Ref<const MatrixXd>& B) const override {
    team.call(Task::solve);
    return L->solve(B);
  }
  const DistributedFactor* distributed() const override { return L.get(); }
  int n_negative() const override { return L->n_negative(); }
  const std::vector<int>& order() const override { return no_order; }
  const linalg::FactorFigures& figures() const override { return L->figures(); }
};

}  // namespace

ModelFactor ModelFactor::stiffness(const TiedModel& model, const linalg::FactorStorage& storage) {
  if (!model.shares().team)
    return ModelFactor(std::make_unique<Definite>(
        linalg::CholeskyFactor(model.K_ii(), model.numbering().group_begin(), model.pins(), storage)));
  std::vector<std::pair<int, double>> springs;
  for (const int pin : model.pins()) springs.emplace_back(pin, model.K_ii().diagonal(pin));
  auto shared = std::make_unique<Shared>(model, 0.0, springs);
  if (shared->L->n_negative() + shared->L->n_zero() > 0)
    throw linalg::SingularMatrix(-1, "the matrix is not positive definite to round-off");
  return ModelFactor(std::move(shared));
}

ModelFactor ModelFactor::shifted(const TiedModel& model, double shift, std::vector<int> order,
                                 const linalg::FactorStorage& storage) {
  if (!model.shares().team)
    return ModelFactor(std::make_unique<Indefinite>(
        linalg::IndefiniteFactor(model.matrices().shifted_stiffness(shift), std::move(order), storage)));
  auto shared = std::make_unique<Shared>(model, shift, std::vector<std::pair<int, double>>{});
  if (shared->L->n_zero() > 0)
    throw std::runtime_error(
        "counting eigenvalues: the limit is too close to an eigenvalue of the structure; move it a little");
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
const DistributedFactor* ModelFactor::distributed() const {
  return impl_->distributed();
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

double peak_memory_of_others(const linalg::Team& team) {
  double greatest = 0.0;
  team.call(Task::tell_memory);
  team.together([&] { greatest = team.greatest(0.0); });
  return greatest;
}

void serve(const linalg::Team& team) {
  std::unique_ptr<ModelShare> share;
  linalg::RowShares rows;
  std::unique_ptr<DistributedFactor> factor;
  std::unique_ptr<linalg::UserOptions> options;
  for (;;) {
    const Task task = team.wait();
    switch (task) {
      case Task::stop:
        return;
      case Task::take_share:
        share = take_share(team, rows);
        break;
      case Task::factorise: {
        double shift = 0.0;
        team.share(shift);
        factor = factorise(team, share->matrices(), shift, rows);
        break;
      }
      case Task::solve:
        factor->solve(MatrixXd());
        break;
      case Task::find_modes:
        join_shared_modes(team, share->matrices(), rows, *factor);
        break;
      case Task::forget:
        factor.reset();
        break;
      case Task::take_options:
        options.reset();
        options = linalg::take_options(team);
        break;
      case Task::tell_memory:
        team.together([&] { team.greatest(linalg::peak_memory()); });
        break;
      case Task::print_log:
        if (options) options->print_log();
        break;
    }
  }
}

}  // namespace flexura::reduce
