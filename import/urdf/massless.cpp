// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/massless.hpp"

#include <fmt/format.h>

#include "import/urdf/at_start.hpp"

namespace flexura::import::urdf {
namespace {

// Of the smallest inertia that a joint moves, or of what this one moves with those before it: it changes their motion by less
// than integrators do.
constexpr double kPlaceholder = 1e-9;

class Treatment {
 public:
  Treatment(Robot& robot, const Choices& choices, Drawer& drawer, Findings& findings)
      : robot_(robot), choices_(choices), drawer_(drawer), findings_(findings), tried_(robot.links.size()) {
    below_.resize(robot.links.size());
    for (const int j : robot.order) below_[static_cast<std::size_t>(joint(j).parent)].push_back(j);
  }

  void run(std::vector<double>& q) {
    for (;;) {
      std::vector<Idle> idle = idle_joints(robot_, q);
      const bool by_mimic = idle.empty();
      if (by_mimic) idle = idle_joints(robot_, q, true);
      if (idle.empty()) return;
      bool derived = false;
      if (choices_.massless == Massless::derive)
        for (const Idle& one : idle) derived = derive_for(one) || derived;
      if (derived) continue;
      const StartMass start = start_mass(robot_, q);
      for (const Idle& one : idle) by_mimic ? stand_in(one, start) : settle(one, start, q);
      if (choices_.massless == Massless::refuse) return;
    }
  }

 private:
  Joint& joint(int j) { return robot_.joints[static_cast<std::size_t>(j)]; }

  // The links that the joint moves as one body; where these have inertia or no shapes, those between it and the joints before.
  bool derive_for(const Idle& idle) {
    for (int at = idle.joint; at >= 0; at = parent_joint(at)) {
      if (joint(at).kind == JointKind::fixed) continue;
      if (derive(joint(at).child)) return true;
      if (idle.moves_nothing) return false;
    }
    return false;
  }

  int parent_joint(int j) { return robot_.links[static_cast<std::size_t>(joint(j).parent)].parent_joint; }

  bool derive(int first) {
    bool done = false;
    std::vector<int> body = {first};
    for (std::size_t i = 0; i < body.size(); ++i) {
      const auto l = static_cast<std::size_t>(body[i]);
      for (const int j : below_[l])
        if (joint(j).kind == JointKind::fixed) body.push_back(joint(j).child);
      if (tried_[l]) continue;
      tried_[l] = true;
      done = derive_link(robot_.links[l]) || done;
    }
    return done;
  }

  bool derive_link(Link& link) {
    if (link.inertial && !link.inertial->inertia.isZero(0.0)) return false;
    const char* what = "collision shapes";
    MassProperties shape = drawer_.filled(link.collisions);
    if (!(shape.mass > 0.0)) {
      shape = drawer_.filled(link.visuals);
      what = "pictures";
    }
    if (!(shape.mass > 0.0)) return false;
    const bool has_mass = link.inertial && link.inertial->mass > 0.0;
    const double density = has_mass ? link.inertial->mass / shape.mass : choices_.density;
    shape.mass *= density;
    shape.inertia *= density;
    // A mass with its centre is kept; the moments alone are the shapes'.
    if (has_mass) shape.center = link.inertial->center;
    link.inertial = shape;
    findings_.repair(
        "links with the inertia of their shapes",
        has_mass ? fmt::format("link \"{}\" has no moments of inertia: taken are those of its {} with its "
                               "mass, {:.6g} kg",
                               shown(link.name), what, shape.mass)
                 : fmt::format("link \"{}\" has no inertia: taken is that of its {} with {:.6g} kg/m^3, "
                               "{:.6g} kg (--density, --massless)",
                               shown(link.name), what, density, shape.mass),
        link.line);
    return true;
  }

  void settle(const Idle& idle, const StartMass& start, std::vector<double>& q) {
    Joint& j = joint(idle.joint);
    const std::string what = fmt::format(
        "joint \"{}\" {}", shown(j.name),
        idle.moves_nothing ? "moves links without inertia"
                           : "moves links that have no inertia apart from the joints before it, at the "
                             "start position");
    if (choices_.massless == Massless::refuse)
      return findings_.fault(
          fmt::format("{}, so its acceleration would be anything; give the links behind it "
                      "<inertial>, or make the joint fixed",
                      what),
          j.line);
    if (!idle.moves_nothing && has_one_coordinate(j)) {
      findings_.repair("joints that are fixed since they move nothing apart",
                       fmt::format("{}: it is fixed at its start", what), j.line);
      return fix(j, q[static_cast<std::size_t>(idle.joint)]);
    }
    findings_.repair("joints that are driven since they move no inertia",
                     fmt::format("{}: it is driven, and stays at its start until its drive says otherwise "
                                 "(--massless)",
                                 what),
                     j.line);
    j.is_driven = true;
    stand_in(idle, start);
  }

  // The motion of a joint that is driven or mimics is prescribed, but the mass matrix of all coordinates must have an inverse.
  void stand_in(const Idle& idle, const StartMass& start) {
    const Joint& j = joint(idle.joint);
    double H = 0.0;
    for (std::size_t i = 0; i < start.joint_of.size(); ++i) {
      const double carried = start.H(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i));
      if (idle.moves_nothing
              ? carried > 1e-13 * start.size[static_cast<Eigen::Index>(i)] && (H == 0.0 || carried < H)
              : start.joint_of[i] == idle.joint)
        H = carried;
    }
    // What moves with the joints before it must differ from what moves with this one: the link between.
    Link& at = robot_.links[static_cast<std::size_t>(idle.moves_nothing ? j.child : j.parent)];
    std::optional<MassProperties>& link = at.inertial;
    const double small = kPlaceholder * (H > 0.0 ? H : 1.0);
    const MassProperties stand_in{.mass = small, .inertia = small * Matrix3d::Identity()};
    link = link ? *link + stand_in : stand_in;
    findings_.note("links with an inertia so that the equations can be solved",
                   fmt::format("link \"{}\" gets {:.3g} kg and {:.3g} kg m^2, which move nothing: joint "
                               "\"{}\" has no inertia to move",
                               shown(at.name), small, small, shown(j.name)),
                   at.line);
  }

  Robot& robot_;
  const Choices& choices_;
  Drawer& drawer_;
  Findings& findings_;
  std::vector<std::vector<int>> below_;  ///< joints behind each link
  std::vector<bool> tried_;
};

}  // namespace

void treat_massless(Robot& robot, std::vector<double>& q, const Choices& choices, Drawer& drawer,
                    Findings& findings) {
  Treatment(robot, choices, drawer, findings).run(q);
}

}  // namespace flexura::import::urdf
