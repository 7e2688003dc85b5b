// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/beam_part.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "beam/section/shapes.hpp"
#include "mbs/model/ancf_part.hpp"
#include "mbs/model/forces/types.hpp"

namespace flexura::mbs {
namespace {

using input::Section;

/// Mass, centre and inertia of the piece of the axis from x_1 to x_2 about the point p_B, in axes parallel to
/// B.
RigidInertia piece(const BeamPart& part, double x_1, double x_2, const Vector3d& p_B) {
  const Matrix3d R = part.R_BE();
  const double l = x_2 - x_1, m = part.mass_per_length * l, across = m * l * l / 12.0;
  const Matrix3d I =
      Vector3d((part.rho_I_y + part.rho_I_z) * l, across + part.rho_I_y * l, across + part.rho_I_z * l)
          .asDiagonal();
  const Vector3d center = part.from_B + 0.5 * (x_1 + x_2) * R.col(0) - p_B;
  return RigidInertia::from_center(m, center, R * I * R.transpose());
}

}  // namespace

Matrix3d BeamPart::R_BE() const {
  const Vector3d axis = to_B - from_B;
  if (!(axis.norm() > 0.0))
    throw std::invalid_argument("the beam's two ends are the same point; give it a length");
  Matrix3d R;
  R.col(0) = axis.normalized();
  const Vector3d y = y_axis_B - R.col(0) * R.col(0).dot(y_axis_B);
  if (!(y.norm() > 1e-6 * y_axis_B.norm()))
    throw std::invalid_argument("the beam's y axis lies along the beam; give another direction");
  R.col(1) = y.normalized();
  R.col(2) = R.col(0).cross(R.col(1));
  return R;
}

std::vector<std::pair<std::string, Vector3d>> BeamPart::stations() const {
  const Vector3d axis = R_BE().col(0);
  std::vector<std::pair<std::string, Vector3d>> out = {{"root", from_B}, {"tip", to_B}};
  for (const auto& [name, x] : points) out.emplace_back(name, from_B + x * axis);
  return out;
}

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

RigidInertia rigid_inertia(const BeamPart& part) {
  return piece(part, 0.0, part.length(), Vector3d::Zero());
}

std::shared_ptr<const FlexibleBody> ancf_body(const BeamPart& part) {
  beam::ancf::BeamSection section;
  section.C = part.C;
  section.m = part.mass_per_length;
  section.m_zz = part.rho_I_y;
  section.m_yy = part.rho_I_z;
  section.damping_time = part.damping_time;
  return straight_ancf_part(section, part.from_B, part.to_B, part.R_BE().col(1), part.elements, part.points);
}

int Segments::piece_at(const Vector3d& p_B) const {
  const double x = axis_B.dot(p_B - root_B) / element_length;
  return std::clamp(static_cast<int>(std::lround(x)), 0, static_cast<int>(bodies.size()) - 1);
}

Segments add_segments(MechanismDescription& d, int root, const BeamPart& part) {
  const int n = part.elements;
  const double L = part.length(), l = L / n;
  const Matrix3d R = part.R_BE();
  const Matrix6d f = part.C.inverse();
  Matrix6d D = Matrix6d::Zero();
  D(4, 2) = 1.0;
  D(5, 1) = -1.0;
  const Matrix6d F = l * f + l * l * l / 12.0 * D.transpose() * f * D;
  Matrix6d K = F.inverse();
  K = (0.5 * (K + K.transpose())).eval();

  const std::string name = d.bodies[root].name;
  Segments out;
  out.root_B = part.from_B;
  out.axis_B = R.col(0);
  out.element_length = l;
  for (int k = 0; k <= n; ++k) {
    // The first piece keeps the body's own frame; the others have theirs at their nodes.
    const Vector3d node = part.from_B + k * l * R.col(0), origin = k == 0 ? Vector3d::Zero() : node;
    const RigidInertia inertia =
        piece(part, std::max(0.0, (k - 0.5) * l), std::min(L, (k + 0.5) * l), origin);
    out.origins_B.push_back(origin);
    if (k == 0) {
      d.bodies[root].inertia = inertia;
      out.bodies.push_back(root);
      continue;
    }
    const int before = out.bodies.back();
    const int body = d.add_body({.name = fmt::format("{}.{}", name, k), .inertia = inertia});
    out.bodies.push_back(body);
    const Vector3d middle = part.from_B + (k - 0.5) * l * R.col(0);
    const int F_marker =
        d.add_marker(before, fmt::format("joint_{}_from", k), {R, middle - out.origins_B[k - 1]});
    const int M_marker = d.add_marker(body, fmt::format("joint_{}_to", k), {R, middle - origin});
    // In the tree, where what moves the pieces apart is a coordinate: a loop closes elsewhere.
    out.joints.push_back(d.add_joint(fmt::format("{}.joint_{}", name, k), "six_dof", F_marker, M_marker));
    d.joints.back().keep_in_tree = true;
    d.forces.push_back(
        make_bushing(fmt::format("{}.spring_{}", name, k), F_marker, M_marker, K, part.damping_time * K));
  }
  return out;
}

}  // namespace flexura::mbs
