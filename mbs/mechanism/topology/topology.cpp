// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/topology/topology.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>
#include <stdexcept>

namespace flexura::mbs {

Topology::Topology(MechanismDescription description) : d(std::move(description)) {
  build_tree();
  number_states();
}

void Topology::build_tree() {
  const int n_bodies = static_cast<int>(d.bodies.size());
  for (int b = 1; b < n_bodies; ++b) {
    BodyDescription& body = d.bodies[b];
    if (body.flexible && (!body.flexible->acts_back() || body.flexible->m() == 0))
      body.inertia = body.flexible->undeformed_inertia();  // as it moves
    const double mass = body.flexible ? body.flexible->mass() : body.inertia.mass;
    if (mass < 0.0)
      throw std::invalid_argument(
          fmt::format("body \"{}\" has the mass {} kg; a mass must not be negative", body.name, mass));
  }
  for (const JointDescription& joint : d.joints) {
    const int a = d.markers.at(joint.marker_F).body, b = d.markers.at(joint.marker_M).body;
    if (a == b)
      throw std::invalid_argument(fmt::format(
          "joint \"{}\" goes from \"{}\" to \"{}\", two markers of one body; a joint joins two bodies",
          joint.name, d.markers[joint.marker_F].name, d.markers[joint.marker_M].name));
  }
  grow_tree();
  if (split_branches()) grow_tree();
  on_node.assign(d.markers.size(), false);
  is_carried = on_node;
  for (std::size_t i = 0; i < d.markers.size(); ++i) {
    const FlexibleBody* const flexible = d.bodies[d.markers[i].body].flexible.get();
    on_node[i] = d.markers[i].node >= 0 && flexible;
    is_carried[i] = on_node[i] && flexible->acts_back();
  }
  markers_of_body.assign(n_bodies, {});
  for (std::size_t i = 0; i < d.markers.size(); ++i)
    markers_of_body[d.markers[i].body].push_back(static_cast<int>(i));
}

void Topology::grow_tree() {
  const int n_bodies = static_cast<int>(d.bodies.size());
  order.clear();
  bodies.assign(n_bodies, {});
  std::vector<bool> reached(n_bodies, false), used(d.joints.size(), false);
  reached[0] = true;
  std::vector<int> queue{0};

  // Breadth first in the order of the file, except that a driven or coupled joint (or connection) is taken as soon as one
  // of its bodies is reached, since the coordinate of a state counts turns, then one whose coordinate the user set or that
  // must not be cut, then one along which forces act: angles of joints that close loops are known within +-pi only.
  enum Priority { ordinary, loaded, set, wanted };
  std::vector<Priority> priority(d.joints.size(), ordinary);
  for (const auto& force : d.forces)
    for (const CoordinateRef& c : force->coordinates()) priority[c.joint] = loaded;
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    if (!d.joints[j].initial_coordinates.empty() || d.joints[j].keep_in_tree) priority[j] = set;
    if (d.joints[j].is_driven()) priority[j] = wanted;
  }
  for (const auto& constraint : d.constraints)
    for (const CoordinateRef& c : constraint->coordinates()) priority[c.joint] = wanted;
  const auto next_joint = [&](Priority level, int body) {
    for (std::size_t j = 0; j < d.joints.size(); ++j) {
      const JointDescription& joint = d.joints[j];
      if (used[j] || joint.cut || priority[j] != level) continue;
      if (joint.is_connection && level != wanted) continue;
      const int f = d.markers[joint.marker_F].body, m = d.markers[joint.marker_M].body;
      if (reached[f] == reached[m]) continue;
      if (body >= 0 && f != body && m != body) continue;
      return static_cast<int>(j);
    }
    return -1;
  };
  const auto take = [&](int j) {
    const int f = d.markers[d.joints[j].marker_F].body, m = d.markers[d.joints[j].marker_M].body;
    const bool reversed = !reached[f];
    const int outer = reversed ? f : m;
    used[j] = reached[outer] = true;
    place_joint(outer, j, reversed);
    queue.push_back(outer);
  };
  // Joints lead where they can; where they end, the connection with the fewest freedoms leads on.
  const auto next_connection = [&] {
    int best = -1;
    for (std::size_t j = 0; j < d.joints.size(); ++j) {
      const JointDescription& joint = d.joints[j];
      if (used[j] || !joint.is_connection) continue;
      if (reached[d.markers[joint.marker_F].body] == reached[d.markers[joint.marker_M].body]) continue;
      if (best < 0 || joint.joint->n_v() < d.joints[best].joint->n_v()) best = static_cast<int>(j);
    }
    return best;
  };
  const auto follow_joints = [&] {
    for (std::size_t k = 0; k < queue.size(); ++k) {
      while (true) {
        int j = next_joint(wanted, -1);
        if (j < 0) j = next_joint(set, -1);
        if (j < 0) j = next_joint(loaded, -1);
        if (j < 0) j = next_joint(ordinary, queue[k]);
        if (j < 0) break;
        take(j);
      }
    }
  };
  const auto sweep = [&] {
    follow_joints();
    for (int j = next_connection(); j >= 0; j = next_connection()) {
      take(j);
      follow_joints();
    }
  };
  sweep();
  // Bodies that no joint leads to float free: the first of each such group gets six freedoms to ground.
  for (int b = 1; b < n_bodies; ++b) {
    if (reached[b]) continue;
    const int F = d.add_marker(0, "origin_of_" + d.bodies[b].name, {});
    const int M = d.add_marker(b, "frame", {});
    const int j = d.add_joint(d.bodies[b].name, "six_dof", F, M);
    used.push_back(false);
    priority.push_back(ordinary);
    take(j);
    sweep();
  }
  // What drives or couples a joint that closes a loop acts on the coordinate that its frames have, of which angles do not
  // count turns: one of them is taken for the turn that fits, two would fit at more than one.
  for (const auto& constraint : d.constraints) {
    std::set<int> without_turns;
    for (const CoordinateRef& c : constraint->coordinates())
      if (!used[c.joint] && d.joints[c.joint].joint->coordinates()[c.index].dimension == input::dim::angle)
        without_turns.insert(c.joint);
    if (without_turns.size() < 2) continue;
    std::vector<std::string> names;
    for (const int j : without_turns) names.push_back("\"" + d.joints[j].name + "\"");
    throw std::invalid_argument(
        fmt::format("constraint \"{}\" couples the angles of {}, joints that close loops, whose frames do "
                    "not tell whole turns; of at "
                    "most one joint that may be so: close the loops at other joints (cut = true there), or "
                    "take away drives and "
                    "couplings of theirs",
                    constraint->name(), fmt::join(names, " and ")));
  }

  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    const JointDescription& joint = d.joints[j];
    if (used[j] || joint.is_connection || (joint.initial_coordinates.empty() && joint.initial_speeds.empty()))
      continue;
    throw std::invalid_argument(fmt::format(
        "joint \"{}\" closes a loop, so its coordinate and speed follow from those of the other joints; take "
        "its initial values away, or {}",
        joint.name, joint.cut ? "its cut = true" : "cut another joint of the loop with cut = true"));
  }
}

void Topology::place_joint(int body, int joint, bool reversed) {
  const JointDescription& j = d.joints[joint];
  TreeBody& t = bodies[body];
  t.joint = joint;
  t.reversed = reversed;
  t.marker_in = reversed ? j.marker_M : j.marker_F;
  t.marker_out = reversed ? j.marker_F : j.marker_M;
  t.parent = d.markers[t.marker_in].body;
  order.push_back(body);
}

void Topology::number_states() {
  places.resize(d.joints.size());
  for (std::size_t j = 0; j < d.joints.size(); ++j)
    places[j] = {d.joints[j].joint.get(), d.joints[j].marker_F, d.joints[j].marker_M};
  for (int b : order) {
    TreeBody& body = bodies[b];
    JointPlace& place = places[body.joint];
    place.i_p = n_p;
    place.i_v = n_v;
    n_p += place.joint->n_p();
    n_v += place.joint->n_v();
    body.i_p = n_p;
    body.i_v = n_v;
    const FlexibleBody* const flexible = d.bodies[b].flexible.get();
    body.n_need = flexible ? flexible->m() : 0;
    body.m = flexible && flexible->acts_back() ? body.n_need : 0;
    body.i_need = body.i_v;
    n_p += body.m;
    n_v += body.m;
    n_flx += body.m;
  }
  n_need = n_v;
  for (int b : order)
    if (TreeBody& body = bodies[b]; body.n_need > body.m) {
      body.i_need = n_need;
      n_need += body.n_need;
    }
  for (const auto& control : d.controls) n_own += control->n_states();
  for (const auto& force : d.forces) n_own += force->n_states();
  n_dyn = n_own;
  for (int b : order)
    if (TreeBody& body = bodies[b]; body.n_need > body.m) {
      body.i_c = n_dyn;
      n_dyn += 2 * body.n_need;
    }
}

bool Topology::is_reversed(int joint) const {
  for (int b : order)
    if (bodies[b].joint == joint) return bodies[b].reversed;
  return false;
}

}  // namespace flexura::mbs
