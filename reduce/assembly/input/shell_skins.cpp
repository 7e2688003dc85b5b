// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/input/shell_skins.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "mesh/model/geometry.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/elements/shell.hpp"
#include "reduce/elements/shell_section.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

// The cells around a node whose normals lie within 60 degrees of the first's, either way.
struct Sheet {
  Vector3d first = Vector3d::Zero(), normal = Vector3d::Zero();
  double area = 0.0, thickness = 0.0, offset = 0.0;  // thickness and offset: times area
  double mass = 0.0, moment = 0.0, rotary = 0.0;     // mass: of cells with an offset
  double alpha = 0.0;                                // times area
  mesh::Index upper = -1, lower = -1;
};

struct Corner {
  std::size_t sheet;
  bool flipped;  // the cell's normal is against the sheet's
};

}  // namespace

void add_shell_skins(Part& part) {
  mesh::Mesh& mesh = part.mesh;
  if (mesh.shells.empty() || !part.skins.empty()) return;
  std::map<mesh::Index, std::vector<Sheet>> sheets;
  std::vector<std::vector<Corner>> corners(mesh.shells.size());
  for (std::size_t b = 0; b < mesh.shells.size(); ++b) {
    const mesh::CellBlock& block = mesh.shells[b];
    NodePositions x(block.nodes.cols(), 3);
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      for (Index a = 0; a < x.rows(); ++a) x.row(a) = mesh.points.row(block.nodes(cell, a));
      const ShellFrame frame = shell_frame(x);
      const Vector3d normal = frame.R.col(2);
      const double t = block.thickness[cell], offset = block.offset.empty() ? 0.0 : block.offset[cell];
      const Material& material = part.materials.at(block.material.empty() ? 0 : block.material[cell]);
      const ShellMass per_area = shell_mass_per_area(material, t);
      const double share = frame.area / static_cast<double>(x.rows());
      for (Index a = 0; a < x.rows(); ++a) {
        std::vector<Sheet>& around = sheets[block.nodes(cell, a)];
        auto sheet = std::find_if(around.begin(), around.end(),
                                  [&](const Sheet& s) { return std::abs(s.first.dot(normal)) > 0.5; });
        if (sheet == around.end()) {
          around.push_back({.first = normal});
          sheet = around.end() - 1;
        }
        const bool flipped = sheet->first.dot(normal) < 0.0;
        sheet->normal += (flipped ? -share : share) * normal;
        sheet->area += share;
        sheet->thickness += share * t;
        sheet->offset += (flipped ? -share : share) * offset;
        if (offset != 0.0) sheet->mass += share * per_area.mass;
        sheet->moment += (flipped ? -share : share) * per_area.first;
        sheet->rotary += share * per_area.second;
        sheet->alpha += share * material.damping.alpha;
        corners[b].push_back({static_cast<std::size_t>(sheet - around.begin()), flipped});
      }
    }
  }

  std::vector<Vector3d> added;
  const mesh::Index n_before = mesh.n_nodes();
  const auto add_point = [&](mesh::Index node, const Vector3d& arm) {
    const auto point = static_cast<mesh::Index>(n_before + static_cast<mesh::Index>(added.size()));
    added.emplace_back(mesh.points.row(node).transpose() + arm);
    part.followers.push_back({point, {{node, motion_at(arm)}}});
    return point;
  };
  for (auto& [node, around] : sheets)
    for (Sheet& sheet : around) {
      const double t = sheet.thickness / sheet.area, offset = sheet.offset / sheet.area,
                   alpha = sheet.alpha / sheet.area;
      const Vector3d n = sheet.normal.normalized();
      mesh::Index middle = node;
      if (offset != 0.0 || sheet.mass > 0.0) {
        middle = add_point(node, offset * n);
        if (sheet.mass > 0.0) part.masses.push_back({middle, sheet.mass, alpha});
      }
      sheet.upper = add_point(node, (offset + 0.5 * t) * n);
      sheet.lower = add_point(node, (offset - 0.5 * t) * n);
      const double w = sheet.rotary / (0.5 * t * t), more = sheet.moment / t;
      part.masses.push_back({sheet.upper, w + more, alpha});
      part.masses.push_back({sheet.lower, w - more, alpha});
      part.masses.push_back({middle, -2.0 * w, alpha});
    }
  mesh.points.conservativeResize(n_before + static_cast<Index>(added.size()), 3);
  for (std::size_t k = 0; k < added.size(); ++k)
    mesh.points.row(n_before + static_cast<Index>(k)) = added[k].transpose();
  if (!mesh.node_label.empty()) mesh.node_label.resize(static_cast<std::size_t>(mesh.n_nodes()), -1);

  // The boundary of the solids stays; the middle surfaces give way to what is seen of them.
  std::vector<mesh::CellBlock> shells = std::move(mesh.shells);
  mesh.shells.clear();
  mesh::extract_boundary(mesh);
  mesh.shells = std::move(shells);
  std::map<std::pair<mesh::Index, mesh::Index>, int> uses;
  const auto each_edge = [&](const auto& visit) {
    for (std::size_t b = 0; b < mesh.shells.size(); ++b) {
      const auto& nodes = mesh.shells[b].nodes;
      for (Index cell = 0; cell < nodes.rows(); ++cell)
        for (Index a = 0; a < nodes.cols(); ++a)
          visit(b, cell, a, (a + 1) % nodes.cols(),
                std::minmax({nodes(cell, a), nodes(cell, (a + 1) % nodes.cols())}));
    }
  };
  each_edge(
      [&](std::size_t, Index, Index, Index, std::pair<mesh::Index, mesh::Index> edge) { ++uses[edge]; });
  for (std::size_t b = 0; b < mesh.shells.size(); ++b) {
    const mesh::CellBlock& block = mesh.shells[b];
    ShellSkins skins{block.nodes, block.nodes};
    for (Index k = 0; k < block.nodes.size(); ++k) {
      const Corner& corner = corners[b][static_cast<std::size_t>(k)];
      const Sheet& sheet = sheets.at(block.nodes.data()[k])[corner.sheet];
      skins.top.data()[k] = corner.flipped ? sheet.lower : sheet.upper;
      skins.bottom.data()[k] = corner.flipped ? sheet.upper : sheet.lower;
    }
    mesh.boundary.push_back({.type = block.type, .nodes = skins.top});
    mesh.boundary.push_back({.type = block.type, .nodes = skins.bottom.rowwise().reverse()});
    part.skins.push_back(std::move(skins));
  }
  std::vector<std::array<mesh::Index, 4>> walls;
  each_edge([&](std::size_t b, Index cell, Index a, Index c, std::pair<mesh::Index, mesh::Index> edge) {
    const ShellSkins& skins = part.skins[b];
    if (uses.at(edge) == 1)
      walls.push_back({skins.bottom(cell, a), skins.bottom(cell, c), skins.top(cell, c), skins.top(cell, a)});
  });
  mesh::CellBlock wall{.type = mesh::CellType::quad4};
  wall.nodes.resize(static_cast<Index>(walls.size()), 4);
  for (std::size_t k = 0; k < walls.size(); ++k)
    for (int a = 0; a < 4; ++a) wall.nodes(static_cast<Index>(k), a) = walls[k][static_cast<std::size_t>(a)];
  if (!walls.empty()) mesh.boundary.push_back(std::move(wall));
}

}  // namespace flexura::reduce
