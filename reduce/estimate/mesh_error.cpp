// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/mesh_error.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "reduce/estimate/cell_data.hpp"
#include "reduce/estimate/stress_recovery.hpp"
#include "reduce/linalg/dense/parallel.hpp"

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

constexpr Index kColumns = 12;

}  // namespace

double bulk_over_shear(const Material& material) {
  return (material.D(0, 0) + 2.0 * material.D(0, 1)) / (3.0 * material.D(3, 3));
}

bool is_nearly_incompressible(const Part& part) {
  return std::any_of(part.materials.begin(), part.materials.end(), [](const Material& material) {
    // Of an isotropic material; others have no single ratio.
    const bool isotropic =
        std::abs(material.D(0, 0) - material.D(0, 1) - 2.0 * material.D(3, 3)) < 1e-6 * material.D(0, 0);
    return isotropic && bulk_over_shear(material) > 100.0;
  });
}

MeshEnergy recovered_energy(const Part& part, const MatrixXd& U, const linalg::Progress& progress) {
  if (part.matrices || part.mesh.solids.empty() || U.cols() == 0) return {};
  linalg::report(progress, "mesh error", 0.0);
  const Index n = U.cols();
  const StressRecovery recovery(part);
  Eigen::MatrixXf recovered(6 * static_cast<Index>(recovery.n_places()), n);
  for (Index q = 0; q < n; q += kColumns) {
    const Index width = std::min(kColumns, n - q);
    recovered.middleCols(q, width) = recovery.recover(U.middleCols(q, width));
    linalg::report(progress, "mesh error", 0.5 * static_cast<double>(q + width) / static_cast<double>(n));
  }
  const std::vector<Matrix6> roots = square_roots_of_compliance(part);
  MeshEnergy out;
  out.by_cell.setZero(part.mesh.n_solid_cells(), n);
  Index first_cell = 0;
  for (std::size_t b = 0; b < part.mesh.solids.size(); ++b) {
    const mesh::CellBlock& block = part.mesh.solids[b];
    const TabulatedRule& rule = solid_element(block.type).mass;
    const Element& element = solid_element(block.type, formulation_of(block, part.formulation));
    constexpr int kChunks = 64;
    linalg::parallel_for(kChunks, [&](int chunk) {
      for (Index cell = block.nodes.rows() * chunk / kChunks;
           cell < block.nodes.rows() * (chunk + 1) / kChunks; ++cell) {
        const Index n_nodes = block.nodes.cols();
        const CellStress stress(part, block, cell);
        MatrixXd u(3 * n_nodes, n), at_nodes(n_nodes, 6 * n);
        for (Index a = 0; a < n_nodes; ++a) {
          u.middleRows<3>(3 * a) = U.middleRows<3>(3 * static_cast<Index>(block.nodes(cell, a)));
          const Index place = 6 * static_cast<Index>(recovery.places(b)(cell, a));
          for (Index c = 0; c < 6; ++c)
            at_nodes.row(a).segment(c * n, n) = recovered.row(place + c).cast<double>();
        }
        const std::size_t material = material_of(block, cell);
        Eigen::RowVectorXd energy = Eigen::RowVectorXd::Zero(n);
        for (const TabulatedRule::Point& point : rule.points) {
          double det = 0.0;
          MatrixXd s = stress.at(point, u, &det);
          const Eigen::RowVectorXd smooth = point.N.transpose() * at_nodes;
          for (Index c = 0; c < 6; ++c) s.row(c) -= smooth.segment(c * n, n);
          energy += point.weight * std::max(det, 0.0) * (roots[material] * s).colwise().squaredNorm();
        }
        // What is held by nothing else strains without stresses: the stiffness of the hourglasses is no material's, and the
        // shape that bends by them a mere fraction of what it must cost.
        if (element.strains == Strains::uniform) {
          MatrixXd K;
          fill_hourglass_stiffness(element, positions(part.mesh, block, cell), part.materials[material].D, K);
          energy += u.cwiseProduct(K * u).colwise().sum();
        }
        out.by_cell.row(first_cell + cell) = energy.cast<float>();
      }
    });
    first_cell += block.nodes.rows();
  }
  out.energy = out.by_cell.cast<double>().colwise().sum().transpose();
  linalg::report(progress, "mesh error", 1.0);
  return out;
}

}  // namespace flexura::reduce
