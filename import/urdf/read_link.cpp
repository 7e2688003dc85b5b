// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "import/urdf/read_elements.hpp"
#include "import/urdf/xml.hpp"

namespace flexura::import::urdf {
namespace {

std::string moments_text(const Matrix3d& I) {
  const Vector3d m = Eigen::SelfAdjointEigenSolver<Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
  return fmt::format("{:.6g}, {:.6g}, {:.6g} kg m^2", m[0], m[1], m[2]);
}

Matrix3d read_inertia(const Element& e, const std::string& link, Findings& findings) {
  Matrix3d I;
  const auto at = [&](const char* name) {
    return findings.kept([&] { return name[1] == name[2] ? e.number(name) : e.number(name, 0.0); });
  };
  const double xx = at("ixx"), yy = at("iyy"), zz = at("izz"), xy = at("ixy"), xz = at("ixz"), yz = at("iyz");
  if (!e.has("ixy") || !e.has("ixz") || !e.has("iyz"))
    findings.note("links with products of inertia that are not given",
                  fmt::format("link \"{}\": products of inertia that are not given are taken as 0", link),
                  e.line());
  I << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  if (is_inertia(I)) return I;
  const std::string what = fmt::format(
      "the inertia of link \"{}\" has the principal moments {}, which no body has", link, moments_text(I));
  try {
    const Matrix3d near = nearest_inertia(I);
    findings.repair("inertias that no body has",
                    fmt::format("{}; taken are the nearest that one has, {}: check signs, units and that it "
                                "is about the centre of mass",
                                what, moments_text(near)),
                    e.line());
    return near;
  } catch (const std::invalid_argument& why) {
    findings.fault(fmt::format("{}, and {}", what, why.what()), e.line());
    return Matrix3d::Zero();
  }
}

std::optional<MassProperties> read_inertial(const Element& e, const std::string& link, Findings& findings) {
  const auto mass = e.child("mass");
  auto inertia = e.child("inertia");
  constexpr const char* moments[] = {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"};
  if (inertia && std::ranges::none_of(moments, [&](const char* name) { return inertia->has(name); }))
    inertia.reset();
  if (!mass && !inertia) {
    findings.note("links whose <inertial> is empty",
                  fmt::format("<inertial> of link \"{}\" holds neither mass nor inertia", link), e.line());
    return {};
  }
  const Pose X = findings.kept([&] { return e.origin(); });
  MassProperties result{.center = X.p};
  if (mass) {
    result.mass = findings.kept([&] { return mass->number("value"); });
    if (result.mass < 0.0)
      findings.fault(
          fmt::format("the mass of link \"{}\" is {}, it cannot be negative; correct it", link, result.mass),
          mass->line());
  }
  if (inertia) {
    result.inertia = X.R * read_inertia(*inertia, link, findings) * X.R.transpose();
  } else if (result.mass > 0.0) {
    findings.repair("masses without an inertia",
                    fmt::format("<inertial> of link \"{}\" has no <inertia>: its mass, {} kg, is taken as a "
                                "point",
                                link, result.mass),
                    e.line());
  }
  if (result.inertia.isZero(0.0) || result.mass > 0.0) return result;
  if (!mass)
    findings.fault(fmt::format("<inertial> of link \"{}\" has no <mass>; give it", link), e.line());
  else if (result.mass == 0.0)
    findings.note("moments of inertia without a mass",
                  fmt::format("link \"{}\" has moments of inertia but no mass: taken as it stands", link),
                  mass->line());
  return result;
}

/// Throws std::invalid_argument where there is nothing to be drawn.
Shape read_geometry(const Element& g, const std::string& link) {
  Shape shape;
  const auto positive = [&](const char* attribute) {
    const double x = g.number(attribute);
    if (!(x > 0.0)) g.refuse(fmt::format("{} of <{}> is {}, it must be positive", attribute, g.tag(), x));
    return x;
  };
  if (g.tag() == "box") {
    if (!g.has("size")) g.refuse("<box> has no size; give it");
    shape.size = g.vector("size", Vector3d::Ones());
    if (!(shape.size.minCoeff() > 0.0)) g.refuse("size of <box> must be three positive numbers");
  } else if (g.tag() == "cylinder" || g.tag() == "capsule") {
    shape.kind = g.tag() == "capsule" ? Shape::Kind::capsule : Shape::Kind::cylinder;
    shape.radius = positive("radius");
    shape.length = positive("length");
  } else if (g.tag() == "sphere") {
    shape.kind = Shape::Kind::sphere;
    shape.radius = positive("radius");
  } else if (g.tag() == "mesh") {
    shape.kind = Shape::Kind::mesh;
    shape.mesh = g.text("filename");
    if (const char* one = "scale"; g.has(one)) {
      const auto factor = parse_number(g.text(one));
      shape.size = factor ? Vector3d::Constant(*factor) : g.vector(one, Vector3d::Ones());
    }
    if (!(shape.size.cwiseAbs().minCoeff() > 0.0)) g.refuse("scale of <mesh> must not be zero");
  } else {
    g.refuse(
        fmt::format("<{}> of link \"{}\" is no shape of a URDF; box, cylinder, sphere, capsule and mesh "
                    "are",
                    shown(g.tag()), link));
  }
  return shape;
}

void read_shapes(const Element& e, const char* tag, const std::string& link, std::vector<Shape>& shapes,
                 Colors& colors, Findings& findings) {
  for (const Element& one : e.children(tag)) {
    const auto geometry = one.children("geometry");
    const auto kinds = geometry.empty() ? std::vector<Element>{} : geometry.front().children();
    if (kinds.empty()) {
      findings.note("shapes without a geometry",
                    fmt::format("link \"{}\" without a <{}> that has no <geometry>", link, tag), one.line());
      continue;
    }
    if (kinds.size() > 1)
      findings.note(
          "shapes with several geometries",
          fmt::format("<{}> of link \"{}\" has {} geometries: the first is taken", tag, link, kinds.size()),
          one.line());
    try {
      Shape shape = read_geometry(kinds.front(), link);
      shape.X_LS = one.origin();
      const auto materials = one.children("material");
      if (materials.size() > 1)
        findings.note("colours given twice",
                      fmt::format("a <{}> of link \"{}\" has {} materials: the first is taken", tag, link,
                                  materials.size()),
                      one.line());
      if (!materials.empty()) {
        const Element& material = materials.front();
        Colors own;
        note_color(material, material.has("name") ? colors : own, findings);
        const std::string name = material.has("name") ? material.text("name") : "";
        if (!own.empty()) shape.color = own.begin()->second;
        if (const auto known = colors.find(name); known != colors.end()) shape.color = known->second;
      }
      shapes.push_back(std::move(shape));
    } catch (const std::invalid_argument& why) {
      findings.note("shapes that cannot be drawn",
                    fmt::format("link \"{}\" without a <{}>: {}", link, tag, why.what()));
    }
  }
}

}  // namespace

void note_color(const Element& material, Colors& colors, Findings& findings) {
  const std::string name = material.has("name") ? material.text("name") : "";
  if (name.empty()) findings.note("colours without a name", "a <material> has no name", material.line());
  const auto list = material.children("color");
  if (list.empty() || !list.front().has("rgba")) return;
  // Four numbers of 0 .. 1, or three.
  const std::string rgba = list.front().text("rgba");
  int c[3] = {};
  std::size_t at = 0;
  for (int& x : c) {
    at = rgba.find_first_not_of(" \t\r\n,", at);
    if (at == std::string::npos) return;
    const std::size_t end = std::min(rgba.find_first_of(" \t\r\n,", at), rgba.size());
    const auto value = parse_number(std::string_view(rgba).substr(at, end - at));
    if (!value) return;
    x = static_cast<int>(255.0 * std::clamp(*value, 0.0, 1.0) + 0.5);
    at = end;
  }
  colors[name] = fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
}

Link read_link(const Element& e, Colors& colors, Findings& findings) {
  Link link;
  link.name = findings.kept([&] { return e.text("name"); });
  link.line = e.line();
  const std::string name = shown(link.name);
  if (const auto inertial = e.child("inertial")) link.inertial = read_inertial(*inertial, name, findings);
  read_shapes(e, "visual", name, link.visuals, colors, findings);
  read_shapes(e, "collision", name, link.collisions, colors, findings);
  return link;
}

void read_touch(const Element& gazebo, Touch& touch) {
  const auto positive = [&](const char* tag, double& value) {
    const auto list = gazebo.children(tag);
    if (list.empty()) return;
    const auto x = parse_number(list.front().has("value") ? list.front().text("value") : list.front().text());
    if (x && *x >= 0.0) value = *x;
  };
  positive("mu1", touch.friction);
  positive("kp", touch.stiffness);
  positive("kd", touch.damping);
}

}  // namespace flexura::import::urdf
