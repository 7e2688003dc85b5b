// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_matrices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "reduce/assembly/tied_pattern.hpp"
#include "reduce/assembly/ties/tied_codes.hpp"
#include "reduce/assembly/ties/tied_spread.hpp"
#include "reduce/elements/shell.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {

TiedMatrices::TiedMatrices(const Part& part, const TiedNumbering& numbering) : numbering_(numbering) {
  TiedPatterns patterns = tied_patterns(part, numbering);
  K_ii_ = std::move(patterns.K_ii);
  m_ = std::move(patterns.m);
}

void TiedMatrices::assemble(const Part& part, const AssemblyOptions& options) {
  constexpr int kChunk = 256;  // elements computed together, on all cores, before they are added one by one
  struct Result {
    Eigen::MatrixXd K, m;
    double smallest_det = 0.0;
  };
  std::vector<Result> results(kChunk);
  std::vector<Eigen::Triplet<double>> K_ib;
  K_bb_.setZero(numbering_.n_b(), numbering_.n_b());
  std::int64_t n_cells = 0, n_done = 0, n_inverted = 0;
  std::string inverted;
  for (const auto* blocks : {&part.mesh.solids, &part.mesh.shells})
    for (const mesh::CellBlock& block : *blocks) n_cells += block.nodes.rows();

  // One element into K_ii, K_ib, K_bb, its nodes with three dofs each or six.  Elements away from the ties, nearly all,
  // go the direct way.
  std::vector<int> dofs, tied;
  Eigen::MatrixXd C, K_tied;
  const auto add_stiffness = [&](const auto& cell, const Eigen::MatrixXd& K_e) {
    const bool turns = K_e.rows() == 6 * cell.size();
    dofs.clear();
    bool direct = true;
    for (Eigen::Index a = 0; a < cell.size(); ++a) {
      for (int d = 0; d < 3; ++d) dofs.push_back(numbering_.code(cell(a), d));
      const int r = turns ? numbering_.rotation_of(cell(a)) : -1;
      for (int d = 0; d < 3 && turns; ++d) dofs.push_back(r >= 0 ? numbering_.rotation_code(r)[d] : kUnused);
    }
    for (const int code : dofs) direct = direct && code >= 0;
    if (direct) {
      K_ii_->add(dofs, K_e);
      return;
    }
    // K_tied = C^T K_e C with the distinct dofs (interior or boundary codes) that the element's nodes follow.
    tied.clear();
    const auto column_of = [&](int code) {
      const auto found = std::find(tied.begin(), tied.end(), code);
      if (found != tied.end()) return static_cast<Eigen::Index>(found - tied.begin());
      tied.push_back(code);
      return static_cast<Eigen::Index>(tied.size()) - 1;
    };
    Eigen::Index n_columns = static_cast<Eigen::Index>(dofs.size());
    for (Eigen::Index a = 0; a < cell.size(); ++a)
      n_columns += static_cast<Eigen::Index>(numbering_.followed(cell(a)).code.size());
    C.setZero(static_cast<Eigen::Index>(dofs.size()), n_columns);
    const Eigen::Index width = turns ? 6 : 3;
    for (Eigen::Index a = 0; a < cell.size(); ++a) {
      if (numbering_.follows(cell(a))) {
        const TiedNumbering::Followed followed = numbering_.followed(cell(a));
        for (std::size_t k = 0; k < followed.code.size(); ++k)
          C.block<3, 1>(width * a, column_of(followed.code[k])) = followed.C[k];
      } else {
        for (int d = 0; d < 3; ++d) C(width * a + d, column_of(dofs[width * a + d])) = 1.0;
      }
      for (Eigen::Index d = 3; d < width; ++d)
        if (const int code = dofs[width * a + d]; is_dof(code)) C(width * a + d, column_of(code)) = 1.0;
    }
    const auto used = C.leftCols(static_cast<Eigen::Index>(tied.size()));
    K_tied = used.transpose() * K_e * used;
    K_tied = (0.5 * (K_tied + K_tied.transpose())).eval();
    K_ii_->add(tied, K_tied);  // skips boundary codes: they are negative
    for (std::size_t j = 0; j < tied.size(); ++j) {
      if (tied[j] >= 0) continue;
      for (std::size_t i = 0; i < tied.size(); ++i) {
        if (tied[i] >= 0)
          K_ib.emplace_back(tied[i], boundary_of(tied[j]), K_tied(i, j));
        else
          K_bb_(boundary_of(tied[i]), boundary_of(tied[j])) += K_tied(i, j);
      }
    }
  };

  if (part.matrices) {
    const NodalMatrices& given = *part.matrices;
    for (std::size_t k = 0; k < given.pairs.size(); ++k) {
      const auto& [a, b] = given.pairs[k];
      Eigen::Matrix3d K_ab = given.K[k];
      K_ab.diagonal().array() += options.shift * given.m[k];
      if (a == b) {
        m_->add_to_diagonal(a, given.m[k]);
        add_stiffness(Eigen::Matrix<mesh::Index, 1, 1>(a), Eigen::MatrixXd(K_ab));
        continue;
      }
      const int nodes[] = {a, b};
      Eigen::MatrixXd m_e = Eigen::MatrixXd::Zero(2, 2), K_e = Eigen::MatrixXd::Zero(6, 6);
      m_e(0, 1) = m_e(1, 0) = given.m[k];
      K_e.topRightCorner<3, 3>() = K_ab;
      K_e.bottomLeftCorner<3, 3>() = K_ab.transpose();
      m_->add(nodes, m_e);
      add_stiffness(Eigen::Matrix<mesh::Index, 1, 2>(a, b), K_e);
    }
  }
  // Cells first to first + count of a block, into K and M; n_dofs is that of a node in their matrices.
  const auto take_in = [&](const mesh::CellBlock& block, Eigen::Index first, int count, Eigen::Index n_dofs) {
    for (int k = 0; k < count; ++k) {
      const auto cell = block.nodes.row(first + k);
      Result& result = results[k];
      if (!(result.smallest_det > 0.0)) {
        if (++n_inverted <= 5)
          inverted += fmt::format("{}{}", n_inverted > 1 ? ", " : "",
                                  block.label.empty() ? n_done + k : block.label[first + k]);
        continue;
      }
      m_->add({cell.data(), static_cast<std::size_t>(cell.size())}, result.m);
      if (options.shift != 0.0)
        for (Eigen::Index a = 0; a < cell.size(); ++a)
          for (Eigen::Index c = 0; c < cell.size(); ++c)
            result.K.block<3, 3>(n_dofs * a, n_dofs * c).diagonal().array() += options.shift * result.m(a, c);
      add_stiffness(cell, result.K);
    }
    n_done += count;
    linalg::report(options.progress, "assembly", static_cast<double>(n_done) / static_cast<double>(n_cells));
  };
  for (const mesh::CellBlock& block : part.mesh.solids) {
    if (part.matrices) break;
    const Element& element = solid_element(block.type, formulation_of(block, part.formulation));
    for (Eigen::Index first = 0; first < block.nodes.rows(); first += kChunk) {
      const int count = static_cast<int>(std::min<Eigen::Index>(kChunk, block.nodes.rows() - first));
      linalg::parallel_for(count, [&](int k) {
        const Eigen::Index cell = first + k;
        const std::size_t material = block.material.empty() ? 0 : block.material[cell];
        if (material >= part.materials.size())
          throw std::invalid_argument(
              fmt::format("a cell has material number {}, but the part has {} material{}", material,
                          part.materials.size(), part.materials.size() == 1 ? "" : "s"));
        NodePositions x(element.n_nodes, 3);
        for (int a = 0; a < element.n_nodes; ++a) x.row(a) = numbering_.points().row(block.nodes(cell, a));
        Result& result = results[k];
        result.smallest_det = element_stiffness(element, x, part.materials[material].D, result.K);
        result.smallest_det =
            std::min(result.smallest_det,
                     element_mass(element, x, part.materials[material].density, part.mass, result.m));
      });
      take_in(block, first, count, 3);
    }
  }
  for (const mesh::CellBlock& block : part.mesh.shells) {
    for (Eigen::Index first = 0; first < block.nodes.rows(); first += kChunk) {
      const int count = static_cast<int>(std::min<Eigen::Index>(kChunk, block.nodes.rows() - first));
      linalg::parallel_for(count, [&](int k) {
        const Eigen::Index cell = first + k;
        const Material& material = part.materials.at(block.material.empty() ? 0 : block.material[cell]);
        const double offset = block.offset.empty() ? 0.0 : block.offset[cell];
        NodePositions x(block.nodes.cols(), 3);
        for (Eigen::Index a = 0; a < x.rows(); ++a) x.row(a) = numbering_.points().row(block.nodes(cell, a));
        Result& result = results[k];
        result.smallest_det = shell_stiffness(x, material, block.thickness[cell], offset, result.K);
        shell_mass(x, material.density, block.thickness[cell], part.mass, result.m);
        if (offset != 0.0) result.m.setZero();  // it is on points beside the nodes (shell_skins.hpp)
      });
      take_in(block, first, count, 6);
    }
  }
  if (n_inverted > 0)
    throw std::invalid_argument(
        fmt::format("{} of {} cells {} inverted or flat (det J <= 0 at a quadrature point): cell{} {}{}; "
                    "mend the mesh or mesh anew",
                    n_inverted, n_cells, n_inverted == 1 ? "is" : "are", n_inverted == 1 ? "" : "s", inverted,
                    n_inverted > 5 ? ", ..." : ""));
  for (const NodalMass& mass : part.masses) {
    m_->add_to_diagonal(mass.node, mass.mass);
    if (options.shift == 0.0) continue;
    const Eigen::Matrix<mesh::Index, 1, 1> cell(mass.node);
    add_stiffness(cell, options.shift * mass.mass * Eigen::MatrixXd::Identity(3, 3));
  }
  for (const FrameElement& frame : part.frames)
    add_stiffness(Eigen::Map<const Eigen::Matrix<mesh::Index, 1, Eigen::Dynamic>>(
                      frame.nodes.data(), static_cast<Eigen::Index>(frame.nodes.size())),
                  frame.K);
  for (const Link& link : part.links) {
    const Eigen::Matrix3d k = link.stiffness * direction_projector(numbering_, link);
    Eigen::MatrixXd K_e(6, 6);
    K_e << k, -k, -k, k;
    const Eigen::Matrix<mesh::Index, 1, 2> cell(link.from, link.to);
    add_stiffness(cell, K_e);
  }
  K_ii_->finish();
  m_->finish();
  K_ib_.resize(numbering_.n_i(), numbering_.n_b());
  K_ib_.setFromTriplets(K_ib.begin(), K_ib.end());
}

linalg::SymmetricMatrix TiedMatrices::shifted_stiffness(double shift) const {
  linalg::SymmetricMatrix K = K_ii_->copy();
  // The interior dofs that a node follows, and its motion for a unit of each.
  struct Follows {
    std::vector<int> dof;
    std::vector<Eigen::Vector3d> C;
  };
  const auto follows = [&](int node, Follows& out) {
    out.dof.clear(), out.C.clear();
    numbering_.each_dof(node, [&](int code, const Eigen::Vector3d& motion) {
      if (code < 0) return;
      out.dof.push_back(code);
      out.C.push_back(motion);
    });
  };
  const linalg::UpperCsr m = m_->csr();
  Follows of_p, of_q;
  for (int p = 0; p < m.n; ++p) {
    follows(p, of_p);
    for (int k = m.row_begin[p]; !of_p.dof.empty() && k < m.row_begin[p + 1]; ++k) {
      const int q = m.columns[k];
      follows(q, of_q);
      for (std::size_t a = 0; a < of_p.dof.size(); ++a)
        for (std::size_t b = p == q ? a : 0; b < of_q.dof.size(); ++b) {
          double value = shift * m.values[k] * of_p.C[a].dot(of_q.C[b]);
          if (p != q && of_p.dof[a] == of_q.dof[b]) value *= 2.0;  // (p, q) and (q, p)
          if (value != 0.0) K.add_to_entry(of_p.dof[a], of_q.dof[b], value);
        }
    }
  }
  return K;
}

// C_i^T (m (x) I_3) C_i X by panels of eight columns, one panel per core at a time; a single one on all cores.
void TiedMatrices::multiply_M_ii(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const {
  constexpr Eigen::Index kWidth = linalg::RowPanel::ColsAtCompileTime;
  Y.setZero(numbering_.n_i(), X.cols());
  const int n_panels = static_cast<int>((X.cols() + kWidth - 1) / kWidth);
  linalg::parallel_for(n_panels, [&](int panel) {
    const Eigen::Index first = panel * kWidth, width = std::min(kWidth, X.cols() - first);
    linalg::RowPanel U = linalg::RowPanel::Zero(static_cast<Eigen::Index>(numbering_.codes().size()), kWidth),
                     MU;
    spread(
        numbering_,
        [&](int code, auto&& row) {
          for (Eigen::Index c = 0; c < kWidth; ++c)
            row(c) = code >= 0 && c < width ? X(code, first + c) : 0.0;
        },
        U);
    m_->multiply_kron3(U, MU, n_panels == 1);
    collect(numbering_, MU, [&](int code, const auto& row) {
      if (code < 0) return;
      for (Eigen::Index c = 0; c < width; ++c) Y(code, first + c) += row(c);
    });
  });
}

Eigen::Matrix3d direction_projector(const TiedNumbering& numbering, const Link& link) {
  const TiedNumbering::Points& points = numbering.points();
  const Eigen::Vector3d line = (points.row(link.to) - points.row(link.from)).transpose();
  // Closer than round-off of coordinates tells no direction.
  if (line.norm() < 1e-9 * numbering.length()) return Eigen::Matrix3d::Identity();
  return line * line.transpose() / line.squaredNorm();
}

}  // namespace flexura::reduce
