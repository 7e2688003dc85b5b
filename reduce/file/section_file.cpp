// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/section_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/plausible.hpp"
#include "reduce/file/polygon.hpp"

namespace flexura::reduce {

using input::InputError;
using input::Section;
using input::TableSchema;
namespace dim = input::dim;

namespace {

TableSchema material_schema() {
  TableSchema s{.name = "material",
                .doc = "Isotropic (young, poisson) or orthotropic (E_1 ...), axis 1 the fibre's."};
  s.keys = {input::quantity("density", dim::density, "mass per volume").required().at_least(0),
            input::quantity("young", dim::pressure, "Young's modulus").above(0),
            input::quantity("poisson", dim::none, "Poisson's ratio").above(-1).below(0.5)};
  for (const char* name : {"E_1", "E_2", "E_3", "G_12", "G_13", "G_23"})
    s.keys.push_back(input::quantity(name, dim::pressure, "orthotropic modulus").above(0));
  for (const char* name : {"nu_12", "nu_13", "nu_23"})
    s.keys.push_back(
        input::quantity(name, dim::none, "contraction along the second axis of a pull along the first"));
  return s;
}

std::vector<input::Key> ply_keys() {
  return {input::text("material", "name of a material; may be left out where there is only one"),
          input::quantity("fibre_angle", dim::angle, "of axis 1 from the beam's axis, about the ply's normal")
              .or_default("0 deg")};
}

beam::PlyMaterial read_material(const std::string& name, const Section& in) {
  const bool isotropic = in.has("young") || in.has("poisson");
  if (isotropic) {
    if (!in.has("young") || !in.has("poisson"))
      throw InputError(in.where() + ": an isotropic material needs `young` and `poisson`");
    return beam::ply_of(
        beam::isotropic(name, in.quantity("young"), in.quantity("poisson"), in.quantity("density")));
  }
  const auto q = [&](const char* key) {
    if (!in.has(key))
      throw InputError(
          fmt::format("{}: give `young` and `poisson`, or all of E_1, E_2, E_3, G_12, G_13, G_23, nu_12, "
                      "nu_13, nu_23; {} is missing",
                      in.where(), key));
    return in.quantity(key);
  };
  return {name,       in.quantity("density"),
          q("E_1"),   q("E_2"),
          q("E_3"),   q("G_12"),
          q("G_13"),  q("G_23"),
          q("nu_12"), q("nu_13"),
          q("nu_23")};
}

mesh::PlaneLoop read_points(const Section& in, double unit, bool closed) {
  const Eigen::MatrixXd points = in.matrix("points");
  if (points.cols() != 2 || points.rows() < 2)
    in.refuse("points", fmt::format("is {} x {}; points are rows [y, z]", points.rows(), points.cols()));
  // Farther away no digit of the geometry kernel is left for a section; NaN.
  constexpr double most = 1e4;
  if (const double size = unit * points.cwiseAbs().maxCoeff(); !(size < most) || !points.allFinite())
    in.refuse("points", fmt::format("reaches {:.3g} m; all must be below {:g} m", size, most),
              "check `unit`");
  mesh::PlaneLoop loop;
  for (int k = 0; k < points.rows(); ++k) loop.push_back({unit * points(k, 0), unit * points(k, 1)});
  return without_repeated(loop, closed);
}

mesh::PlaneLoop read_polygon(const Section& in, double unit) {
  mesh::PlaneLoop loop = read_points(in, unit, true);
  if (const std::string fault = polygon_fault(loop); !fault.empty())
    in.refuse("points", "is no outline: " + fault,
              "give the corners one after the other around it; what is inside goes into [hole.NAME], several "
              "pieces into "
              "several regions");
  return loop;
}

double area_of(const mesh::PlaneLoop& loop) {
  return shared_area(loop, loop);
}

mesh::PlaneLoop read_midline(const Section& in, double unit) {
  const mesh::PlaneLoop line = read_points(in, unit, false);
  if (line.size() < 2) in.refuse("points", "is a single place", "a mid-line has two points or more");
  for (std::size_t k = 1; k + 1 < line.size(); ++k) {
    const auto at = [&](std::size_t i) { return Eigen::Vector2d(line[i][0], line[i][1]); };
    const Eigen::Vector2d before = (at(k) - at(k - 1)).normalized(), after = (at(k + 1) - at(k)).normalized();
    if (before.dot(after) < 0.0 && std::abs(before.x() * after.y() - before.y() * after.x()) < 1e-6)
      in.refuse("points",
                fmt::format("folds back on itself at ({:g}, {:g})", line[k][0] / unit, line[k][1] / unit),
                "give each wall once");
  }
  return line;
}

void note_odd(const beam::PlyMaterial& m, std::vector<std::string>& warnings) {
  if (m.rho == 0.0) return;  // a section for statics
  if (std::string odd = input::odd_material(m.name, 3.0 * m.G_12, m.rho); !odd.empty())
    warnings.push_back(std::move(odd));
}

}  // namespace

const TableSchema& section_file_schema() {
  static const TableSchema schema = [] {
    TableSchema region{.name = "region",
                       .doc = "A polygon of one material. What two regions share belongs to the first."};
    region.keys = ply_keys();
    region.keys.push_back(input::matrix("points", "corners, rows [y, z] in `unit`").required());
    region.keys.push_back(
        input::quantity("plane_angle", dim::angle, "direction of the ply in the section, from y")
            .or_default("0 deg"));
    TableSchema hole{.name = "hole", .doc = "A polygon cut out of a region, over whose edge it may reach."};
    hole.keys = {input::text("region", "name of the region").required(),
                 input::matrix("points", "corners, rows [y, z] in `unit`").required()};
    TableSchema wall{.name = "wall", .doc = "A thin wall along a mid-line; its plies lie along it."};
    wall.keys = ply_keys();
    wall.keys.push_back(input::matrix("points", "the mid-line, rows [y, z] in `unit`").required());
    wall.keys.push_back(input::quantity("thickness", dim::length, "thickness").required().above(0));
    TableSchema s{.name = "section file", .doc = "A cross-section for `flexura section`."};
    s.keys = {
        input::text("name", "name of the section; default: the file's name"),
        input::choice("unit", {"m", "mm", "cm", "in"}, "unit of `points`").or_default("mm"),
        input::text("cad", "instead of regions and walls: a CAD file of planar faces, relative to this file"),
        input::quantity("size", dim::length, "element size, at most area over outline; default: half of that")
            .above(0),
        input::table_map("material", material_schema(), "material by name").required(),
        input::table_map("region", region, "polygons by name"),
        input::table_map("hole", hole, "holes by name"),
        input::table_map("wall", wall, "walls by name"),
    };
    return s;
  }();
  return schema;
}

std::vector<mesh::PlaneRegion> wall_regions(const mesh::PlaneLoop& midline, double thickness) {
  const auto at = [&](std::size_t k) { return Eigen::Vector2d(midline[k][0], midline[k][1]); };
  const std::size_t n = midline.size();
  const bool closed = n > 3 && (at(0) - at(n - 1)).norm() < 1e-9;
  // At a corner that turns by phi both walls end at the mitre of the outer side, t/2 tan(phi/2) beyond the
  // corner.
  const auto beyond = [&](const Eigen::Vector2d& before, const Eigen::Vector2d& after) {
    const double turn = std::acos(std::clamp(before.dot(after), -1.0, 1.0));
    return 0.5 * thickness * std::tan(0.5 * std::min(turn, 2.0));
  };
  std::vector<Eigen::Vector2d> along;
  for (std::size_t k = 0; k + 1 < n; ++k) along.push_back((at(k + 1) - at(k)).normalized());
  std::vector<mesh::PlaneRegion> regions;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    Eigen::Vector2d from = at(k), to = at(k + 1);
    if (k > 0 || closed) from -= beyond(along[k > 0 ? k - 1 : along.size() - 1], along[k]) * along[k];
    if (k + 2 < n || closed) to += beyond(along[k], along[k + 2 < n ? k + 1 : 0]) * along[k];
    const Eigen::Vector2d side = 0.5 * thickness * Eigen::Vector2d(-along[k].y(), along[k].x());
    mesh::PlaneRegion region;
    for (const Eigen::Vector2d& p : {Eigen::Vector2d(from - side), Eigen::Vector2d(to - side),
                                     Eigen::Vector2d(to + side), Eigen::Vector2d(from + side)})
      region.outer.push_back({p.x(), p.y()});
    regions.push_back(region);
  }
  return regions;
}

SectionInput read_section_file(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const Section in = input::read_document(file, section_file_schema(), overrides);
  SectionInput section;
  section.name = in.title();
  if (in.has("size")) section.planar.size = in.quantity("size");
  const std::map<std::string, double> units = {{"m", 1.0}, {"mm", 1e-3}, {"cm", 1e-2}, {"in", 0.0254}};
  const double unit = units.at(in.text("unit"));

  std::vector<std::string> names;
  std::vector<beam::PlyMaterial> materials;
  for (const auto& [name, m] : in.table_map("material")) {
    names.push_back(name);
    materials.push_back(read_material(name, m));
    note_odd(materials.back(), section.warnings);
  }
  const auto material_of = [&](const Section& where) -> const beam::PlyMaterial& {
    if (!where.has("material")) {
      if (materials.size() != 1)
        throw InputError(fmt::format("{}: name a material; there are {}", where.where(), materials.size()));
      return materials.front();
    }
    const auto it = std::find(names.begin(), names.end(), where.text("material"));
    if (it == names.end())
      where.refuse("material",
                   "there is no such material" + input::suggestion(where.text("material"), names));
    return materials[it - names.begin()];
  };
  if (in.has("cad")) {
    if (in.has("region") || in.has("wall"))
      in.refuse("cad", "stands beside regions or walls", "keep one of the two");
    section.planar.cad = in.file("cad");
    if (!std::filesystem::exists(section.planar.cad)) in.refuse("cad", "there is no such file");
    if (materials.size() != 1) in.refuse("material", "a CAD section takes exactly one material");
    section.plies = {beam::Ply{materials.front()}};
    return section;
  }
  std::vector<std::string> regions;
  if (in.has("region"))
    for (const auto& [name, r] : in.table_map("region")) {
      regions.push_back(name);
      section.regions.push_back("region." + name);
      section.planar.regions.push_back({read_polygon(r, unit), {}});
      section.plies.push_back({material_of(r), r.quantity("fibre_angle"), r.quantity("plane_angle")});
    }
  if (in.has("hole"))
    for (const auto& [name, h] : in.table_map("hole")) {
      const auto it = std::find(regions.begin(), regions.end(), h.text("region"));
      if (it == regions.end())
        h.refuse("region", "there is no such region" + input::suggestion(h.text("region"), regions));
      mesh::PlaneRegion& region = section.planar.regions[it - regions.begin()];
      mesh::PlaneLoop hole = read_polygon(h, unit);
      const double whole = area_of(region.outer), cut = shared_area(region.outer, hole);
      // Beside round-off of the areas.
      if (!(cut > 1e-9 * std::max(whole, area_of(hole))))
        h.refuse("points", fmt::format("lies outside of region.{}: it cuts nothing out", *it),
                 "check the region's name and `points`, or take the hole away");
      if (!(whole - cut > 1e-9 * whole))
        h.refuse("points", fmt::format("leaves nothing of region.{}", *it),
                 "check the region's name and `points`");
      region.holes.push_back(std::move(hole));
    }
  if (in.has("wall"))
    for (const auto& [name, w] : in.table_map("wall"))
      for (const mesh::PlaneRegion& region : wall_regions(read_midline(w, unit), w.quantity("thickness"))) {
        const double y = region.outer[1][0] - region.outer[0][0], z = region.outer[1][1] - region.outer[0][1];
        section.planar.regions.push_back(region);
        section.regions.push_back("wall." + name);
        section.plies.push_back({material_of(w), w.quantity("fibre_angle"), std::atan2(z, y)});
      }
  if (section.planar.regions.empty())
    throw InputError(file.string() +
                     ": the section has no material; give [region.NAME], [wall.NAME] or `cad`");
  return section;
}

beam::SectionProperties solve(const SectionInput& input, std::vector<std::string>* warnings) {
  const mesh::PlanarMesh planar = mesh::mesh_planar(input.planar);
  if (warnings) {
    *warnings = input.warnings;
    warnings->insert(warnings->end(), planar.messages.begin(), planar.messages.end());
    // What regions share belongs to the first: of one inside another that stands before it nothing is left.
    std::map<std::string, int> triangles;
    for (const std::string& name : input.regions) triangles[name] = 0;
    for (const int region : planar.region)
      if (input.planar.cad.empty()) ++triangles[input.regions[static_cast<std::size_t>(region)]];
    for (const auto& [name, n] : triangles)
      if (n == 0)
        warnings->push_back(fmt::format(
            "{} adds nothing: it lies within others that stand before it in the file; if its material "
            "is meant there, put it before them",
            name));
  }
  beam::SectionMesh mesh{planar.points, planar.triangles, planar.region, {}};
  if (!input.planar.cad.empty()) mesh.ply.clear();
  return beam::solve_section(input.name, mesh, input.plies);
}

}  // namespace flexura::reduce
