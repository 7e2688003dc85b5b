// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/read_body.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "mbs/base/math/rotation.hpp"
#include "mbs/file/bodies/read_flexible_body.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/mechanism/description/body_faults.hpp"

namespace flexura::mbs {

using input::Section;

namespace {

Matrix3d read_rotation(const Section& s) {
  const int given = s.has("axis") + s.has("rotation") + s.has("quaternion");
  if (given > 1) s.refuse("", "has more than one of axis, rotation, quaternion", "keep one");
  if (s.has("x_axis") && !s.has("axis")) s.refuse("x_axis", "goes with axis only", "give the z axis by axis");
  if (s.has("rotation")) return rotation_exp(s.vector3("rotation"));
  if (s.has("quaternion")) {
    const Eigen::Vector4d q = s.quaternion("quaternion");
    return rotation_of_quaternion(q.data());
  }
  if (!s.has("axis")) return Matrix3d::Identity();
  const Vector3d axis = s.vector3("axis");
  if (!(axis.norm() > 0.0)) s.refuse("axis", "has no length", "write for example [0, 0, 1]");
  Matrix3d R = frame_along(axis);
  if (s.has("x_axis")) {
    const Vector3d wanted = s.vector3("x_axis");
    const Vector3d x = wanted - wanted.dot(R.col(2)) * R.col(2);
    if (!(x.norm() > 1e-9 * wanted.norm())) s.refuse("x_axis", "is parallel to axis", "turn it away");
    R.col(0) = x.normalized();
    R.col(1) = R.col(2).cross(R.col(0));
  }
  return R;
}

}  // namespace

Pose read_pose(const Section& s) {
  return {read_rotation(s), s.has("position") ? s.vector3("position") : Vector3d::Zero()};
}

std::string shapes_json(const Section& s) {
  nlohmann::json shapes = nlohmann::json::array();
  const auto list = [](const Vector3d& x) { return nlohmann::json{x.x(), x.y(), x.z()}; };
  for (const Section& shape : s.tables("shape")) {
    nlohmann::json j;
    const std::string type = shape.text("type");
    j["type"] = type;
    if (type == "cylinder") {
      const Vector3d from = shape.vector3("from"), to = shape.vector3("to");
      if (!((to - from).norm() > 0.0))
        shape.refuse("to", "is the same point as from", "give the cylinder a length");
      j["position"] = list(0.5 * (from + to));
      j["axis"] = list((to - from).normalized());
      j["length"] = (to - from).norm();
    } else {
      j["position"] = list(shape.vector3("center"));
    }
    if (type == "box") {
      j["size"] = list(shape.vector3("size"));
      j["rotation"] = {1.0, 0.0, 0.0, 0.0};
    } else {
      j["radius"] = shape.quantity("radius");
    }
    if (shape.has("color")) j["color"] = shape.text("color");
    shapes.push_back(std::move(j));
  }
  return shapes.empty() ? "" : shapes.dump();
}

void refuse_keys_of_others(const Section& s) {
  const bool has_superelement = s.has("superelement"), has_beam = s.has("beam");
  std::vector<std::string> given;
  if (has_superelement || has_beam)
    for (const char* key : {"mass", "center", "inertia"})
      if (s.has(key)) given.emplace_back(key);
  // A superelement may be rigid in one run and deform in another.
  if (!has_superelement)
    for (const input::Key& key : flexible_body_keys())
      if (key.name != "fidelity" && key.name != "surface_point" && s.has(key.name)) given.push_back(key.name);
  if (!given.empty()) {
    std::string rule =
        has_superelement ? "a superelement brings its own mass, centre and inertia"
        : has_beam ? "a beam brings its own mass, centre and inertia, and has no modes of a superelement"
                   : "a rigid body has no modes and does not deform";
    if (given.size() > 1) rule += fmt::format(" ({} are given)", fmt::join(given, ", "));
    s.refuse(given.front(), rule,
             fmt::format("{} or take {} away",
                         has_superelement ? "give no superelement"
                         : has_beam       ? "give no beam"
                                          : "give a superelement (flexura reduce)",
                         given.size() == 1 ? "it" : "them"));
  }
  if (has_superelement || has_beam || !s.has("fidelity") || s.text("fidelity") == kAutomaticFidelity) return;
  if (const Fidelity& fidelity = fidelity_of(s);
      fidelity.of_superelement && fidelity.of_superelement->deforms())
    s.refuse("fidelity", "a body of mass and inertia does not deform",
             "give a superelement (flexura reduce) or fidelity = \"rigid\"");
}

RigidInertia read_inertia(const Section& s) {
  if (!s.has("mass")) s.refuse("", "has neither mass nor superelement", "give one of them");
  const double mass = s.quantity("mass");
  Matrix3d I = Matrix3d::Zero();
  if (s.has("inertia")) {
    const std::vector<double> x = s.quantities("inertia");
    if (x.size() != 3 && x.size() != 6)
      s.refuse("inertia", fmt::format("has {} entries", x.size()),
               "write 3 (Ixx, Iyy, Izz) or 6 (and Ixy, Iyz, Izx)");
    I.diagonal() << x[0], x[1], x[2];
    if (x.size() == 6) {
      I(0, 1) = I(1, 0) = x[3];
      I(1, 2) = I(2, 1) = x[4];
      I(2, 0) = I(0, 2) = x[5];
    }
  }
  if (const auto fault = body_fault(mass, s.vector3("center"), I))
    s.refuse(fault->key, fault->rule, fault->remedy);
  return RigidInertia::from_center(mass, s.vector3("center"), I);
}

}  // namespace flexura::mbs
