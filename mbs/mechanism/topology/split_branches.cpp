// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <set>

#include "mbs/mechanism/topology/topology.hpp"

/// Long branches of flexible bodies.  In the coordinates of a tree every body's equations hold those of all
/// bodies inboard of it: the matrices of a chain of n bodies with m modes are full, and factors cost (n m)^3.
/// A joint that stands as a constraint parts them: each body then knows its neighbours alone, and factors
/// cost n m^3.  Measured on chains with 20 modes (tests/benchmarks/run chains): as fast at five bodies, twice
/// at seven, seven times at fourteen.
namespace flexura::mbs {
namespace {

constexpr int kMostBodies = 5;  // modal ones behind one another
constexpr int kMostModes = 100;

}  // namespace

/// Marks joints that are to stand as constraints; true where there is one.  Joints whose coordinates anything
/// sets, drives, loads or reads keep them: as constraints these would not count turns.
bool Topology::split_branches() {
  // Coordinates of small deformations: dense matrices are all that couples them.
  const auto is_linear = [&](int b) {
    const FlexibleBody* const flexible = d.bodies[b].flexible.get();
    return flexible && flexible->acts_back() && flexible->is_linear();
  };
  std::vector<int> bodies_before(bodies.size(), 0), modes_before(bodies.size(), 0);
  bool is_long = false;
  for (const int b : order) {
    const int parent = bodies[b].parent;
    bodies_before[b] = bodies_before[parent] + is_linear(b);
    modes_before[b] = modes_before[parent] + (is_linear(b) ? d.bodies[b].flexible->m() : 0);
    is_long = is_long || (bodies_before[b] > kMostBodies && modes_before[b] > kMostModes);
  }
  if (!is_long) return false;

  std::set<int> wanted;
  for (const auto& constraint : d.constraints)
    for (const CoordinateRef& c : constraint->coordinates()) wanted.insert(c.joint);
  for (const auto& force : d.forces)
    for (const CoordinateRef& c : force->coordinates()) wanted.insert(c.joint);
  // The names of all coordinates are there for formulas; what counts is whether one reads them.
  std::set<int> read;
  const auto note = [&](const std::vector<int>& signals) { read.insert(signals.begin(), signals.end()); };
  for (const auto& force : d.forces) note(force->reads());
  for (const auto& control : d.controls) note(control->reads());
  for (const auto& measure : d.measures) note(measure->reads());
  const auto is_free = [&](int j) {
    const JointDescription& joint = d.joints[j];
    if (joint.keep_in_tree || joint.is_driven() || wanted.contains(j) || joint.joint->n_rows() == 0 ||
        !joint.initial_coordinates.empty() || !joint.initial_speeds.empty())
      return false;
    const auto is_read = [&](const CoordinateInfo& c) {
      return read.contains(d.signals.find(joint.name + "." + c.name));
    };
    return std::ranges::none_of(joint.joint->coordinates(), is_read) &&
           std::ranges::none_of(joint.joint->speeds(), is_read);
  };
  // Between a flexible body and the next one inboard: the joint nearest to the outer one that may go.
  whole_order = order;
  split_joint.assign(bodies.size(), -1);
  bool any = false;
  for (const int b : order) {
    if (!is_linear(b)) continue;
    int begins = -1;  // the branch, with this body
    for (int k = b; k != 0; k = bodies[k].parent) {
      if (k != b && is_linear(k)) break;
      if (split_joint[k] >= 0) {
        begins = -1;
        break;
      }
      if (begins < 0 && is_free(bodies[k].joint)) begins = k;
      if (bodies[k].parent == 0) begins = -1;  // no flexible body inboard
    }
    if (begins < 0) continue;
    const int j = bodies[begins].joint;
    split_joint[begins] = j;
    d.joints[j].cut = d.joints[j].splits = true;
    any = true;
  }
  if (!any) whole_order.clear();
  return any;
}

}  // namespace flexura::mbs
