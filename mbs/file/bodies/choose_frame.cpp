// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/choose_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mbs/file/fidelities.hpp"

namespace flexura::mbs {
namespace {

/// Why the joint gives no boundary condition that holds at all times (SP's conditions: the node has the
/// directions that the joint locks, and these stand still in the body); empty where it gives one.
std::string cannot_hold(const superelement::Superelement& se, const BodyNodes& nodes,
                        const MechanismDescription& d, const JointDescription& joint, int body) {
  if (!locks_the_same_wherever_it_is(d, joint, body))
    return fmt::format("what joint \"{}\" locks does not stand still in the body as it moves", joint.name);
  if (!keeps(se, nodes, d, joint, body))
    return fmt::format("joint \"{}\" locks a direction that \"{}\" does not keep", joint.name,
                       nodes[d.markers[marker_on(d, joint, body)].node].name);
  return "";
}

}  // namespace

std::string choose_frame(const input::Section& s, const superelement::Superelement& se,
                         const BodyNodes& nodes, const std::vector<BodyNode>& linked,
                         const MechanismDescription& d, int body, BasisOptions& options,
                         std::vector<std::string>& notes) {
  const std::string& name = d.bodies[body].name;
  const Fidelity::OfSuperelement& fidelity = *fidelity_of(s).of_superelement;
  // What a single joint holds vibrates as held there; the motion cannot tell a deformation so that does not act back.
  const auto joints = std::ranges::count_if(
      d.joints, [&](const JointDescription& joint) { return marker_on(d, joint, body) >= 0; });
  const bool held_by_one = fidelity.held_by_joints && joints == 1 && frame_joint(d, body) != nullptr;
  const std::string frame = s.has("frame")                          ? s.text("frame")
                            : held_by_one                           ? "joint_fixed"
                            : fidelity.held_by_joints && joints > 1 ? "joints"
                                                                    : "mean_axis";
  // What a rigid link joins moves as one piece however far it turns only where it is at rest in the frame:
  // displacements that are linear in the modes leave a turned piece by second order.
  const auto link = std::ranges::find_if(linked, [](const BodyNode& node) { return node.ties.cols() > 0; });
  if (link != linked.end() && frame == "mean_axis" && !s.has("frame")) {
    options.frame = node_loads(*link);
    notes.push_back(
        fmt::format("body \"{}\": the rigid link of marker \"{}\" gives the frame", name, link->name));
  }
  const bool joint_fixed = frame == "joint_fixed";
  if (frame == "joints") {
    options.frame = held_by_joints(se, nodes, d, body);
    const bool is_held = options.frame.cols() > 0,
               is_free = s.has("boundary") && s.text("boundary") == "free";
    if (!is_free) options.held = options.frame;
    if (!is_held && s.has("frame"))
      s.refuse("frame", "no joint of this body sits on an interface and locks a direction",
               "let joints' markers stand on interfaces (on = \"INTERFACE\"), or take this key away");
    if (is_held)
      notes.push_back(fmt::format("body \"{}\": its joints hold the frame{} in {} directions", name,
                                  is_free ? "" : " and the eigenmodes", options.frame.cols()));
  }
  const bool is_asked = joint_fixed || s.has("boundary");
  std::string boundary = frame == "joints"   ? "free"  // held above, or asked for
                         : s.has("boundary") ? s.text("boundary")
                         : joint_fixed || frame_joint(d, body) != nullptr ? "joint"
                                                                          : "free";
  std::string of_the_boundary;
  if (joint_fixed || boundary == "joint") {
    const JointDescription* joint = frame_joint(d, body);
    const std::string key = joint_fixed ? "frame" : "boundary";
    if (!joint)
      s.refuse(key, "no joint sits on an interface of this body",
               "let a joint's marker stand on an interface (on = \"INTERFACE\"), or take this key away");
    const MarkerDescription& marker = d.markers[marker_on(d, *joint, body)];
    const int node = marker.node;
    if (boundary == "joint") {
      options.held = held_directions(nodes, d, *joint, body);
      if (const std::string reason = cannot_hold(se, nodes, d, *joint, body); !reason.empty()) {
        if (s.has("boundary"))
          s.refuse("boundary", reason, "write boundary = \"free\", or take the key away");
        of_the_boundary =
            fmt::format("body \"{}\": {}: its eigenmodes are those of the free body", name, reason);
        boundary = "free";
        options.held.resize(se.n(), 0);
      }
    }
    if (joint_fixed && node < static_cast<int>(se.interfaces.size()))
      options.fixed_interface = node;
    else if (joint_fixed)
      options.frame = node_loads(nodes[node]);
    if (boundary == "joint" || joint_fixed) {
      if (!of_the_boundary.empty()) notes.push_back(std::exchange(of_the_boundary, ""));
      of_the_boundary = fmt::format(
          "body \"{}\": joint \"{}\" on {} \"{}\" gives {}", name, joint->name,
          node < static_cast<int>(se.interfaces.size()) ? "interface" : "marker", nodes[node].name,
          joint_fixed && boundary == "joint" ? "the frame and the eigenmodes' boundary condition"
          : joint_fixed                      ? "the frame"
                                             : "the eigenmodes' boundary condition");
    }
    if (is_asked) notes.push_back(std::exchange(of_the_boundary, ""));
  }
  return of_the_boundary;
}

}  // namespace flexura::mbs
