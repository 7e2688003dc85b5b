// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/beam_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <sstream>

namespace flexura::reduce {

using input::InputError;
using input::Section;
using input::TableSchema;
namespace dim = input::dim;

namespace {

constexpr input::Dimension kStaticMoment{{3, 0, 0, 0}};
const std::vector<std::string> kDirections = {"x", "y", "z", "rx", "ry", "rz"};

TableSchema material_schema() {
  TableSchema s{.name = "material", .doc = "An isotropic linear elastic material."};
  s.keys = {
      input::quantity("young", dim::pressure, "Young's modulus").required().above(0),
      input::quantity("poisson", dim::none, "Poisson's ratio").above(-1).below(0.5),
      input::quantity("shear", dim::pressure, "shear modulus, instead of Poisson's ratio").above(0),
      input::quantity("density", dim::density, "mass per volume").required().at_least(0),
  };
  return s;
}

TableSchema section_schema() {
  TableSchema s{
      .name = "section",
      .doc = "A cross-section: x along the member, y its width, z its height. The numbers are SIMBEAM's."};
  s.selector = "type";
  s.keys = {
      input::choice("type",
                    {"circle", "hollow_circle", "rectangle", "hollow_rectangle", "ellipse", "hollow_ellipse",
                     "basic", "advanced", "matrix", "file"},
                    "1, 2, 4, 5, 6, 7: standard shapes; 10 General Basic; 11 General Advanced; 12 Matrix "
                    "Input; file: what --section wrote")
          .required(),
      input::text("material", "name of a material; may be left out where there is only one"),
      input::choice("shear_factor", {"default", "cowper", "hutchinson", "zero_poisson", "rigid"},
                    "formula of the shear areas of standard shapes; default: Cowper (1966), hollow ellipse "
                    "zero_poisson")
          .or_default("default"),
      input::flag("open_thin_walled",
                  "the section is open and thin-walled: members whose warping is held are named")
          .or_default("false"),
      input::quantity("I_w", {{6, 0, 0, 0}}, "warping constant, for that warning's figures").at_least(0),
  };
  const auto length = [](const char* name, const char* doc) {
    return input::quantity(name, dim::length, doc).required().above(0);
  };
  s.variants["circle"] = {.name = "section circle", .keys = {length("diameter", "diameter")}};
  s.variants["hollow_circle"] = {
      .name = "section hollow_circle",
      .keys = {length("outer_diameter", "outer diameter"), length("inner_diameter", "inner diameter")}};
  s.variants["rectangle"] = {.name = "section rectangle",
                             .keys = {length("width", "along y"), length("height", "along z")}};
  s.variants["hollow_rectangle"] = {
      .name = "section hollow_rectangle",
      .keys = {length("width", "outer, along y"), length("height", "outer, along z"),
               length("web", "thickness of the walls along z"),
               length("flange", "thickness of the walls along y")}};
  s.variants["ellipse"] = {
      .name = "section ellipse",
      .keys = {length("width", "full axis along y"), length("height", "full axis along z")}};
  s.variants["hollow_ellipse"] = {
      .name = "section hollow_ellipse",
      .keys = {length("width", "outer axis along y"), length("height", "outer axis along z"),
               length("inner_width", "inner axis along y"), length("inner_height", "inner axis along z")}};
  std::vector<input::Key> basic = {
      input::quantity("A", dim::area, "area").required(),
      input::quantity("I_y", dim::area_moment, "int z^2 dA about the origin").required(),
      input::quantity("I_z", dim::area_moment, "int y^2 dA about the origin").required(),
      input::quantity("I_t", dim::area_moment, "torsion constant").required(),
      input::quantity("A_sy", dim::area, "shear area along y; left out: rigid in shear"),
      input::quantity("A_sz", dim::area, "shear area along z; left out: rigid in shear"),
  };
  s.variants["basic"] = {.name = "section basic", .keys = basic};
  for (input::Key& key : std::vector<input::Key>{
           input::quantity("I_yz", dim::area_moment, "minus int y z dA about the origin").or_default("0"),
           input::quantity("S_y", kStaticMoment, "static moment int z dA").or_default("0"),
           input::quantity("S_z", kStaticMoment, "static moment int y dA").or_default("0"),
           input::quantity("y_cs", dim::length, "shear centre").or_default("0"),
           input::quantity("z_cs", dim::length, "shear centre").or_default("0"),
           input::quantity("y_cg", dim::length, "centre of gravity").or_default("0"),
           input::quantity("z_cg", dim::length, "centre of gravity").or_default("0")})
    basic.push_back(key);
  s.variants["advanced"] = {.name = "section advanced", .keys = basic};
  s.variants["matrix"] = {
      .name = "section matrix",
      .keys = {
          input::matrix("stiffness", "6x6, order N, V_y, V_z, T, M_y, M_z, in N, N m, N m^2").required(),
          input::matrix("mass", "6x6, order of u_x, u_y, u_z, theta_x, theta_y, theta_z, in kg/m, kg, kg m")
              .required()}};
  s.variants["file"] = {.name = "section file",
                        .keys = {input::text("file", "section file, relative to the part file").required()}};
  return s;
}

// What section_result (section_file.cpp) writes.
const TableSchema& result_schema() {
  static const TableSchema schema = [] {
    TableSchema s{.name = "section", .doc = "A solved section."};
    s.keys = {input::quantity("I_t", dim::area_moment, "torsion constant").required(),
              input::quantity("I_w", {{6, 0, 0, 0}}, "warping constant").required(),
              input::quantity("young", dim::pressure, "reference").required(),
              input::quantity("shear", dim::pressure, "reference").required(),
              input::flag("open_thin_walled", "open and thin-walled").required(),
              input::quantity("y_cs", dim::length, "shear centre").required(),
              input::quantity("z_cs", dim::length, "shear centre").required(),
              input::matrix("stiffness", "6x6").required(),
              input::matrix("mass", "6x6").required(),
              input::matrix("outline", "rows [y, z] in m")};
    return s;
  }();
  return schema;
}

TableSchema member_schema() {
  TableSchema s{.name = "member", .doc = "A straight member between two nodes."};
  s.keys = {
      input::texts("nodes", "its two nodes; x runs from the first to the second").required().sized(2),
      input::text("section", "name of a section; may be left out where there is only one"),
      input::text("section_at_end", "tapered: the section at the second node, of the same type"),
      input::choice("theory", {"timoshenko", "euler_bernoulli"}, "with or without shear deformation")
          .or_default("timoshenko"),
      input::vector3(
          "direction", dim::none,
          "points to the side of the section's +y (width); default: height as near to the part's z as can "
          "be, members along z have their width along y"),
      input::text("direction_node", "instead: a node on that side"),
      input::vector3("offset_1", dim::length, "rigid arm from the first node to the member's end"),
      input::vector3("offset_2", dim::length, "rigid arm from the second node to the member's end"),
      input::texts("release_1",
                   "released at the first end: some of x, y, z, rx, ry, rz, in the member's axes"),
      input::texts("release_2", "released at the second end"),
      input::flag("warping_free", "the joints let both ends warp").or_default("false"),
      input::integer("elements", "number of elements; default: by [mesh]").at_least(1),
  };
  return s;
}

TableSchema mesh_schema() {
  TableSchema s{.name = "mesh",
                .doc = "How members are divided into elements; the finest of the rules counts."};
  s.keys = {
      input::integer("elements", "elements of each member at least").or_default("4").at_least(1),
      input::quantity("size", dim::length, "greatest length of an element").above(0),
      input::quantity("frequency", dim::frequency, "resolve all waves up to this frequency").above(0),
      input::quantity("frequency_error", dim::none, "relative error wanted there")
          .or_default("0.001")
          .above(0),
  };
  return s;
}

// Names of one kind and their numbers.
struct Names {
  const char* kind;
  std::vector<std::string> known;

  int find(const Section& in, const std::string& key, const std::string& word) const {
    const auto it = std::find(known.begin(), known.end(), word);
    if (it == known.end())
      in.refuse(key, fmt::format("\"{}\" is not a {}{}", word, kind, input::suggestion(word, known)));
    return static_cast<int>(it - known.begin());
  }
  // The only one where the key is left out.
  int find_or_only(const Section& in, const std::string& key) const {
    if (in.has(key)) return find(in, key, in.text(key));
    if (known.size() != 1)
      throw InputError(
          fmt::format("{}: name a {} with `{}`; there are {}", in.where(), kind, key, known.size()));
    return 0;
  }
};

std::bitset<6> directions(const Section& in, const std::string& key) {
  std::bitset<6> chosen;
  for (const std::string& word : in.texts(key)) {
    const auto it = std::find(kDirections.begin(), kDirections.end(), word);
    if (it == kDirections.end())
      in.refuse(key, fmt::format("\"{}\" is not a direction{}", word, input::suggestion(word, kDirections)));
    chosen[it - kDirections.begin()] = true;
  }
  return chosen;
}

beam::Material read_material(const std::string& name, const Section& in) {
  if (in.has("poisson") == in.has("shear"))
    throw InputError(fmt::format("{}: give either `poisson` or `shear`", in.where()));
  const double E = in.quantity("young"), rho = in.quantity("density");
  if (in.has("shear")) return {name, E, in.quantity("shear"), rho};
  return beam::isotropic(name, E, in.quantity("poisson"), rho);
}

beam::Matrix6d matrix6(const Section& in, const std::string& key) {
  const Eigen::MatrixXd matrix = in.matrix(key);
  if (matrix.rows() != 6 || matrix.cols() != 6)
    in.refuse(key, fmt::format("is {} x {}, a section has 6 x 6", matrix.rows(), matrix.cols()));
  return matrix;
}

beam::Section read_solved_section(const std::string& name, const std::filesystem::path& file) {
  const Section in = input::read_document(file, result_schema());
  beam::Section section = beam::matrix_section(name, matrix6(in, "stiffness"), matrix6(in, "mass"));
  section.I_w = in.quantity("I_w");
  section.open_thin_walled = in.flag("open_thin_walled");
  section.material = beam::Material{name, in.quantity("young"), in.quantity("shear"), 0.0};
  beam::Constants constants;  // for the warning of restrained warping
  constants.I_t = in.quantity("I_t");
  constants.A_sy = 1.0 / (section.material->G * section.f(beam::V_y, beam::V_y));
  constants.A_sz = 1.0 / (section.material->G * section.f(beam::V_z, beam::V_z));
  section.constants = constants;
  if (in.has("outline")) section.outline = {in.matrix("outline")};
  return section;
}

beam::SectionEntry read_section(const std::string& name, const Section& in,
                                const std::vector<beam::Material>& materials, const Names& material_names) {
  const std::string type = in.text("type"), factor = in.text("shear_factor");
  beam::SectionEntry entry;
  if (factor == "cowper") entry.formula = beam::ShearFormula::cowper;
  if (factor == "hutchinson") entry.formula = beam::ShearFormula::hutchinson;
  if (factor == "zero_poisson") entry.formula = beam::ShearFormula::zero_poisson;
  if (factor == "rigid") entry.formula = beam::ShearFormula::rigid;
  const auto q = [&](const char* key) { return in.quantity(key); };
  if (type == "circle") entry.shape = beam::Circle{q("diameter")};
  if (type == "hollow_circle") entry.shape = beam::HollowCircle{q("outer_diameter"), q("inner_diameter")};
  if (type == "rectangle") entry.shape = beam::Rectangle{q("width"), q("height")};
  if (type == "hollow_rectangle")
    entry.shape = beam::HollowRectangle{q("width"), q("height"), q("web"), q("flange")};
  if (type == "ellipse") entry.shape = beam::Ellipse{q("width"), q("height")};
  if (type == "hollow_ellipse")
    entry.shape = beam::HollowEllipse{q("width"), q("height"), q("inner_width"), q("inner_height")};
  try {
    if (type == "file") {
      entry.section = read_solved_section(name, in.file("file"));
      return entry;
    }
    if (type == "matrix") {
      entry.section = beam::matrix_section(name, matrix6(in, "stiffness"), matrix6(in, "mass"));
    } else {
      const beam::Material& material = materials[material_names.find_or_only(in, "material")];
      if (entry.shape) {
        entry.section = beam::make_section(name, *entry.shape, material, entry.formula);
      } else {
        beam::Constants c;
        c.A = q("A");
        c.I_y = q("I_y");
        c.I_z = q("I_z");
        c.I_t = q("I_t");
        if (in.has("A_sy")) c.A_sy = q("A_sy");
        if (in.has("A_sz")) c.A_sz = q("A_sz");
        if (type == "advanced") {
          c.I_yz = q("I_yz");
          c.S_y = q("S_y");
          c.S_z = q("S_z");
          c.y_cs = q("y_cs");
          c.z_cs = q("z_cs");
          c.y_cg = q("y_cg");
          c.z_cg = q("z_cg");
        }
        entry.section = beam::make_section(name, c, material);
      }
    }
  } catch (const std::invalid_argument& error) {
    throw InputError(in.where() + ": " + error.what());
  }
  entry.section.open_thin_walled = in.flag("open_thin_walled");
  if (in.has("I_w")) entry.section.I_w = q("I_w");
  return entry;
}

beam::Member read_member(const std::string& name, const Section& in, const Names& nodes,
                         const Names& sections) {
  beam::Member member;
  member.name = name;
  const std::vector<std::string> ends = in.texts("nodes");
  for (int end = 0; end < 2; ++end) {
    member.end[end].node = nodes.find(in, "nodes", ends[end]);
    member.end[end].warping_free = in.flag("warping_free");
    const std::string offset = end == 0 ? "offset_1" : "offset_2",
                      release = end == 0 ? "release_1" : "release_2";
    if (in.has(offset)) member.end[end].offset_B = in.vector3(offset);
    if (in.has(release)) member.end[end].released = directions(in, release);
  }
  member.section = sections.find_or_only(in, "section");
  if (in.has("section_at_end"))
    member.section_at_end = sections.find(in, "section_at_end", in.text("section_at_end"));
  member.theory =
      in.text("theory") == "timoshenko" ? beam::Theory::timoshenko : beam::Theory::euler_bernoulli;
  if (in.has("direction") && in.has("direction_node"))
    in.refuse("direction_node", "stands beside `direction`", "keep one of the two");
  if (in.has("direction")) member.direction_B = in.vector3("direction");
  if (in.has("direction_node"))
    member.direction_node = nodes.find(in, "direction_node", in.text("direction_node"));
  if (in.has("elements")) member.elements = in.integer("elements");
  return member;
}

}  // namespace

const TableSchema& beam_schema() {
  static const TableSchema schema = [] {
    TableSchema node{.name = "node", .doc = "A point of the structure."};
    node.keys = {input::vector3("position", dim::length, "in the part's frame").required()};
    TableSchema mass{.name = "mass", .doc = "A rigid body on a node."};
    mass.keys = {
        input::text("node", "where").required(),
        input::quantity("mass", dim::mass, "mass").required().at_least(0),
        input::vector3("center", dim::length, "from the node to the centre of mass"),
        input::vector3("inertia", dim::inertia, "I_xx, I_yy, I_zz about the centre of mass"),
        input::vector3("products", dim::inertia, "I_xy, I_yz, I_zx (entries of the inertia tensor)"),
    };
    TableSchema interface {
      .name = "interface", .doc = "A node where other bodies, joints and forces take hold."
    };
    interface.keys = {input::text("node", "name of the node; default: the interface's own name"),
                      input::texts("directions", "kept: some of x, y, z, rx, ry, rz; default: all")};
    TableSchema s{.name = "beam part file",
                  .doc =
                      "A structure of beams for `flexura reduce`. Quantities carry their unit (\"210 GPa\", "
                      "\"12 mm\"); "
                      "plain numbers are SI. A file with a table [member.NAME] is read as a beam part."};
    s.keys = {
        input::text("name", "name of the part; default: the file's name"),
        input::table_map("material", material_schema(), "material by name"),
        input::table_map("section", section_schema(), "cross-section by name").required(),
        input::table_map("node", node, "node by name").required(),
        input::table_map("member", member_schema(), "member by name").required(),
        input::table_map("mass", mass, "point masses by name"),
        input::table_map("interface", interface, "interfaces by name").required(),
        input::table("mesh", mesh_schema(), "division into elements"),
        input::table("modes", modes_schema(), "modes"),
    };
    return s;
  }();
  return schema;
}

bool is_beam_file(const std::filesystem::path& file) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first != std::string::npos && line.compare(first, 8, "[member.") == 0) return true;
  }
  return false;
}

BeamPartInput read_beam_part(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const Section in = input::read_document(file, beam_schema(), overrides);
  BeamPartInput part;
  part.name = in.has("name") ? in.text("name") : file.stem().string();
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  part.source = text.str();

  beam::Model& model = part.model;
  Names materials{"material", {}}, sections{"section", {}}, nodes{"node", {}};
  std::vector<beam::Material> material_list;
  if (in.has("material"))
    for (const auto& [name, m] : in.table_map("material")) {
      materials.known.push_back(name);
      material_list.push_back(read_material(name, m));
    }
  for (const auto& [name, s] : in.table_map("section")) {
    sections.known.push_back(name);
    model.sections.push_back(read_section(name, s, material_list, materials));
  }
  for (const auto& [name, n] : in.table_map("node")) {
    nodes.known.push_back(name);
    model.nodes.push_back({name, n.vector3("position")});
  }
  for (const auto& [name, m] : in.table_map("member"))
    model.members.push_back(read_member(name, m, nodes, sections));
  if (in.has("mass"))
    for (const auto& [name, m] : in.table_map("mass")) {
      beam::PointMass mass;
      mass.node = nodes.find(m, "node", m.text("node"));
      mass.mass = m.quantity("mass");
      if (m.has("center")) mass.p_NC_B = m.vector3("center");
      if (m.has("inertia")) mass.I_C_B.diagonal() = m.vector3("inertia");
      if (m.has("products")) {
        const Eigen::Vector3d p = m.vector3("products");
        mass.I_C_B(0, 1) = mass.I_C_B(1, 0) = p.x();
        mass.I_C_B(1, 2) = mass.I_C_B(2, 1) = p.y();
        mass.I_C_B(2, 0) = mass.I_C_B(0, 2) = p.z();
      }
      model.point_masses.push_back(mass);
    }
  for (const auto& [name, i] : in.table_map("interface")) {
    BeamInterface interface {
      name, -1, { 0, 1, 2, 3, 4, 5 }
    };
    interface.node = nodes.find(i, "node", i.has("node") ? i.text("node") : name);
    if (i.has("directions")) {
      const std::bitset<6> kept = directions(i, "directions");
      interface.directions.clear();
      for (int k = 0; k < 6; ++k)
        if (kept[k]) interface.directions.push_back(k);
    }
    part.interfaces.push_back(interface);
  }
  const Section mesh = in.table("mesh");
  part.subdivision.elements_per_member = mesh.integer("elements");
  if (mesh.has("size")) part.subdivision.max_length = mesh.quantity("size");
  if (mesh.has("frequency")) part.subdivision.max_frequency_hz = mesh.quantity("frequency");
  part.subdivision.frequency_error = mesh.quantity("frequency_error");
  part.modes = read_modes(in.table("modes"));
  try {
    beam::check(model);
  } catch (const std::invalid_argument& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  return part;
}

}  // namespace flexura::reduce
