// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>

#include "reduce/elements/element.hpp"
#include "reduce/elements/solid.hpp"

namespace flexura::reduce {
namespace {

using mesh::CellType;

const TabulatedRule& face_rule(CellType type) {
  static const std::map<CellType, TabulatedRule> rules = [] {
    std::map<CellType, TabulatedRule> table;
    for (CellType face : {CellType::tri3, CellType::tri6, CellType::quad4, CellType::quad8, CellType::quad9})
      table.emplace(face, tabulate(face, mesh::volume_quadrature(face)));
    return table;
  }();
  const auto found = rules.find(type);
  if (found == rules.end())
    throw std::invalid_argument(std::string("cells of type ") + mesh::name_of(type) + " are not faces");
  return found->second;
}

// Calls visit(nodes of the cell, N, normal times dA) for every quadrature point of every face.
template <class Visit>
void for_each_point(const mesh::Mesh& mesh, std::span<const mesh::CellBlock> faces, const Visit& visit) {
  for (const mesh::CellBlock& block : faces) {
    const TabulatedRule& rule = face_rule(block.type);
    NodePositions x(block.nodes.cols(), 3);
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell) {
      for (Eigen::Index a = 0; a < block.nodes.cols(); ++a) x.row(a) = mesh.points.row(block.nodes(cell, a));
      for (const TabulatedRule::Point& point : rule.points) {
        const Eigen::Matrix<double, 3, 3> tangents = point.dN.transpose() * x;
        const Eigen::Vector3d dA =
            point.weight * tangents.row(0).transpose().cross(tangents.row(1).transpose());
        visit(block.nodes.row(cell), point.N, dA);
      }
    }
  }
}

}  // namespace

Eigen::SparseMatrix<double> surface_mass(const mesh::Mesh& mesh, std::span<const mesh::CellBlock> faces,
                                         std::span<const mesh::Index> nodes) {
  std::vector<Eigen::Triplet<double>> entries;
  for_each_point(mesh, faces, [&](const auto& cell, const auto& N, const Eigen::Vector3d& dA) {
    int local[kMaxNodes];
    for (Eigen::Index a = 0; a < N.size(); ++a) {
      const auto found = std::lower_bound(nodes.begin(), nodes.end(), cell(a));
      if (found == nodes.end() || *found != cell(a))
        throw std::invalid_argument("a face has node " + std::to_string(cell(a)) +
                                    ", which its node set lacks");
      local[a] = static_cast<int>(found - nodes.begin());
    }
    const double area = dA.norm();
    for (Eigen::Index a = 0; a < N.size(); ++a)
      for (Eigen::Index c = 0; c < N.size(); ++c)
        entries.emplace_back(local[a], local[c], N(a) * N(c) * area);
  });
  const auto n = static_cast<Eigen::Index>(nodes.size());
  Eigen::SparseMatrix<double> W(n, n);
  W.setFromTriplets(entries.begin(), entries.end());
  return W;
}

Eigen::Matrix<double, Eigen::Dynamic, 3> pressure_load(const mesh::Mesh& mesh,
                                                       std::span<const mesh::CellBlock> faces) {
  Eigen::Matrix<double, Eigen::Dynamic, 3> load =
      Eigen::Matrix<double, Eigen::Dynamic, 3>::Zero(mesh.n_nodes(), 3);
  for_each_point(mesh, faces, [&](const auto& cell, const auto& N, const Eigen::Vector3d& dA) {
    for (Eigen::Index a = 0; a < N.size(); ++a) load.row(cell(a)) += N(a) * dA.transpose();
  });
  return load;
}

}  // namespace flexura::reduce
