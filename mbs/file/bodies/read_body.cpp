// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/read_body.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <set>

#include "mbs/file/bodies/read_flexible_body.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/mechanism/description/body_faults.hpp"

namespace flexura::mbs {

using input::Section;

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
  // A superelement or a beam may be rigid in one run and deform in another.
  const std::set<std::string> of_surfaces = {"superelement", "stress", "stress_point", "section_point"};
  if (!has_superelement)
    for (const input::Key& key : flexible_body_keys())
      if (key.name != "fidelity" && key.name != "surface_point" && s.has(key.name) &&
          (!has_beam || of_surfaces.contains(key.name)))
        given.push_back(key.name);
  if (!given.empty()) {
    std::string rule = has_superelement ? "a superelement brings its own mass, centre and inertia"
                       : has_beam ? "a beam brings its own mass, centre and inertia, and has no stresses or "
                                    "section forces of a superelement"
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
