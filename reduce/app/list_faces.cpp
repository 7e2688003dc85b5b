// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/list_faces.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <ostream>
#include <stdexcept>

#include "mbs/base/files/inputs.hpp"
#include "mbs/view/parts_page.hpp"
#include "mesh/gmsh/picture.hpp"
#include "mesh/gmsh/sheet.hpp"
#include "mesh/page/numbered_face.hpp"
#include "reduce/app/face_lines.hpp"
#include "reduce/app/list_deck.hpp"
#include "reduce/file/foreign_formats.hpp"
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
  const auto rank = [&](const mesh::Face& f) {
    // A bore is what pins go through; then shafts, then planes.
    return f.area * (is_bore(f) || (f.hole && !others_of(f, faces).empty()) ? 1e6
                     : f.kind == mesh::FaceKind::cylinder && is_whole(f)    ? 1e3
                     : f.kind == mesh::FaceKind::plane                      ? 1.0
                                                                            : 1e-3);
  };
  const auto best = std::max_element(faces.begin(), faces.end(),
                                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  if (best == faces.end()) return;
  out << "\nIn the part file, for example:\n\n";
  const std::vector<mesh::Index> others = others_of(*best, faces);
  if (!others.empty())
    out << fmt::format("# faces {} and {} together\n", best->number, fmt::join(others, ", "));
  if (best->kind == mesh::FaceKind::cylinder && (is_whole(*best) || !others.empty())) {
    // Coordinates that are round-off of the file's are zero.
    double size = 0.0;
    for (const mesh::Face& face : faces) size = std::max(size, face.box.cwiseAbs().maxCoeff());
    const auto rounded = [](Eigen::Vector3d v, double scale) -> Eigen::Vector3d {
      return (v.array().abs() < 1e-9 * scale).select(0.0, v);
    };
    const Eigen::Vector3d p = rounded(best->axis_point, size) * 1e3, a = rounded(best->axis, 1.0);
    // A bore on the same axis, of the same radius, would be taken as well.
    const bool has_twin = std::any_of(faces.begin(), faces.end(), [&](const mesh::Face& f) {
      const Eigen::Vector3d off = f.axis_point - best->axis_point;
      return f.number != best->number && std::ranges::find(others, f.number) == others.end() &&
             f.kind == best->kind && f.solid == best->solid &&
             std::abs(f.radius - best->radius) < 1e-6 * size && f.axis.cross(best->axis).norm() < 1e-6 &&
             off.cross(best->axis).norm() < 1e-6 * size;
    });
    out << fmt::format(
        "[interface.{}]\nby = \"cylinder\"\npoint = [\"{:.6g} mm\", \"{:.6g} mm\", \"{:.6g} mm\"]\n"
        "axis = [{:.6g}, {:.6g}, {:.6g}]\nradius = \"{:.6g} mm\"\n",
        best->hole ? "bore" : "shaft", p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), best->radius * 1e3);
    if (has_twin)
      out << fmt::format(
          "extent = [\"{:.6g} mm\", \"{:.6g} mm\"]  # along the axis from the point: without it all bores of "
          "this "
          "radius on this axis\n",
          -0.5e3 * best->length, 0.5e3 * best->length);
  } else {
    out << "[interface.face]\n"
        << surface_lines(*best, faces)
               .value_or(fmt::format(
                   "by = \"faces\"\nfaces = [{}]\n# numbers change with the drawing; by = \"near\" takes "
                   "the face nearest to a point\n",
                   best->number));
  }
}

}  // namespace

void print_faces(const std::filesystem::path& file, std::ostream& out) {
  files::note_input(file);
  const std::string end = ending_of(file);
  if (end == ".toml") {
    const PartInput part = read_part(file);
    if (is_deck(part.format)) return print_deck(part.cad.path, part.format, out);
  } else if (end == ".inp" || end == ".unv" || end == ".bdf" || end == ".dat" || end == ".nas") {
    return print_deck(file,
                      end == ".inp"   ? PartFormat::abaqus
                      : end == ".unv" ? PartFormat::unv
                                      : PartFormat::nastran,
                      out);
  }
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

void write_faces_page(const std::filesystem::path& file, const std::filesystem::path& html) {
  mesh::CadOptions options{.path = file};
  std::string part_file = "part.toml";
  if (file.extension() == ".toml") {
    const PartInput part = read_part(file);
    if (part.sheet_thickness > 0.0)
      throw std::invalid_argument(
          file.string() + ": is a part of sheets, and the page of faces shows solids only; leave --html out");
    options = part.cad;
    part_file = file.filename().string();
  }
  const mesh::CadReport report = mesh::list_faces(options);
  const mesh::FacesPicture picture = mesh::draw_faces(options);
  view::PartsPage page{.title = options.path.filename().string(), .created_by = "flexura reduce"};
  view::DrawnPart part{.name = page.title, .file = part_file, .color = ""};
  std::map<mesh::Index, std::int32_t> place;
  const std::vector<std::string> lines = face_lines(report.faces, picture);
  for (std::size_t i = 0; i < report.faces.size(); ++i) {
    place[report.faces[i].number] = static_cast<std::int32_t>(i);
    part.faces.push_back(mesh::numbered_face(report.faces[i]));
    part.faces.back().lines = lines[i];
  }
  part.vertices = picture.vertices;
  part.edges = picture.edges;
  for (std::size_t t = 0; t < picture.triangles.size(); ++t)
    if (const auto known = place.find(picture.face[t]); known != place.end()) {
      part.triangles.push_back(picture.triangles[t]);
      part.face.push_back(known->second);
    }
  page.parts.push_back(std::move(part));
  page.bodies.push_back({.name = page.title, .text = fmt::format("{} faces", report.faces.size())});
  view::write_parts_page(html, page);
}

}  // namespace flexura::reduce
