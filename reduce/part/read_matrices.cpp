// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/read_matrices.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace flexura::reduce {
namespace {

/// Of a packed text no more is unpacked, and of a matrix no more numbers are held, than a file of its size can mean: 13 MB can be
/// made of 3 GB of blanks.  Matrices as programs print them pack to a third or a tenth.
double most_of(const std::filesystem::path& path) {
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(path, none);
  return none ? 0.0 : 1e7 + 20.0 * static_cast<double>(size);
}

/// The lines of a text file, packed by gzip or not.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path)
      : path_(path), file_(gzopen(path.c_str(), "rb"), gzclose), most_(most_of(path)) {
    if (!file_) throw std::invalid_argument(path.string() + ": there is no such file");
  }

  /// False at the end of the file.
  bool next(std::string& line) {
    constexpr std::size_t longest = 2'000'000;  // a row of 20,000 modes has a quarter of that
    char buffer[4096];
    line.clear();
    ++number_;
    while (gzgets(file_.get(), buffer, sizeof buffer) != nullptr) {
      line += buffer;
      if (static_cast<double>(gztell(file_.get())) > most_)
        refuse("unpacks to more than 20 times the file's size; give the matrix unpacked");
      if (line.size() > longest) refuse(fmt::format("is longer than {} letters; is this a matrix?", longest));
      if (line.empty()) refuse("holds a zero character; a text file is wanted");
      if (line.back() == '\n') return true;
    }
    int code = Z_OK;
    gzerror(file_.get(), &code);
    if (code != Z_OK && code != Z_STREAM_END) refuse("cannot be unpacked; the file is damaged or cut short");
    return !line.empty();
  }
  int number() const { return number_; }
  [[noreturn]] void refuse(const std::string& what) const {
    throw std::invalid_argument(fmt::format("{}, line {}: {}", path_.string(), number_, what));
  }

 private:
  std::filesystem::path path_;
  std::unique_ptr<gzFile_s, int (*)(gzFile)> file_;
  double most_;  // bytes
  int number_ = 0;
};

/// Calls with the numbers of each line that is neither blank nor a comment; commas are blanks.
void for_each_line(const std::filesystem::path& path,
                   const std::function<void(const std::vector<double>&, int line)>& work) {
  Lines lines(path);
  std::vector<double> numbers;
  for (std::string text; lines.next(text);) {
    numbers.clear();
    for (const char* at = text.c_str(); *at != '\0';) {
      while (*at == ',' || std::isspace(static_cast<unsigned char>(*at))) ++at;
      if (*at == '\0' || *at == '#' || *at == '%' || *at == '*') break;
      char* end = nullptr;
      const double value = std::strtod(at, &end);
      if (end == at) lines.refuse("a number is wanted");
      if (!std::isfinite(value)) lines.refuse("an entry is not finite");
      numbers.push_back(value);
      at = end;
    }
    if (!numbers.empty()) work(numbers, lines.number());
  }
}

/// The words of Matrix Market's first line; empty for other files.
std::string matrix_market_head(const std::filesystem::path& path) {
  std::string head;
  return Lines(path).next(head) && head.starts_with("%%MatrixMarket") ? head : "";
}

constexpr double kUnset = std::numeric_limits<double>::infinity();

using Blocks = std::map<std::array<mesh::Index, 2>, Eigen::Matrix3d>;

Blocks read_blocks(const std::filesystem::path& path, const mesh::Mesh& mesh) {
  const std::int64_t n = 3 * static_cast<std::int64_t>(mesh.n_nodes());
  std::unordered_map<std::int64_t, mesh::Index> place;
  for (mesh::Index k = 0; k < mesh.n_nodes(); ++k)
    place[mesh.node_label.empty() ? k + 1 : mesh.node_label[k]] = k;
  Blocks blocks;
  bool head = !matrix_market_head(path).empty();  // its first line says rows, columns, entries
  for_each_line(path, [&](const std::vector<double>& v, int line) {
    const auto refuse = [&](const std::string& what) {
      throw std::invalid_argument(fmt::format("{}, line {}: {}", path.string(), line, what));
    };
    if (head) {
      head = false;
      if (v.size() != 3 || v[0] != static_cast<double>(n) || v[1] != static_cast<double>(n))
        refuse(fmt::format("a matrix of {} rows and columns is wanted, three for each of the {} nodes", n,
                           mesh.n_nodes()));
      return;
    }
    std::int64_t row[2];
    if (v.size() == 3) {
      row[0] = static_cast<std::int64_t>(v[0]) - 1;
      row[1] = static_cast<std::int64_t>(v[1]) - 1;
    } else if (v.size() == 5) {
      for (int side = 0; side < 2; ++side) {
        const auto found = place.find(static_cast<std::int64_t>(v[2 * side]));
        if (found == place.end()) refuse(fmt::format("there is no node {}", v[2 * side]));
        if (!(v[2 * side + 1] >= 1.0 && v[2 * side + 1] <= 3.0))
          refuse(fmt::format("direction {} is none of 1, 2, 3; rotations are not taken", v[2 * side + 1]));
        row[side] =
            3 * static_cast<std::int64_t>(found->second) + static_cast<std::int64_t>(v[2 * side + 1]) - 1;
      }
    } else {
      refuse(fmt::format(
          "{} numbers; row, column, value are wanted, or node, direction, node, direction, value", v.size()));
    }
    for (const std::int64_t r : row)
      if (r < 0 || r >= n)
        refuse(
            fmt::format("row or column {} lies beyond the {} that {} nodes have", r + 1, n, mesh.n_nodes()));
    if (row[0] / 3 > row[1] / 3) std::swap(row[0], row[1]);
    const auto a = static_cast<mesh::Index>(row[0] / 3), b = static_cast<mesh::Index>(row[1] / 3);
    Eigen::Matrix3d& block = blocks.try_emplace({a, b}, Eigen::Matrix3d::Constant(kUnset)).first->second;
    const auto i = static_cast<int>(row[0] % 3), j = static_cast<int>(row[1] % 3);
    const auto put = [&](double& entry) {
      // Both triangles come from one number, printed twice.
      if (entry != kUnset && std::abs(entry - v.back()) > 1e-6 * (std::abs(entry) + std::abs(v.back())))
        refuse(fmt::format("this entry and its mirror image differ ({} and {}); the matrix must be symmetric",
                           v.back(), entry));
      entry = v.back();
    };
    put(block(i, j));
    if (a == b && i != j) put(block(j, i));
  });
  for (auto& [pair, block] : blocks) block = (block.array() == kUnset).select(0.0, block);
  return blocks;
}

}  // namespace

NodalMatrices read_mass_matrix(const std::filesystem::path& mass, const mesh::Mesh& mesh) {
  const Blocks M = read_blocks(mass, mesh);
  double greatest = 0.0;
  for (const auto& [pair, block] : M) greatest = std::max(greatest, block.cwiseAbs().maxCoeff());
  NodalMatrices out;
  for (const auto& [pair, block] : M) {
    const double m = block.trace() / 3.0;
    // Printed digits: six at least.
    if ((block - m * Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-6 * greatest)
      throw std::invalid_argument(
          fmt::format("{}: the mass between nodes {} and {} is not the same in the three directions; only "
                      "mass matrices of "
                      "solid elements and point masses are taken",
                      mass.string(), pair[0] + 1, pair[1] + 1));
    out.pairs.push_back(pair);
    out.K.push_back(Eigen::Matrix3d::Zero());
    out.m.push_back(m);
  }
  return out;
}

NodalMatrices read_matrices(const std::filesystem::path& stiffness, const std::filesystem::path& mass,
                            const std::filesystem::path& damping, const mesh::Mesh& mesh) {
  const Blocks K = read_blocks(stiffness, mesh);
  NodalMatrices out = read_mass_matrix(mass, mesh);
  std::map<std::array<mesh::Index, 2>, std::size_t> place;
  for (std::size_t k = 0; k < out.pairs.size(); ++k) place[out.pairs[k]] = k;
  const auto take = [&](const Blocks& blocks, std::vector<Eigen::Matrix3d>& into) {
    into.resize(out.pairs.size(), Eigen::Matrix3d::Zero());
    for (const auto& [pair, block] : blocks) {
      const auto [at, is_new] = place.emplace(pair, out.pairs.size());
      if (is_new) {
        out.pairs.push_back(pair);
        into.push_back(block);
      } else {
        into[at->second] = block;
      }
    }
    for (std::vector<Eigen::Matrix3d>* list : {&out.K, &out.D})
      if (!list->empty()) list->resize(out.pairs.size(), Eigen::Matrix3d::Zero());
    out.m.resize(out.pairs.size(), 0.0);
  };
  take(K, out.K);
  if (!damping.empty()) take(read_blocks(damping, mesh), out.D);
  return out;
}

Eigen::MatrixXd read_dense(const std::filesystem::path& path) {
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
