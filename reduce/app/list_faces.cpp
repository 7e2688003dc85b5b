// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/list_faces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <ostream>

#include "mbs/base/files/inputs.hpp"
#include "mesh/gmsh/sheet.hpp"
#include "reduce/file/part_file.hpp"

namespace flexura::reduce {

namespace {

mesh::CadReport faces_of(const std::filesystem::path& file) {
  if (file.extension() != ".toml") return mesh::list_faces({.path = file});
  const PartInput part = read_part(file);
  return part.sheet_thickness > 0.0 ? mesh::list_sheet(part.cad) : mesh::list_faces(part.cad);
}

bool is_whole(const mesh::Face& face) {
  return face.sweep > 1.5 * std::numbers::pi;
}

bool is_bore(const mesh::Face& face) {
  return face.kind == mesh::FaceKind::cylinder && face.hole && is_whole(face);
}

/// An interface table for the largest bore, else the largest shaft, else the largest plane: something to copy and change.
void print_example(const std::vector<mesh::Face>& faces, std::ostream& out) {
  const auto rank = [](const mesh::Face& f) {
    // A bore is what pins go through; then shafts, then planes.
    return f.area * (is_bore(f)                                          ? 1e6
                     : f.kind == mesh::FaceKind::cylinder && is_whole(f) ? 1e3
                     : f.kind == mesh::FaceKind::plane                   ? 1.0
                                                                         : 1e-3);
  };
  const auto best = std::max_element(faces.begin(), faces.end(),
                                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  if (best == faces.end()) return;
  out << "\nIn the part file, for example:\n\n";
  if (best->kind == mesh::FaceKind::cylinder && is_whole(*best)) {
    // Coordinates that are round-off of the file's are zero.
    double size = 0.0;
    for (const mesh::Face& face : faces) size = std::max(size, face.box.cwiseAbs().maxCoeff());
    const auto rounded = [](Eigen::Vector3d v, double scale) -> Eigen::Vector3d {
      return (v.array().abs() < 1e-9 * scale).select(0.0, v);
    };
    const Eigen::Vector3d p = rounded(best->axis_point, size) * 1e3, a = rounded(best->axis, 1.0);
    out << fmt::format(
        "[interface.{}]\nby = \"cylinder\"\npoint = [\"{:.6g} mm\", \"{:.6g} mm\", \"{:.6g} mm\"]\n"
        "axis = [{:.6g}, {:.6g}, {:.6g}]\nradius = \"{:.6g} mm\"\n",
        is_bore(*best) ? "bore" : "shaft", p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), best->radius * 1e3);
  } else {
    out << fmt::format("[interface.face]\nby = \"faces\"\nfaces = [{}]\n", best->number);
  }
}

}  // namespace

void print_faces(const std::filesystem::path& file, std::ostream& out) {
  files::note_input(file);
  const mesh::CadReport report = faces_of(file);
  for (const std::string& message : report.messages) out << message << '\n';
  out << fmt::format("{}: {} solid{}, lengths in {}\n", file.filename().string(), report.solids.size(),
                     report.solids.size() == 1 ? "" : "s", report.unit);
  for (const mesh::CadSolid& s : report.solids) {
    out << fmt::format("  solid {}{}: volume {:.6g} mm^3, centre {}{}\n", s.number,
                       s.name.empty() ? "" : " \"" + s.name + '"', s.volume * 1e9,
                       mesh::describe_point_mm(s.centroid),
                       s.same_as > 0 ? fmt::format(", the same as solid {}", s.same_as) : "");
  }
  out << fmt::format("{} faces\n", report.faces.size());
  int solid = 0;
  for (const mesh::Face& face : report.faces) {
    if (report.solids.size() > 1 && face.solid != solid) {
      solid = face.solid;
      out << fmt::format(" of solid {}\n", solid);
    }
    out << "  " << mesh::describe(face) << '\n';
  }
  print_example(report.faces, out);
}

}  // namespace flexura::reduce
