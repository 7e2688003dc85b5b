// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "import/mjcf/sections.hpp"
#include "import/xml/values.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::mjcf {
namespace {

using tree::JointKind;

std::size_t coordinates(const tree::Joint& joint) {
  return joint.kind == JointKind::free        ? 7U
         : joint.kind == JointKind::spherical ? 4U
                                              : static_cast<std::size_t>(joint.freedoms());
}

// Values of one keyframe in the order of the joints: qpos; and qvel, whose turns MuJoCo has in the axes of the child.
class KeyWriter {
 public:
  KeyWriter(const Scene& scene, const tree::Writer& writer) : tree_(scene.tree), writer_(writer) {}

  std::string values(const std::vector<double>& q, const std::vector<double>& v) {
    std::size_t at = 0, at_v = 0;
    for (std::size_t j = 0; j < tree_.joints.size(); ++j) {
      const tree::Joint& joint = tree_.joints[j];
      name_ = writer_.joint(static_cast<int>(j));
      if (joint.has_one_coordinate()) {
        if (!q.empty()) put(joint.turns() ? "angle" : "position", q[at]);
        if (!v.empty()) put("speed", v[at_v]);
      } else if (joint.freedoms() > 0) {
        const bool slides = joint.kind == JointKind::free;
        const std::size_t turn = at + (slides ? 3 : 0), turn_v = at_v + (slides ? 3 : 0);
        for (std::size_t k = 0; slides && k < 3; ++k) {
          if (!q.empty()) put(std::string(1, "xyz"[k]), q[at + k]);
          if (!v.empty()) put(std::string("v_") + "xyz"[k], v[at_v + k]);
        }
        const Matrix3d R = q.empty() ? joint.X_FM.R : mbs::rotation_of_quaternion(&q[turn]);
        for (std::size_t k = 0; !q.empty() && k < 4; ++k) put(std::string("q") + "wxyz"[k], q[turn + k]);
        if (!v.empty()) {
          const Vector3d w = R * Vector3d(v[turn_v], v[turn_v + 1], v[turn_v + 2]);
          for (int k = 0; k < 3; ++k) put(std::string("omega_") + "xyz"[k], w[k]);
        }
      }
      at += coordinates(joint);
      at_v += static_cast<std::size_t>(joint.freedoms());
    }
    return "{ " + text_ + " }";
  }

 private:
  void put(const std::string& what, double value) {
    text_ += fmt::format("{}\"{}.{}\" = {}", text_.empty() ? "" : ", ", name_, what, toml(value));
  }

  const tree::Tree& tree_;
  const tree::Writer& writer_;
  std::string name_, text_;
};

}  // namespace

void add_keyframes(const Scene& scene, tree::Writer& writer, Findings& findings) {
  const Model& model = *scene.scopes.front().model;
  std::size_t n_q = 0, n_v = 0;
  for (const tree::Joint& joint : scene.tree.joints) {
    n_q += coordinates(joint);
    n_v += static_cast<std::size_t>(joint.freedoms());
  }
  for (const Node* section : model.sections("keyframe"))
    for (const Node* key : section->all("key")) {
      const std::vector<double> q = xml::numbers(*key, "qpos", findings),
                                v = xml::numbers(*key, "qvel", findings);
      const std::string name = key->get("name", "key");
      if ((!q.empty() && q.size() != n_q) || (!v.empty() && v.size() != n_v)) {
        xml::note(findings, *key, "keyframes left out",
                  fmt::format(
                      "keyframe \"{}\" has {} positions and {} speeds, the bodies {} and {}: it is left out",
                      shown(name), q.size(), v.size(), n_q, n_v));
        continue;
      }
      for (const char* other : {"act", "ctrl", "mpos", "mquat"})
        if (key->has(other))
          xml::note(findings, *key, "values of keyframes left out",
                    fmt::format("of keyframe \"{}\" {} is left out: a state holds positions and speeds",
                                shown(name), other));
      if (q.empty() && v.empty()) continue;
      std::vector<Line> lines = {{"values", KeyWriter(scene, writer).values(q, v)}};
      if (const double t = xml::number(*key, "time", 0.0, findings); t != 0.0)
        lines.emplace_back("time", toml(t));
      writer.add("state", name, {"keyframe \"" + shown(name) + "\""}, lines);
    }
}

}  // namespace flexura::import::mjcf
