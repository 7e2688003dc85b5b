// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "mesh/model/select.hpp"

// What the rules of select.cpp share; for its .cpp files only.
namespace flexura::mesh::selecting {

inline constexpr double kAngle = 0.5 * std::numbers::pi / 180;  // between stated and found directions
inline constexpr double kRelative = 0.005;                      // default tolerance on radii

struct Context {
  const Mesh& mesh;
  const std::vector<Face>& faces;
  double diagonal;
  bool cad() const { return !faces.empty() && !mesh.boundary_face.empty(); }
};

/// "12.5 mm".
std::string mm(double length);

/// The unit vector; std::invalid_argument, naming `what`, for zero.
Eigen::Vector3d unit(const Eigen::Vector3d& v, const char* what);

double distance_to_axis(const Eigen::Vector3d& p, const Eigen::Vector3d& point, const Eigen::Vector3d& axis);

/// Boundary cells that `chosen` says yes to, as blocks; k counts through all blocks.
std::vector<CellBlock> pick_cells(
    const Mesh& mesh, const std::function<bool(const CellBlock&, Index cell, std::size_t k)>& chosen);

/// The cells with their nodes.
NodeSet set_of(std::vector<CellBlock> cells);

/// Area and reference point: the area's centroid, without area the mean of the nodes.
void measure(const Mesh& mesh, Selection& selection);

void put_on_axis(Selection& selection, const Eigen::Vector3d& point, const Eigen::Vector3d& axis);

Selection select_faces(const Context& c, std::vector<const Face*> faces);

/// Faces by increasing misfit, as candidates for a message.
std::string nearest(const std::vector<Face>& faces, FaceKind kind,
                    const std::function<double(const Face&)>& misfit);

Selection select(const Context& c, const CylinderRule& rule);

/// Free edges of shells in a plane, or about an axis at the radius: the rim of a sheet, the edge of its hole.  None: nothing.
std::optional<Selection> select_edges(const Context& c, const Rule& rule);

}  // namespace flexura::mesh::selecting
