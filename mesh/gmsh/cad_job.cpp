// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/cad_job.hpp"

#include <unistd.h>

#include <algorithm>
#include <stdexcept>

namespace flexura::mesh {

namespace fs = std::filesystem;

namespace {

Eigen::Matrix<double, 2, 3> box_of(const std::array<double, 6>& a) {
  Eigen::Matrix<double, 2, 3> box;
  box << a[0], a[1], a[2], a[3], a[4], a[5];
  return box;
}

}  // namespace

Job first_job(const CadOptions& options, const CadFile& file, CadReport& report) {
  Job job;
  job.path = fs::absolute(options.path).string();
  job.format = file.format;
  job.solids = options.solids;
  job.fuse = options.fuse;
  job.heal = options.heal;
  job.order = options.order;
  job.elements_per_circle = options.elements_per_circle;
  job.parent = getpid();
  report.unit = file.unit.empty() ? "mm" : file.unit;
  if (file.format == "brep" || file.format == "stl") {  // no unit in the file: numbers come as they are
    report.unit = options.unit.empty() ? "mm" : options.unit;
    job.to_m = metres_in(report.unit);
    if (options.unit.empty())
      report.messages.push_back((file.format == "stl" ? "STL" : "BREP") +
                                std::string(" files have no unit; its numbers are taken as mm"));
  } else if (!options.unit.empty()) {  // OpenCASCADE converts from the declared unit to mm; undo that
    if (file.unit.empty())
      throw std::invalid_argument(options.path.string() +
                                  ": the unit of length in the file cannot be read, so it "
                                  "cannot be replaced by " +
                                  options.unit);
    job.to_m = 1e-3 * metres_in(options.unit) / metres_in(file.unit);
    if (options.unit != file.unit)
      report.messages.push_back("the file says " + file.unit + "; its numbers are taken as " + options.unit);
    report.unit = options.unit;
  }
  return job;
}

Eigen::Vector3d vector_of(const std::array<double, 3>& a) {
  return {a[0], a[1], a[2]};
}

void fill_report(const ResultRecord& record, CadReport& report) {
  report.solids.clear();
  report.faces.clear();
  for (const SolidRecord& from : record.solids) {
    CadSolid solid;
    solid.number = from.number;
    solid.name = from.name;
    solid.volume = from.volume;
    solid.centroid = vector_of(from.centroid);
    solid.inertia = Eigen::Map<const Eigen::Matrix3d>(from.inertia.data());
    solid.box = box_of(from.box);
    solid.same_as = from.same_as;
    report.solids.push_back(solid);
  }
  for (const FaceRecord& from : record.faces) {
    Face face;
    face.number = from.number;
    face.solid = from.solid;
    face.name = from.name;
    face.kind = static_cast<FaceKind>(from.kind);
    face.area = from.area;
    face.centroid = vector_of(from.centroid);
    face.box = box_of(from.box);
    face.normal = vector_of(from.normal);
    face.axis_point = vector_of(from.axis_point);
    face.axis = vector_of(from.axis);
    face.radius = from.radius;
    face.length = from.length;
    face.sweep = from.sweep;
    face.hole = from.hole;
    report.faces.push_back(face);
  }
  report.area = record.area;
}

double listing_limit_s(const fs::path& file) {
  std::error_code unknown;
  const auto bytes = static_cast<double>(fs::file_size(file, unknown));
  return 20.0 + (unknown ? 0.0 : 1e-4 * bytes);
}

void add_named_sets(const std::vector<Face>& faces, Mesh& mesh) {
  for (const Face& face : faces) {
    if (face.name.empty()) continue;
    NodeSet& set = mesh.sets[face.name];
    std::size_t k = 0;
    for (const CellBlock& surface : mesh.boundary) {
      std::vector<Index> rows;
      for (Index cell = 0; cell < surface.nodes.rows(); ++cell, ++k)
        if (mesh.boundary_face[k] == face.number) rows.push_back(cell);
      if (rows.empty()) continue;
      CellBlock own;
      own.type = surface.type;
      own.nodes = surface.nodes(rows, Eigen::all);
      set.nodes.insert(set.nodes.end(), own.nodes.data(), own.nodes.data() + own.nodes.size());
      set.faces.push_back(std::move(own));
    }
    std::sort(set.nodes.begin(), set.nodes.end());
    set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
  }
}

}  // namespace flexura::mesh
