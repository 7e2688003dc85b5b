// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "import/sdf/reader.hpp"
#include "import/xml/values.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::sdf {
namespace {

using tree::JointKind;
using xml::Node;

constexpr double kStopFrequency_hz = 20.0, kStopDampingRatio = 0.3;  // as of URDF

double number_in(const Node* parent, const char* tag, double otherwise, Findings& findings) {
  const Node* const child = parent == nullptr ? nullptr : parent->child(tag);
  if (child == nullptr || child->text.empty()) return otherwise;
  if (const auto value = xml::parse_number(child->text)) return *value;
  // The largest of double, and "inf", stand for no limit.
  if (xml::is_unbounded(child->text)) return otherwise;
  xml::fault(findings, *child,
             fmt::format("<{}> is \"{}\", a finite number is wanted; correct it", tag, shown(child->text)));
  return otherwise;
}

class JointReader {
 public:
  JointReader(const Source& source, const World& world, const std::map<std::string, int>& number,
              const std::vector<Pose>& X_WL, tree::Tree& tree, Findings& findings)
      : e_(*source.element),
        source_(source),
        world_(world),
        number_(number),
        X_WL_(X_WL),
        tree_(tree),
        findings_(findings) {}

  std::vector<tree::Joint> read() {
    const std::string type = e_.get("type");
    static const std::map<std::string, JointKind> kinds = {
        {"revolute", JointKind::revolute},   {"continuous", JointKind::revolute},
        {"prismatic", JointKind::prismatic}, {"ball", JointKind::spherical},
        {"fixed", JointKind::fixed},         {"screw", JointKind::screw},
        {"revolute2", JointKind::revolute},  {"universal", JointKind::revolute},
        {"gearbox", JointKind::fixed}};
    const auto kind = kinds.find(type);
    if (kind == kinds.end()) {
      xml::fault(
          findings_, e_,
          fmt::format("joint \"{}\" is of type \"{}\"; write revolute, continuous, revolute2, universal, "
                      "prismatic, ball, screw, gearbox or fixed",
                      shown(source_.name), shown(type)));
      return {};
    }
    const auto parent = end("parent"), child = end("child");
    if (!parent || !child || type == "gearbox") return {};
    if (*parent == *child) {
      xml::fault(findings_, e_,
                 fmt::format("joint \"{}\" joins a link to itself; correct <parent> or <child>",
                             shown(source_.name)));
      return {};
    }
    parent_ = *parent;
    child_ = *child;
    try {
      X_WJ_ = world_.frames.in_world("joint " + source_.name);
    } catch (const std::invalid_argument& why) {
      xml::fault(findings_, e_, fmt::format("joint \"{}\": {}", shown(source_.name), why.what()));
      return {};
    }
    std::vector<tree::Joint> joints;
    if (type == "revolute2" || type == "universal") {
      const int between = static_cast<int>(tree_.links.size());
      tree_.links.push_back(
          {.name = source_.name + "_cross", .comments = {"between the two axes of a joint"}});
      joints.push_back(joint(kind->second, e_.child("axis"), Vector3d::UnitX(), parent_, between, "_1"));
      joints.push_back(joint(kind->second, e_.child("axis2"), Vector3d::UnitY(), between, child_, "_2"));
    } else {
      joints.push_back(joint(kind->second, e_.child("axis"), Vector3d::UnitZ(), parent_, child_, ""));
    }
    if (type == "continuous") joints.back().lower = joints.back().upper = std::nullopt;
    return joints;
  }

 private:
  std::optional<int> end(const char* tag) {
    const Node* const e = e_.child(tag);
    const Node* const named = e != nullptr && e->child("link") != nullptr ? e->child("link") : e;
    const std::string name = named == nullptr ? "" : named->text.empty() ? named->get("link") : named->text;
    if (name.empty()) {
      xml::fault(findings_, e_, fmt::format("joint \"{}\" has no <{}>; give it", shown(source_.name), tag));
      return {};
    }
    const std::string link = world_.link_of(name, source_.scope);
    if (link == "world") return -1;
    const auto found = number_.find(link);
    if (found == number_.end()) {
      xml::fault(
          findings_, *e,
          fmt::format("the {} of joint \"{}\" is \"{}\", which the file does not have; correct the name", tag,
                      shown(source_.name), shown(name)));
      return {};
    }
    return found->second;
  }

  Pose X_W(int link) const { return link < 0 ? Pose{} : X_WL_[static_cast<std::size_t>(link)]; }

  // Up to 1.4 in the model's axes, later in the joint's, the model's again where use_parent_model_frame or expressed_in say so.
  Vector3d axis_in_world(const Node* axis, const Vector3d& otherwise) {
    const Node* const xyz = axis == nullptr ? nullptr : axis->child("xyz");
    Vector3d a = otherwise;
    if (xyz != nullptr && !xyz->text.empty()) {
      const auto x = xml::parse_numbers(xyz->text);
      if (x && x->size() == 3 && Vector3d((*x)[0], (*x)[1], (*x)[2]).norm() > 0.0)
        a = Vector3d((*x)[0], (*x)[1], (*x)[2]).normalized();
      else
        xml::fault(
            findings_, *xyz,
            fmt::format(
                "the axis of joint \"{}\" is \"{}\", three numbers with a direction are wanted; correct it",
                shown(source_.name), shown(xyz->text)));
    }
    const std::string in = xyz == nullptr ? "" : xyz->get("expressed_in");
    const Node* const by_model = axis == nullptr ? nullptr : axis->child("use_parent_model_frame");
    try {
      if (!in.empty()) {
        const std::string frame = world_.resolve(in, source_.scope);
        if (frame.empty())
          throw std::invalid_argument(fmt::format("frame \"{}\" is not there; correct the name", shown(in)));
        return world_.frames.in_world(frame).R * a;
      }
      const bool model =
          by_model != nullptr ? by_model->text == "1" || by_model->text == "true" : source_.version < 1.45;
      if (model && !source_.scope.empty()) return world_.frames.in_world(source_.scope + "__model__").R * a;
    } catch (const std::invalid_argument& why) {
      xml::fault(findings_, e_, fmt::format("joint \"{}\": {}", shown(source_.name), why.what()));
    }
    return X_WJ_.R * a;
  }

  tree::Joint joint(JointKind kind, const Node* axis, const Vector3d& otherwise, int parent, int child,
                    const char* behind) {
    tree::Joint joint{.name = source_.name + behind,
                      .line = *e_.file == findings_.file() ? e_.line : 0,
                      .kind = kind,
                      .parent = parent,
                      .child = child};
    Pose X_WM = X_WJ_;
    if (joint.has_one_coordinate()) X_WM.R = mbs::frame_along(axis_in_world(axis, otherwise));
    // The link between two axes has the child's frame.
    const auto in_link = [&](int link) {
      return X_W(static_cast<std::size_t>(link) < X_WL_.size() || link < 0 ? link : child_).inverse() * X_WM;
    };
    joint.X_PF = in_link(parent);
    joint.X_CM = in_link(child);
    if (kind == JointKind::screw) joint.pitch = pitch();
    if (joint.has_one_coordinate() || kind == JointKind::spherical) read_axis(axis, joint);
    return joint;
  }

  // thread_pitch counts turns [rad] per metre of a left-handed thread, screw_thread_pitch metres in a turn.
  double pitch() {
    if (e_.child("screw_thread_pitch") != nullptr)
      return not_zero(number_in(&e_, "screw_thread_pitch", 1.0, findings_));
    return -2.0 * std::numbers::pi / not_zero(number_in(&e_, "thread_pitch", 1.0, findings_));
  }
  double not_zero(double pitch) {
    if (pitch != 0.0) return pitch;
    xml::fault(findings_, e_,
               fmt::format("the thread pitch of joint \"{}\" is 0; give it, or make the joint revolute",
                           shown(source_.name)));
    return 1.0;
  }

  void read_axis(const Node* axis, tree::Joint& joint) {
    const Node* const dynamics = axis == nullptr ? nullptr : axis->child("dynamics");
    joint.damping = number_in(dynamics, "damping", 0.0, findings_);
    joint.friction = number_in(dynamics, "friction", 0.0, findings_);
    joint.stiffness = number_in(dynamics, "spring_stiffness", 0.0, findings_);
    joint.rest = number_in(dynamics, "spring_reference", 0.0, findings_);
    for (const auto& [value, name] : {std::pair(&joint.damping, "damping"), {&joint.friction, "friction"}})
      if (*value < 0.0) {
        xml::fault(findings_, *dynamics,
                   fmt::format("{} of joint \"{}\" is {}, it cannot be negative; correct it", name,
                               shown(source_.name), *value));
        *value = 0.0;
      }
    const Node* const limit = axis == nullptr ? nullptr : axis->child("limit");
    if (limit == nullptr || !joint.has_one_coordinate()) return;
    constexpr double none = 1e15;  // the format writes 1e16 for no limit
    double lower = number_in(limit, "lower", -1e16, findings_),
           upper = number_in(limit, "upper", 1e16, findings_);
    if (lower > upper) {
      xml::repair(findings_, *limit, "limits that are reversed",
                  fmt::format("joint \"{}\": lower {} is above upper {}; they are exchanged",
                              shown(source_.name), lower, upper));
      std::swap(lower, upper);
    }
    if (lower == upper && lower == 0.0) {
      xml::note(
          findings_, *limit, "joints that limits lock",
          fmt::format("joint \"{}\" has equal limits, {}: it is fixed here", shown(source_.name), lower));
      joint.kind = JointKind::fixed;
      return;
    }
    if (lower > -none) joint.lower = lower;
    if (upper < none) joint.upper = upper;
    if (lower == upper) joint.upper = std::nextafter(lower, lower + 1.0);
    joint.stop_frequency = 2.0 * std::numbers::pi * kStopFrequency_hz;
    joint.stop_damping_ratio = kStopDampingRatio;
    for (const auto& [tag, what] : {std::pair("effort", "effort"), {"velocity", "speed"}})
      if (const double most = number_in(limit, tag, -1.0, findings_); most > 0.0 && most < none)
        joint.comments.push_back(
            fmt::format("the file's greatest {}, {}, is no law of the joint and not enforced", what, most));
  }

  const Node& e_;
  const Source& source_;
  const World& world_;
  const std::map<std::string, int>& number_;
  const std::vector<Pose>& X_WL_;
  tree::Tree& tree_;
  Findings& findings_;
  int parent_ = -1, child_ = -1;
  Pose X_WJ_;
};

}  // namespace

std::vector<tree::Joint> read_joint(const Source& source, const World& world,
                                    const std::map<std::string, int>& number, const std::vector<Pose>& X_WL,
                                    tree::Tree& tree, Findings& findings) {
  return JointReader(source, world, number, X_WL, tree, findings).read();
}

std::vector<Coupling> read_couplings(const World& world, const tree::Tree& tree,
                                     const std::map<std::string, int>& number, Findings& findings) {
  std::vector<Coupling> couplings;
  const auto joint_called = [&](const std::string& name) {
    const auto found = std::ranges::find(tree.joints, name, &tree::Joint::name);
    return found != tree.joints.end() && found->has_one_coordinate()
               ? static_cast<int>(found - tree.joints.begin())
               : -1;
  };
  const auto link = [&](const Source& s, const char* tag) {
    const Node* const e = s.element->child(tag);
    const auto found = number.find(e == nullptr ? "" : world.link_of(e->text, s.scope));
    return found == number.end() ? -1 : found->second;
  };
  // The turn of `outer` against `inner` by their joint: (joint, sign).
  const auto turn = [&](int inner, int outer) -> std::pair<int, double> {
    for (std::size_t j = 0; j < tree.joints.size(); ++j) {
      const tree::Joint& joint = tree.joints[j];
      if (!joint.has_one_coordinate()) continue;
      if (joint.parent == inner && joint.child == outer) return {static_cast<int>(j), 1.0};
      if (joint.parent == outer && joint.child == inner) return {static_cast<int>(j), -1.0};
    }
    return {-1, 0.0};
  };
  for (const Source& s : world.joints) {
    const Node& e = *s.element;
    if (e.get("type") == "gearbox") {
      // theta_2 = -ratio theta_1 of child and parent against the reference body.
      const int reference = link(s, "gearbox_reference_body");
      const auto first = turn(reference, link(s, "parent")), second = turn(reference, link(s, "child"));
      const double ratio = number_in(&e, "gearbox_ratio", 1.0, findings);
      if (first.first < 0 || second.first < 0)
        xml::fault(findings, e,
                   fmt::format("gearbox \"{}\": parent and child must be joined to <gearbox_reference_body> "
                               "by joints of one "
                               "axis; correct the names",
                               shown(s.name)));
      else
        couplings.push_back(
            {s.name, {{second.first, second.second}, {first.first, ratio * first.second}}, 0.0});
    }
    for (const char* tag : {"axis", "axis2"}) {
      const Node* const axis = e.child(tag);
      const Node* const mimic = axis == nullptr ? nullptr : axis->child("mimic");
      if (mimic == nullptr) continue;
      const bool two = e.get("type") == "revolute2" || e.get("type") == "universal";
      const int self = joint_called(s.name + (!two ? "" : std::string(tag) == "axis" ? "_1" : "_2"));
      const int leader = joint_called(s.scope + mimic->get("joint"));
      if (self < 0 || leader < 0) {
        xml::fault(findings, *mimic,
                   fmt::format("joint \"{}\" mimics \"{}\": both must be joints of one axis", shown(s.name),
                               shown(mimic->get("joint"))));
        continue;
      }
      const double m = number_in(mimic, "multiplier", 1.0, findings);
      couplings.push_back(
          {s.name + "_mimic",
           {{self, 1.0}, {leader, -m}},
           number_in(mimic, "offset", 0.0, findings) - m * number_in(mimic, "reference", 0.0, findings)});
    }
  }
  return couplings;
}

}  // namespace flexura::import::sdf
