// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/sdf/frames.hpp"

#include <fmt/format.h>

#include <numbers>
#include <stdexcept>

#include "import/xml/values.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::sdf {

Pose pose_in(const xml::Node& element, Findings& findings) {
  const xml::Node* const pose = element.child("pose");
  if (pose == nullptr || pose->text.empty()) return {};
  const auto x = xml::parse_numbers(pose->text);
  const bool quaternion = pose->get("rotation_format") == "quat_xyzw";
  if (!x || x->size() != (quaternion ? 7U : 6U)) {
    xml::fault(findings, *pose,
               fmt::format("<pose> of <{}> is \"{}\", {} finite numbers are wanted; correct it",
                           shown(element.tag), shown(pose->text), quaternion ? 7 : 6));
    return {};
  }
  Pose X;
  X.p = {(*x)[0], (*x)[1], (*x)[2]};
  if (quaternion) {
    const double q[4] = {(*x)[6], (*x)[3], (*x)[4], (*x)[5]};
    if (Eigen::Vector4d(q[0], q[1], q[2], q[3]).norm() > 0.0)
      X.R = mbs::rotation_of_quaternion(q);
    else
      xml::fault(findings, *pose, "the quaternion of <pose> has no length; correct it");
    return X;
  }
  const double unit =
      pose->get("degrees") == "true" || pose->get("degrees") == "1" ? std::numbers::pi / 180.0 : 1.0;
  X.R = mbs::rotation_exp({0.0, 0.0, unit * (*x)[5]}) * mbs::rotation_exp({0.0, unit * (*x)[4], 0.0}) *
        mbs::rotation_exp({unit * (*x)[3], 0.0, 0.0});
  return X;
}

const Frames::Frame* Frames::find(const std::string& name) const {
  const auto found = frames_.find(name);
  return found == frames_.end() ? nullptr : &found->second;
}

Pose Frames::in(const std::string& name, const std::string& base, int depth) const {
  constexpr int deepest = 1000;
  if (name == base) return {};
  const Frame* const frame = find(name);
  if (frame == nullptr)
    throw std::invalid_argument(fmt::format("frame \"{}\" is not there; correct the name", shown(name)));
  if (depth > deepest)
    throw std::invalid_argument(
        fmt::format("frame \"{}\" is given in itself, directly or by way of others; give it in another one",
                    shown(name)));
  const Pose X = in(frame->parent, base, depth + 1) * frame->X;
  return frame->placed.empty() ? X : X * in(frame->placed, name, depth + 1).inverse();
}

}  // namespace flexura::import::sdf
