// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/cell_sample.hpp"

#include <algorithm>
#include <numeric>

namespace flexura::reduce {

using Eigen::Index;

namespace {

// Cells in the order of pieces of at most `most`: halves along the longest side, again and again.
void bisect(const Eigen::Matrix3Xd& centres, std::vector<std::size_t>& order, std::size_t first,
            std::size_t last, std::size_t most, std::vector<std::size_t>& ends) {
  if (last - first <= most) {
    ends.push_back(last);
    return;
  }
  Eigen::Vector3d low = centres.col(static_cast<Index>(order[first])), high = low;
  for (std::size_t k = first; k < last; ++k) {
    low = low.cwiseMin(centres.col(static_cast<Index>(order[k])));
    high = high.cwiseMax(centres.col(static_cast<Index>(order[k])));
  }
  Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = (first + last) / 2;
  const auto begin = order.begin();
  // Ties by number, so that every machine makes the same pieces.
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(last), [&](std::size_t a, std::size_t b) {
                     const double x = centres(axis, static_cast<Index>(a)),
                                  y = centres(axis, static_cast<Index>(b));
                     return x < y || (x == y && a < b);
                   });
  bisect(centres, order, first, middle, most, ends);
  bisect(centres, order, middle, last, most, ends);
}

}  // namespace

CellSample choose_cells(const Part& part, const Eigen::MatrixXf& indicator) {
  const auto n_cells = static_cast<std::size_t>(indicator.rows());
  // Nodes at a piece's border are held, so that small pieces tell too little by a few per cent only (pieces of 128 cells 0.8 to 1.1
  // of what all cells tell, once 1.4; of 64 from 0.7 on; with free borders of 128 up to three times as much).  Several random ones
  // tell how much ratios vary; large meshes have time for more of them.
  constexpr std::size_t piece = 128, n_top = 2;
  const std::size_t n_random = std::clamp(n_cells / 2000, std::size_t{3}, std::size_t{12});
  CellSample out;
  if (n_cells <= (n_top + n_random + 1) * piece) {
    out.cells.resize(n_cells);
    std::iota(out.cells.begin(), out.cells.end(), std::size_t{0});
    out.random.assign(n_cells, 1);
    return out;
  }
  Eigen::Matrix3Xd centres(3, indicator.rows());
  Index cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Index row = 0; row < block.nodes.rows(); ++row, ++cell) {
      const int corners = mesh::shape_of(block.type).corners;
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int a = 0; a < corners; ++a) sum += part.mesh.points.row(block.nodes(row, a)).transpose();
      centres.col(cell) = sum / corners;
    }
  std::vector<std::size_t> order(n_cells), ends;
  std::iota(order.begin(), order.end(), std::size_t{0});
  bisect(centres, order, 0, n_cells, piece, ends);

  // Of each piece the greatest share of a state's indicator.
  const std::size_t n_pieces = ends.size();
  const Eigen::RowVectorXf over_total = indicator.colwise().sum().cwiseMax(1e-37f).cwiseInverse();
  std::vector<float> share(n_pieces);
  for (std::size_t p = 0, first = 0; p < n_pieces; first = ends[p++]) {
    Eigen::RowVectorXf sum = Eigen::RowVectorXf::Zero(indicator.cols());
    for (std::size_t k = first; k < ends[p]; ++k) sum += indicator.row(static_cast<Index>(order[k]));
    share[p] = sum.cwiseProduct(over_total).maxCoeff();
  }
  std::vector<std::size_t> by_share(n_pieces);
  std::iota(by_share.begin(), by_share.end(), std::size_t{0});
  std::stable_sort(by_share.begin(), by_share.end(),
                   [&](std::size_t a, std::size_t b) { return share[a] > share[b]; });
  std::vector<char> top(n_pieces, 0);
  for (std::size_t k = 0; k < n_top; ++k) top[by_share[k]] = 1;
  const std::size_t n_others = n_pieces - n_top;
  std::size_t other = 0, taken = 0;
  for (std::size_t p = 0, first = 0; p < n_pieces; first = ends[p++]) {
    bool random = false;
    if (!top[p]) {
      random = taken < n_random && other == (2 * taken + 1) * n_others / (2 * n_random);
      taken += random;
      ++other;
    }
    if (!top[p] && !random) continue;
    for (std::size_t k = first; k < ends[p]; ++k) {
      out.cells.push_back(order[k]);
      out.random.push_back(random);
    }
  }
  return out;
}

void extend(const CellSample& sample, const Eigen::MatrixXf& of_sample, Eigen::MatrixXf& indicator) {
  std::vector<char> chosen(static_cast<std::size_t>(indicator.rows()), 0);
  Eigen::RowVectorXd known = Eigen::RowVectorXd::Zero(indicator.cols()), indicated = known, all_known = known,
                     all_indicated = known;
  for (std::size_t k = 0; k < sample.cells.size(); ++k) {
    const auto cell = static_cast<Index>(sample.cells[k]);
    chosen[sample.cells[k]] = 1;
    const Eigen::RowVectorXd here = of_sample.row(static_cast<Index>(k)).cast<double>(),
                             said = indicator.row(cell).cast<double>();
    all_known += here;
    all_indicated += said;
    if (sample.random[k]) {
      known += here;
      indicated += said;
    }
    indicator.row(cell) = of_sample.row(static_cast<Index>(k));
  }
  for (Index c = 0; c < indicator.cols(); ++c) {
    // A state with nothing at the random places has it at the others.
    const bool few = indicated(c) < 1e-3 * all_indicated(c);
    const double whole = few ? all_indicated(c) : indicated(c),
                 ratio = whole > 0.0 ? (few ? all_known(c) : known(c)) / whole : 0.0;
    for (Index cell = 0; cell < indicator.rows(); ++cell)
      if (!chosen[static_cast<std::size_t>(cell)]) indicator(cell, c) *= static_cast<float>(ratio);
  }
}

}  // namespace flexura::reduce
