// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/part_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <sstream>

#include "reduce/file/foreign_formats.hpp"
#include "reduce/file/part_modes.hpp"

namespace flexura::reduce {

using input::InputError;
using input::Section;

namespace {

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

/// Length and mass unit of a mesh file in SI.
void read_units(const Section& geometry, PartInput& part) {
  static const std::map<std::string, std::pair<double, std::string>> lengths = {
      {"m", {1.0, "kg"}},
      {"mm", {1e-3, "t"}},
      {"cm", {1e-2, ""}},
      {"um", {1e-6, ""}},
      {"inch", {0.0254, "lbf s^2/in"}},
      {"ft", {0.3048, "slug"}}};
  const auto& [length, mass] = lengths.at(geometry.has("unit") ? geometry.text("unit") : "m");
  part.unit_length = length;
  part.unit_mass = mass_unit(geometry.has("mass_unit") ? geometry.text("mass_unit")
                             : mass.empty()            ? "kg"
                                                       : mass);
  part.mass_unit_known = geometry.has("mass_unit") || !mass.empty();
}

PartFormat format_of(const Section& geometry) {
  const std::filesystem::path path = geometry.file("file");
  const std::string end = ending_of(path);
  if (end == ".msh") return PartFormat::gmsh;
  if (end == ".inp") return PartFormat::abaqus;
  if (end == ".bdf" || end == ".dat" || end == ".nas") return PartFormat::nastran;
  if (end == ".unv") return PartFormat::unv;
  if (end == ".csv" || end == ".txt") return PartFormat::nodes;
  if (is_cad_ending(end) || end == ".xml")
    return PartFormat::cad;  // whose reader answers FlexData with its key
  const std::string what = foreign_format(path);
  geometry.refuse(
      "file", what.empty() ? "is a kind of file that is not known here" : what,
      what.empty()
          ? "known are CAD (.step, .iges, .brep, .stl), decks and meshes (.inp, .bdf, .dat, .nas, .msh, "
            ".unv) and nodes of matrices (.csv, .txt)"
          : "");
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

Material read_material(const std::string& name, const Section& in, bool of_deck) {
  const double density = in.quantity("density");
  const bool whole = in.has("moduli") && in.has("ratios") && in.has("shear");
  const bool any =
      in.has("moduli") || in.has("ratios") || in.has("shear") || in.has("axis_x") || in.has("axis_y");
  if (!any && in.has("young") && in.has("poisson"))
    return isotropic(name, in.quantity("young"), in.quantity("poisson"), density);
  if (!any && !in.has("young") && !in.has("poisson") && of_deck)  // the deck has the rest
    return {.name = name, .density = density};
  if (!whole || in.has("young") || in.has("poisson"))
    throw InputError(
        in.where() +
        ": a material has young and poisson, or, orthotropic, moduli, ratios and shear; one of the two, "
        "complete");
  const auto E = in.quantities("moduli"), nu = in.quantities("ratios"), G = in.quantities("shear");
  Material material;
  try {
    material = orthotropic(name, {E[0], E[1], E[2], nu[0], nu[1], nu[2], G[0], G[1], G[2]}, density);
  } catch (const std::invalid_argument& error) {
    throw InputError(in.where() + ": " + error.what());
  }
  if (!in.has("axis_x") && !in.has("axis_y")) return material;
  Eigen::Matrix3d R;
  R.col(0) = in.has("axis_x") ? direction(in, "axis_x") : Eigen::Vector3d::UnitX();
  R.col(1) = in.has("axis_y") ? direction(in, "axis_y") : Eigen::Vector3d::UnitY();
  R.col(2) = R.col(0).cross(R.col(1));
  if (R.col(2).norm() < 1e-6)
    throw InputError(in.where() +
                     ": axis_x and axis_y lie on one line; give two directions of the material's plane");
  R.col(2).normalize();
  R.col(1) = R.col(2).cross(R.col(0));
  return turned(std::move(material), R);
}

InterfaceInput read_interface(const std::string& name, const Section& in) {
  InterfaceInput f{.name = name, .where = in.where()};
  if (in.text("by") == "tie")
    f.deck_tie = in.integer("element");
  else
    f.rule = read_rule(in);
  const std::string tie = in.text("tie");
  f.tie = tie == "average"   ? Tie::average
          : tie == "node"    ? Tie::node
          : tie == "elastic" ? Tie::elastic
                             : Tie::rigid;
  f.equal_weights = in.has("weights") ? in.text("weights") == "equal" : in.text("by") == "nodes";
  if (in.has("weights") && (f.deck_tie || (f.tie != Tie::average && f.tie != Tie::elastic)))
    in.refuse("weights", "goes with a mean: an average or elastic tie that is none of the deck",
              "leave the key out, or tie the interface as an average");
  if (f.tie == Tie::node) f.directions = {0, 1, 2};
  if (in.has("directions")) {
    static const std::vector<std::string> known = {"x", "y", "z", "rx", "ry", "rz"};
    f.directions.clear();
    for (const std::string& word : in.texts("directions")) {
      const auto found = std::find(known.begin(), known.end(), word);
      if (found == known.end())
        in.refuse("directions", "are of x, y, z, rx, ry, rz, each once", "\"" + word + "\" is none of them");
      f.directions.push_back(static_cast<int>(found - known.begin()));
    }
    std::sort(f.directions.begin(), f.directions.end());
    if (f.directions.empty() ||
        std::adjacent_find(f.directions.begin(), f.directions.end()) != f.directions.end())
      in.refuse("directions", "are of x, y, z, rx, ry, rz, each once", "leave the key out for all six");
  }
  if (f.tie == Tie::elastic && f.directions.size() < 6)
    in.refuse("directions", "are all six with an elastic tie", "leave the key out, or tie it as an average");
  if (in.has("reference")) f.reference = in.vector3("reference");
  return f;
}

MassInput read_mass(const std::string& name, const Section& in) {
  MassInput m{.name = name, .where = in.where()};
  if (in.has("interface") == in.has("node"))
    throw InputError(in.where() + ": a point mass is on an interface or on a node, one of the two");
  if (in.has("interface")) m.interface = in.text("interface");
  if (in.has("node")) m.node = in.integer("node");
  m.mass.mass = in.quantity("mass");
  if (in.has("offset")) m.mass.offset = in.vector3("offset");
  if (in.has("inertia")) {
    const std::vector<double> J = in.quantities("inertia");
    m.mass.inertia = Eigen::Vector3d(J[0], J[1], J[2]).asDiagonal();
  }
  return m;
}

LinkInput read_link(const std::string& name, const Section& in) {
  LinkInput l{.name = name, .where = in.where()};
  if (in.has("interfaces") == in.has("nodes"))
    throw InputError(in.where() + ": a link joins two interfaces or two nodes, one of the two");
  if (in.has("interfaces")) l.interfaces = in.texts("interfaces");
  for (const std::string& end : l.interfaces)
    if (end == "ground" || end == "world")
      in.refuse("interfaces",
                "a link joins two places of the part; a spring to the ground would resist the part's rigid "
                "motion, which belongs to the mechanism",
                "put a force element of the mechanism (spring_damper, bushing) between the interface and the "
                "ground");
  if (in.has("nodes")) l.nodes = in.integers("nodes");
  l.stiffness = in.quantity("stiffness");
  l.damping = in.quantity("damping");
  return l;
}

LoadInput read_load(const std::string& name, const Section& in) {
  const std::string type = in.text("type");
  LoadInput l{.name = name, .keep_shape = in.flag("keep_shape"), .where = in.where()};
  if (type == "gravity") l.vector = in.vector3("acceleration");
  if (type == "rotation") {
    l.type = LoadType::rotation;
    l.point = in.vector3("point");
    l.vector = direction(in, "axis");
    l.value = in.quantity("speed");
  }
  if (type == "pressure") {
    l.type = LoadType::pressure;
    if (in.has("group") == in.has("faces"))
      throw InputError(in.where() + ": a pressure acts on a group or on faces by number, one of the two");
    if (in.has("group")) {
      l.faces = mesh::NameRule{in.text("group")};
    } else {
      const std::vector<int> faces = in.integers("faces");
      l.faces = mesh::FacesRule{{faces.begin(), faces.end()}};
    }
    l.value = in.quantity("pressure");
    if (in.has("side")) l.side = direction(in, "side");
  }
  if (type == "field") {
    l.type = LoadType::field;
    l.formulas = {in.text("x"), in.text("y"), in.text("z")};
  }
  if (type == "preload") {
    l.type = LoadType::preload;
    l.keep_shape = true;
    l.strain = in.text("strain");
    if (in.has("axis")) l.vector = direction(in, "axis");
    if (in.has("material")) l.material = in.text("material");
  }
  return l;
}

}  // namespace

double mass_unit(const std::string& name) {
  static const std::map<std::string, double> masses = {
      {"kg", 1.0}, {"t", 1e3}, {"g", 1e-3}, {"lbf s^2/in", 175.12683524647636}, {"slug", 14.593902937206365}};
  return masses.at(name);
}

PartInput read_part(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const Section in = input::read_document(file, part_schema(), overrides);
  PartInput part;
  part.name = in.title();
  part.source = read_text(file);
  const std::string mass = in.text("mass");
  part.mass = mass == "lumped"    ? MassKind::lumped
              : mass == "reduced" ? MassKind::reduced
                                  : MassKind::consistent;

  part.where = in.where();
  const Section geometry = in.table("geometry"), meshing = in.table("mesh");
  part.cad = read_cad(geometry, meshing);
  part.format = format_of(geometry);
  part.formulation =
      meshing.text("formulation") == "enhanced" ? Formulation::enhanced : Formulation::standard;
  read_units(geometry, part);
  if (geometry.has("density")) part.density = geometry.quantity("density");
  part.strict = geometry.flag("strict");
  if (geometry.has("keep")) (geometry.text("keep") == "all" ? part.keep_all : part.keep_largest) = true;
  if (geometry.has("program")) {
    if (part.format != PartFormat::abaqus)
      geometry.refuse("program", "is for decks of Abaqus and CalculiX (.inp)", "take the key away");
    part.program =
        geometry.text("program") == "abaqus" ? mesh::DeckProgram::abaqus : mesh::DeckProgram::calculix;
  }
  if (part.format != PartFormat::cad) {
    for (const char* key : {"order", "size", "elements_per_circle"})
      if (meshing.has(key)) meshing.refuse(key, "is for CAD parts", "a mesh file is taken as it is");
    for (const char* key : {"solid", "fuse", "heal"})
      if (geometry.has(key)) geometry.refuse(key, "is for CAD parts", "a mesh file is taken as it is");
  }

  if (in.has("shell")) {
    const Section shell = in.table("shell");
    part.sheet_thickness = shell.quantity("thickness");
    if (part.format != PartFormat::cad && part.format != PartFormat::gmsh)
      throw InputError(shell.where() +
                       ": is for CAD parts and .msh meshes; shells of a deck have their thickness there");
    if (meshing.has("order"))
      meshing.refuse("order", "is for solids; shells have three and four nodes", "leave the key out");
    if (in.flag("stiffening")) in.refuse("stiffening", "is not known of shells", "leave the key out");
  }
  if (in.has("matrices")) {
    const Section matrices = in.table("matrices");
    part.stiffness = matrices.file("stiffness");
    part.mass_matrix = matrices.file("mass");
    if (matrices.has("damping")) part.damping_matrix = matrices.file("damping");
    if (part.format == PartFormat::cad)
      geometry.refuse("file", "finished matrices go with the nodes of a mesh file or of a table (.csv)");
    if (in.flag("stiffening") || in.table("recovery").flag("stress"))
      throw InputError(in.where() +
                       ": stress modes and geometric stiffening need the elements, finished "
                       "matrices do not have them; take stress and stiffening away");
  } else if (in.has("mode_vectors")) {
    read_finished_modes(in, part);
  } else if (part.format == PartFormat::nodes) {
    geometry.refuse("file", "is a table of nodes without elements",
                    "add a table [matrices] with their K and M, or [mode_vectors]");
  }
  const bool is_deck = part.format == PartFormat::abaqus || part.format == PartFormat::nastran;
  for (const auto& [name, m] : in.table_map("material"))
    part.materials.push_back(read_material(name, m, is_deck));
  if (part.format == PartFormat::cad && part.materials.size() != 1) {
    if (part.materials.empty())
      throw InputError(in.where() +
                       ": a CAD part takes exactly one material; add the table [material.NAME] it "
                       "is made of");
    in.refuse("material", "a CAD part takes exactly one material",
              "keep the one table [material.NAME] it is made of");
  }
  for (const auto& [name, f] : in.table_map("interface")) part.interfaces.push_back(read_interface(name, f));
  for (const auto& [name, m] : in.table_map("mass_point")) part.masses.push_back(read_mass(name, m));
  for (const auto& [name, l] : in.table_map("link")) part.links.push_back(read_link(name, l));
  for (const auto& [name, l] : in.table_map("load")) {
    part.loads.push_back(read_load(name, l));
    if (part.loads.back().keep_shape && !part.finished.vectors.empty())
      l.refuse("keep_shape", "computes a shape, but the vectors are finished", "leave the key out");
  }

  if (const Section solver = in.table("solver"); solver.has("petsc")) {
    try {
      part.petsc = linalg::parse_options(solver.text("petsc"));
    } catch (const std::invalid_argument& error) {
      throw InputError(solver.where("petsc") + ": " + error.what());
    }
  }
  read_request(in, part);
  read_interface_modes(in.table("modes"), part);
  const Section recovery = in.table("recovery");
  part.recovery = read_recovery(recovery);
  if (recovery.has("groups")) {
    part.recovery.groups = recovery.texts("groups");
    part.recovery.where = recovery.where("groups");
    if (!part.recovery.groups.empty() && !part.recovery.stress)
      recovery.refuse("groups", "chooses where stress modes are kept, but there are none",
                      "add stress = true");
  }
  return part;
}

}  // namespace flexura::reduce
