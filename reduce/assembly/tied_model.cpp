// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_model.hpp"

#include <cmath>
#include <utility>

#include "reduce/assembly/ties/tied_checks.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::MatrixXd;
using Eigen::Ref;

const char* name_of(Tie tie) {
  switch (tie) {
    case Tie::rigid:
      return "rigid";
    case Tie::average:
      return "average";
    case Tie::node:
      return "node";
    case Tie::elastic:
      return "elastic";
  }
  return "unknown";
}

TiedModel::TiedModel(const Part& part, const AssemblyOptions& options)
    : numbering_(checked_numbering(part, options.may_be_free)),
      pins_(options.shift == 0.0 ? choose_pins(numbering_) : std::vector<int>{}),
      averages_(part, numbering_),
      motions_(numbering_, averages_),
      matrices_(part, numbering_),
      n_i_(numbering_.n_i()),
      n_rows_(numbering_.n_i()) {
  matrices_.assemble(part, options);
  K_bb_ = matrices_.K_bb();
}

TiedModel::TiedModel(const PartShare& share, const AssemblyOptions& options)
    : numbering_(share.numbering),
      averages_(Eigen::SparseMatrix<double, Eigen::RowMajor>(share.At.transpose().sparseView()),
                share.averaged_dofs),
      motions_(numbering_, averages_),
      matrices_(share.part, numbering_),
      share_(&share),
      exchange_(std::make_unique<linalg::RowExchange>(*share.team, share.rows)),
      n_i_(share.n_i),
      n_rows_(share.rows.n_own(*share.team)) {
  const int first = share.rows.begin[share.team->rank()];
  for (const int pin : share.pins)
    pins_.push_back(pin >= first && pin < first + n_rows_ ? pin - first : kElsewhere);
  matrices_.assemble(share.part, options);
  share.team->meet();
  K_bb_ = sum(matrices_.K_bb());
}

MatrixXd TiedModel::sum(MatrixXd terms) const {
  if (share_) share_->team->sum({terms.data(), static_cast<std::size_t>(terms.size())});
  return terms;
}

MatrixXd TiedModel::inner(const Ref<const MatrixXd>& A, const Ref<const MatrixXd>& B) const {
  return sum(linalg::transpose_times(A, B));
}

double TiedModel::norm(const MatrixXd& A) const {
  return share_ ? std::sqrt(sum(MatrixXd::Constant(1, 1, A.squaredNorm()))(0, 0)) : A.norm();
}

void TiedModel::share(MatrixXd& small) const {
  if (!share_) return;
  int rows = static_cast<int>(small.rows()), cols = static_cast<int>(small.cols());
  share_->team->share(rows);
  share_->team->share(cols);
  small.resize(rows, cols);
  share_->team->share({small.data(), static_cast<std::size_t>(small.size())});
}

bool TiedModel::decide(bool here) const {
  int yes = here;
  if (share_) share_->team->share(yes);
  return yes != 0;
}

// Products of the rank's share with vectors of which it owns some rows.
template <class Product>
void TiedModel::shared(const Ref<const MatrixXd>& X, MatrixXd& Y, const Product& product) const {
  if (!share_) return product(X, Y);
  MatrixXd parts;
  product(exchange_->spread(X), parts);
  Y = exchange_->collect(parts);
}

void TiedModel::multiply_K(const Ref<const MatrixXd>& X, MatrixXd& Y) const {
  shared(X, Y, [&](const auto& x, MatrixXd& y) { K_ii().multiply(x, y); });
}

void TiedModel::multiply_magnitudes(const Ref<const MatrixXd>& X, MatrixXd& Y) const {
  shared(X, Y, [&](const auto& x, MatrixXd& y) { K_ii().multiply_magnitudes(x, y); });
}

void TiedModel::multiply_M(const Ref<const MatrixXd>& X, MatrixXd& Y) const {
  shared(X, Y, [&](const auto& x, MatrixXd& y) { matrices_.multiply_M_ii(x, y); });
}

MatrixXd TiedModel::dense_K_ib() const {
  const MatrixXd K_ib = matrices_.K_ib();
  return share_ ? exchange_->collect(K_ib) : K_ib;
}

void TiedModel::expand(const Ref<const MatrixXd>& u_i, const Ref<const MatrixXd>& u_b, MatrixXd& U) const {
  if (share_)
    motions_.expand(exchange_->spread(u_i), u_b, U);
  else
    motions_.expand(u_i, u_b, U);
}

void TiedModel::gather(const Ref<const MatrixXd>& F, MatrixXd& f_i, MatrixXd& f_b) const {
  motions_.gather(F, f_i, f_b);
  if (!share_) return;
  f_i = exchange_->collect(f_i);
  f_b = sum(std::move(f_b));
}

MatrixXd TiedModel::interface_motion(int k, const Ref<const MatrixXd>& u_i) const {
  if (!share_) return motions_.interface_motion(k, u_i, MatrixXd::Zero(n_b(), u_i.cols()));
  return sum(share_->Jt.at(static_cast<std::size_t>(k)).transpose() * u_i);
}

MatrixXd TiedModel::own_rows(MatrixXd interior) const {
  return share_ ? exchange_->own_of(interior) : interior;
}

std::vector<int> TiedModel::rows_in(const TiedModel& other) const {
  const std::vector<int> there = motions_.interior_in(other.motions_);
  if (!share_) return there;
  const auto row_of = [](const TiedModel& model, int dof) {
    const PartShare& share = *model.share_;
    return share.rows.number[dof] - share.rows.begin[share.team->rank()];
  };
  std::vector<int> rows(static_cast<std::size_t>(n_rows_), -1);
  for (std::size_t dof = 0; dof < there.size(); ++dof) {
    const int row = row_of(*this, static_cast<int>(dof));
    if (row >= 0 && row < n_rows_ && there[dof] >= 0) rows[row] = row_of(other, there[dof]);
  }
  return rows;
}

Eigen::VectorXd TiedModel::pin_stiffness() const {
  Eigen::VectorXd s = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(pins_.size()));
  if (!share_) {
    double largest = 0.0;
    for (int row = 0; row < n_rows_; ++row) largest = std::max(largest, K_ii().diagonal(row));
    for (std::size_t p = 0; p < pins_.size();
         ++p) {  // nothing at all resists what is rigid alone: across a plane truss
      const double own = K_ii().diagonal(pins_[p]);
      s(static_cast<Eigen::Index>(p)) = own > 1e-12 * largest ? own : largest;
    }
    return s;
  }
  for (std::size_t p = 0; p < pins_.size(); ++p)
    for (std::size_t i = 0; i < share_->rows.number.size(); ++i)
      if (share_->rows.number[i] == share_->pins[p])
        s(static_cast<Eigen::Index>(p)) = K_ii().diagonal(static_cast<int>(i));
  return sum(s);
}

MatrixXd TiedModel::at_nodes(const Ref<const MatrixXd>& U, const std::vector<mesh::Index>& nodes) const {
  if (!share_) {
    MatrixXd out(3 * static_cast<Eigen::Index>(nodes.size()), U.cols());
    for (std::size_t v = 0; v < nodes.size(); ++v)
      out.middleRows<3>(3 * static_cast<Eigen::Index>(v)) =
          U.middleRows<3>(3 * static_cast<Eigen::Index>(nodes[v]));
    return out;
  }
  return collect_nodes(*share_, U, nodes);
}

}  // namespace flexura::reduce
