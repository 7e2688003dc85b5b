// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cell.hpp"

#include <cmath>
#include <map>
#include <stdexcept>

#include "mesh/model/dual.hpp"

namespace flexura::mesh {
namespace {

using Edges = std::vector<std::array<int, 2>>;

Edges edges_of(CellType type) {
  switch (type) {
    case CellType::line2:
    case CellType::line3:
      return {{0, 1}};
    case CellType::tri3:
    case CellType::tri6:
      return {{0, 1}, {1, 2}, {2, 0}};
    case CellType::quad4:
    case CellType::quad8:
    case CellType::quad9:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    case CellType::tet4:
    case CellType::tet10:
      return {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    case CellType::hex8:
    case CellType::hex20:
    case CellType::hex27:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    case CellType::wedge6:
    case CellType::wedge15:
      return {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
    case CellType::pyramid5:
    case CellType::pyramid13:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};
  }
  throw std::invalid_argument("unknown cell type");
}

int corners_of(CellType type) {
  switch (type) {
    case CellType::line2:
    case CellType::line3:
      return 2;
    case CellType::tri3:
    case CellType::tri6:
      return 3;
    case CellType::quad4:
    case CellType::quad8:
    case CellType::quad9:
    case CellType::tet4:
    case CellType::tet10:
      return 4;
    case CellType::pyramid5:
    case CellType::pyramid13:
      return 5;
    case CellType::wedge6:
    case CellType::wedge15:
      return 6;
    default:
      return 8;
  }
}

/// Corner rings of the faces, counter-clockwise from outside.
std::vector<std::vector<int>> face_corners(CellType type) {
  switch (type) {
    case CellType::tet4:
    case CellType::tet10:
      return {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    case CellType::hex8:
    case CellType::hex20:
    case CellType::hex27:  // in the order of hex27's face centres
      return {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
    case CellType::wedge6:
    case CellType::wedge15:
      return {{0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
    case CellType::pyramid5:
    case CellType::pyramid13:
      return {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    default:
      return {};
  }
}

CellShape build_shape(CellType type) {
  CellShape shape{corners_of(type), edges_of(type), {}};
  const int n = nodes_per_cell(type);
  const bool quadratic = n > shape.corners && dimension_of(type) == 3;
  const std::vector<std::vector<int>> rings = face_corners(type);
  for (std::size_t f = 0; f < rings.size(); ++f) {
    const std::vector<int>& ring = rings[f];
    CellFace face{ring.size() == 3 ? CellType::tri3 : CellType::quad4, ring};
    if (quadratic) {
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const int a = ring[k], b = ring[(k + 1) % ring.size()];
        for (std::size_t e = 0; e < shape.edges.size(); ++e) {
          const auto& edge = shape.edges[e];
          if ((edge[0] == a && edge[1] == b) || (edge[0] == b && edge[1] == a))
            face.nodes.push_back(shape.corners + static_cast<int>(e));
        }
      }
      face.type = ring.size() == 3 ? CellType::tri6 : CellType::quad8;
      if (type == CellType::hex27) {
        face.nodes.push_back(20 + static_cast<int>(f));
        face.type = CellType::quad9;
      }
    }
    shape.faces.push_back(std::move(face));
  }
  return shape;
}

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;

Points corner_coordinates(CellType type) {
  Points x;
  switch (corners_of(type)) {
    case 2:
      x.resize(2, 3);
      x << -1, 0, 0, 1, 0, 0;
      break;
    case 3:
      x.resize(3, 3);
      x << 0, 0, 0, 1, 0, 0, 0, 1, 0;
      break;
    case 4:
      x.resize(4, 3);
      if (dimension_of(type) == 3)
        x << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
      else
        x << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0;
      break;
    case 5:
      x.resize(5, 3);
      x << -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1;
      break;
    case 6:
      x.resize(6, 3);
      x << 0, 0, -1, 1, 0, -1, 0, 1, -1, 0, 0, 1, 1, 0, 1, 0, 1, 1;
      break;
    default:
      x.resize(8, 3);
      x << -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1;
  }
  return x;
}

Points build_reference_nodes(CellType type) {
  const CellShape& shape = shape_of(type);
  const Points corners = corner_coordinates(type);
  Points x(nodes_per_cell(type), 3);
  x.setZero();  // the centres of quad9 and hex27
  x.topRows(shape.corners) = corners;
  if (x.rows() == shape.corners) return x;
  for (std::size_t e = 0; e < shape.edges.size(); ++e)
    x.row(shape.corners + static_cast<int>(e)) =
        0.5 * (corners.row(shape.edges[e][0]) + corners.row(shape.edges[e][1]));
  if (type == CellType::hex27)
    for (int f = 0; f < 6; ++f) x(20 + f, f / 2) = f % 2 ? 1 : -1;
  return x;
}

/// Shape functions of all types on numbers that may carry derivatives; x[3] are the reference coordinates.
template <class T>
std::vector<T> shape_functions(CellType type, const std::array<T, 3>& x) {
  const Points& node = reference_nodes(type);
  const CellShape& shape = shape_of(type);
  const int n = nodes_per_cell(type), n_corners = shape.corners;
  std::vector<T> N(n, T(0.0));
  const auto quadratic_line = [](double a, const T& r) {  // Lagrange on -1, 0, 1
    return a == 0 ? (1.0 - r) * (1.0 + r) : 0.5 * r * (r + a);
  };
  switch (type) {
    case CellType::line2:
      for (int k = 0; k < 2; ++k) N[k] = 0.5 * (1.0 + node(k, 0) * x[0]);
      break;
    case CellType::line3:
      for (int k = 0; k < 3; ++k) N[k] = quadratic_line(node(k, 0), x[0]);
      break;
    case CellType::tri3:
    case CellType::tri6:
    case CellType::tet4:
    case CellType::tet10: {
      std::vector<T> L(n_corners, T(1.0));  // barycentric
      for (int k = 1; k < n_corners; ++k) {
        L[k] = x[k - 1];
        L[0] = L[0] - x[k - 1];
      }
      const bool linear = n == n_corners;
      for (int k = 0; k < n_corners; ++k) N[k] = linear ? L[k] : L[k] * (2.0 * L[k] - 1.0);
      if (!linear)
        for (std::size_t e = 0; e < shape.edges.size(); ++e)
          N[n_corners + e] = 4.0 * L[shape.edges[e][0]] * L[shape.edges[e][1]];
      break;
    }
    case CellType::quad4:
      for (int k = 0; k < 4; ++k) N[k] = 0.25 * (1.0 + node(k, 0) * x[0]) * (1.0 + node(k, 1) * x[1]);
      break;
    case CellType::hex8:
      for (int k = 0; k < 8; ++k)
        N[k] = 0.125 * (1.0 + node(k, 0) * x[0]) * (1.0 + node(k, 1) * x[1]) * (1.0 + node(k, 2) * x[2]);
      break;
    case CellType::quad9:
    case CellType::hex27:
      for (int k = 0; k < n; ++k) {
        N[k] = quadratic_line(node(k, 0), x[0]) * quadratic_line(node(k, 1), x[1]);
        if (type == CellType::hex27) N[k] = N[k] * quadratic_line(node(k, 2), x[2]);
      }
      break;
    case CellType::quad8:
    case CellType::hex20: {
      const int d = dimension_of(type);
      for (int k = 0; k < n; ++k) {
        T product(1.0), sum(1.0 - d);
        for (int i = 0; i < d; ++i) {
          const double a = node(k, i);
          product = product * (a == 0 ? (1.0 - x[i]) * (1.0 + x[i]) : 0.5 * (1.0 + a * x[i]));
          sum = sum + a * x[i];
        }
        N[k] = k < n_corners ? product * sum : product;
      }
      break;
    }
    case CellType::wedge6:
    case CellType::wedge15: {
      const std::array<T, 3> L{1.0 - x[0] - x[1], x[0], x[1]};
      const T t = x[2];
      for (int k = 0; k < 6; ++k) {
        const T linear = L[k % 3] * 0.5 * (1.0 + node(k, 2) * t);
        N[k] = type == CellType::wedge6
                   ? linear
                   : linear * (2.0 * L[k % 3] - 1.0) - 0.5 * L[k % 3] * (1.0 - t) * (1.0 + t);
      }
      if (type == CellType::wedge15) {
        for (int e = 0; e < 6; ++e)
          N[6 + e] = 2.0 * L[shape.edges[e][0] % 3] * L[shape.edges[e][1] % 3] * (1.0 + node(6 + e, 2) * t);
        for (int e = 0; e < 3; ++e) N[12 + e] = L[e] * (1.0 - t) * (1.0 + t);
      }
      break;
    }
    case CellType::pyramid5:
    case CellType::pyramid13: {
      const T r = x[0], s = x[1], t = x[2];
      const T rest = 1.0 - t;
      for (int k = 0; k < 4; ++k) {
        const double a = node(k, 0), b = node(k, 1);
        N[k] = 0.25 * ((1.0 + a * r) * (1.0 + b * s) - t + (a * b) * (r * s * t / rest));
        if (type == CellType::pyramid13) N[k] = N[k] * (a * r + b * s - 1.0);
      }
      N[4] = type == CellType::pyramid5 ? t : t * (2.0 * t - 1.0);
      if (type == CellType::pyramid13) {
        for (int k = 5; k < 9; ++k) {  // base edges: along r where the node's s is +-1
          const bool along_r = node(k, 0) == 0;
          const T u = along_r ? r : s, v = along_r ? s : r;
          const double side = along_r ? node(k, 1) : node(k, 0);
          N[k] = 0.5 * (rest + u) * (rest - u) * (rest + side * v) / rest;
        }
        for (int k = 9; k < 13; ++k) {
          const double a = node(k - 9, 0), b = node(k - 9, 1);
          N[k] = t * (rest + a * r) * (rest + b * s) / rest;
        }
      }
      break;
    }
  }
  return N;
}

/// One table for each cell type, filled on first use (thread-safe static in the caller).
template <class T, class Build>
const T& table(CellType type, Build build) {
  static const std::vector<T> all = [&] {
    std::vector<T> rows;
    for (int k = 0; k <= static_cast<int>(CellType::line3); ++k)
      rows.push_back(build(static_cast<CellType>(k)));
    return rows;
  }();
  return all.at(static_cast<std::size_t>(type));
}

}  // namespace

const CellShape& shape_of(CellType type) {
  return table<CellShape>(type, build_shape);
}

const Points& reference_nodes(CellType type) {
  return table<Points>(type, build_reference_nodes);
}

ShapeValues evaluate_shape(CellType type, const Eigen::Vector3d& point) {
  Eigen::Vector3d p = point;
  if (corners_of(type) == 5) p.z() = std::min(p.z(), 1 - 1e-9);
  const std::vector<Dual> N = shape_functions<Dual>(
      type, {Dual::variable(p.x(), 0), Dual::variable(p.y(), 1), Dual::variable(p.z(), 2)});
  ShapeValues values{Eigen::VectorXd(N.size()), Points(N.size(), 3)};
  for (std::size_t k = 0; k < N.size(); ++k) {
    values.N[k] = N[k].value;
    values.dN.row(k) = N[k].gradient.transpose();
  }
  return values;
}

}  // namespace flexura::mesh
