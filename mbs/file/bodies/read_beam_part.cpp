// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/read_beam_part.hpp"

#include <fmt/format.h>

#include <algorithm>
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
      "A prismatic beam, for every fidelity. Its ends are the "
      "markers root and "
      "tip. The section is given by a material and a shape (diameter, or width and height), by its constants "
      "(of a rod "
      "without EA and GA; of a cable EA and mass_per_length are enough), or by its 6 x 6 matrices.";
  schema.keys = {
      vector3("from", dim::length, "the root in the body's frame").or_default("[0, 0, 0]"),
      vector3("to", dim::length,
              "the tip in the body's frame (of a curved beam, where it would be were the beam straight)")
          .required(),
      vector3("y_axis", dim::none, "direction of the section's y axis (its width), in the body's frame")
          .or_default("[0, 1, 0]"),
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
      matrix("stiffness",
             "6 x 6, of N, V_y, V_z, T, M_y, M_z against their strains, in N, N m, N m^2: with all "
             "couplings, as flexura "
             "section prints it"),
      matrix("mass",
             "6 x 6, of u_x, u_y, u_z, theta_x, theta_y, theta_z, in kg/m, kg, kg m; beside stiffness"),
      flag("planar",
           "it bends in the plane of its axis and y_axis alone, and is rigid across it: half the coordinates "
           "and a third of the time or less; for the fidelities beam, rod, cable and ancf. Of the section's "
           "constants EA, "
           "GA_y, EI_z, mass_per_length and rho_I_z are then enough (of a rod EI_z, rho_I_z and the mass, of "
           "a cable EA and the mass; of ancf, whose planar element of eight coordinates neither shears nor "
           "has rotary "
           "inertia, EA, EI_z and the mass)")
          .or_default("false"),
      vector3("curvature", Dimension{{-1, 0, 0, 0}},
              "of the stress-free axis: its twist, and its curvature about the section's y and z, the same "
              "all along; for "
              "the fidelities beam, rod and cable")
          .or_default("[0, 0, 0]"),
      quantity("damping_time", dim::time, "internal damping: stress = C (strain + damping_time * its rate)")
          .or_default("0 s")
          .at_least(0.0),
      table_map("point", point, "further places for markers"),
  };
  return schema;
}

namespace {

Eigen::MatrixXd matrix6(const Section& s, const std::string& key) {
  const Eigen::MatrixXd matrix = s.matrix(key);
  if (matrix.rows() != 6 || matrix.cols() != 6)
    s.refuse(key, fmt::format("is {} x {}", matrix.rows(), matrix.cols()), "write the 6 x 6 of a section");
  return matrix;
}

void take(const beam::SectionInertia& inertia, BeamPart& part) {
  part.mass_per_length = inertia.m;
  part.rho_I_y = inertia.m_zz;
  part.rho_I_z = inertia.m_yy;
  part.m_y = inertia.m_y;
  part.m_z = inertia.m_z;
  part.m_yz = inertia.m_yz;
}

constexpr const char* kConstants[] = {"EA",      "GA_y",   "GA_z", "GI_t", "EI_y", "EI_z", "mass_per_length",
                                      "rho_I_y", "rho_I_z"};
constexpr const char* kAcrossThePlane[] = {"GA_z", "GI_t", "EI_y", "rho_I_y"};
constexpr const char* kShape[] = {"young", "density", "diameter", "inner_diameter", "width", "height"};
constexpr const char* kMatrices[] = {"stiffness", "mass"};

template <std::size_t n>
const char* first_given(const Section& s, const char* const (&keys)[n]) {
  for (const char* const key : keys)
    if (s.has(key)) return key;
  return nullptr;
}

void read_constants(const Section& s, const BeamUse& use, BeamPart& part) {
  const auto ignored = [&](const std::string& key) {
    return std::ranges::find(use.ignores, key) != use.ignores.end() ||
           (part.is_planar && (std::ranges::find(kAcrossThePlane, key) != std::end(kAcrossThePlane) ||
                               std::ranges::find(use.ignores_in_plane, key) != use.ignores_in_plane.end()));
  };
  // Across its plane a planar beam is rigid: any positive number stands for that.
  const double across = part.is_planar ? 1.0 : 0.0;
  for (const char* const key : kConstants)
    if (!s.has(key) && !ignored(key))
      s.refuse("", fmt::format("has no {}", key), "give all constants of the section");
  const auto value = [&](const char* key, double otherwise) {
    return s.has(key) ? s.quantity(key) : otherwise;
  };
  part.mass_per_length = s.quantity("mass_per_length");
  // Of a thread, so that it has no axis about which nothing turns.
  const double thread = part.mass_per_length * 1e-6 * part.length() * part.length();
  part.C = Vector6d(value("EA", 1.0), value("GA_y", 1.0), value("GA_z", 1.0), value("GI_t", 1.0),
                    value("EI_y", across), value("EI_z", 0.0))
               .asDiagonal();
  part.rho_I_y = value("rho_I_y", thread);
  part.rho_I_z = value("rho_I_z", thread);
}

void read_shape(const Section& s, BeamPart& part) {
  for (const char* const key : {"young", "density"})
    if (!s.has(key))
      s.refuse("", fmt::format("has no {}", key), "give a material and a shape, or the section's constants");
  const bool round = s.has("diameter"), rectangle = s.has("width") && s.has("height");
  if (rectangle && s.has("inner_diameter"))
    s.refuse("inner_diameter", "is of a round section", "give a diameter in place of width and height");
  if (round == rectangle)
    s.refuse("", round ? "has a diameter and a width" : "has no shape of its section",
             "give diameter, or width and height");
  const beam::Material material =
      beam::isotropic("material", s.quantity("young"), s.quantity("poisson"), s.quantity("density"));
  beam::Shape shape = beam::Rectangle{};
  if (!round)
    shape = beam::Rectangle{s.quantity("width"), s.quantity("height")};
  else if (s.has("inner_diameter"))
    shape = beam::HollowCircle{s.quantity("diameter"), s.quantity("inner_diameter")};
  else
    shape = beam::Circle{s.quantity("diameter")};
  const beam::Section section = beam::make_section("section", shape, material);
  part.C = section.stiffness();
  take(section.inertia, part);
}

}  // namespace

BeamPart read_beam_part(const Section& s, const BeamUse& use) {
  BeamPart part;
  part.from_B = s.vector3("from");
  part.to_B = s.vector3("to");
  part.y_axis_B = s.vector3("y_axis");
  part.elements = s.integer("elements");
  part.damping_time = s.quantity("damping_time");
  part.curvature = s.vector3("curvature");
  if (!part.curvature.isZero(0.0) && !use.may_be_curved)
    s.refuse("curvature", "this fidelity has straight beams alone", "use fidelity = \"beam\"");
  part.is_planar = s.flag("planar");
  if (part.is_planar && !use.may_be_planar)
    s.refuse("planar", "this fidelity has beams in space alone",
             "use fidelity = \"beam\", \"rod\", \"cable\" or \"ancf\", or take planar away");
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

  const char *constant = first_given(s, kConstants), *of_shape = first_given(s, kShape),
             *of_matrix = first_given(s, kMatrices);
  if (const char* const other = of_shape ? of_shape : of_matrix; constant && other)
    s.refuse(constant, fmt::format("stands beside {}", other),
             of_shape ? "give the section by a material and a shape or by its constants, not by both"
                      : "give the section by its constants or by its matrices, not by both");
  if (of_shape && of_matrix)
    s.refuse(of_shape, fmt::format("stands beside {}", of_matrix),
             "give the section by a material and a shape or by its matrices, not by both");
  try {
    if (of_matrix) {
      for (const char* const key : kMatrices)
        if (!s.has(key)) s.refuse("", fmt::format("has no {}", key), "give both matrices of the section");
      const beam::Section section =
          beam::matrix_section("section", matrix6(s, "stiffness"), matrix6(s, "mass"));
      part.C = section.stiffness();
      take(section.inertia, part);
    } else if (constant) {
      read_constants(s, use, part);
    } else {
      read_shape(s, part);
    }
  } catch (const std::invalid_argument& error) {
    s.refuse("", error.what());
  }
  return part;
}

}  // namespace flexura::mbs
