// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/part_file.hpp"

#include <fstream>
#include <sstream>

namespace flexura::reduce {

using input::InputError;
using input::Section;
using input::TableSchema;
namespace dim = input::dim;

namespace {

TableSchema geometry_schema() {
  TableSchema s{.name = "geometry", .doc = "The CAD part. STEP, IGES and BREP are read."};
  s.keys = {
      input::text("file", "CAD file, relative to the part file").required(),
      input::choice("unit", {"m", "mm", "cm", "um", "inch", "ft"},
                    "length unit of the CAD file; overrides what the file says (BREP files say nothing: mm)"),
      input::integer("solid", "which solid of the file, counted from 1 as `--list-faces` prints them")
          .at_least(1),
      input::flag("fuse", "join all solids of the file into one").or_default("false"),
      input::flag("heal",
                  "let the CAD kernel repair the shape before meshing; may change its volume slightly")
          .or_default("false"),
  };
  return s;
}

TableSchema mesh_schema() {
  TableSchema s{.name = "mesh", .doc = "How the geometry is meshed. May be left out."};
  s.keys = {
      input::integer("order", "1: four-node, 2: ten-node tetrahedra").or_default("2").at_least(1).at_most(2),
      input::quantity("size", dim::length, "element size; chosen from the part's dimensions when left out")
          .above(0),
      input::quantity("elements_per_circle", dim::none,
                      "refine curved faces so that a full circle takes this many elements; 0: no refinement")
          .or_default("8")
          .at_least(0),
      input::quantity("time_limit", dim::time, "give the mesher up after this time")
          .or_default("600 s")
          .above(0),
  };
  return s;
}

TableSchema material_schema() {
  TableSchema s{.name = "material", .doc = "An isotropic linear elastic material."};
  s.keys = {
      input::quantity("young", dim::pressure, "Young's modulus").required().above(0),
      input::quantity("poisson", dim::none, "Poisson's ratio").required().above(-1).below(0.5),
      input::quantity("density", dim::density, "mass per volume").required().above(0),
  };
  return s;
}

TableSchema interface_schema() {
  TableSchema s{
      .name = "interface",
      .doc =
          "Where other bodies, joints and forces take hold. Each becomes one node of six degrees of "
          "freedom, tied to the chosen faces."};
  s.selector = "by";
  s.keys = {
      input::choice("by", {"cylinder", "plane", "near", "faces", "group", "nodes"},
                    "how the faces are chosen")
          .required(),
      input::choice(
          "tie", {"rigid", "average"},
          "`rigid`: the faces follow the node as one rigid piece (RBE2). `average`: the node follows the "
          "area-weighted mean motion of the faces and does not stiffen them (RBE3)")
          .or_default("rigid"),
      input::vector3(
          "reference", dim::length,
          "position of the interface node; default: centre of the chosen faces, for a cylinder the middle "
          "of its axis"),
  };
  const auto point = [](const char* doc) { return input::vector3("point", dim::length, doc).required(); };
  s.variants["cylinder"] = {
      .name = "interface by cylinder",
      .keys = {
          point("a point on the axis"), input::vector3("axis", dim::none, "direction of the axis").required(),
          input::quantity("radius", dim::length,
                          "radius; may be left out where only one cylinder has this axis")
              .above(0),
          input::quantities("extent", dim::length,
                            "only faces between these two distances along the axis, counted from `point`")
              .sized(2)}};
  s.variants["plane"] = {.name = "interface by plane",
                         .keys = {point("a point in the plane"),
                                  input::vector3("normal", dim::none, "normal of the plane").required()}};
  s.variants["near"] = {
      .name = "interface by nearness",
      .keys = {
          point("the nearest face is taken"),
          input::quantity("radius", dim::length, "take every face within this distance instead").above(0)}};
  s.variants["faces"] = {
      .name = "interface by face numbers",
      .keys = {input::integers("faces", "face numbers as `--list-faces` prints them").required()}};
  s.variants["group"] = {.name = "interface by group",
                         .keys = {input::text("group", "name of a physical group or named set").required()}};
  s.variants["nodes"] = {.name = "interface by nodes",
                         .keys = {input::integers("nodes", "node numbers of the mesh file").required()}};
  return s;
}

TableSchema recovery_schema() {
  TableSchema s{.name = "recovery",
                .doc = "What the superelement keeps besides the displacements of its surface."};
  s.keys = {
      input::flag("stress",
                  "stress modes: nodal stresses of every shape on the surface, for von Mises stress and the "
                  "like at run time")
          .or_default("false"),
      input::texts("groups",
                   "stress modes only at the nodes of these named sets; default: the whole surface"),
      input::choice("precision", {"single", "double"}, "how stress modes are stored").or_default("single"),
  };
  return s;
}

RecoveryInput read_recovery(const Section& in) {
  RecoveryInput r{.stress = in.flag("stress"),
                  .double_precision = in.text("precision") == "double",
                  .where = in.where("groups")};
  if (in.has("groups")) r.groups = in.texts("groups");
  if (!r.groups.empty() && !r.stress)
    in.refuse("groups", "chooses where stress modes are kept, but there are none", "add stress = true");
  return r;
}

std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Eigen::Vector3d direction(const Section& in, const std::string& key) {
  const Eigen::Vector3d d = in.vector3(key);
  if (d.norm() == 0.0) in.refuse(key, "is a direction and must not be zero", "write e.g. [0, 0, 1]");
  return d.normalized();
}

mesh::Rule read_rule(const Section& in) {
  const std::string by = in.text("by");
  if (by == "cylinder") {
    mesh::CylinderRule rule{.point = in.vector3("point"), .direction = direction(in, "axis")};
    if (in.has("radius")) rule.radius = in.quantity("radius");
    if (in.has("extent")) {
      const std::vector<double> e = in.quantities("extent");
      if (e[0] >= e[1]) in.refuse("extent", "runs from the smaller to the greater distance along the axis");
      rule.extent = {e[0], e[1]};
    }
    return rule;
  }
  if (by == "plane") return mesh::PlaneRule{.point = in.vector3("point"), .normal = direction(in, "normal")};
  if (by == "near") {
    mesh::NearRule rule{.point = in.vector3("point")};
    if (in.has("radius")) rule.radius = in.quantity("radius");
    return rule;
  }
  if (by == "faces") {
    const std::vector<int> faces = in.integers("faces");
    return mesh::FacesRule{{faces.begin(), faces.end()}};
  }
  if (by == "group") return mesh::NameRule{in.text("group")};
  const std::vector<int> nodes = in.integers("nodes");
  return mesh::NodesRule{.labels = {nodes.begin(), nodes.end()}};
}

mesh::CadOptions read_cad(const Section& geometry, const Section& mesh) {
  mesh::CadOptions cad;
  cad.path = geometry.file("file");
  if (!std::filesystem::exists(cad.path)) {
    geometry.refuse("file", "there is no such file", "relative names start at the part file's folder");
  }
  if (geometry.has("unit")) cad.unit = geometry.text("unit");
  if (geometry.has("solid")) cad.solids = {geometry.integer("solid")};
  cad.fuse = geometry.flag("fuse");
  cad.heal = geometry.flag("heal");
  cad.order = mesh.integer("order");
  if (mesh.has("size")) cad.size = mesh.quantity("size");
  cad.elements_per_circle = mesh.quantity("elements_per_circle");
  cad.time_limit_s = mesh.quantity("time_limit");
  return cad;
}

InterfaceInput read_interface(const std::string& name, const Section& in) {
  InterfaceInput f{.name = name, .rule = read_rule(in), .where = in.where()};
  f.tie = in.text("tie") == "average" ? Tie::average : Tie::rigid;
  if (in.has("reference")) f.reference = in.vector3("reference");
  return f;
}

}  // namespace

TableSchema modes_schema() {
  TableSchema s{.name = "modes", .doc = "Fixed-interface normal modes to keep beside the constraint modes."};
  s.keys = {
      input::integer("count", "number of modes").or_default("20").at_least(0),
      input::quantity("up_to", dim::frequency, "keep all modes up to this frequency instead of a fixed count")
          .above(0),
      input::quantity("damping", dim::none,
                      "modal damping ratio proposed to the runtime (diagonal in modal space)")
          .or_default("0.01")
          .at_least(0),
  };
  return s;
}

ModesInput read_modes(const Section& in) {
  ModesInput modes;
  modes.count = in.integer("count");
  if (in.has("up_to")) modes.up_to = in.quantity("up_to");
  modes.damping = in.quantity("damping");
  return modes;
}

const TableSchema& part_schema() {
  static const TableSchema schema = [] {
    TableSchema s{.name = "part file",
                  .doc =
                      "What `flexura reduce` takes. Lengths, moduli and the like are written with their unit "
                      "(\"210 GPa\", \"12 mm\"); plain numbers are SI."};
    s.keys = {
        input::text("name", "name of the part; default: the file's name"),
        input::choice("mass", {"consistent", "lumped"}, "mass matrix of the elements")
            .or_default("consistent"),
        input::flag("stiffening",
                    "keep the geometric stiffening terms: what loads and rotation add to the stiffness")
            .or_default("false"),
        input::table("geometry", geometry_schema(), "CAD part").required(),
        input::table("mesh", mesh_schema(), "meshing"),
        input::table_map("material", material_schema(), "material by name").required(),
        input::table_map("interface", interface_schema(), "interfaces by name"),
        input::table("modes", modes_schema(), "modes"),
        input::table("recovery", recovery_schema(), "stresses"),
    };
    return s;
  }();
  return schema;
}

PartInput read_part(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const Section in = input::read_document(file, part_schema(), overrides);
  PartInput part;
  part.name = in.has("name") ? in.text("name") : file.stem().string();
  part.source = read_text(file);
  part.mass = in.text("mass") == "lumped" ? MassKind::lumped : MassKind::consistent;

  part.cad = read_cad(in.table("geometry"), in.table("mesh"));

  for (const auto& [name, m] : in.table_map("material")) {
    part.materials.push_back(
        isotropic(name, m.quantity("young"), m.quantity("poisson"), m.quantity("density")));
  }
  if (part.materials.size() != 1) {
    in.refuse("material", "a CAD part takes exactly one material",
              "keep the one table [material.NAME] it is made of");
  }
  for (const auto& [name, f] : in.table_map("interface")) part.interfaces.push_back(read_interface(name, f));
  if (part.interfaces.empty()) {
    throw InputError(in.where() +
                     ": the part has no interface; add a table [interface.NAME] for each place where joints "
                     "or forces act, `flexura reduce --list-faces` shows what can be chosen");
  }

  part.modes = read_modes(in.table("modes"));
  part.recovery = read_recovery(in.table("recovery"));
  part.stiffening = in.flag("stiffening");
  return part;
}

}  // namespace flexura::reduce
