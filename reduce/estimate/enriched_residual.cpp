// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enriched_residual.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <memory>

#include "reduce/elements/strain.hpp"
#include "reduce/estimate/cell_data.hpp"
#include "reduce/estimate/enriched_cells.hpp"
#include "reduce/estimate/enrichment.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr int kTogether = EnrichedCells::kLanes;
using DoublePanel = Eigen::Matrix<double, Eigen::Dynamic, kStatesTogether, Eigen::RowMajor>;

// Sixteen states each, filled up with zeros.
std::vector<DoublePanel> panels_of(const MatrixXd& U) {
  std::vector<DoublePanel> out;
  for (Index first = 0; first < U.cols(); first += kStatesTogether) {
    const Index width = std::min<Index>(kStatesTogether, U.cols() - first);
    DoublePanel& panel = out.emplace_back(U.rows(), kStatesTogether);
    if (width < kStatesTogether) panel.setZero();
    linalg::parallel_for(16, [&](int chunk) {
      constexpr Index kRows = 64;  // that stay in the cache while the columns are read
      for (Index row = U.rows() * chunk / 16, last = U.rows() * (chunk + 1) / 16; row < last; row += kRows) {
        const Index n = std::min(kRows, last - row);
        panel.block(row, 0, n, width) = U.block(row, first, n, width);
      }
    });
  }
  return out;
}

// Elements whose stress is not that of their displacements alone (strain.hpp): what theirs adds to the residual,
// - integral B_w^T D (B* - B) u dV.
class OwnStrains {
 public:
  OwnStrains(const mesh::CellBlock& block, const Part& part)
      : block_(block),
        part_(part),
        element_(solid_element(block.type, formulation_of(block, part.formulation))) {
    if (!differ()) return;
    for (const TabulatedRule::Point& point : element_.mass.points)
      gained_.push_back(evaluate_enrichment(block.type, point.xi).dw);
  }

  bool differ() const {
    return element_.strains != Strains::whole || element_.enhancement != Enhancement::none;
  }

  // r: 3 g x 16 by rows; sign: of the g gained functions.
  void add(Index row, const std::vector<float>& sign, const DoublePanel& u, float* r) const {
    const NodePositions x = positions(part_.mesh, block_, row);
    const Matrix6& D = part_.materials[material_of(block_, row)].D;
    const StrainField field(element_, x, D);
    const Index g = gained_.front().rows();
    MatrixXd C = MatrixXd::Zero(3 * g, 3 * x.rows());
    NodePositions gradients;
    StrainMatrix own, plain;
    for (std::size_t q = 0; q < gained_.size(); ++q) {
      const TabulatedRule::Point& point = element_.mass.points[q];
      const double det = field.at(point, own);
      if (!(det > 0.0)) return;
      spatial_gradients(point, x, gradients);
      fill_strain_matrix(gradients, plain);
      const StrainMatrix stress = (point.weight * det) * D * (own - plain);
      const Eigen::Matrix3d J = point.dN.transpose() * x;
      const Eigen::Matrix<double, Eigen::Dynamic, 3> dw = gained_[q] * J.inverse().transpose();
      for (Index f = 0; f < g; ++f) C.middleRows<3>(3 * f) += strain_operator(dw.row(f)).transpose() * stress;
    }
    for (Index f = 0; f < g; ++f) C.middleRows<3>(3 * f) *= sign[static_cast<std::size_t>(f)];
    Eigen::Map<Eigen::Matrix<float, Eigen::Dynamic, kStatesTogether, Eigen::RowMajor>>(
        r, 3 * g, kStatesTogether) -= (C * u).cast<float>();
  }

 private:
  const mesh::CellBlock& block_;
  const Part& part_;
  const Element& element_;
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, 3>> gained_;
};

// What a thread needs for cells of a block, and what it has found of them.
class Worker {
 public:
  Worker(const Part& part, const EnrichedMesh& mesh, const mesh::CellBlock& block)
      : part_(part),
        mesh_(mesh),
        block_(block),
        cells_(block.type, part.materials),
        u_(3 * cells_.n_own(), kStatesTogether),
        own_strains_(block, part) {}

  // Of `count` cells from `first` on: r, n_panels blocks of 3 g x 16 a cell, and stiffness, 3 g a cell.
  void compute(std::size_t first, int count, const std::vector<DoublePanel>& U, const Eigen::VectorXd& lambda,
               float* r, float* stiffness) {
    EnrichedCells::Cell lanes[kTogether];
    for (int lane = 0; lane < count; ++lane) {
      const EnrichedMesh::Cell& cell = mesh_.cells()[first + static_cast<std::size_t>(lane)];
      std::vector<float> sign(static_cast<std::size_t>(cells_.n()), 1.0f);
      for (std::size_t f = 0; f < static_cast<std::size_t>(cell.n_functions); ++f)
        sign[f] =
            mesh_.numbers()[cell.first_function + f] < 0 ? 0.0f : mesh_.signs()[cell.first_function + f];
      lanes[lane] = {positions(part_.mesh, block_, cell.row), material_of(block_, cell.row), std::move(sign)};
    }
    cells_.take(lanes);
    cells_.compute_coupling();
    const Index m = cells_.n_own(), g = cells_.n_gained();
    for (int lane = 0; lane < count; ++lane, stiffness += 3 * g) {
      const Index row = mesh_.cells()[first + static_cast<std::size_t>(lane)].row;
      for (std::size_t p = 0; p < U.size(); ++p, r += 3 * g * kStatesTogether) {
        for (Index a = 0; a < m; ++a)
          u_.middleRows<3>(3 * a) = U[p].middleRows<3>(3 * static_cast<Index>(block_.nodes(row, a)));
        cells_.residual(lane, u_.data(), lambda.data() + static_cast<Index>(p) * kStatesTogether, r);
        if (own_strains_.differ()) own_strains_.add(row, lanes[lane].sign, u_, r);
      }
      cells_.copy_diagonal(lane, stiffness);
    }
  }
  Index n_gained() const { return cells_.n_gained(); }

 private:
  const Part& part_;
  const EnrichedMesh& mesh_;
  const mesh::CellBlock& block_;
  EnrichedCells cells_;
  DoublePanel u_;
  OwnStrains own_strains_;
};

// Up to eight cells of a block.
struct Group {
  std::size_t first_cell;
  int n_cells;
};

}  // namespace

EnrichedResidual enriched_residual(const Part& part, const EnrichedMesh& mesh, const MatrixXd& displacements,
                                   const Eigen::VectorXd& lambda, const linalg::Progress& progress) {
  const std::vector<DoublePanel> U = panels_of(displacements);
  const auto n_panels = static_cast<Index>(U.size());
  Eigen::VectorXd lambdas = Eigen::VectorXd::Zero(n_panels * kStatesTogether);
  lambdas.head(lambda.size()) = lambda;
  const std::vector<EnrichedMesh::Cell>& cells = mesh.cells();
  const Index n_rows = 3 * static_cast<Index>(mesh.n_functions());
  EnrichedResidual out{std::vector<StatePanel>(U.size(), StatePanel::Zero(n_rows, kStatesTogether)),
                       std::vector<float>(static_cast<std::size_t>(n_rows), 0.0f)};
  std::vector<Group> groups;
  int most_functions = 0;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (groups.empty() || groups.back().n_cells == kTogether ||
        cells[groups.back().first_cell].block != cells[k].block)
      groups.push_back({k, 0});
    ++groups.back().n_cells;
    most_functions = std::max(most_functions, cells[k].n_functions);
  }
  // Batches of groups on all cores, added up in the order of the cells: the same to the bit with any number of threads.
  constexpr int kBatch = 128, kChunks = 16;
  const auto n_groups = static_cast<int>(groups.size());
  const Index stiffness_size = 3L * most_functions * kTogether,
              residual_size = n_panels * kStatesTogether * stiffness_size;  // of a group
  std::vector<float> residual(static_cast<std::size_t>(kBatch * residual_size)),
      stiffness(static_cast<std::size_t>(kBatch * stiffness_size));
  std::vector<std::vector<std::unique_ptr<Worker>>> of_chunks(kChunks);
  for (auto& of_blocks : of_chunks) of_blocks.resize(part.mesh.solids.size());
  for (int first = 0; first < n_groups; first += kBatch) {
    const int count = std::min(kBatch, n_groups - first), chunks = std::min(kChunks, count);
    linalg::parallel_for(chunks, [&](int chunk) {
      for (int k = chunk * count / chunks; k < (chunk + 1) * count / chunks; ++k) {
        const Group& group = groups[first + k];
        const auto b = static_cast<std::size_t>(cells[group.first_cell].block);
        std::unique_ptr<Worker>& worker = of_chunks[static_cast<std::size_t>(chunk)][b];
        if (!worker) worker = std::make_unique<Worker>(part, mesh, part.mesh.solids[b]);
        worker->compute(group.first_cell, group.n_cells, U, lambdas, residual.data() + k * residual_size,
                        stiffness.data() + k * stiffness_size);
      }
    });
    for (int k = 0; k < count; ++k) {
      const Group& group = groups[first + k];
      const float *r = residual.data() + k * residual_size, *s = stiffness.data() + k * stiffness_size;
      for (int lane = 0; lane < group.n_cells; ++lane) {
        const EnrichedMesh::Cell& cell = cells[group.first_cell + static_cast<std::size_t>(lane)];
        const int* numbers = mesh.numbers().data() + cell.first_function;
        for (StatePanel& panel : out.r)
          for (int f = 0; f < cell.n_functions; ++f, r += 3 * kStatesTogether)
            if (numbers[f] >= 0)
              panel.middleRows<3>(3 * static_cast<Index>(numbers[f])) +=
                  Eigen::Map<const Eigen::Matrix<float, 3, kStatesTogether, Eigen::RowMajor>>(r);
        for (int f = 0; f < cell.n_functions; ++f, s += 3)
          for (int d = 0; d < 3 && numbers[f] >= 0; ++d) out.stiffness[3 * numbers[f] + d] += s[d];
      }
    }
    linalg::report(progress, "mesh error", 0.5 * (first + count) / n_groups);
  }
  return out;
}

}  // namespace flexura::reduce
