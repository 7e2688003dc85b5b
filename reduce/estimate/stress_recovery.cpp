// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/stress_recovery.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <mutex>

#include "mesh/model/cells/record.hpp"
#include "reduce/estimate/cell_data.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using mesh::CellType;

namespace {

// Where the stresses of a cell are best: the points of the next lower Gauss rule.
mesh::Quadrature superconvergent_points(CellType type) {
  if (const auto as = mesh::record_of(type).stress_points) return mesh::stiffness_quadrature(*as);
  const Eigen::Matrix<double, 1, 3> centre = mesh::reference_nodes(type).colwise().mean();
  return {centre, Eigen::VectorXd::Ones(1)};
}

int n_terms(int degree) {
  return (degree + 1) * (degree + 2) * (degree + 3) / 6;
}

Eigen::RowVectorXd terms(int degree, const Eigen::Vector3d& x) {
  Eigen::RowVectorXd p(n_terms(degree));
  p(0) = 1.0;
  if (degree > 0) p.segment<3>(1) = x.transpose();
  if (degree > 1)
    p.segment<6>(4) << x(0) * x(0), x(1) * x(1), x(2) * x(2), x(0) * x(1), x(1) * x(2), x(2) * x(0);
  return p;
}

// argmin |P a - S|: terms are taken in their order, each less what the former ones have of it; one that adds nothing
// at the points (x^2 where they stand on two planes) is left out, so that what is simplest explains them.
MatrixXd fit(const MatrixXd& P, const MatrixXd& S) {
  constexpr double kAdds = 0.05;  // of the term's own size at the points
  const Index n = P.cols();
  MatrixXd Q(P.rows(), n), R = MatrixXd::Zero(n, n);
  std::vector<Index> kept;
  for (Index j = 0; j < n; ++j) {
    Eigen::VectorXd q = P.col(j);
    const double size = q.norm();
    const auto rank = static_cast<Index>(kept.size());
    Eigen::VectorXd r = Eigen::VectorXd::Zero(rank);
    for (int pass = 0; pass < 2; ++pass) {
      const Eigen::VectorXd share = Q.leftCols(rank).transpose() * q;
      q -= Q.leftCols(rank) * share;
      r += share;
    }
    const double rest = q.norm();
    if (!(rest > kAdds * size) || !(size > 0.0)) continue;
    R.col(rank).head(rank) = r;
    R(rank, rank) = rest;
    Q.col(rank) = q / rest;
    kept.push_back(j);
  }
  const auto rank = static_cast<Index>(kept.size());
  const MatrixXd a =
      R.topLeftCorner(rank, rank).triangularView<Eigen::Upper>().solve(Q.leftCols(rank).transpose() * S);
  MatrixXd out = MatrixXd::Zero(n, S.cols());
  for (Index k = 0; k < rank; ++k) out.row(kept[static_cast<std::size_t>(k)]) = a.row(k);
  return out;
}

MatrixXd displacements(const mesh::CellBlock& block, Index cell, const Eigen::Ref<const MatrixXd>& T) {
  MatrixXd u(3 * block.nodes.cols(), T.cols());
  for (Index a = 0; a < block.nodes.cols(); ++a)
    u.middleRows<3>(3 * a) = T.middleRows<3>(3 * static_cast<Index>(block.nodes(cell, a)));
  return u;
}

}  // namespace

CellStress::CellStress(const Part& part, const mesh::CellBlock& block, Index row)
    : D_(part.materials[material_of(block, row)].D),
      strains_(solid_element(block.type, formulation_of(block, part.formulation)),
               positions(part.mesh, block, row), D_) {}

MatrixXd CellStress::at(const TabulatedRule::Point& point, const Eigen::Ref<const MatrixXd>& u,
                        double* det) const {
  StrainMatrix B;
  const double determinant = strains_.at(point, B);
  if (det) *det = determinant;
  return D_ * B * u;
}

StressRecovery::StressRecovery(const Part& part) : part_(part) {
  for (const mesh::CellBlock& block : part.mesh.solids)
    sampling_.push_back(tabulate(block.type, superconvergent_points(block.type)));
  number_places();
  make_patches();
}

// Places of nodes, one for each material that meets there, and the sampling points of all cells.
void StressRecovery::number_places() {
  std::map<std::pair<mesh::Index, int>, int> number;
  for (std::size_t b = 0; b < part_.mesh.solids.size(); ++b) {
    const mesh::CellBlock& block = part_.mesh.solids[b];
    auto& places = places_.emplace_back(block.nodes.rows(), block.nodes.cols());
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      for (Index a = 0; a < block.nodes.cols(); ++a) {
        const auto [found, fresh] =
            number.try_emplace({block.nodes(cell, a), static_cast<int>(material_of(block, cell))}, n_places_);
        if (fresh) {
          ++n_places_;
          node_of_place_.push_back(block.nodes(cell, a));
        }
        places(cell, a) = found->second;
      }
      cells_.push_back({static_cast<int>(b), cell, n_samples_});
      n_samples_ += static_cast<int>(sampling_[b].points.size());
    }
  }
  sample_points_.resize(n_samples_, 3);
  for (const Cell& cell : cells_) {
    const NodePositions x = positions(part_.mesh, part_.mesh.solids[cell.block], cell.row);
    int k = cell.first_sample;
    for (const TabulatedRule::Point& point : sampling_[cell.block].points)
      sample_points_.row(k++) = point.N.transpose() * x;
  }
}

void StressRecovery::make_patches() {
  // Cells around each corner place, and which corners a place takes its value from.
  std::vector<std::vector<int>> around(n_places_);
  std::vector<std::vector<int>> corners_of(n_places_);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const auto& places = places_[cells_[c].block];
    const mesh::CellShape& shape = mesh::shape_of(part_.mesh.solids[cells_[c].block].type);
    for (int a = 0; a < shape.corners; ++a) around[places(cells_[c].row, a)].push_back(static_cast<int>(c));
    for (Index a = shape.corners; a < places.cols(); ++a) {
      std::vector<int>& from = corners_of[places(cells_[c].row, a)];
      if (!from.empty()) continue;
      const auto edge = static_cast<std::size_t>(a - shape.corners);
      if (edge < shape.edges.size())
        for (const int end : shape.edges[edge]) from.push_back(places(cells_[c].row, end));
      else  // the middle of a face or of the cell
        for (int k = 0; k < shape.corners; ++k) from.push_back(places(cells_[c].row, k));
    }
  }
  std::vector<int> patch_of(n_places_, -1);
  for (int place = 0; place < n_places_; ++place) {
    if (around[place].empty()) continue;
    Patch patch;
    patch.cells = around[place];
    bool quadratic = false;
    int n = 0;
    const auto count = [&] {
      n = 0;
      for (const int c : patch.cells) n += static_cast<int>(sampling_[cells_[c].block].points.size());
    };
    for (const int c : patch.cells) quadratic |= is_quadratic(part_.mesh.solids[cells_[c].block].type);
    patch.degree = quadratic ? 2 : 1;
    count();
    // Twice as many points as terms: fits with fewer follow the points instead of smoothing them.
    for (int ring = 0; ring < 2 && n < 2 * n_terms(patch.degree); ++ring) {
      std::vector<int> more = patch.cells;
      for (const int c : patch.cells) {
        const auto& places = places_[cells_[c].block];
        const int corners = mesh::shape_of(part_.mesh.solids[cells_[c].block].type).corners;
        for (int a = 0; a < corners; ++a) {
          const std::vector<int>& next = around[places(cells_[c].row, a)];
          more.insert(more.end(), next.begin(), next.end());
        }
      }
      std::sort(more.begin(), more.end());
      more.erase(std::unique(more.begin(), more.end()), more.end());
      patch.cells = std::move(more);
      count();
    }
    while (patch.degree > 0 && n < n_terms(patch.degree) + 2) --patch.degree;
    shape_patch(patch);
    patch_of[place] = static_cast<int>(patches_.size());
    patch.at.push_back(place);
    patch.share.push_back(1.0);
    patches_.push_back(std::move(patch));
  }
  for (int place = 0; place < n_places_; ++place) {
    if (patch_of[place] >= 0) continue;
    for (const int corner : corners_of[place]) {
      Patch& patch = patches_[patch_of[corner]];
      patch.at.push_back(place);
      patch.share.push_back(1.0 / static_cast<double>(corners_of[place].size()));
    }
  }
}

void StressRecovery::shape_patch(Patch& patch) const {
  std::vector<int> samples;
  for (const int c : patch.cells)
    for (std::size_t k = 0; k < sampling_[cells_[c].block].points.size(); ++k)
      samples.push_back(cells_[c].first_sample + static_cast<int>(k));
  const MatrixXd x = sample_points_(samples, Eigen::all);
  patch.centre = x.colwise().mean().transpose();
  const MatrixXd off = x.rowwise() - patch.centre.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(
      Eigen::Matrix3d(off.transpose() * off / static_cast<double>(x.rows())));
  const double largest = std::sqrt(std::max(axes.eigenvalues()(2), 0.0));
  for (int a = 0; a < 3; ++a) {
    // A direction in which the points do not spread has no share in the fit.
    const double spread = std::sqrt(std::max(axes.eigenvalues()(a), 0.0));
    patch.to_local.row(a) = axes.eigenvectors().col(a).transpose() *
                            (spread > 1e-6 * largest && spread > 0.0 ? 1.0 / spread : 0.0);
  }
}

Eigen::MatrixXf StressRecovery::recover(const Eigen::Ref<const MatrixXd>& T) const {
  const Index k = T.cols();
  MatrixXd samples(6 * static_cast<Index>(n_samples_), k);
  const int n_chunks = std::max(1, std::min<int>(static_cast<int>(cells_.size()), 64));
  linalg::parallel_for(n_chunks, [&](int chunk) {
    const std::size_t first = cells_.size() * chunk / n_chunks, last = cells_.size() * (chunk + 1) / n_chunks;
    for (std::size_t c = first; c < last; ++c) {
      const Cell& cell = cells_[c];
      const mesh::CellBlock& block = part_.mesh.solids[cell.block];
      const CellStress stress(part_, block, cell.row);
      const MatrixXd u = displacements(block, cell.row, T);
      Index row = 6 * static_cast<Index>(cell.first_sample);
      for (const TabulatedRule::Point& point : sampling_[cell.block].points) {
        samples.middleRows<6>(row) = stress.at(point, u);
        row += 6;
      }
    }
  });
  // Values that patches give to shared places are added up in the order of the patches, whatever the threads do.
  std::vector<MatrixXd> values(patches_.size());
  const int n_parts = std::max(1, std::min<int>(static_cast<int>(patches_.size()), 64));
  linalg::parallel_for(n_parts, [&](int part) {
    const std::size_t first = patches_.size() * part / n_parts, last = patches_.size() * (part + 1) / n_parts;
    for (std::size_t p = first; p < last; ++p) {
      const Patch& patch = patches_[p];
      std::vector<int> rows;
      for (const int c : patch.cells)
        for (std::size_t s = 0; s < sampling_[cells_[c].block].points.size(); ++s)
          rows.push_back(cells_[c].first_sample + static_cast<int>(s));
      MatrixXd P(static_cast<Index>(rows.size()), n_terms(patch.degree));
      MatrixXd S(P.rows(), 6 * k);
      for (std::size_t s = 0; s < rows.size(); ++s) {
        P.row(static_cast<Index>(s)) =
            terms(patch.degree, patch.to_local * (sample_points_.row(rows[s]).transpose() - patch.centre));
        for (Index c = 0; c < 6; ++c)
          S.row(static_cast<Index>(s)).segment(c * k, k) = samples.row(6 * static_cast<Index>(rows[s]) + c);
      }
      MatrixXd Q(static_cast<Index>(patch.at.size()), P.cols());
      for (std::size_t a = 0; a < patch.at.size(); ++a) {
        const Eigen::Vector3d x = part_.mesh.points.row(node_of_place_[patch.at[a]]).transpose();
        Q.row(static_cast<Index>(a)) =
            patch.share[a] * terms(patch.degree, patch.to_local * (x - patch.centre));
      }
      values[p] = Q * fit(P, S);
    }
  });
  Eigen::MatrixXf out = Eigen::MatrixXf::Zero(6 * static_cast<Index>(n_places_), k);
  for (std::size_t p = 0; p < patches_.size(); ++p)
    for (std::size_t a = 0; a < patches_[p].at.size(); ++a)
      for (Index c = 0; c < 6; ++c)
        out.row(6 * static_cast<Index>(patches_[p].at[a]) + c) +=
            values[p].row(static_cast<Index>(a)).segment(c * k, k).cast<float>();
  return out;
}

}  // namespace flexura::reduce
