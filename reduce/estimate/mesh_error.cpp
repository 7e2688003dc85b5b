// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/mesh_error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "reduce/estimate/stress_recovery.hpp"
#include "reduce/linalg/dense.hpp"
#include "reduce/linalg/parallel.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// C = L L^T: stresses times L^T are square roots of energy densities.
std::vector<Matrix6> square_roots_of_compliance(const Part& part) {
  std::vector<Matrix6> out;
  for (const Material& material : part.materials) {
    const Matrix6 C = material.D.inverse();
    out.emplace_back(Eigen::LLT<Matrix6>(0.5 * (C + C.transpose())).matrixU());
  }
  return out;
}

// As many rows together as make a good matrix product.
constexpr Index kRows = 4096;
constexpr Index kColumns = 12;

}  // namespace

MatrixXd mesh_error(const Part& part, const MatrixXd& T, const linalg::Progress& progress) {
  if (part.matrices || part.mesh.solids.empty()) return {};
  linalg::report(progress, "mesh error", 0.0);
  const Index n = T.cols();
  const StressRecovery recovery(part);
  Eigen::MatrixXf recovered(6 * static_cast<Index>(recovery.n_places()), n);
  for (Index q = 0; q < n; q += kColumns) {
    const Index width = std::min(kColumns, n - q);
    recovered.middleCols(q, width) = recovery.recover(T.middleCols(q, width));
    linalg::report(progress, "mesh error", 0.5 * static_cast<double>(q + width) / static_cast<double>(n));
  }
  const std::vector<Matrix6> roots = square_roots_of_compliance(part);
  MatrixXd E = MatrixXd::Zero(n, n);
  for (std::size_t b = 0; b < part.mesh.solids.size(); ++b) {
    const mesh::CellBlock& block = part.mesh.solids[b];
    const TabulatedRule& rule = solid_element(block.type).mass;
    const auto n_points = static_cast<Index>(rule.points.size());
    const Index per_chunk = std::max<Index>(1, kRows / (6 * n_points));
    const auto n_chunks = static_cast<int>((block.nodes.rows() + per_chunk - 1) / per_chunk);
    // Sums of a fixed number of chunks each, added up in order: the same to the bit with any number of threads.
    const int n_sums = std::min(n_chunks, 16);
    std::vector<MatrixXd> sums(static_cast<std::size_t>(n_sums), MatrixXd::Zero(n, n));
    linalg::parallel_for(n_sums, [&](int part_sum) {
      MatrixXd rows(6 * n_points * per_chunk, n);
      for (int chunk = part_sum; chunk < n_chunks; chunk += n_sums) {
        const Index first = chunk * per_chunk, last = std::min(block.nodes.rows(), first + per_chunk);
        Index row = 0;
        for (Index cell = first; cell < last; ++cell) {
          NodePositions x(block.nodes.cols(), 3);
          MatrixXd u(3 * x.rows(), n), at_nodes(x.rows(), 6 * n);
          for (Index a = 0; a < x.rows(); ++a) {
            x.row(a) = part.mesh.points.row(block.nodes(cell, a));
            u.middleRows<3>(3 * a) = T.middleRows<3>(3 * static_cast<Index>(block.nodes(cell, a)));
            const Index place = 6 * static_cast<Index>(recovery.places(b)(cell, a));
            for (Index c = 0; c < 6; ++c)
              at_nodes.row(a).segment(c * n, n) = recovered.row(place + c).cast<double>();
          }
          const int material = block.material.empty() ? 0 : static_cast<int>(block.material[cell]);
          for (const TabulatedRule::Point& point : rule.points) {
            double det = 0.0;
            MatrixXd s = stress_at(point, x, part.materials[material].D, u, &det);
            const Eigen::RowVectorXd smooth = point.N.transpose() * at_nodes;
            for (Index c = 0; c < 6; ++c) s.row(c) -= smooth.segment(c * n, n);
            rows.middleRows<6>(row) = std::sqrt(point.weight * std::max(det, 0.0)) * (roots[material] * s);
            row += 6;
          }
        }
        sums[part_sum].selfadjointView<Eigen::Lower>().rankUpdate(rows.topRows(row).transpose());
      }
    });
    for (const MatrixXd& sum : sums) E += MatrixXd(sum.selfadjointView<Eigen::Lower>());
  }
  linalg::report(progress, "mesh error", 1.0);
  return E;
}

}  // namespace flexura::reduce
