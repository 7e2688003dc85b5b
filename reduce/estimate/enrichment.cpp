// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enrichment.hpp"

#include <map>

#include "mesh/model/cells/record.hpp"
#include "reduce/estimate/cell_data.hpp"

namespace flexura::reduce {

using mesh::CellType;

namespace {

// A value and its derivatives by the reference coordinates.
struct Field {
  double v = 0.0;
  Eigen::RowVector3d d = Eigen::RowVector3d::Zero();
};
Field operator*(const Field& a, const Field& b) {
  return {a.v * b.v, a.v * b.d + b.v * a.d};
}
Field operator*(double c, const Field& a) {
  return {c * a.v, c * a.d};
}
Field operator+(const Field& a, const Field& b) {
  return {a.v + b.v, a.d + b.d};
}
Field operator-(const Field& a, const Field& b) {
  return {a.v - b.v, a.d - b.d};
}
Field constant(double c) {
  return {c, Eigen::RowVector3d::Zero()};
}
Field coordinate(const Eigen::Vector3d& x, int a) {
  Field f{x(a), Eigen::RowVector3d::Zero()};
  f.d(a) = 1.0;
  return f;
}
Field bubble(const Field& t) {
  return constant(1.0) - t * t;
}

enum class Family { triangle, quadrilateral, tetrahedron, hexahedron, wedge, none };

Family family_of(CellType type) {
  switch (type) {
    case CellType::tri3:
    case CellType::tri6:
      return Family::triangle;
    case CellType::quad4:
    case CellType::quad8:
      return Family::quadrilateral;
    case CellType::tet4:
    case CellType::tet10:
      return Family::tetrahedron;
    case CellType::hex8:
    case CellType::hex20:
      return Family::hexahedron;
    case CellType::wedge6:
    case CellType::wedge15:
      return Family::wedge;
    default:
      return Family::none;
  }
}

// Local coordinates in which a function is a product: barycentric ones of the triangle (or tetrahedron), straight ones.
struct Coordinates {
  std::array<Field, 4> l;  // of the corners of the simplex
  std::array<Field, 3> x;
};

Coordinates coordinates_at(Family family, const Eigen::Vector3d& point) {
  Coordinates c;
  for (int a = 0; a < 3; ++a) c.x[a] = coordinate(point, a);
  if (family == Family::tetrahedron)
    c.l = {constant(1.0) - c.x[0] - c.x[1] - c.x[2], c.x[0], c.x[1], c.x[2]};
  else
    c.l = {constant(1.0) - c.x[0] - c.x[1], c.x[0], c.x[1], Field{}};
  return c;
}

// (1 + s x) / 2
Field towards(double s, const Field& x) {
  return 0.5 * (constant(1.0) + s * x);
}

Field edge_function(const Field& even, const Field& t, bool cubic) {
  return cubic ? t * even : even;
}

// On the edge of a simplex between corners a and b.
Field simplex_edge(const Coordinates& c, int a, int b, bool cubic) {
  return edge_function(4.0 * (c.l[a] * c.l[b]), c.l[b] - c.l[a], cubic);
}

Field value_of(Family family, bool cubic, const EnrichmentFunction& f, const Coordinates& c, CellType type) {
  const auto& at = mesh::reference_nodes(type);
  const auto& k = f.corners;
  const bool is_edge = k[2] < 0;
  switch (family) {
    case Family::triangle:
    case Family::tetrahedron:
      return is_edge ? simplex_edge(c, k[0], k[1], cubic) : 27.0 * (c.l[k[0]] * c.l[k[1]] * c.l[k[2]]);
    case Family::quadrilateral:
    case Family::hexahedron: {
      const int n = family == Family::hexahedron ? 3 : 2;
      Field out = constant(1.0);
      for (int d = 0; d < n; ++d) {
        bool varies = false;
        for (int j = 1; j < 4 && k[j] >= 0; ++j) varies |= at(k[j], d) != at(k[0], d);
        if (!varies)
          out = out * towards(at(k[0], d), c.x[d]);
        else if (is_edge)
          out = out * edge_function(bubble(c.x[d]), at(k[1], d) * c.x[d], cubic);
        else
          out = out * bubble(c.x[d]);
      }
      return out;
    }
    case Family::wedge: {
      const auto level = [&](int corner) { return towards(at(corner, 2), c.x[2]); };
      if (is_edge) {
        if (k[0] % 3 == k[1] % 3)
          return c.l[k[0] % 3] * edge_function(bubble(c.x[2]), at(k[1], 2) * c.x[2], cubic);
        return simplex_edge(c, k[0] % 3, k[1] % 3, cubic) * level(k[0]);
      }
      if (k[3] < 0) return 27.0 * (c.l[0] * c.l[1] * c.l[2] * level(k[0]));
      // Of a rectangle: the edge of the triangle over which it stands.
      const int a = k[0] % 3, b = k[1] % 3 == a ? k[2] % 3 : k[1] % 3;
      return simplex_edge(c, a, b, false) * bubble(c.x[2]);
    }
    case Family::none:
      break;
  }
  return {};
}

std::vector<EnrichmentFunction> build(CellType type) {
  std::vector<EnrichmentFunction> out;
  if (family_of(type) == Family::none) return out;
  const mesh::CellShape& shape = mesh::shape_of(type);
  const bool quadratic = is_quadratic(type);
  for (const auto& edge : shape.edges) out.push_back({{edge[0], edge[1], -1, -1}, quadratic});
  if (!quadratic) return out;
  if (mesh::dimension_of(type) == 2) {
    std::array<int, 4> all{0, 1, 2, shape.corners == 4 ? 3 : -1};
    out.push_back({all, false});
  }
  for (const mesh::CellFace& face : shape.faces) {
    const bool triangle = face.type == CellType::tri6;
    out.push_back({{face.nodes[0], face.nodes[1], face.nodes[2], triangle ? -1 : face.nodes[3]}, false});
  }
  return out;
}

}  // namespace

const std::vector<EnrichmentFunction>& enrichment_of(CellType type) {
  static const std::map<CellType, std::vector<EnrichmentFunction>> all = [] {
    std::map<CellType, std::vector<EnrichmentFunction>> table;
    for (const mesh::CellRecord& record : mesh::cell_records()) table[record.type] = build(record.type);
    return table;
  }();
  return all.at(type);
}

EnrichmentValues evaluate_enrichment(CellType type, const Eigen::Vector3d& point) {
  const std::vector<EnrichmentFunction>& functions = enrichment_of(type);
  const Family family = family_of(type);
  const Coordinates c = coordinates_at(family, point);
  EnrichmentValues out;
  out.w.resize(static_cast<Eigen::Index>(functions.size()));
  out.dw.resize(static_cast<Eigen::Index>(functions.size()), 3);
  for (std::size_t k = 0; k < functions.size(); ++k) {
    const Field f = value_of(family, is_quadratic(type), functions[k], c, type);
    out.w(static_cast<Eigen::Index>(k)) = f.v;
    out.dw.row(static_cast<Eigen::Index>(k)) = f.d;
  }
  return out;
}

}  // namespace flexura::reduce
