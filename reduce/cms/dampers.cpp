// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/dampers.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "reduce/cms/damping.hpp"
#include "reduce/elements/shell.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// On rank 0 of a team, which has all materials and what is no cell.
bool damps(const Part& part) {
  return std::ranges::any_of(part.materials, [](const Material& m) { return m.damping.any(); }) ||
         std::ranges::any_of(part.masses, [](const NodalMass& m) { return m.alpha != 0.0; }) ||
         std::ranges::any_of(part.links, [](const Link& link) { return link.damping != 0.0; }) ||
         std::ranges::any_of(part.frames,
                             [](const FrameElement& f) { return f.D.size() > 0 || f.K_loss.size() > 0; }) ||
         (part.matrices && !part.matrices->D.empty());
}

struct Sums {
  MatrixXd viscous, structural;  // n x n
};

// Adds to X the element's matrix A by the motions q of its nodes.
void add(const MatrixXd& q, const MatrixXd& A, MatrixXd& X) {
  X.noalias() += q.transpose() * (A * q);
}

// One cell: K by its dofs, m by its nodes, of `width` dofs each.
void add_cell(const MaterialDamping& damping, const MatrixXd& q, const MatrixXd& K, const MatrixXd& m,
              Index width, Sums& sums) {
  MatrixXd D = damping.beta * K;
  if (damping.alpha != 0.0)
    for (Index a = 0; a < m.rows(); ++a)
      for (Index b = 0; b < m.cols(); ++b)
        D.block<3, 3>(width * a, width * b).diagonal().array() += damping.alpha * m(a, b);
  if (damping.alpha != 0.0 || damping.beta != 0.0) add(q, D, sums.viscous);
  if (damping.loss != 0.0) add(q, damping.loss * K, sums.structural);
}

class DamperSums {
 public:
  DamperSums(const Part& part, const TiedModel& model, const MatrixXd& T, const MatrixXd& rotations)
      : part_(part), model_(model), T_(T), rotations_(rotations) {
    sums_.viscous.setZero(T.cols(), T.cols());
    sums_.structural = sums_.viscous;
  }

  Sums run() {
    if (!part_.matrices) add_cells();
    add_masses();
    add_frames();
    add_links();
    add_matrix();
    return std::move(sums_);
  }

 private:
  template <class Nodes>
  MatrixXd motions(const Nodes& nodes, Index n, Index width) const {
    MatrixXd q = MatrixXd::Zero(width * n, T_.cols());
    for (Index a = 0; a < n; ++a) {
      const auto node = static_cast<mesh::Index>(nodes[a]);
      q.middleRows<3>(width * a) = T_.middleRows<3>(3 * static_cast<Index>(node));
      if (const int turns = width == 6 ? model_.numbering().rotation_of(node) : -1; turns >= 0)
        q.middleRows<3>(width * a + 3) = rotations_.middleRows<3>(3 * static_cast<Index>(turns));
    }
    return q;
  }

  const Material& material_of(const mesh::CellBlock& block, Index cell) const {
    return part_.materials.at(block.material.empty() ? 0 : static_cast<std::size_t>(block.material[cell]));
  }

  // Work on all cells of a block whose material damps; in shares whose sums do not depend on the number of cores.
  template <class Work>
  void each_cell(const mesh::CellBlock& block, const Work& work) {
    constexpr int kShares = 8;
    std::vector<Sums> shares(
        kShares, Sums{MatrixXd::Zero(T_.cols(), T_.cols()), MatrixXd::Zero(T_.cols(), T_.cols())});
    linalg::parallel_for(kShares, [&](int share) {
      for (Index cell = share; cell < block.nodes.rows(); cell += kShares)
        if (material_of(block, cell).damping.any()) work(cell, shares[static_cast<std::size_t>(share)]);
    });
    for (const Sums& share : shares) {
      sums_.viscous += share.viscous;
      sums_.structural += share.structural;
    }
  }

  void add_cells() {
    const auto places = [&](const mesh::CellBlock& block, Index cell) {
      NodePositions x(block.nodes.cols(), 3);
      for (Index a = 0; a < x.rows(); ++a) x.row(a) = part_.mesh.points.row(block.nodes(cell, a));
      return x;
    };
    for (const mesh::CellBlock& block : part_.mesh.solids) {
      const Element& element = solid_element(block.type, formulation_of(block, part_.formulation));
      each_cell(block, [&](Index cell, Sums& sums) {
        const Material& material = material_of(block, cell);
        const NodePositions x = places(block, cell);
        MatrixXd K, m;
        element_stiffness(element, x, material.D, K);
        element_mass(element, x, material.density, part_.mass, m);
        add_cell(material.damping, motions(block.nodes.row(cell), x.rows(), 3), K, m, 3, sums);
      });
    }
    for (const mesh::CellBlock& block : part_.mesh.shells)
      each_cell(block, [&](Index cell, Sums& sums) {
        const Material& material = material_of(block, cell);
        const NodePositions x = places(block, cell);
        const double offset = block.offset.empty() ? 0.0 : block.offset[cell];
        MatrixXd K, m;
        shell_stiffness(x, material, block.thickness[cell], offset, K);
        shell_mass(x, material.density, block.thickness[cell], part_.mass, m);
        if (offset != 0.0) m.setZero();  // it is on points beside the nodes (shell_skins.hpp)
        add_cell(material.damping, motions(block.nodes.row(cell), x.rows(), 6), K, m, 6, sums);
      });
  }

  void add_masses() {
    for (const NodalMass& mass : part_.masses) {
      if (mass.alpha == 0.0) continue;
      const auto u = T_.middleRows<3>(3 * static_cast<Index>(mass.node));
      sums_.viscous += mass.alpha * mass.mass * u.transpose() * u;
    }
  }

  void add_frames() {
    for (const FrameElement& frame : part_.frames) {
      if (frame.D.size() == 0 && frame.K_loss.size() == 0) continue;
      const auto n = static_cast<Index>(frame.nodes.size());
      const MatrixXd q = motions(frame.nodes, n, 6);
      if (frame.K_loss.size() > 0) add(q, frame.K_loss, sums_.structural);
      if (frame.D.size() == 0) continue;
      for (Index a = 0; a < n; ++a) {
        const mesh::Index node = frame.nodes[static_cast<std::size_t>(a)];
        if (model_.numbering().rotation_of(node) >= 0 || frame.D.middleRows<3>(6 * a + 3).isZero(0.0))
          continue;
        throw std::invalid_argument(
            fmt::format("a damper acts on the rotation of node {}, which nothing else holds; give the node a "
                        "spring or a beam there, or the damper displacements alone",
                        part_.mesh.node_label.empty() ? node + 1 : part_.mesh.node_label[node]));
      }
      add(q, frame.D, sums_.viscous);
    }
  }

  void add_links() {
    for (const Link& link : part_.links) {
      if (link.damping == 0.0) continue;
      const MatrixXd rate = T_.middleRows<3>(3 * static_cast<Index>(link.to)) -
                            T_.middleRows<3>(3 * static_cast<Index>(link.from));
      add(rate, link.damping * direction_projector(model_.numbering(), link), sums_.viscous);
    }
  }

  void add_matrix() {
    if (!part_.matrices) return;
    const NodalMatrices& given = *part_.matrices;
    for (std::size_t k = 0; k < given.D.size(); ++k) {
      if (given.D[k].isZero(0.0)) continue;
      const auto u = T_.middleRows<3>(3 * static_cast<Index>(given.pairs[k][0])),
                 v = T_.middleRows<3>(3 * static_cast<Index>(given.pairs[k][1]));
      const MatrixXd D = u.transpose() * (given.D[k] * v);
      sums_.viscous += D;
      if (given.pairs[k][0] != given.pairs[k][1]) sums_.viscous += D.transpose();
    }
  }

  const Part& part_;
  const TiedModel& model_;
  const MatrixXd &T_, &rotations_;
  Sums sums_;
};

MatrixXd symmetric(const MatrixXd& D) {
  return 0.5 * (D + D.transpose());
}

}  // namespace

MatrixXd without_rigid_damping(const MatrixXd& D, const MatrixXd& R, const MatrixXd& M,
                               ReductionReport& report) {
  const MatrixXd D_R = D * R, M_R = M * R, R_M_R = R.transpose() * M_R;
  double share = 0.0, rate = 0.0;  // of what it could resist; [1/s]
  for (Index k = 0; k < R.cols(); ++k) {
    const double resists = R.col(k).dot(D_R.col(k)),
                 most = R.col(k).cwiseAbs().dot(D.cwiseAbs() * R.col(k).cwiseAbs());
    if (most > 0.0) share = std::max(share, std::abs(resists) / most);
    if (R_M_R(k, k) > 0.0) rate = std::max(rate, resists / R_M_R(k, k));
  }
  if (share < 1e-14) return D;  // round-off
  if (share > 1e-6)             // printed digits
    report.notes.push_back(fmt::format(
        "the part's damping resists its rigid motion, which would decay at up to {:.4g} 1/s; that share is "
        "left out: forces of the mechanism stand for what surrounds the body",
        rate));
  const MatrixXd back = R_M_R.completeOrthogonalDecomposition().pseudoInverse();
  const MatrixXd P = MatrixXd::Identity(D.rows(), D.cols()) - R * back * M_R.transpose();
  return symmetric(P.transpose() * D * P);
}

MatrixXd damping_matrix(const Part& part, const TiedModel& model, const MatrixXd& T,
                        const MatrixXd& rotations, Reduction& reduction) {
  if (!model.decide(damps(part))) return {};
  Sums sums = DamperSums(part, model, T, rotations).run();
  sums.viscous = model.sum(std::move(sums.viscous));
  sums.structural = model.sum(std::move(sums.structural));
  if (!model.leads()) return {};
  MatrixXd R = MatrixXd::Zero(T.cols(), 6);
  R.topRows(model.n_b()) = model.motions().rigid_b();
  MatrixXd D = without_rigid_damping(symmetric(sums.viscous), R, reduction.M_se, reduction.report);
  if (sums.structural.isZero(0.0)) return D;
  const linalg::DenseEigen modes = modes_beside_rigid(reduction.K_se, reduction.M_se, R);
  // Of hinges within the part round-off stands for 0, below it as well: nothing damps them.
  const Eigen::VectorXd share = (modes.values.array() > 0.0).select(modes.values.array().pow(-0.25), 0.0);
  const MatrixXd &Y = modes.vectors, M_Y = reduction.M_se * Y * share.asDiagonal();
  return D + symmetric(M_Y * (Y.transpose() * symmetric(sums.structural) * Y) * M_Y.transpose());
}

}  // namespace flexura::reduce
