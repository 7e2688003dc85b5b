// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/list_faces.hpp"

#include <fmt/format.h>

#include <algorithm>
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

/// An interface table for the largest bore, else the largest plane: something to copy and change.
void print_example(const std::vector<mesh::Face>& faces, std::ostream& out) {
  const auto rank = [](const mesh::Face& f) {
    return f.area * (f.kind == mesh::FaceKind::cylinder ? 1e3 : f.kind == mesh::FaceKind::plane ? 1.0 : 1e-3);
  };
  const auto best = std::max_element(faces.begin(), faces.end(),
                                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  if (best == faces.end()) return;
  out << "\nIn the part file, for example:\n\n";
  if (best->kind == mesh::FaceKind::cylinder) {
    const Eigen::Vector3d p = best->axis_point * 1e3, a = best->axis;
    out << fmt::format(
        "[interface.bore]\nby = \"cylinder\"\npoint = [\"{:.6g} mm\", \"{:.6g} mm\", \"{:.6g} mm\"]\n"
        "axis = [{:.6g}, {:.6g}, {:.6g}]\nradius = \"{:.6g} mm\"\n",
        p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), best->radius * 1e3);
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
