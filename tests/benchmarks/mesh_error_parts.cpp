// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/benchmarks/mesh_error_parts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "mesh/model/geometry.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/library/mesh_sizes.hpp"
#include "reduce/part/make_part.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Vector3d;
using mesh::CellType;

// --- bricks in rows, finer towards the planes between them ---------------------------------------------------------

/// Lengths of the pieces along one axis, how many cells each has, and which of the planes at their ends hold re-entrant edges.
struct Row {
  std::vector<double> lengths;
  std::vector<int> cells;
  std::vector<int> sharp = {};  ///< from 0
};

/// Where the place t, counted in cells, lies in a row; graded, each half of a piece is finer towards its end like
/// (k / n)^grading (I. Babuska, R. B. Kellogg, J. Pitkaranta, Numer. Math. 33 (1979) 447): 3 at re-entrant edges, around which
/// energies converge like h^1.09 on even cells, 1.5 at the others, where averaging ties leave corners of stress that jumps (h^2).
double place_in(const Row& row, double t, bool graded) {
  double at = 0.0;
  for (std::size_t k = 0; k < row.lengths.size(); ++k) {
    const double n = row.cells[k];
    if (t > n && k + 1 < row.lengths.size()) {
      t -= n;
      at += row.lengths[k];
      continue;
    }
    const auto grading = [&](std::size_t plane) {
      const bool sharp =
          std::find(row.sharp.begin(), row.sharp.end(), static_cast<int>(plane)) != row.sharp.end();
      return !graded ? 1.0 : sharp ? 3.0 : 1.5;
    };
    const double s = t / n;
    const double g = s < 0.5 ? 0.5 * std::pow(2.0 * s, grading(k))
                             : 1.0 - 0.5 * std::pow(std::max(0.0, 2.0 * (1.0 - s)), grading(k + 1));
    return at + row.lengths[k] * g;
  }
  return at;
}

mesh::Mesh bricks(const std::array<Row, 3>& rows, CellType type, bool graded) {
  std::array<int, 3> n{};
  for (std::size_t d = 0; d < 3; ++d)
    for (const int cells : rows[d].cells) n[d] += cells;
  mesh::Mesh mesh = testing::box({double(n[0]), double(n[1]), double(n[2])}, n, type);
  testing::deform(
      mesh,
      [&](const Vector3d& x) {
        return Vector3d(place_in(rows[0], x(0), graded), place_in(rows[1], x(1), graded),
                        place_in(rows[2], x(2), graded));
      },
      true);
  return mesh;
}

/// The cells of a mesh whose centre is inside.
mesh::Mesh carved(mesh::Mesh mesh, const std::function<bool(const Vector3d&)>& inside) {
  for (mesh::CellBlock& block : mesh.solids) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell) {
      Vector3d centre = Vector3d::Zero();
      const int corners = mesh::shape_of(block.type).corners;
      for (int a = 0; a < corners; ++a) centre += mesh.points.row(block.nodes(cell, a)).transpose() / corners;
      if (inside(centre)) kept.push_back(cell);
    }
    block.nodes = block.nodes(kept, Eigen::all).eval();
  }
  mesh.boundary.clear();
  mesh::drop_unused_nodes(mesh);
  mesh::extract_boundary(mesh);
  return mesh;
}

/// Interfaces "left" and "right" on two planes x . normal = at.
Part part_of(mesh::Mesh mesh, const Vector3d& left, double left_at, const Vector3d& right, double right_at,
             Tie tie = Tie::average) {
  Part part;
  part.mesh = std::move(mesh);
  part.materials = {testing::steel()};
  const double size = part.mesh.points.cwiseAbs().maxCoeff();
  const auto put = [&](const std::string& name, const Vector3d& normal, double at) {
    InterfaceSpec spec{name, tie, Vector3d::Zero(), testing::nodes_where(part.mesh, [&](const Vector3d& x) {
                         return std::abs(x.dot(normal) - at) < 1e-9 * size;
                       })};
    spec.point = mesh::measure_surface(part.mesh, spec.set.faces).centroid;
    part.interfaces.push_back(spec);
  };
  put("left", left, left_at);
  put("right", right, right_at);
  return part;
}

const Vector3d kX(1, 0, 0), kY(0, 1, 0);

/// A part of bricks by how many cells its rows have.
using Made = std::function<Part(std::vector<int>, CellType, bool)>;

Part whole_box(const Vector3d& size, const std::vector<int>& n, CellType type, bool graded) {
  mesh::Mesh mesh =
      bricks({Row{{size(0)}, {n[0]}}, Row{{size(1)}, {n[1]}}, Row{{size(2)}, {n[2]}}}, type, graded);
  return part_of(carved(std::move(mesh), [](const Vector3d&) { return true; }), kX, 0.0, kX, size(0));
}

Part block(const std::vector<int>& n, CellType type, bool graded) {
  return whole_box({1.0, 0.23, 0.17}, n, type, graded);
}

Part plate(const std::vector<int>& n, CellType type, bool graded) {
  return whole_box({0.3, 0.2, 0.004}, n, type, graded);
}

/// 0.4 x 0.12 x 0.12 m with a step to half of it in both directions, sharp inside.
Part stepped(const std::vector<int>& n, CellType type, bool graded) {
  mesh::Mesh mesh = bricks({Row{{0.2, 0.2}, {n[0], n[0]}, {1}}, Row{{0.06, 0.06}, {n[1], n[1]}, {1}},
                            Row{{0.06, 0.06}, {n[1], n[1]}, {1}}},
                           type, graded);
  return part_of(
      carved(std::move(mesh), [](const Vector3d& x) { return x(0) < 0.2 || (x(1) < 0.06 && x(2) < 0.06); }),
      kX, 0.0, kX, 0.4);
}

/// An angle: legs of 0.3 m, 0.05 x 0.05 m.
Part angle(const std::vector<int>& n, CellType type, bool graded, Tie tie) {
  mesh::Mesh mesh = bricks(
      {Row{{0.05, 0.25}, {n[0], n[1]}, {1}}, Row{{0.05, 0.25}, {n[0], n[1]}, {1}}, Row{{0.05}, {n[0]}}}, type,
      graded);
  return part_of(carved(std::move(mesh), [](const Vector3d& x) { return x(0) < 0.05 || x(1) < 0.05; }), kX,
                 0.3, kY, 0.3, tie);
}

/// A round shaft with a sharp shoulder, by the map of a square on a disc: 0.4 m, radii 0.05 and 0.025 m.
Part shaft(const std::vector<int>& n, CellType type, bool graded) {
  mesh::Mesh mesh =
      bricks({Row{{0.2, 0.2}, {n[0], n[0]}, {1}}, Row{{0.5, 1.0, 0.5}, {n[1], 2 * n[1], n[1]}, {1, 2}},
              Row{{0.5, 1.0, 0.5}, {n[1], 2 * n[1], n[1]}, {1, 2}}},
             type, graded);
  mesh = carved(std::move(mesh), [](const Vector3d& x) {
    return x(0) < 0.2 || (std::abs(x(1) - 1.0) < 0.5 && std::abs(x(2) - 1.0) < 0.5);
  });
  testing::deform(mesh, [](const Vector3d& x) {
    const double y = x(1) - 1.0, z = x(2) - 1.0;
    const double greatest = std::max(std::abs(y), std::abs(z)), length = std::hypot(y, z);
    const double f = length > 0.0 ? 0.05 * greatest / length : 0.0;
    return Vector3d(x(0), f * y, f * z);
  });
  return part_of(std::move(mesh), kX, 0.0, kX, 0.4);
}

/// A frame like a U: 0.3 x 0.2 x 0.04 m, 0.05 m wide.
Part fork(const std::vector<int>& n, CellType type, bool graded) {
  mesh::Mesh mesh = bricks({Row{{0.05, 0.25}, {n[0], n[1]}, {1}},
                            Row{{0.05, 0.1, 0.05}, {n[0], n[2], n[0]}, {1, 2}}, Row{{0.04}, {n[0]}}},
                           type, graded);
  return part_of(
      carved(std::move(mesh), [](const Vector3d& x) { return x(0) < 0.05 || x(1) < 0.05 || x(1) > 0.15; }),
      kX, 0.3, kX, 0.0);
}

/// A bar of 0.4 x 0.04 x 0.02 m, twisted by a quarter turn.
Part twisted(const std::vector<int>& n, CellType type, bool graded) {
  Part part = whole_box({0.4, 0.04, 0.02}, n, type, graded);
  testing::deform(part.mesh, [](const Vector3d& x) {
    const double angle = std::numbers::pi / 2 * x(0) / 0.4, y = x(1) - 0.02, z = x(2) - 0.01;
    return Vector3d(x(0), y * std::cos(angle) - z * std::sin(angle),
                    y * std::sin(angle) + z * std::cos(angle));
  });
  return part_of(std::move(part.mesh), kX, 0.0, kX, 0.4);
}

/// A square tube of 0.3 x 0.1 x 0.1 m with walls of 0.02 m.
Part tube(const std::vector<int>& n, CellType type, bool graded) {
  const Row across{{0.02, 0.06, 0.02}, {n[1], n[2], n[1]}, {1, 2}};
  mesh::Mesh mesh = bricks({Row{{0.3}, {n[0]}}, across, across}, type, graded);
  return part_of(
      carved(std::move(mesh),
             [](const Vector3d& x) { return x(1) < 0.02 || x(1) > 0.08 || x(2) < 0.02 || x(2) > 0.08; }),
      kX, 0.0, kX, 0.3);
}

/// A plate of 0.24 x 0.16 x 0.006 m with a square hole of 0.06 m, sharp inside.
Part window(const std::vector<int>& n, CellType type, bool graded) {
  mesh::Mesh mesh = bricks({Row{{0.09, 0.06, 0.09}, {n[0], n[1], n[0]}, {1, 2}},
                            Row{{0.05, 0.06, 0.05}, {n[1], n[1], n[1]}, {1, 2}}, Row{{0.006}, {n[2]}}},
                           type, graded);
  return part_of(
      carved(std::move(mesh),
             [](const Vector3d& x) { return std::abs(x(0) - 0.12) > 0.03 || std::abs(x(1) - 0.08) > 0.03; }),
      kX, 0.0, kX, 0.24);
}

/// A quarter of a ring: mean radius 0.17 m, 0.04 m by 0.03 m.
Part arch(const std::vector<int>& n, CellType type, bool graded) {
  Part part = whole_box({0.3, 0.04, 0.03}, n, type, graded);
  testing::deform(part.mesh, [](const Vector3d& x) {
    const double angle = std::numbers::pi / 2 * x(0) / 0.3, r = 0.15 + x(1);
    return Vector3d(r * std::sin(angle), r * std::cos(angle), x(2));
  });
  return part_of(std::move(part.mesh), kX, 0.0, kY, 0.0);
}

/// A bar of 0.3 m that tapers from 0.06 x 0.04 m to two fifths of it.
Part taper(const std::vector<int>& n, CellType type, bool graded) {
  Part part = whole_box({0.3, 0.06, 0.04}, n, type, graded);
  testing::deform(part.mesh, [](const Vector3d& x) {
    const double f = 1.0 - 0.6 * x(0) / 0.3;
    return Vector3d(x(0), f * (x(1) - 0.03), f * (x(2) - 0.02));
  });
  return part_of(std::move(part.mesh), kX, 0.0, kX, 0.3);
}

/// A beam of T section: 0.3 m, flange 0.1 x 0.02 m, web 0.02 x 0.06 m.
Part tee(const std::vector<int>& n, CellType type, bool graded) {
  mesh::Mesh mesh = bricks({Row{{0.3}, {n[0]}}, Row{{0.04, 0.02, 0.04}, {n[1], n[2], n[1]}, {1, 2}},
                            Row{{0.02, 0.06}, {n[2], n[1]}, {1}}},
                           type, graded);
  return part_of(
      carved(std::move(mesh), [](const Vector3d& x) { return x(2) < 0.02 || std::abs(x(1) - 0.05) < 0.01; }),
      kX, 0.0, kX, 0.3);
}

/// A crank like a Z: arms of 0.16 m, 0.08 m apart, 0.04 x 0.03 m.
Part zed(const std::vector<int>& n, CellType type, bool graded) {
  mesh::Mesh mesh = bricks({Row{{0.12, 0.04, 0.12}, {n[1], n[0], n[1]}, {1, 2}},
                            Row{{0.04, 0.08, 0.04}, {n[0], n[1], n[0]}, {1, 2}}, Row{{0.03}, {n[0]}}},
                           type, graded);
  return part_of(carved(std::move(mesh),
                        [](const Vector3d& x) {
                          const bool low = x(1) < 0.04 && x(0)<0.16, high = x(1)> 0.12 && x(0) > 0.12;
                          return low || high || std::abs(x(0) - 0.14) < 0.02;
                        }),
                 kX, 0.0, kX, 0.28);
}

Sequence graded(const std::string& kind, const Made& make, const std::vector<double>& cells,
                const std::vector<int>& levels = {4, 6, 9}) {
  // Graded by 3 energies along re-entrant edges converge like h^3.3; what a row's middle leaves is left to doubt.
  Sequence out{kind, static_cast<double>(levels[2]) / levels[1], 2.0, {}};
  for (const int level : levels)
    out.meshes.push_back([=] {
      std::vector<int> n;
      for (const double c : cells) n.push_back(static_cast<int>(std::lround(c * level)));
      return make(n, CellType::hex20, true);
    });
  return out;
}

// --- CAD parts --------------------------------------------------------------------------------------------------

Part meshed(PartInput input) {
  input.cad.worker = std::filesystem::path(FLEXURA_BIN_DIR) / "flexura-mesh";
  return make_part(input, load_part_mesh(input, {})).part;
}

Part cad(const std::string& file, double size, int order) {
  PartInput input = read_part(file);
  input.cad.size = size;
  input.cad.order = order;
  input.cad.elements_per_circle = 12;
  input.cad.size_min = size / 3;
  return meshed(input);
}

/// Ten-node tetrahedra of a size, along edges of unbounded stress a tenth of it, all times `scale`.
Part graded_cad(const std::string& file, double size, double scale) {
  constexpr double kAtEdges = 0.1;
  const Part part = cad(file, size, 2);
  const std::vector<char> sharp = nodes_at_sharp_edges(part);
  Eigen::VectorXd factor = Eigen::VectorXd::Ones(part.mesh.n_solid_cells());
  Eigen::Index cell = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row, ++cell)
      for (int a = 0; a < mesh::shape_of(block.type).corners; ++a)
        if (sharp[static_cast<std::size_t>(block.nodes(row, a))]) factor(cell) = kAtEdges;
  PartInput input = read_part(file);
  input.cad.sizes = size_points(part.mesh, factor, sharp);
  for (std::size_t k = 3; k < input.cad.sizes.size(); k += 4) input.cad.sizes[k] *= scale;
  input.cad.elements_per_circle = 12.0 / scale;
  return meshed(input);
}

Sequence graded_cad_sequence(const std::string& kind, const std::string& file, double size) {
  Sequence out{kind, 1.4, 1.09, {}};  // the tenth along the edges stays: there energies converge like h^1.09
  for (const double scale : {1.4, 1.0, 1.0 / 1.4})
    out.meshes.push_back([=] { return graded_cad(file, size, scale); });
  return out;
}

}  // namespace

Part crank_arm(double size) {
  return cad(std::string(FLEXURA_SOURCE_DIR) + "/tests/found/user/crank_arm.toml", size, 2);
}

std::vector<Subject> subjects() {
  std::vector<Subject> out;
  bool held_out = false;
  const auto add = [&](const std::string& name, const Made& make, const std::vector<int>& cells,
                       CellType type, const Sequence& fine) {
    out.push_back({name, [=] { return make(cells, type, false); }, fine, held_out});
  };
  const Made angle_average = [](const std::vector<int>&n, CellType type,
                                bool graded) { return angle(n, type, graded, Tie::average); },
             angle_rigid = [](const std::vector<int>&n, CellType type, bool graded) {
               return angle(n, type, graded, Tie::rigid);
             };
  const Sequence fine_block = graded("block", block, {3, 1, 1}),
                 fine_plate = graded("plate", plate, {4, 3, 0.5}),
                 fine_stepped = graded("stepped", stepped, {1, 1}),
                 fine_angle = graded("angle", angle_average, {1, 1}),
                 fine_rigid = graded("angle rigid", angle_rigid, {1, 1}),
                 fine_shaft = graded("shaft", shaft, {4, 1}, {1, 2, 4}),
                 fine_fork = graded("fork", fork, {1, 1, 1}),
                 fine_twisted = graded("twisted", twisted, {2, 1, 1}),
                 fine_tube = graded("tube", tube, {1, 1, 1}),
                 fine_window = graded("window", window, {1, 1, 0.5}),
                 fine_arch = graded("arch", arch, {2, 1, 1}), fine_taper = graded("taper", taper, {2, 1, 1}),
                 fine_tee = graded("tee", tee, {1.5, 1, 0.75}), fine_zed = graded("zed", zed, {1, 1.5});
  add("block tet10 6x2x2", block, {6, 2, 2}, CellType::tet10, fine_block);
  add("block tet10 4x1x1", block, {4, 1, 1}, CellType::tet10, fine_block);
  add("block hex20 8x2x2", block, {8, 2, 2}, CellType::hex20, fine_block);
  add("block hex20 4x1x1", block, {4, 1, 1}, CellType::hex20, fine_block);
  add("block wedge15 5x1x1", block, {5, 1, 1}, CellType::wedge15, fine_block);
  add("block wedge15 10x2x2", block, {10, 2, 2}, CellType::wedge15, fine_block);
  add("block hex8 16x4x4", block, {16, 4, 4}, CellType::hex8, fine_block);
  add("block hex8 8x2x2", block, {8, 2, 2}, CellType::hex8, fine_block);
  add("block tet4 24x6x4", block, {24, 6, 4}, CellType::tet4, fine_block);
  add("block wedge6 16x4x4", block, {16, 4, 4}, CellType::wedge6, fine_block);
  add("plate hex20 6x4x1", plate, {6, 4, 1}, CellType::hex20, fine_plate);
  add("plate tet10 12x8x1", plate, {12, 8, 1}, CellType::tet10, fine_plate);
  add("plate hex8 60x40x2", plate, {60, 40, 2}, CellType::hex8, fine_plate);
  add("stepped block tet10", stepped, {4, 2}, CellType::tet10, fine_stepped);
  add("stepped block hex20", stepped, {2, 1}, CellType::hex20, fine_stepped);
  add("stepped block hex8", stepped, {8, 4}, CellType::hex8, fine_stepped);
  add("angle tet10 1 across", angle_average, {1, 5}, CellType::tet10, fine_angle);
  add("angle hex20 2 across", angle_average, {2, 10}, CellType::hex20, fine_angle);
  add("angle tet4 3 across", angle_average, {3, 15}, CellType::tet4, fine_angle);
  add("angle, rigid ends tet10", angle_rigid, {1, 5}, CellType::tet10, fine_rigid);
  add("shouldered shaft hex20", shaft, {4, 1}, CellType::hex20, fine_shaft);
  const std::string root = FLEXURA_SOURCE_DIR;
  const auto add_cad = [&](const std::string& name, const std::string& file, double size, double fine,
                           int order = 2) {
    const std::string path = root + "/" + file;
    out.push_back(
        {name, [=] { return cad(path, size, order); }, graded_cad_sequence(file, path, fine), held_out});
  };
  add_cad("rod", "tests/found/user/rod.toml", 0.012, 0.010);
  add_cad("crank arm", "tests/found/user/crank_arm.toml", 0.01, 0.008);
  add_cad("bracket", "tests/found/user/bracket.toml", 0.02, 0.010);
  held_out = true;
  add("fork tet10", fork, {1, 5, 2}, CellType::tet10, fine_fork);
  add("fork hex20", fork, {1, 5, 2}, CellType::hex20, fine_fork);
  add("twisted bar tet10", twisted, {6, 2, 1}, CellType::tet10, fine_twisted);
  add("twisted bar hex8", twisted, {18, 6, 3}, CellType::hex8, fine_twisted);
  add("square tube tet10", tube, {3, 1, 3}, CellType::tet10, fine_tube);
  add("square tube wedge15", tube, {3, 1, 3}, CellType::wedge15, fine_tube);
  add("plate with a square hole tet10", window, {3, 2, 1}, CellType::tet10, fine_window);
  add("plate with a square hole hex20", window, {3, 2, 1}, CellType::hex20, fine_window);
  add("quarter ring tet10", arch, {5, 1, 1}, CellType::tet10, fine_arch);
  add("quarter ring hex8", arch, {16, 4, 3}, CellType::hex8, fine_arch);
  add("tapered bar tet10", taper, {5, 1, 1}, CellType::tet10, fine_taper);
  add("tapered bar wedge15", taper, {6, 1, 1}, CellType::wedge15, fine_taper);
  add("T beam tet10", tee, {6, 2, 1}, CellType::tet10, fine_tee);
  add("T beam hex20", tee, {5, 1, 1}, CellType::hex20, fine_tee);
  add("Z crank tet10", zed, {1, 3}, CellType::tet10, fine_zed);
  add("Z crank tet4", zed, {3, 9}, CellType::tet4, fine_zed);
  add_cad("shaft with shoulders, held at its seats", "tests/found/reduce/shaft_seats.toml", 0.02, 0.010);
  add_cad("shaft with shoulders, mean of its ends", "tests/found/reduce/av.toml", 0.02, 0.010);
  add_cad("connecting rod", "cases/steam_engine/conrod.toml", 0.015, 0.012);
  add_cad("connecting rod tet4", "cases/steam_engine/conrod.toml", 0.009, 0.012, 1);
  add_cad("angle bracket with three interfaces", "docs/tutorials/bracket/bracket.toml", 0.012, 0.010);
  add_cad("motor shaft", "cases/cad_parts/shaft.toml", 0.003, 0.002);
  return out;
}

}  // namespace flexura::reduce
