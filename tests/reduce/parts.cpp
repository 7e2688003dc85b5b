// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/reduce/parts.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/cells/record.hpp"
#include "mesh/model/geometry.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"

namespace flexura::reduce::testing {
namespace {

using mesh::CellType;
using mesh::Index;

// The cell of the same corners and no other nodes.
CellType corner_type(CellType type) {
  for (const mesh::CellRecord& record : mesh::cell_records())
    if (record.is_linear() && record.dimension == mesh::dimension_of(type) &&
        record.shape.corners == mesh::shape_of(type).corners)
      return record.type;
  throw std::invalid_argument(std::string(mesh::name_of(type)) + " has no linear cell of its shape");
}

// Corner cells of one brick, in the bricks' own corner numbers 0-7 (VTK order); 8 is the centre.
std::vector<std::vector<int>> split_brick(CellType type) {
  switch (type) {
    case CellType::tet4:  // the six paths from corner 0 to corner 6
      return {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
    case CellType::wedge6:
      return {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
    case CellType::pyramid5:
      return {{0, 1, 2, 3, 8}, {4, 7, 6, 5, 8}, {0, 4, 5, 1, 8},
              {1, 5, 6, 2, 8}, {2, 6, 7, 3, 8}, {3, 7, 4, 0, 8}};
    default:
      return {{0, 1, 2, 3, 4, 5, 6, 7}};
  }
}

}  // namespace

mesh::Mesh box(const Eigen::Vector3d& size, const std::array<int, 3>& n, CellType type) {
  const int nx = n[0], ny = n[1], nz = n[2];
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) points.emplace_back(size(0) * i / nx, size(1) * j / ny, size(2) * k / nz);
  const auto at = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  const mesh::CellShape& shape = mesh::shape_of(type);
  std::map<std::vector<int>, int> between;  // corners -> the node in their middle
  const auto middle = [&](std::vector<int> corners) {
    std::sort(corners.begin(), corners.end());
    const auto [found, fresh] = between.try_emplace(corners, static_cast<int>(points.size()));
    if (fresh) {
      Eigen::Vector3d x = Eigen::Vector3d::Zero();
      for (int c : corners) x += points[c] / static_cast<double>(corners.size());
      points.push_back(x);
    }
    return found->second;
  };
  std::vector<std::vector<int>> cells;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        std::vector<int> brick{
            at(i, j, k),     at(i + 1, j, k),     at(i + 1, j + 1, k),     at(i, j + 1, k),
            at(i, j, k + 1), at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)};
        if (corner_type(type) == CellType::pyramid5) {
          const std::vector<int> corners = brick;
          brick.push_back(middle(corners));
        }
        for (const auto& local : split_brick(corner_type(type))) {
          std::vector<int> cell;
          for (int c : local) cell.push_back(brick[c]);
          const std::vector<int> corners = cell;
          // Every other node lies in the middle of the corners whose linear functions are not zero there.
          for (int a = shape.corners; a < mesh::nodes_per_cell(type); ++a) {
            const Eigen::VectorXd N =
                mesh::evaluate_shape(corner_type(type), mesh::reference_nodes(type).row(a)).N;
            std::vector<int> around;
            for (int c = 0; c < shape.corners; ++c)
              if (std::abs(N(c)) > 1e-9) around.push_back(corners[c]);
            cell.push_back(middle(around));
          }
          cells.push_back(cell);
        }
      }
  mesh::Mesh mesh;
  mesh.points.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t a = 0; a < points.size(); ++a) mesh.points.row(static_cast<Eigen::Index>(a)) = points[a];
  mesh::CellBlock block;
  block.type = type;
  block.nodes.resize(static_cast<Eigen::Index>(cells.size()), mesh::nodes_per_cell(type));
  for (std::size_t e = 0; e < cells.size(); ++e)
    for (std::size_t a = 0; a < cells[e].size(); ++a)
      block.nodes(static_cast<Eigen::Index>(e), static_cast<Eigen::Index>(a)) = cells[e][a];
  mesh.solids.push_back(block);
  mesh::extract_boundary(mesh);
  return mesh;
}

void deform(mesh::Mesh& mesh, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map,
            bool straight) {
  for (Eigen::Index a = 0; a < mesh.points.rows(); ++a) {
    const Eigen::Vector3d x = mesh.points.row(a);
    mesh.points.row(a) = map(x);
  }
  if (!straight) return;
  for (const mesh::CellBlock& block : mesh.solids) {
    const mesh::CellShape& shape = mesh::shape_of(block.type);
    if (block.nodes.cols() == shape.corners) continue;
    for (Eigen::Index e = 0; e < block.nodes.rows(); ++e)
      for (std::size_t k = 0; k < shape.edges.size(); ++k)
        mesh.points.row(block.nodes(e, shape.corners + static_cast<int>(k))) =
            0.5 * (mesh.points.row(block.nodes(e, shape.edges[k][0])) +
                   mesh.points.row(block.nodes(e, shape.edges[k][1])));
  }
}

mesh::NodeSet nodes_where(const mesh::Mesh& mesh, const std::function<bool(const Eigen::Vector3d&)>& inside) {
  mesh::NodeSet set;
  std::vector<char> in(mesh.n_nodes(), 0);
  for (Index a = 0; a < mesh.n_nodes(); ++a)
    if ((in[a] = inside(mesh.points.row(a)))) set.nodes.push_back(a);
  for (const mesh::CellBlock& block : mesh.boundary) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index f = 0; f < block.nodes.rows(); ++f)
      if (std::all_of(block.nodes.row(f).begin(), block.nodes.row(f).end(), [&](Index a) { return in[a]; }))
        rows.push_back(f);
    if (rows.empty()) continue;
    mesh::CellBlock faces;
    faces.type = block.type;
    faces.nodes = block.nodes(rows, Eigen::all);
    set.faces.push_back(faces);
  }
  return set;
}

Material steel() {
  return isotropic("steel", 2.1e11, 0.3, 7850.0);
}

Part beam(const Eigen::Vector3d& size, const std::array<int, 3>& n, CellType type, Tie left, Tie right) {
  Part part;
  part.mesh = box(size, n, type);
  part.materials = {steel()};
  const double end = size(0);
  const Eigen::Vector3d centre(0.0, 0.5 * size(1), 0.5 * size(2));
  const auto face = [&](double x) {
    return nodes_where(part.mesh, [=](const Eigen::Vector3d& p) { return std::abs(p(0) - x) < 1e-9 * end; });
  };
  part.interfaces.push_back({"left", left, centre, face(0.0)});
  part.interfaces.push_back({"right", right, centre + Eigen::Vector3d(end, 0, 0), face(end)});
  return part;
}

mesh::Mesh read_abaqus(const std::string& path, CellType type) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path);
  std::vector<Eigen::Vector3d> points;
  std::vector<std::vector<int>> cells;
  enum { other, node, element } section = other;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("*", 0) == 0) {
      section = line.rfind("*Node", 0) == 0 ? node : line.rfind("*Element,", 0) == 0 ? element : other;
      continue;
    }
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    int number = 0;
    if (section == other || !(words >> number)) continue;
    if (section == node) {
      Eigen::Vector3d x;
      words >> x(0) >> x(1) >> x(2);
      points.push_back(x);
    } else {
      std::vector<int> cell;
      for (int a = 0; words >> a;) cell.push_back(a - 1);
      cells.push_back(cell);
    }
  }
  mesh::Mesh mesh;
  mesh.points.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t a = 0; a < points.size(); ++a) mesh.points.row(static_cast<Eigen::Index>(a)) = points[a];
  mesh::CellBlock block;
  block.type = type;
  block.nodes.resize(static_cast<Eigen::Index>(cells.size()), mesh::nodes_per_cell(type));
  for (std::size_t e = 0; e < cells.size(); ++e)
    for (std::size_t a = 0; a < cells[e].size(); ++a)
      block.nodes(static_cast<Eigen::Index>(e), static_cast<Eigen::Index>(a)) = cells[e][a];
  mesh.solids.push_back(block);
  mesh::extract_boundary(mesh);
  return mesh;
}

Eigen::MatrixXd read_coordinates(const std::string& path, int n) {
  gzFile file = gzopen(path.c_str(), "rb");
  if (!file) throw std::runtime_error("cannot open " + path);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
  char line[256];
  while (gzgets(file, line, sizeof line)) {
    int i = 0, j = 0;
    double value = 0.0;
    if (std::sscanf(line, "%d %d %lf", &i, &j, &value) == 3) matrix(i - 1, j - 1) = value;
  }
  gzclose(file);
  return matrix;
}

Eigen::MatrixXd dense(const linalg::SymmetricMatrix& matrix) {
  const linalg::UpperCsr csr = matrix.csr();
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(csr.n, csr.n);
  for (int i = 0; i < csr.n; ++i)
    for (int k = csr.row_begin[i]; k < csr.row_begin[i + 1]; ++k)
      full(i, csr.columns[k]) = full(csr.columns[k], i) = csr.values[k];
  return full;
}

Eigen::MatrixXd kron3(const Eigen::MatrixXd& m) {
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(3 * m.rows(), 3 * m.cols());
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) M.block<3, 3>(3 * i, 3 * j).diagonal().setConstant(m(i, j));
  return M;
}

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index cols, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd X(rows, cols);
  for (double& x : X.reshaped()) x = uniform(random);
  return X;
}

}  // namespace flexura::reduce::testing
