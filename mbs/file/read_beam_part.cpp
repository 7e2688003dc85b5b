// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/read_beam_part.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "beam/section/shapes.hpp"

namespace flexura::mbs {

using input::Section;

input::TableSchema beam_part_schema() {
  using namespace input;
  const Dimension bending{{3, 1, -2, 0}}, rotary{{1, 1, 0, 0}};
  TableSchema point;
  point.name = "point";
  point.doc = "A place on the beam's axis that markers can sit on (on = \"NAME\").";
  point.keys = {
      quantity("at", dim::length, "distance from the root along the beam").required().at_least(0.0)};
  TableSchema schema;
  schema.name = "beam";
  schema.doc =
      "A prismatic beam, for the fidelities ancf, segments and rigid. Its ends are the markers root and tip. "
      "The section is given by a material and a shape (diameter, or width and height), or by its constants.";
  schema.keys = {
      vector3("from", dim::length, "the root in the body's frame").or_default("[0, 0, 0]"),
      vector3("to", dim::length, "the tip").required(),
      vector3("y_axis", dim::none, "direction of the section's y axis (its width)").or_default("[0, 1, 0]"),
      integer("elements", "number of elements, or of springs between segments")
          .or_default("10")
          .at_least(1)
          .at_most(500),
      quantity("young", dim::pressure, "Young's modulus").above(0.0),
      quantity("poisson", dim::none, "Poisson's ratio").or_default("0.3").above(-1.0).below(0.5),
      quantity("density", dim::density, "mass per volume").above(0.0),
      quantity("diameter", dim::length, "of a circular section").above(0.0),
      quantity("inner_diameter", dim::length, "of its hole").above(0.0),
      quantity("width", dim::length, "of a rectangular section, along y").above(0.0),
      quantity("height", dim::length, "along z").above(0.0),
      quantity("EA", dim::force, "stretch stiffness").above(0.0),
      quantity("GA_y", dim::force, "shear stiffness along y, with its shear factor").above(0.0),
      quantity("GA_z", dim::force, "along z").above(0.0),
      quantity("GI_t", bending, "torsional stiffness").above(0.0),
      quantity("EI_y", bending, "bending stiffness about y").above(0.0),
      quantity("EI_z", bending, "about z").above(0.0),
      quantity("mass_per_length", dim::linear_density, "mass per length").above(0.0),
      quantity("rho_I_y", rotary, "rotary inertia per length about y").above(0.0),
      quantity("rho_I_z", rotary, "about z").above(0.0),
      quantity("damping_time", dim::time, "internal damping: stress = C (strain + damping_time * its rate)")
          .or_default("0 s")
          .at_least(0.0),
      table_map("point", point, "further places for markers"),
  };
  return schema;
}

BeamPart read_beam_part(const Section& s) {
  BeamPart part;
  part.from_B = s.vector3("from");
  part.to_B = s.vector3("to");
  part.y_axis_B = s.vector3("y_axis");
  part.elements = s.integer("elements");
  part.damping_time = s.quantity("damping_time");
  try {
    part.R_BE();
  } catch (const std::invalid_argument& error) {
    s.refuse("", error.what());
  }
  for (const auto& [name, point] : s.table_map("point")) {
    const double x = point.quantity("at");
    if (name == "root" || name == "tip")
      point.refuse("", "is the name of an end of the beam", "choose another name");
    if (x > part.length() * (1.0 + 1e-12))
      point.refuse("at", fmt::format("lies beyond the tip at {:g} m", part.length()));
    part.points.emplace_back(name, x);
  }

  const char* constants[] = {"EA",      "GA_y",   "GA_z", "GI_t", "EI_y", "EI_z", "mass_per_length",
                             "rho_I_y", "rho_I_z"};
  const char* shape[] = {"young", "density", "diameter", "inner_diameter", "width", "height"};
  const char *a_constant = nullptr, *of_shape = nullptr;
  for (const char* key : constants)
    if (s.has(key)) a_constant = key;
  for (const char* key : shape)
    if (s.has(key)) of_shape = key;
  if (a_constant && of_shape)
    s.refuse(a_constant, fmt::format("stands beside {}", of_shape),
             "give the section by a material and a shape or by its constants, not by both");
  if (a_constant) {
    for (const char* key : constants)
      if (!s.has(key)) s.refuse("", fmt::format("has no {}", key), "give all constants of the section");
    part.C = Vector6d(s.quantity("EA"), s.quantity("GA_y"), s.quantity("GA_z"), s.quantity("GI_t"),
                      s.quantity("EI_y"), s.quantity("EI_z"))
                 .asDiagonal();
    part.mass_per_length = s.quantity("mass_per_length");
    part.rho_I_y = s.quantity("rho_I_y");
    part.rho_I_z = s.quantity("rho_I_z");
    return part;
  }
  for (const char* key : {"young", "density"})
    if (!s.has(key))
      s.refuse("", fmt::format("has no {}", key), "give a material and a shape, or the section's constants");
  const bool round = s.has("diameter"), rectangle = s.has("width") && s.has("height");
  if (round == rectangle)
    s.refuse("", round ? "has a diameter and a width" : "has no shape of its section",
             "give diameter, or width and height");
  try {
    const beam::Material material =
        beam::isotropic("material", s.quantity("young"), s.quantity("poisson"), s.quantity("density"));
    beam::Shape section_shape = beam::Rectangle{};
    if (!round)
      section_shape = beam::Rectangle{s.quantity("width"), s.quantity("height")};
    else if (s.has("inner_diameter"))
      section_shape = beam::HollowCircle{s.quantity("diameter"), s.quantity("inner_diameter")};
    else
      section_shape = beam::Circle{s.quantity("diameter")};
    const beam::Section section = beam::make_section("section", section_shape, material);
    part.C = section.stiffness();
    part.mass_per_length = section.inertia.m;
    part.rho_I_y = section.inertia.m_zz;
    part.rho_I_z = section.inertia.m_yy;
  } catch (const std::invalid_argument& error) {
    s.refuse("", error.what());
  }
  return part;
}

}  // namespace flexura::mbs
