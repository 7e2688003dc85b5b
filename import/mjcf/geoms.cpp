// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/geoms.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "import/mjcf/meshes.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::mjcf {
namespace {

using Kind = tree::Solid::Kind;

std::string color_of(const Node& geom) {
  const auto rgba = xml::parse_numbers(geom.get("rgba"));
  if (!rgba || rgba->size() < 3) return {};
  const auto byte = [&](std::size_t k) {
    return static_cast<int>(255.0 * std::clamp((*rgba)[k], 0.0, 1.0) + 0.5);
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(0), byte(1), byte(2));
}

const std::map<std::string, Kind>& solids() {
  static const std::map<std::string, Kind> kinds = {{"sphere", Kind::sphere},
                                                    {"capsule", Kind::capsule},
                                                    {"cylinder", Kind::cylinder},
                                                    {"ellipsoid", Kind::ellipsoid},
                                                    {"box", Kind::box}};
  return kinds;
}

// Sizes as the file gives them; with fromto the half length is that of the line.
tree::Solid solid_of(const Node& geom, const Model& model, Kind kind, Findings& findings) {
  tree::Solid solid{.kind = kind, .X_LS = pose_of(geom, model.compiler, findings)};
  std::vector<double> size = xml::numbers(geom, "size", findings);
  const bool is_long = kind == Kind::capsule || kind == Kind::cylinder;
  if (geom.has("fromto") && kind != Kind::sphere) {
    const std::vector<double> ends = xml::numbers(geom, "fromto", findings);
    if (ends.size() == 6) {
      const Vector3d a(ends[0], ends[1], ends[2]), b(ends[3], ends[4], ends[5]);
      const double half = 0.5 * (b - a).norm();
      if (!(half > 0.0))
        xml::fault(findings, geom, fmt::format("fromto of <geom> has two equal points; correct them"));
      solid.X_LS.p = 0.5 * (a + b);
      if (half > 0.0)
        solid.X_LS.R = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), a - b).toRotationMatrix();
      size.resize(3, 0.0);
      if (is_long)
        size[1] = half;
      else
        size = {size[0], size[0], half};
    } else {
      xml::fault(findings, geom,
                 fmt::format("fromto of <geom> has {} numbers, 6 are wanted; correct it", ends.size()));
    }
  }
  const std::size_t wanted = kind == Kind::sphere ? 1 : is_long ? 2 : 3;
  bool positive = size.size() >= wanted;
  size.resize(3, 0.0);
  for (std::size_t k = 0; k < wanted; ++k) positive = positive && size[k] > 0.0;
  if (!positive)
    xml::fault(findings, geom,
               fmt::format("size of <geom> is \"{}\", a {} has {} positive numbers; correct it",
                           shown(geom.get("size")), geom.get("type", "sphere"), wanted));
  solid.size = {size[0], size[1], size[2]};
  solid.color = color_of(geom);
  return solid;
}

// mass, else density.
tree::Inertial weighed(const Node& geom, tree::Inertial unit, Findings& findings) {
  const bool by_mass = geom.has("mass");
  const double value =
      by_mass ? xml::number(geom, "mass", 0.0, findings) : xml::number(geom, "density", 1000.0, findings);
  if (value < 0.0)
    xml::fault(findings, geom,
               fmt::format("{} of <geom> is {}, it cannot be negative; correct it",
                           by_mass ? "mass" : "density", value));
  const double factor = !by_mass ? value : unit.mass > 0.0 ? value / unit.mass : 0.0;
  unit.mass *= factor;
  unit.inertia *= factor;
  return unit;
}

bool is_massless(const Node& geom) {
  return xml::parse_number(geom.get("mass", geom.get("density", "1"))) == 0.0;
}

}  // namespace

Geom read_geom(const Node& geom, const Model& model, Findings& findings) {
  Geom result;
  const std::string mesh = geom.get("mesh");
  result.kind = geom.get("type", mesh.empty() ? "sphere" : "mesh");
  if (result.kind == "plane" || result.kind == "hfield") return result;
  const auto solid = solids().find(result.kind);
  if (mesh.empty() && solid != solids().end()) {
    result.solid = solid_of(geom, model, solid->second, findings);
    if (xml::flag(geom, "shellinertia", false, findings) && !is_massless(geom))
      result.open = "shellinertia of simple shapes is not read";
    result.inertial = weighed(geom, tree::uniform(*result.solid, 1.0), findings);
    return result;
  }
  if (result.kind == "sdf") {
    if (!is_massless(geom)) result.open = "the volume of a geom of the type sdf is computed by a plugin";
    return result;
  }
  if (result.kind != "mesh" && solid == solids().end()) {
    xml::fault(
        findings, geom,
        fmt::format("<geom> is of the type \"{}\"; write sphere, capsule, cylinder, ellipsoid, box, mesh, "
                    "plane or hfield",
                    shown(result.kind)));
    return result;
  }
  const auto found = model.meshes.find(mesh);
  try {
    if (found == model.meshes.end())
      throw std::invalid_argument(fmt::format("there is no <mesh> \"{}\"; name one of <asset>", shown(mesh)));
    if (result.kind != "mesh")
      throw std::invalid_argument(
          fmt::format("a {} that is fitted to a mesh is not read; give it a size, or the body an <inertial>",
                      result.kind));
    result.solid = tree::Solid{.kind = Kind::surface,
                               .X_LS = pose_of(geom, model.compiler, findings),
                               .surface = read_mesh(found->second, model),
                               .color = color_of(geom)};
    std::string rule = found->second.get("inertia", "legacy");
    if (xml::flag(geom, "shellinertia", false, findings)) rule = "shell";
    result.inertial =
        weighed(geom, mesh_inertial(result.solid->surface, rule, 1.0).in(result.solid->X_LS), findings);
    if (!(result.inertial.mass > 0.0) && !is_massless(geom))
      throw std::invalid_argument(fmt::format("mesh \"{}\" encloses no volume", shown(mesh)));
  } catch (const std::invalid_argument& why) {
    if (!is_massless(geom)) result.open = why.what();
  }
  return result;
}

tree::Inertial read_inertial(const Node& e, const Compiler& compiler, Findings& findings) {
  tree::Inertial own;
  own.mass = xml::number(e, "mass", 0.0, findings);
  if (own.mass < 0.0) {
    xml::fault(findings, e,
               fmt::format("mass of <inertial> is {}, it cannot be negative; correct it", own.mass));
    own.mass = 0.0;
  }
  if (e.has("fullinertia")) {
    std::vector<double> I = xml::numbers(e, "fullinertia", findings);
    if (I.size() != 6) {
      xml::fault(findings, e, fmt::format("fullinertia has {} numbers, 6 are wanted; correct it", I.size()));
      I.assign(6, 0.0);
    }
    own.inertia << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
  } else {
    own.inertia = xml::vector(e, "diaginertia", Vector3d::Zero(), findings).asDiagonal();
  }
  if (!is_inertia(own.inertia)) {
    const auto moments = [](const Matrix3d& I) {
      const Vector3d m = Eigen::SelfAdjointEigenSolver<Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
      return fmt::format("{:.6g}, {:.6g}, {:.6g}", m[0], m[1], m[2]);
    };
    const Matrix3d given = own.inertia;
    // The compiler's own repair makes a ball of it.
    if (compiler.balance_inertia)
      own.inertia = given.trace() / 3.0 * Matrix3d::Identity();
    else if (given.trace() > 0.0)
      own.inertia = nearest_inertia(given);
    else
      xml::fault(findings, e,
                 fmt::format("the principal moments {} kg m^2 are those of no body, and their sum is not "
                             "positive; correct them",
                             moments(given)));
    if (given.trace() > 0.0)
      xml::repair(findings, e, "inertias of no body",
                  fmt::format("the principal moments {} kg m^2 are those of no body; "
                              "taken are {}",
                              moments(given), moments(own.inertia)));
  }
  return own.in(pose_of(e, compiler, findings));
}

void bound(tree::Inertial& inertial, const Compiler& compiler) {
  inertial.mass = std::max(inertial.mass, compiler.least_mass);
  if (!(compiler.least_inertia > 0.0)) return;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(inertial.inertia);
  const Vector3d moments = solver.eigenvalues().cwiseMax(compiler.least_inertia);
  inertial.inertia = solver.eigenvectors() * moments.asDiagonal() * solver.eigenvectors().transpose();
}

}  // namespace flexura::import::mjcf
