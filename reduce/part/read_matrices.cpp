// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/read_matrices.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "reduce/part/nastran_matrices.hpp"
#include "reduce/part/op4.hpp"
#include "reduce/part/text_lines.hpp"

namespace flexura::reduce {
namespace {

/// The words of Matrix Market's first line; empty for other files.
std::string matrix_market_head(const std::filesystem::path& path) {
  std::string head;
  return Lines(path).next(head) && head.starts_with("%%MatrixMarket") ? head : "";
}

constexpr double kUnset = std::numeric_limits<double>::infinity();

/// Blocks of three rows and columns: 2 n is node n's displacement, 2 n + 1 its rotation.  The first is the smaller.
using Blocks = std::map<std::array<mesh::Index, 2>, Eigen::Matrix3d>;

constexpr bool turns(mesh::Index half) {
  return half % 2 != 0;
}

/// Collects entries into blocks.
class BlockReader {
 public:
  BlockReader(const std::filesystem::path& path, const mesh::Mesh& mesh) : path_(path), mesh_(mesh) {
    for (mesh::Index k = 0; k < mesh.n_nodes(); ++k)
      place_[mesh.node_label.empty() ? k + 1 : mesh.node_label[k]] = k;
  }

  /// `letter`: which of several matrices of a Nastran file; `rows`: of each node, 3 or 6, 0: as the file tells by its size.
  Blocks read(char letter, int rows) {
    if (is_op4(path_)) {
      read_op4(
          path_, letter,
          [&](const Op4Head& head) {
            const std::int64_t n_nodes = mesh_.n_nodes();
            for (const int width : {3, 6})
              if (head.rows == width * n_nodes && head.columns == head.rows) {
                rows = width;
                return;
              }
            throw std::invalid_argument(fmt::format(
                "{}: matrix {} has {} rows and {} columns; {} or {} are wanted, three or six for each of the "
                "{} "
                "nodes by ascending number (Nastran's g-set without scalar points: KGG, MGG)",
                path_.string(), head.name, head.rows, head.columns, 3 * n_nodes, 6 * n_nodes, n_nodes));
          },
          [&](std::int64_t row, std::int64_t column, double value) {
            if (value == 0.0) return;
            const auto spread = [&](std::int64_t k) { return k / rows * 6 + k % rows; };
            add(0, spread(row), spread(column), value);
          });
    } else if (is_nastran_text(path_)) {
      read_dmig(path_, letter, [&](const DmigEntry& e) {
        for (int side = 0; side < 2; ++side)
          if (e.component[side] == 0)
            refuse(e.line, fmt::format("point {} is a scalar point (component 0), but K has none: a body "
                                       "that is reduced to modes has "
                                       "them in both",
                                       e.point[side]));
        add(e.line, row_of(e.line, e.point[0], e.component[0]), row_of(e.line, e.point[1], e.component[1]),
            e.value);
      });
    } else {
      read_numbers(rows);
    }
    for (auto& [pair, block] : blocks_) block = (block.array() == kUnset).select(0.0, block);
    return std::move(blocks_);
  }

 private:
  struct Entry {
    std::int64_t row, column;
    double value;
    int line;
  };

  [[noreturn]] void refuse(int line, const std::string& what) const {
    if (line == 0) throw std::invalid_argument(fmt::format("{}: {}", path_.string(), what));
    throw std::invalid_argument(fmt::format("{}, line {}: {}", path_.string(), line, what));
  }

  /// Row among six of each node.
  std::int64_t row_of(int line, std::int64_t label, std::int64_t direction) const {
    const auto found = place_.find(label);
    if (found == place_.end()) refuse(line, fmt::format("there is no node {}", label));
    if (direction < 1 || direction > 6)
      refuse(line, fmt::format("direction {} is none of 1 to 6 (displacements, rotations)", direction));
    return 6 * static_cast<std::int64_t>(found->second) + direction - 1;
  }

  void read_numbers(int rows) {
    const std::int64_t n_nodes = mesh_.n_nodes();
    bool head = !matrix_market_head(path_).empty();  // its first line says rows, columns, entries
    std::vector<Entry> entries;                      // by rows of the file
    for_each_line(path_, [&](const std::vector<double>& v, int line) {
      if (head) {
        head = false;
        for (const int width : {3, 6})
          if (v.size() == 3 && v[0] == static_cast<double>(width * n_nodes) && v[1] == v[0]) {
            rows = width;
            return;
          }
        refuse(line,
               fmt::format("a matrix of {} or {} rows and columns is wanted, three or six for each of the {} "
                           "nodes",
                           3 * n_nodes, 6 * n_nodes, n_nodes));
      }
      if (v.size() == 5) {
        const auto row = [&](int side) {
          return row_of(line, static_cast<std::int64_t>(v[2 * side]),
                        static_cast<std::int64_t>(v[2 * side + 1]));
        };
        add(line, row(0), row(1), v[4]);
        return;
      }
      if (v.size() != 3)
        refuse(line,
               fmt::format(
                   "{} numbers; row, column, value are wanted, or node, direction, node, direction, value",
                   v.size()));
      for (const int side : {0, 1})
        if (v[side] < 1.0 || v[side] > static_cast<double>(6 * n_nodes)) refuse_size(line, v[side]);
      entries.push_back(
          {static_cast<std::int64_t>(v[0]) - 1, static_cast<std::int64_t>(v[1]) - 1, v[2], line});
    });
    // Without a head: of six rows each the last node has displacements at least, which are beyond three rows each.
    if (rows == 0 && !entries.empty()) {
      const auto last_of = [](const Entry& e) { return std::max(e.row, e.column); };
      const Entry& last = *std::ranges::max_element(entries, {}, last_of);
      rows = last_of(last) < 3 * n_nodes ? 3 : 6;
      if (rows == 6 && last_of(last) < 6 * (n_nodes - 1))
        refuse_size(last.line, static_cast<double>(last_of(last) + 1));
    }
    for (const Entry& e : entries) {
      const auto spread = [&](std::int64_t row) {
        if (row >= rows * n_nodes) refuse_size(e.line, static_cast<double>(row + 1));
        return row / rows * 6 + row % rows;
      };
      add(e.line, spread(e.row), spread(e.column), e.value);
    }
  }

  [[noreturn]] void refuse_size(int line, double row) const {
    const std::int64_t n_nodes = mesh_.n_nodes();
    refuse(line, fmt::format(
                     "row or column {} lies beyond the {} that {} nodes have with three rows each, or is not "
                     "of a matrix of all {} with six each",
                     row, 3 * n_nodes, n_nodes, 6 * n_nodes));
  }

  void add(int line, std::int64_t row, std::int64_t column, double value) {
    if (row / 3 > column / 3) std::swap(row, column);
    const auto a = static_cast<mesh::Index>(row / 3), b = static_cast<mesh::Index>(column / 3);
    Eigen::Matrix3d& block = blocks_.try_emplace({a, b}, Eigen::Matrix3d::Constant(kUnset)).first->second;
    const auto i = static_cast<int>(row % 3), j = static_cast<int>(column % 3);
    const auto put = [&](double& entry) {
      // Both triangles come from one number, printed twice.
      if (entry != kUnset && std::abs(entry - value) > 1e-6 * (std::abs(entry) + std::abs(value)))
        refuse(line,
               fmt::format("this entry and its mirror image differ ({} and {}); the matrix must be symmetric",
                           value, entry));
      entry = value;
    };
    put(block(i, j));
    if (a == b && i != j) put(block(j, i));
  }

  const std::filesystem::path& path_;
  const mesh::Mesh& mesh_;
  std::unordered_map<std::int64_t, mesh::Index> place_;
  Blocks blocks_;
};

Blocks read_blocks(const std::filesystem::path& path, char letter, const mesh::Mesh& mesh, int rows = 0) {
  return BlockReader(path, mesh).read(letter, rows);
}

std::int64_t label_of(const mesh::Mesh& mesh, mesh::Index node) {
  return mesh.node_label.empty() ? node + 1 : mesh.node_label[node];
}

/// The blocks that have rotations, as elements of one node or two.
class TurningElements {
 public:
  void add(const Blocks& blocks, Eigen::MatrixXd FrameElement::*matrix) {
    for (const auto& [pair, block] : blocks) {
      if (!(turns(pair[0]) || turns(pair[1])) || block.isZero(0.0)) continue;
      const mesh::Index a = pair[0] / 2, b = pair[1] / 2;
      FrameElement& element = elements_[{a, b}];
      const Eigen::Index size = a == b ? 6 : 12;
      if (element.nodes.empty()) element.nodes = a == b ? std::vector{a} : std::vector{a, b};
      for (Eigen::MatrixXd* any : {&element.K, &(element.*matrix)})
        if (any->size() == 0) any->setZero(size, size);
      const Eigen::Index row = 3 * (pair[0] % 2), column = 3 * (pair[1] % 2) + (a == b ? 0 : 6);
      (element.*matrix).block<3, 3>(row, column) = block;
      (element.*matrix).block<3, 3>(column, row) = block.transpose();
    }
  }
  std::vector<FrameElement> take() {
    std::vector<FrameElement> all;
    for (auto& [pair, element] : elements_) all.push_back(std::move(element));
    return all;
  }

 private:
  std::map<std::array<mesh::Index, 2>, FrameElement> elements_;
};

}  // namespace

GivenMatrices read_mass_matrix(const std::filesystem::path& mass, const mesh::Mesh& mesh) {
  const Blocks M = read_blocks(mass, 'M', mesh);
  // Printed digits: six at least, of the largest of a kind: masses, first and second moments.
  std::array<double, 3> greatest{};
  for (const auto& [pair, block] : M) {
    double& size = greatest[static_cast<std::size_t>(turns(pair[0]) + turns(pair[1]))];
    size = std::max(size, block.cwiseAbs().maxCoeff());
  }
  // What other programs leave as zero is round-off of masses times lengths.
  const double length = (mesh.points.colwise().maxCoeff() - mesh.points.colwise().minCoeff()).norm(),
               printed = std::max(1e-6 * greatest[1], 1e-12 * greatest[0] * length);
  GivenMatrices out;
  std::map<std::array<mesh::Index, 2>, TurningMass> turning;
  for (const auto& [pair, block] : M) {
    const std::array<mesh::Index, 2> nodes{pair[0] / 2, pair[1] / 2};
    const auto refuse = [&](const std::string& what) {
      throw std::invalid_argument(fmt::format(
          "{}: the mass between nodes {} and {} {}; only the masses of solids, shells, point masses and "
          "lumped beams are taken: write a lumped mass matrix (Nastran: PARAM,COUPMASS,-1)",
          mass.string(), label_of(mesh, nodes[0]), label_of(mesh, nodes[1]), what));
    };
    if (!turns(pair[0]) && !turns(pair[1])) {
      const double m = block.trace() / 3.0;
      if ((block - m * Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-6 * greatest[0])
        refuse("must be the same in the three directions");
      out.u.pairs.push_back(nodes);
      out.u.K.push_back(Eigen::Matrix3d::Zero());
      out.u.m.push_back(m);
      continue;
    }
    if (block.isZero(0.0)) continue;
    TurningMass& to = turning[nodes];
    to.nodes = nodes;
    if (turns(pair[0]) && turns(pair[1])) {
      to.inertia = block;
    } else {
      // u . (theta x c) = -u . [c] theta
      if ((block + block.transpose()).cwiseAbs().maxCoeff() > printed)
        refuse("must couple displacements and rotations as an offset of a mass does");
      const Eigen::Matrix3d of_u = turns(pair[1]) ? block : Eigen::Matrix3d(block.transpose());
      const Eigen::Vector3d c(of_u(1, 2) - of_u(2, 1), of_u(2, 0) - of_u(0, 2), of_u(0, 1) - of_u(1, 0));
      (turns(pair[1]) ? to.moment_of_second : to.moment_of_first) = 0.5 * c;
    }
  }
  for (auto& [nodes, mass_of] : turning) {
    if (nodes[0] == nodes[1]) mass_of.moment_of_first = mass_of.moment_of_second;
    out.turning.push_back(mass_of);
  }
  return out;
}

GivenMatrices read_matrices(const std::filesystem::path& stiffness, const std::filesystem::path& mass,
                            const std::filesystem::path& damping, const mesh::Mesh& mesh) {
  const Blocks K = read_blocks(stiffness, 'K', mesh);
  GivenMatrices out = read_mass_matrix(mass, mesh);
  std::map<std::array<mesh::Index, 2>, std::size_t> place;
  for (std::size_t k = 0; k < out.u.pairs.size(); ++k) place[out.u.pairs[k]] = k;
  TurningElements turning;
  const auto take = [&](const Blocks& blocks, std::vector<Eigen::Matrix3d>& into) {
    into.resize(out.u.pairs.size(), Eigen::Matrix3d::Zero());
    for (const auto& [halves, block] : blocks) {
      if (turns(halves[0]) || turns(halves[1])) continue;
      const std::array<mesh::Index, 2> pair{halves[0] / 2, halves[1] / 2};
      const auto [at, is_new] = place.emplace(pair, out.u.pairs.size());
      if (is_new) {
        out.u.pairs.push_back(pair);
        into.push_back(block);
      } else {
        into[at->second] = block;
      }
    }
    for (std::vector<Eigen::Matrix3d>* list : {&out.u.K, &out.u.D})
      if (!list->empty()) list->resize(out.u.pairs.size(), Eigen::Matrix3d::Zero());
    out.u.m.resize(out.u.pairs.size(), 0.0);
  };
  take(K, out.u.K);
  turning.add(K, &FrameElement::K);
  if (!damping.empty()) {
    // Dampers need not be at the last node: as many rows as K.
    const bool six =
        std::ranges::any_of(K, [](const auto& k) { return turns(k.first[0]) || turns(k.first[1]); });
    const Blocks D = read_blocks(damping, 'B', mesh, six ? 6 : 3);
    take(D, out.u.D);
    turning.add(D, &FrameElement::D);
  }
  out.frames = turning.take();
  std::vector<char> can_turn(mesh.n_nodes(), 0);
  for (const FrameElement& frame : out.frames)
    for (std::size_t a = 0; a < frame.nodes.size(); ++a)
      if (!frame.K.middleRows<3>(6 * static_cast<Eigen::Index>(a) + 3).isZero(0.0))
        can_turn[frame.nodes[a]] = 1;
  for (const TurningMass& of : out.turning)
    for (const mesh::Index node : of.nodes)
      if (!can_turn[node])
        throw std::invalid_argument(fmt::format(
            "{}: node {} has rotary inertia, but {} has no stiffness of its rotation; give K with six "
            "rows a node, or M without inertia there",
            mass.string(), label_of(mesh, node), stiffness.string()));
  return out;
}

namespace {

Eigen::MatrixXd dense_of_op4(const std::filesystem::path& path, char letter) {
  Eigen::MatrixXd A;
  read_op4(
      path, letter,
      [&](const Op4Head& head) {
        // Columns without an entry are left out of the file, but not most of them.
        const double most = std::max(1e6, 1e3 * static_cast<double>(std::filesystem::file_size(path)));
        if (static_cast<double>(head.rows) * static_cast<double>(head.columns) > most)
          throw std::invalid_argument(
              fmt::format("{}: {} x {} are more numbers than a file of this size can hold", path.string(),
                          head.rows, head.columns));
        A.setZero(head.rows, head.columns);
      },
      [&](std::int64_t row, std::int64_t column, double value) { A(row, column) = value; });
  return A;
}

}  // namespace

Eigen::MatrixXd read_dense(const std::filesystem::path& path, char letter) {
  if (is_op4(path)) return dense_of_op4(path, letter);
  const std::string head = matrix_market_head(path);
  const bool market = !head.empty(), coordinate = head.find("coordinate") != std::string::npos,
             symmetric = head.find("symmetric") != std::string::npos;
  if (market && head.find("complex") != std::string::npos)
    throw std::invalid_argument(path.string() + ": complex vectors are not taken; give real modes");
  std::vector<std::vector<double>> rows;  // of plain text
  Eigen::MatrixXd A;
  Eigen::Index i = 0, j = 0;  // the place of the next number of an array
  bool sized = !market;
  for_each_line(path, [&](const std::vector<double>& v, int line) {
    const auto refuse = [&](const std::string& what) {
      throw std::invalid_argument(fmt::format("{}, line {}: {}", path.string(), line, what));
    };
    if (!sized) {
      if (v.size() != (coordinate ? 3U : 2U) || v[0] < 1 || v[1] < 1 || v[0] > 1e9 || v[1] > 1e9)
        refuse("the numbers of rows and columns are wanted");
      if (v[0] * v[1] > most_of(path))
        refuse(fmt::format("{:g} x {:g} are more numbers than a file of this size can hold", v[0], v[1]));
      A.setZero(static_cast<Eigen::Index>(v[0]), static_cast<Eigen::Index>(v[1]));
      if (symmetric && A.rows() != A.cols()) refuse("a symmetric matrix has as many columns as rows");
      sized = true;
    } else if (!market) {
      if (!rows.empty() && v.size() != rows.front().size())
        refuse(fmt::format("{} numbers, the rows before have {}", v.size(), rows.front().size()));
      rows.push_back(v);
    } else if (coordinate) {
      if (v.size() != 3) refuse("row, column and value are wanted");
      const auto row = static_cast<Eigen::Index>(v[0]) - 1, column = static_cast<Eigen::Index>(v[1]) - 1;
      if (row < 0 || column < 0 || row >= A.rows() || column >= A.cols())
        refuse(fmt::format("row {}, column {} lies outside {} x {}", v[0], v[1], A.rows(), A.cols()));
      A(row, column) = v[2];
      if (symmetric) A(column, row) = v[2];
    } else {
      for (const double value : v) {
        if (j >= A.cols()) refuse("more numbers than the matrix has entries");
        A(i, j) = value;
        if (symmetric) A(j, i) = value;
        if (++i == A.rows()) i = symmetric ? ++j : (++j, 0);
      }
    }
  });
  if (market && !coordinate && j < A.cols())
    throw std::invalid_argument(
        fmt::format("{}: ends before the {} x {} entries are there", path.string(), A.rows(), A.cols()));
  if (!market) {
    if (rows.empty()) throw std::invalid_argument(path.string() + ": holds no numbers");
    A.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.front().size()));
    for (std::size_t r = 0; r < rows.size(); ++r)
      A.row(static_cast<Eigen::Index>(r)) =
          Eigen::Map<const Eigen::RowVectorXd>(rows[r].data(), static_cast<Eigen::Index>(rows[r].size()));
  }
  return A;
}

mesh::Mesh read_nodes(const std::filesystem::path& path) {
  std::map<std::int64_t, Eigen::Vector3d> nodes;
  for_each_line(path, [&](const std::vector<double>& v, int line) {
    if (v.size() != 4)
      throw std::invalid_argument(fmt::format("{}, line {}: {} numbers; node number, x, y, z are wanted",
                                              path.string(), line, v.size()));
    if (!nodes.emplace(static_cast<std::int64_t>(v[0]), Eigen::Vector3d(v[1], v[2], v[3])).second)
      throw std::invalid_argument(fmt::format(
          "{}, line {}: node {} is given twice; node numbers must be unique", path.string(), line, v[0]));
  });
  if (nodes.empty()) throw std::invalid_argument(path.string() + ": holds no nodes");
  mesh::Mesh mesh;
  mesh.points.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (const auto& [label, x] : nodes) {
    mesh.points.row(static_cast<Eigen::Index>(mesh.node_label.size())) = x.transpose();
    mesh.node_label.push_back(label);
  }
  return mesh;
}

}  // namespace flexura::reduce
