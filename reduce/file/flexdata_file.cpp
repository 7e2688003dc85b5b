// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/flexdata_file.hpp"

#include <cctype>
#include <fstream>
#include <map>
#include <sstream>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/files/plain_text.hpp"
#include "reduce/file/part_file.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Matrix3d;

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

Matrix3d symmetric(const std::vector<double>& v) {  // xx, yy, zz, xy, yz, zx
  Matrix3d J;
  J << v[0], v[3], v[5], v[3], v[1], v[4], v[5], v[4], v[2];
  return J;
}

}  // namespace

const input::TableSchema& flexdata_schema() {
  static const input::TableSchema schema = [] {
    namespace dim = input::dim;
    input::TableSchema s{
        .name = "flexdata",
        .doc =
            "The file and what it lacks. Written by `flexura export --format flexdata` it lacks nothing: "
            "`flexura reduce "
            "arm.xml` needs no part file. Modes must be those of the free body, of unit modal mass. Of few "
            "modes (less than six "
            "for each interface node, less six) some directions of the interfaces follow the others; the "
            "program says which. Each ModeLoad becomes a load case, \"load_1\" by its loadcase_id (files of "
            "`flexura "
            "export` keep their names): `distributed_load` of the mechanism puts it on the body. It has a "
            "number for each "
            "mode, or for six rigid modes before them, or for all modes by their numbers; what other "
            "programs write on "
            "rigid modes is left out, as the file does not tell their axes."};
    s.keys = {
        input::text("file", "FlexData file (.xml)").required(),
        input::integer("id", "of the body, where the file holds several").at_least(0),
        input::choice("unit", {"m", "mm", "cm", "inch", "ft"}, "its length unit").or_default("m"),
        input::choice("mass_unit", {"kg", "t", "g", "lbf s^2/in", "slug"},
                      "its mass unit, the time being s; default: what goes with the length unit (m: kg, mm: "
                      "t, inch: lbf s^2/in, "
                      "ft: slug)"),
        input::quantity("mass", dim::mass, "the body's mass").above(0),
        input::vector3("centre", dim::length, "its mass centre"),
        input::quantities("inertia", dim::inertia,
                          "xx, yy, zz, xy, yz, zx: its inertia tensor about the mass centre")
            .sized(6),
        input::texts("names",
                     "of its interface nodes, in the file's order; default: \"node 12\" by their numbers"),
    };
    input::TableSchema top{
        .name = "FlexData part file",
        .doc =
            "A flexible body that another program has reduced, as MotionSolve's Reference_FlexData, for "
            "`flexura reduce`. Quantities carry their unit; plain numbers are SI."};
    top.keys = {input::text("name", "name of the part; default: the file's name"),
                input::table("flexdata", s, "the file").required()};
    return top;
  }();
  return schema;
}

bool is_flexdata_file(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (ending == ".xml") return true;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first != std::string::npos && line.compare(first, 10, "[flexdata]") == 0) return true;
  }
  return false;
}

FlexDataInput read_flexdata_part(const std::filesystem::path& file,
                                 const std::vector<std::string>& overrides) {
  FlexDataInput part{.name = files::plain_text(file.stem().string()), .where = file.string()};
  std::string ending = file.extension().string();
  if (ending != ".toml") {
    if (!overrides.empty())
      throw input::InputError(
          file.string() +
          ": is a FlexData file, which has no entries to set; write a part file with a table "
          "[flexdata]");
    part.file = file;
    return part;
  }
  const input::Section top = input::read_document(file, flexdata_schema(), overrides),
                       in = top.table("flexdata");
  part.name = top.title();
  part.source = text_of(file);
  part.where = in.where();
  part.file = in.file("file");
  if (in.has("id")) part.id = in.integer("id");
  static const std::map<std::string, std::pair<double, std::string>> lengths = {
      {"m", {1.0, "kg"}},
      {"mm", {1e-3, "t"}},
      {"cm", {1e-2, "kg"}},
      {"inch", {0.0254, "lbf s^2/in"}},
      {"ft", {0.3048, "slug"}}};
  const auto& [length, mass] = lengths.at(in.text("unit"));
  part.unit_length = length;
  part.unit_mass = mass_unit(in.has("mass_unit") ? in.text("mass_unit") : mass);
  part.has_units = in.has("unit") || in.has("mass_unit");
  if (in.has("mass")) part.mass = in.quantity("mass");
  if (in.has("centre")) part.centre = in.vector3("centre");
  if (in.has("inertia")) part.inertia = symmetric(in.quantities("inertia"));
  if (in.has("names")) part.names = in.texts("names");
  return part;
}

}  // namespace flexura::reduce
