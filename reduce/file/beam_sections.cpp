// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/beam_sections.hpp"

#include <fmt/format.h>

#include "reduce/file/section_result.hpp"

namespace flexura::reduce {

using input::InputError;
using input::Section;
using input::TableSchema;
namespace dim = input::dim;

namespace {

constexpr input::Dimension kStaticMoment{{3, 0, 0, 0}};

beam::Matrix6d matrix6(const Section& in, const std::string& key) {
  const Eigen::MatrixXd matrix = in.matrix(key);
  if (matrix.rows() != 6 || matrix.cols() != 6)
    in.refuse(key, fmt::format("is {} x {}; write the 6 x 6 of a section", matrix.rows(), matrix.cols()));
  return matrix;
}

}  // namespace

TableSchema beam_material_schema() {
  TableSchema s{.name = "material", .doc = "An isotropic linear elastic material."};
  s.keys = {
      input::quantity("young", dim::pressure, "Young's modulus").required().above(0),
      input::quantity("poisson", dim::none, "Poisson's ratio").above(-1).below(0.5),
      input::quantity("shear", dim::pressure, "shear modulus, instead of Poisson's ratio").above(0),
      input::quantity("density", dim::density, "mass per volume").required().at_least(0),
  };
  return s;
}

TableSchema beam_section_schema() {
  TableSchema s{
      .name = "section",
      .doc = "A cross-section: x along the member, y its width, z its height. The numbers are SIMBEAM's."};
  s.selector = "type";
  s.keys = {
      input::choice("type",
                    {"circle", "hollow_circle", "rectangle", "hollow_rectangle", "ellipse", "hollow_ellipse",
                     "basic", "advanced", "matrix", "file"},
                    "1, 2, 4, 5, 6, 7: standard shapes; 10 General Basic; 11 General Advanced; 12 Matrix "
                    "Input; file: what `flexura section` wrote")
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

beam::Material read_beam_material(const std::string& name, const Section& in) {
  if (in.has("poisson") == in.has("shear"))
    throw InputError(fmt::format("{}: give either `poisson` or `shear`", in.where()));
  const double E = in.quantity("young"), rho = in.quantity("density");
  if (in.has("shear")) return {name, E, in.quantity("shear"), rho};
  return beam::isotropic(name, E, in.quantity("poisson"), rho);
}

beam::SectionEntry read_beam_section(const std::string& name, const Section& in,
                                     const std::vector<beam::Material>& materials,
                                     const Names& material_names) {
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
      entry.section = read_section_result(name, in.file("file"), &entry.outline_stress);
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

}  // namespace flexura::reduce
