// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_codes.hpp"
#include "reduce/assembly/tied_model.hpp"
#include "reduce/elements/shell.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::reduce {
namespace {

// The upper adjacency (self first, ascending) of the vertices that the elements connect.
struct Adjacency {
  std::vector<int> begin{0}, columns;
};

Adjacency upper_adjacency(int n, const std::vector<std::vector<int>>& elements) {
  std::vector<int> begin(n + 1, 0), elements_of;
  for (const auto& element : elements)
    for (int v : element) ++begin[v + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  elements_of.resize(begin[n]);
  std::vector<int> place(begin.begin(), begin.end() - 1);
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (int v : elements[e]) elements_of[place[v]++] = static_cast<int>(e);
  Adjacency graph;
  std::vector<int> mark(n, -1), row;
  for (int v = 0; v < n; ++v) {
    row.assign(1, v);
    mark[v] = v;
    for (int k = begin[v]; k < begin[v + 1]; ++k)
      for (int w : elements[elements_of[k]])
        if (w > v && mark[w] != v) mark[w] = v, row.push_back(w);
    std::sort(row.begin(), row.end());
    graph.columns.insert(graph.columns.end(), row.begin(), row.end());
    graph.begin.push_back(static_cast<int>(graph.columns.size()));
  }
  return graph;
}

}  // namespace

void TiedModel::build_patterns(const Part& part) {
  const int n_groups = static_cast<int>(group_begin_.size()) - 1;
  std::vector<std::vector<int>> by_nodes, by_groups;
  const auto connect = [&](std::vector<int> nodes) {
    std::vector<int> groups;
    for (const int node : nodes) add_groups(node, groups);
    by_nodes.push_back(std::move(nodes));
    by_groups.push_back(std::move(groups));
  };
  if (part.matrices) {
    for (const auto& [a, b] : part.matrices->pairs) connect({a, b});
  } else {
    for (const mesh::CellBlock& block : part.mesh.solids)
      for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
        connect({block.nodes.row(cell).begin(), block.nodes.row(cell).end()});
  }
  for (const Link& link : part.links) connect({link.from, link.to});
  for (const mesh::CellBlock& block : part.mesh.shells)
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
      connect({block.nodes.row(cell).begin(), block.nodes.row(cell).end()});
  for (const FrameElement& frame : part.frames) connect({frame.nodes.begin(), frame.nodes.end()});
  for (const Follower& follower : part.followers) {
    std::vector<int> groups;
    for (const auto& [node, C] : follower.from) add_groups(node, groups);
    by_groups.push_back(std::move(groups));
  }
  Adjacency nodes = upper_adjacency(n_nodes_, by_nodes);
  m_ = std::make_unique<linalg::SymmetricMatrix>(std::move(nodes.begin), std::move(nodes.columns));

  const Adjacency groups = upper_adjacency(n_groups, by_groups);
  std::vector<int> begin{0}, columns;
  std::size_t n_entries = 0;
  for (int g = 0; g < n_groups; ++g) {
    std::size_t width = 0;
    for (int k = groups.begin[g]; k < groups.begin[g + 1]; ++k)
      width += group_begin_[groups.columns[k] + 1] - group_begin_[groups.columns[k]];
    const std::size_t size = group_begin_[g + 1] - group_begin_[g];
    n_entries += width * size - size * (size - 1) / 2;
  }
  if (n_entries > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::runtime_error(
        fmt::format("the stiffness matrix has {} entries, more than 32-bit indices can count: "
                    "use a coarser mesh",
                    n_entries));
  columns.reserve(n_entries);
  for (int g = 0; g < n_groups; ++g)
    for (int i = group_begin_[g]; i < group_begin_[g + 1]; ++i) {
      for (int k = groups.begin[g]; k < groups.begin[g + 1]; ++k) {
        const int h = groups.columns[k];
        for (int j = std::max(i, group_begin_[h]); j < group_begin_[h + 1]; ++j) columns.push_back(j);
      }
      begin.push_back(static_cast<int>(columns.size()));
    }
  K_ii_ = std::make_unique<linalg::SymmetricMatrix>(std::move(begin), std::move(columns));
}

void TiedModel::assemble(const Part& part, const AssemblyOptions& options) {
  constexpr int kChunk = 256;  // elements computed together, on all cores, before they are added one by one
  struct Result {
    Eigen::MatrixXd K, m;
    double smallest_det = 0.0;
  };
  std::vector<Result> results(kChunk);
  std::vector<Eigen::Triplet<double>> K_ib;
  K_bb_.setZero(n_b_, n_b_);
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
      for (int d = 0; d < 3; ++d) dofs.push_back(code_[3 * static_cast<std::size_t>(cell(a)) + d]);
      const int r = turns ? rotation_of_[cell(a)] : -1;
      for (int d = 0; d < 3 && turns; ++d) dofs.push_back(r >= 0 ? rotation_code_[r][d] : kUnused);
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
      if (const int slave = slave_of_[cell(a)]; slave >= 0)
        n_columns += slave_begin_[slave + 1] - slave_begin_[slave];
    C.setZero(static_cast<Eigen::Index>(dofs.size()), n_columns);
    const Eigen::Index width = turns ? 6 : 3;
    for (Eigen::Index a = 0; a < cell.size(); ++a) {
      if (const int slave = slave_of_[cell(a)]; slave >= 0) {
        for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k)
          C.block<3, 1>(width * a, column_of(slave_code_[k])) = slave_C_[k];
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
        for (int a = 0; a < element.n_nodes; ++a) x.row(a) = points_.row(block.nodes(cell, a));
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
        for (Eigen::Index a = 0; a < x.rows(); ++a) x.row(a) = points_.row(block.nodes(cell, a));
        Result& result = results[k];
        result.smallest_det = shell_stiffness(x, material.D, block.thickness[cell], offset, result.K);
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
    const Eigen::Matrix3d k = link.stiffness * direction_projector(link);
    Eigen::MatrixXd K_e(6, 6);
    K_e << k, -k, -k, k;
    const Eigen::Matrix<mesh::Index, 1, 2> cell(link.from, link.to);
    add_stiffness(cell, K_e);
  }
  K_ii_->finish();
  m_->finish();
  K_ib_.resize(n_i_, n_b_);
  K_ib_.setFromTriplets(K_ib.begin(), K_ib.end());
}

// A of the averaging ties.
void TiedModel::average(const Part& part) {
  std::vector<Eigen::Triplet<double>> A;
  for (int k = 0; k < n_interfaces(); ++k) {
    InterfaceDofs& interface = interfaces_[k];
    if (interface.tie != Tie::average) continue;
    InterfaceSpec used = part.interfaces[k];
    if (!used.weights.empty()) {  // of the nodes that belong to cells
      std::vector<double> weights;
      for (std::size_t a = 0; a < used.set.nodes.size(); ++a)
        if (std::binary_search(interface.nodes.begin(), interface.nodes.end(), used.set.nodes[a]))
          weights.push_back(used.weights[a]);
      used.weights = std::move(weights);
    }
    used.set.nodes = interface.nodes;
    interface.average = averaging_map(part.mesh, used);
    for (int direction : interface.directions) {
      const int row = static_cast<int>(averaged_dofs_.size());
      averaged_dofs_.push_back(boundary_of(interface.code[direction]));
      for (std::size_t a = 0; a < interface.nodes.size(); ++a)
        each_dof(interface.nodes[a], [&](int code, const Eigen::Vector3d& C) {
          if (code < 0)
            throw std::invalid_argument(fmt::format(
                "interface '{}' is the mean of nodes of which node {} is bound to another interface: choose "
                "interfaces that "
                "constraints do not join",
                used.name, node_label_.empty() ? interface.nodes[a] : node_label_[interface.nodes[a]]));
          A.emplace_back(
              row, code,
              interface.average.row(direction).segment<3>(3 * static_cast<Eigen::Index>(a)).dot(C));
        });
    }
  }
  A_.resize(static_cast<Eigen::Index>(averaged_dofs_.size()), n_i_);
  A_.setFromTriplets(A.begin(), A.end());
}

}  // namespace flexura::reduce
