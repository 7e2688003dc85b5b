// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/row_exchange.hpp"

#include <mpi.h>

#include <algorithm>
#include <stdexcept>

namespace flexura::linalg {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Lists = std::vector<std::vector<int>>;

constexpr Index kColumns = 32;  // together, to bound the memory of what is packed

// Visits entry (row, column) of n x width numbers with its place: by ranks, and the rows of a rank by columns.
template <class Visit>
void each_packed(const RowShares& rows, Index width, const Visit& visit) {
  const auto n_ranks = static_cast<int>(rows.begin.size()) - 1;
  std::vector<int> owner(rows.number.size());
  for (int r = 0; r < n_ranks; ++r)
    std::fill(owner.begin() + rows.begin[r], owner.begin() + rows.begin[r + 1], r);
  for (std::size_t row = 0; row < rows.number.size(); ++row) {
    const int number = rows.number[row], r = owner[number];
    const Index height = rows.begin[r + 1] - rows.begin[r];
    const Index place = rows.begin[r] * width + (number - rows.begin[r]);
    for (Index c = 0; c < width; ++c) visit(static_cast<Index>(row), c, place + c * height);
  }
}

std::vector<int> counts_of(const RowShares& rows, Index width) {
  std::vector<int> counts;
  for (std::size_t r = 1; r < rows.begin.size(); ++r)
    counts.push_back((rows.begin[r] - rows.begin[r - 1]) * static_cast<int>(width));
  return counts;
}

template <class Type>
std::vector<Type> exchange(const std::vector<Type>& out, const Lists& sent, const Lists& received, int width,
                           MPI_Datatype type) {
  const auto counts = [&](const Lists& lists) {
    std::vector<int> sizes;
    for (const auto& list : lists) sizes.push_back(static_cast<int>(list.size()) * width);
    return sizes;
  };
  const auto places = [](const std::vector<int>& sizes) {
    std::vector<int> begin(sizes.size(), 0);
    for (std::size_t r = 1; r < sizes.size(); ++r) begin[r] = begin[r - 1] + sizes[r - 1];
    return begin;
  };
  const std::vector<int> n_sent = counts(sent), n_received = counts(received);
  const std::vector<int> from = places(n_sent), to = places(n_received);
  std::vector<Type> in(static_cast<std::size_t>(to.back() + n_received.back()));
  if (MPI_Alltoallv(out.data(), n_sent.data(), from.data(), type, in.data(), n_received.data(), to.data(),
                    type, MPI_COMM_WORLD) != MPI_SUCCESS)
    throw std::runtime_error("the processes cannot exchange their rows");
  return in;
}

}  // namespace

MatrixXd scatter_rows(const Team& team, const RowShares& rows, const Eigen::Ref<const MatrixXd>& all) {
  int n_cols = static_cast<int>(all.cols());
  team.share(n_cols);
  MatrixXd own(rows.n_own(team), n_cols);
  std::vector<double> packed;
  for (Index first = 0; first < n_cols; first += kColumns) {
    const Index width = std::min(kColumns, n_cols - first);
    if (team.rank() == 0) {
      packed.resize(rows.number.size() * static_cast<std::size_t>(width));
      each_packed(rows, width, [&](Index row, Index c, Index place) { packed[place] = all(row, first + c); });
    }
    team.scatter(packed.data(), counts_of(rows, width), own.col(first).data());
  }
  return own;
}

RowExchange::RowExchange(const Team& team, const RowShares& rows)
    : n_own_(rows.n_own(team)), n_(static_cast<int>(rows.number.size())), rank_(team.rank()) {
  const auto size = static_cast<std::size_t>(team.size());
  asked_.resize(size);
  given_.resize(size);
  std::vector<int> numbers;
  for (int row = 0; row < n_; ++row) {
    const auto owner = std::upper_bound(rows.begin.begin(), rows.begin.end(), rows.number[row]) - 1;
    asked_[static_cast<std::size_t>(owner - rows.begin.begin())].push_back(row);
  }
  for (std::size_t r = 0; r < size; ++r)
    for (const int row : asked_[r]) numbers.push_back(rows.number[row] - rows.begin[r]);
  std::vector<int> n_asked, n_given(size);
  for (const auto& list : asked_) n_asked.push_back(static_cast<int>(list.size()));
  MPI_Alltoall(n_asked.data(), 1, MPI_INT, n_given.data(), 1, MPI_INT, MPI_COMM_WORLD);
  for (std::size_t r = 0; r < size; ++r) given_[r].resize(static_cast<std::size_t>(n_given[r]));
  const std::vector<int> theirs = exchange(numbers, asked_, given_, 1, MPI_INT);
  std::size_t at = 0;
  for (auto& list : given_)
    for (int& row : list) row = theirs[at++];
}

namespace {

std::size_t total(const Lists& lists) {
  std::size_t n = 0;
  for (const auto& list : lists) n += list.size();
  return n;
}

// Rows of X by ranks, and those of a rank by columns.
std::vector<double> packed(const Lists& lists, const Eigen::Ref<const MatrixXd>& X) {
  std::vector<double> out;
  out.reserve(total(lists) * static_cast<std::size_t>(X.cols()));
  for (const auto& list : lists)
    for (Index c = 0; c < X.cols(); ++c)
      for (const int row : list) out.push_back(X(row, c));
  return out;
}

}  // namespace

MatrixXd RowExchange::spread(const Eigen::Ref<const MatrixXd>& own) const {
  MatrixXd all = MatrixXd::Zero(n_, own.cols());
  for (Index first = 0; first < own.cols(); first += kColumns) {
    const Index width = std::min(kColumns, own.cols() - first);
    const std::vector<double> in = exchange(packed(given_, own.middleCols(first, width)), given_, asked_,
                                            static_cast<int>(width), MPI_DOUBLE);
    std::size_t at = 0;
    for (const auto& list : asked_)
      for (Index c = 0; c < width; ++c)
        for (const int row : list) all(row, first + c) = in[at++];
  }
  return all;
}

MatrixXd RowExchange::collect(const Eigen::Ref<const MatrixXd>& parts) const {
  MatrixXd own = MatrixXd::Zero(n_own_, parts.cols());
  for (Index first = 0; first < parts.cols(); first += kColumns) {
    const Index width = std::min(kColumns, parts.cols() - first);
    const std::vector<double> in = exchange(packed(asked_, parts.middleCols(first, width)), asked_, given_,
                                            static_cast<int>(width), MPI_DOUBLE);
    std::size_t at = 0;
    for (const auto& list : given_)
      for (Index c = 0; c < width; ++c)
        for (const int row : list) own(row, first + c) += in[at++];
  }
  return own;
}

MatrixXd RowExchange::own_of(const Eigen::Ref<const MatrixXd>& parts) const {
  const auto r = static_cast<std::size_t>(rank_);
  MatrixXd own = MatrixXd::Zero(n_own_, parts.cols());
  for (std::size_t k = 0; k < asked_[r].size(); ++k) own.row(given_[r][k]) = parts.row(asked_[r][k]);
  return own;
}

}  // namespace flexura::linalg
