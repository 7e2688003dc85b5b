// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enriched_error.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "reduce/assembly/rigid_motion.hpp"
#include "reduce/estimate/cell_data.hpp"
#include "reduce/estimate/cell_sample.hpp"
#include "reduce/estimate/enriched_cells.hpp"
#include "reduce/estimate/enriched_solve.hpp"
#include "reduce/estimate/enrichment.hpp"
#include "reduce/estimate/sharp_edges.hpp"
#include "reduce/linalg/cell_products.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/parallel.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr int kTogether = EnrichedCells::kLanes;

// Takes the rigid motion of a cell's middle out of displacements of its nodes, so that single precision keeps the strains.
class Strains {
 public:
  Strains(const Element& element, const NodePositions& x) {
    const Index m = x.rows();
    const Eigen::RowVector3d middle = x.colwise().mean();
    NodePositions gradients(m, 3);
    const double det = spatial_gradients(element.centre.points.front(), x, gradients);
    if (!(det > 0.0)) gradients.setZero();
    motion_.setZero(6, 3 * m);
    shape_.resize(3 * m, 6);
    for (Index a = 0; a < m; ++a) {
      const Eigen::RowVector3d g = 0.5 * gradients.row(a);
      motion_.block<3, 3>(0, 3 * a) = Eigen::Matrix3d::Identity() / static_cast<double>(m);
      motion_.block<3, 3>(3, 3 * a) << 0, -g(2), g(1), g(2), 0, -g(0), -g(1), g(0), 0;  // half the curl
      shape_.middleRows<3>(3 * a) = motion_at((x.row(a) - middle).transpose());
    }
  }
  template <class Displacements>
  void reduce(Displacements& u) const {
    const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor> motion = motion_ * u;
    u.noalias() -= shape_ * motion;
  }

 private:
  Eigen::Matrix<double, 6, Eigen::Dynamic> motion_;
  Eigen::Matrix<double, Eigen::Dynamic, 6> shape_;
};

// r of all gained functions, and how stiff they are.
struct Residual {
  std::vector<StatePanel> r;     // 3 n_functions x 16 each
  std::vector<float> stiffness;  // 3 n_functions
};

// What a thread needs for the residuals of cells of one type.
class CellResiduals {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  CellResiduals(const mesh::CellBlock& block, const std::vector<Material>& materials)
      : block_(block), cells_(block.type, materials), element_(solid_element(block.type)) {}

  EnrichedCells& cells() { return cells_; }
  // lambda m(u, w) - a(u, w) of a lane: out gets n_panels blocks of 3 g x 16.
  void compute(int lane, Index row, const NodePositions& x, const Rows& U, const Eigen::VectorXd& lambda, StatePanel& out) {
    const Index m = cells_.n_own(), g = cells_.n_gained(), n = U.cols(), n_panels = (n + kStatesTogether - 1) / kStatesTogether;
    coupling_.resize(static_cast<std::size_t>(9 * g * m));
    mass_.resize(static_cast<std::size_t>(g * m));
    cells_.copy_coupling(lane, coupling_.data());
    cells_.copy_mass(lane, mass_.data());
    u_.resize(3 * m, n);
    for (Index a = 0; a < m; ++a) u_.middleRows<3>(3 * a) = U.middleRows<3>(3 * static_cast<Index>(block_.nodes(row, a)));
    inertia_ = (u_ * lambda.asDiagonal()).cast<float>();
    Strains(element_, x).reduce(u_);
    out.resize(3 * g * n_panels, kStatesTogether);
    strains_.setZero(3 * m, kStatesTogether);
    for (Index panel = 0; panel < n_panels; ++panel) {
      const Index width = std::min<Index>(kStatesTogether, n - panel * kStatesTogether);
      strains_.leftCols(width) = u_.middleCols(panel * kStatesTogether, width).cast<float>();
      auto r = out.middleRows(3 * g * panel, 3 * g);
      linalg::multiply_sixteen(coupling_.data(), static_cast<int>(3 * g), static_cast<int>(3 * m), strains_.data(), r.data());
      r = -r;
      for (Index f = 0; f < g; ++f)
        for (Index a = 0; a < m; ++a)
          r.block(3 * f, 0, 3, width) +=
              mass_[static_cast<std::size_t>(f * m + a)] * inertia_.block(3 * a, panel * kStatesTogether, 3, width);
    }
  }

 private:
  const mesh::CellBlock& block_;
  EnrichedCells cells_;
  const Element& element_;
  std::vector<float> coupling_, mass_;
  Rows u_;
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> inertia_;
  StatePanel strains_;
};

Residual residual_of(const Part& part, const EnrichedMesh& mesh, const MatrixXd& displacements,
                     const Eigen::VectorXd& lambda, const linalg::Progress& progress) {
  const CellResiduals::Rows U = displacements;
  const std::vector<EnrichedMesh::Cell>& cells = mesh.cells();
  const Index n_panels = (U.cols() + kStatesTogether - 1) / kStatesTogether, n_rows = 3 * static_cast<Index>(mesh.n_functions());
  Residual out{std::vector<StatePanel>(static_cast<std::size_t>(n_panels), StatePanel::Zero(n_rows, kStatesTogether)),
               std::vector<float>(static_cast<std::size_t>(n_rows), 0.0f)};
  std::vector<std::pair<std::size_t, int>> groups;  // of up to eight cells of a block
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (groups.empty() || groups.back().second == kTogether || cells[groups.back().first].block != cells[k].block)
      groups.emplace_back(k, 0);
    ++groups.back().second;
  }
  // Batches of groups on all cores, added up in the order of the cells: the same to the bit with any number of threads.
  constexpr int kBatch = 128, kChunks = 16;
  const auto n_groups = static_cast<int>(groups.size());
  std::vector<StatePanel> residual(static_cast<std::size_t>(kBatch * kTogether));
  std::vector<std::vector<float>> stiffness(residual.size());
  std::vector<std::vector<std::unique_ptr<CellResiduals>>> of_chunks(kChunks);
  for (auto& of_blocks : of_chunks) of_blocks.resize(part.mesh.solids.size());
  for (int first = 0; first < n_groups; first += kBatch) {
    const int count = std::min(kBatch, n_groups - first), chunks = std::min(kChunks, count);
    linalg::parallel_for(chunks, [&](int chunk) {
      for (int k = chunk * count / chunks; k < (chunk + 1) * count / chunks; ++k) {
        const auto [first_cell, n_cells] = groups[static_cast<std::size_t>(first + k)];
        const auto b = static_cast<std::size_t>(cells[first_cell].block);
        const mesh::CellBlock& block = part.mesh.solids[b];
        std::unique_ptr<CellResiduals>& work = of_chunks[static_cast<std::size_t>(chunk)][b];
        if (!work) work = std::make_unique<CellResiduals>(block, part.materials);
        EnrichedCells::Cell lanes[kTogether];
        for (int lane = 0; lane < n_cells; ++lane) {
          const EnrichedMesh::Cell& cell = cells[first_cell + static_cast<std::size_t>(lane)];
          std::vector<float> sign(static_cast<std::size_t>(work->cells().n()), 1.0f);
          for (std::size_t f = 0; f < static_cast<std::size_t>(cell.n_functions); ++f)
            sign[f] = mesh.numbers()[cell.first_function + f] < 0 ? 0.0f : mesh.signs()[cell.first_function + f];
          lanes[lane] = {positions(part.mesh, block, cell.row), material_of(block, cell.row), std::move(sign)};
        }
        work->cells().take(lanes);
        work->cells().compute_coupling();
        for (int lane = 0; lane < n_cells; ++lane) {
          const auto at = static_cast<std::size_t>(k * kTogether + lane);
          work->compute(lane, cells[first_cell + static_cast<std::size_t>(lane)].row, lanes[lane].x, U, lambda, residual[at]);
          stiffness[at].resize(static_cast<std::size_t>(3 * work->cells().n_gained()));
          work->cells().copy_diagonal(lane, stiffness[at].data());
        }
      }
    });
    for (int k = 0; k < count; ++k) {
      const auto [first_cell, n_cells] = groups[static_cast<std::size_t>(first + k)];
      for (int lane = 0; lane < n_cells; ++lane) {
        const EnrichedMesh::Cell& cell = cells[first_cell + static_cast<std::size_t>(lane)];
        const auto at = static_cast<std::size_t>(k * kTogether + lane);
        for (int f = 0; f < cell.n_functions; ++f) {
          const int number = mesh.numbers()[cell.first_function + static_cast<std::size_t>(f)];
          if (number < 0) continue;
          const Index row = 3 * static_cast<Index>(number);
          for (Index panel = 0; panel < n_panels; ++panel)
            out.r[static_cast<std::size_t>(panel)].middleRows<3>(row) +=
                residual[at].middleRows<3>(3 * (panel * cell.n_functions + f));
          for (Index d = 0; d < 3; ++d)
            out.stiffness[static_cast<std::size_t>(row + d)] += stiffness[at][static_cast<std::size_t>(3 * f + d)];
        }
      }
    }
    linalg::report(progress, "mesh error", 0.5 * (first + count) / n_groups);
  }
  return out;
}

// The energy of each function by itself, r^2 / k, in equal parts on the cells that have it: n_cells x k.  To within a
// factor that varies little from cell to cell this is where the energy is.
Eigen::MatrixXf energy_of_functions(const EnrichedMesh& mesh, const Residual& residual, Index n_states) {
  std::vector<float> weight(residual.stiffness.size(), 0.0f);
  for (const int number : mesh.numbers())
    if (number >= 0) weight[3 * static_cast<std::size_t>(number)] += 1.0f;
  for (std::size_t k = 0; k < weight.size(); k += 3)
    for (std::size_t d = 3; d-- > 0;)
      weight[k + d] = residual.stiffness[k + d] > 0.0f ? 1.0f / (weight[k] * residual.stiffness[k + d]) : 0.0f;
  Eigen::MatrixXf out(static_cast<Index>(mesh.cells().size()), n_states);
  constexpr int kChunks = 64;
  linalg::parallel_for(kChunks, [&](int chunk) {
    const auto c = static_cast<std::size_t>(chunk), n = mesh.cells().size();
    Eigen::Array<float, 1, kStatesTogether> sum;
    for (std::size_t k = n * c / kChunks; k < n * (c + 1) / kChunks; ++k)
      for (std::size_t panel = 0; panel < residual.r.size(); ++panel) {
        const EnrichedMesh::Cell& cell = mesh.cells()[k];
        sum.setZero();
        for (std::size_t f = cell.first_function; f < cell.first_function + static_cast<std::size_t>(cell.n_functions); ++f)
          for (Index d = 0; d < 3 && mesh.numbers()[f] >= 0; ++d) {
            const Index row = 3 * static_cast<Index>(mesh.numbers()[f]) + d;
            sum += weight[static_cast<std::size_t>(row)] * residual.r[panel].row(row).array().square();
          }
        const Index first = static_cast<Index>(panel) * kStatesTogether, width = std::min<Index>(kStatesTogether, n_states - first);
        out.row(static_cast<Index>(k)).segment(first, width) = sum.matrix().leftCols(width);
      }
  });
  return out;
}

// Of each cell: what all degrees after its own gain over what the next one does.  Where the solution is smooth a fifth more for
// cells of second degree (measured, docs/mesh_error.md).  At edges where stresses are like r^(lambda - 1) the energy that
// degree p leaves falls like p^(-4 lambda) (I. Babuska, M. Suri, RAIRO Model. Math. Anal. Numer. 21 (1987) 199), so that the
// next degree gains 1 - (p / (p + 1))^(4 lambda) of it.
Eigen::VectorXf beyond(const Part& part) {
  constexpr float kSmooth = 1.2f;
  const auto at_edge = [](bool quadratic, double lambda) {
    return static_cast<float>(1.0 / (1.0 - std::pow(quadratic ? 2.0 / 3.0 : 0.5, 4.0 * lambda)));
  };
  const std::vector<SharpEdge> sharp = sharp_edges(part);
  Eigen::VectorXf out(part.mesh.n_solid_cells());
  Index cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const bool quadratic = is_quadratic(block.type);
    const float smooth = quadratic ? kSmooth : 1.0f, reentrant = at_edge(quadratic, 0.545), held = at_edge(quadratic, 0.71);
    for (Index row = 0; row < block.nodes.rows(); ++row, ++cell) {
      out(cell) = smooth;
      for (int a = 0; a < mesh::shape_of(block.type).corners; ++a) {
        const SharpEdge kind = sharp[static_cast<std::size_t>(block.nodes(row, a))];
        if (kind == SharpEdge::reentrant) out(cell) = std::max(out(cell), reentrant);
        if (kind == SharpEdge::held) out(cell) = std::max(out(cell), held);
      }
    }
  }
  return out;
}

}  // namespace

bool enrichment_suits(const Part& part) {
  if (part.matrices || part.mesh.solids.empty()) return false;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    if (enrichment_of(block.type).empty()) return false;
    const Formulation formulation = formulation_of(block, part.formulation);
    if (&solid_element(block.type, formulation) != &solid_element(block.type)) return false;
  }
  for (const InterfaceSpec& interface : part.interfaces)
    if (interface.tie == Tie::elastic) return false;
  return true;
}

MeshEnergy enriched_energy(const Part& part, const MatrixXd& T, const JudgedStates& states,
                           const linalg::Progress& progress) {
  linalg::report(progress, "mesh error", 0.0);
  const EnrichedMesh mesh(part);
  const Index n_states = states.Y.cols();
  Residual residual = residual_of(part, mesh, linalg::times(T, states.Y), states.lambda, progress);
  if (states.force.size() > 0)
    for (const EnrichedMesh::Load& load : mesh.tractions(states.force))
      for (Index c = 0; c < n_states; ++c)
        residual.r[static_cast<std::size_t>(c / kStatesTogether)].block<3, 1>(3 * static_cast<Index>(load.function),
                                                                              c % kStatesTogether) +=
            load.work.col(c).cast<float>();
  MeshEnergy out;
  out.by_cell = energy_of_functions(mesh, residual, n_states);
  const CellSample sample = choose_cells(part, out.by_cell);
  Eigen::MatrixXf of_sample(static_cast<Index>(sample.cells.size()), n_states);
  EnrichedSolve solve(part, mesh, sample.cells);
  for (Index first = 0; first < n_states; first += kStatesTogether) {
    const Index width = std::min<Index>(kStatesTogether, n_states - first);
    of_sample.middleCols(first, width) =
        solve.energies(residual.r[static_cast<std::size_t>(first / kStatesTogether)]).leftCols(width);
    linalg::report(progress, "mesh error", 0.5 + 0.5 * static_cast<double>(first + width) / static_cast<double>(n_states));
  }
  extend(sample, of_sample, out.by_cell);
  out.by_cell.array().colwise() *= beyond(part).array();
  out.energy = out.by_cell.cast<double>().colwise().sum().transpose();
  linalg::report(progress, "mesh error", 1.0);
  return out;
}

}  // namespace flexura::reduce
