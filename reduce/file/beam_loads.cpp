// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/beam_loads.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace flexura::reduce {

using input::InputError;
using input::Section;
namespace dim = input::dim;

namespace {

constexpr input::Dimension kLineForce = dim::stiffness, kLineMoment = dim::force;  // N/m, N m/m

beam::Vector6d pair_of(const Section& in, const char* force, const char* moment) {
  beam::Vector6d load = beam::Vector6d::Zero();
  if (in.has(force)) load.head<3>() = in.vector3(force);
  if (in.has(moment)) load.tail<3>() = in.vector3(moment);
  return load;
}

}  // namespace

input::TableSchema load_schema() {
  input::TableSchema s{.name = "load",
                       .doc =
                           "A load on a node, or spread along a member. Loads of one case act together: "
                           "`flexura reduce --statics` "
                           "shows what they do with the interfaces held, and the superelement keeps them."};
  s.keys = {
      input::text("case", "the case it belongs to; default: the load's own name"),
      input::text("node", "where a single force and moment act"),
      input::vector3("force", dim::force, "on the node, in the part's axes"),
      input::vector3("moment", dim::torque, "on the node, in the part's axes"),
      input::text("member", "instead: the member along which a load is spread"),
      input::vector3("line_force", kLineForce, "force per length at the member's first end"),
      input::vector3("line_moment", kLineMoment, "moment per length at the member's first end"),
      input::vector3("line_force_2", kLineForce,
                     "at the second end, linear between; default: as at the first"),
      input::vector3("line_moment_2", kLineMoment,
                     "at the second end, linear between; default: as at the first"),
      input::quantity("preload", dim::force,
                      "of the member: the tension that it has with both ends held, as it is too short for "
                      "its place (below zero: too "
                      "long). The structure gives way and takes a part of it"),
      input::choice("axes", {"part", "member"}, "axes of what is spread along a member").or_default("part"),
  };
  return s;
}

void read_load(const std::string& name, const Section& in, const Names& nodes, const Names& members,
               std::vector<LoadCase>& cases) {
  if (in.has("node") == in.has("member"))
    throw InputError(fmt::format("{}: give either `node` or `member`", in.where()));
  const bool on_node = in.has("node");
  for (const char* key : {"force", "moment"})
    if (!on_node && in.has(key))
      in.refuse(key, "is for nodes", "along a member write line_force or line_moment");
  for (const char* key : {"line_force", "line_moment", "line_force_2", "line_moment_2", "preload"})
    if (on_node && in.has(key)) in.refuse(key, "is for members", "on a node write force or moment");
  const std::string wanted = in.has("case") ? in.text("case") : name;
  auto at = std::find_if(cases.begin(), cases.end(), [&](const LoadCase& c) { return c.name == wanted; });
  if (at == cases.end()) at = cases.insert(cases.end(), LoadCase{wanted, {}, {}, {}});
  if (on_node) {
    const int node = nodes.find(in, "node", in.text("node"));
    at->nodal.push_back({node, pair_of(in, "force", "moment")});
    return;
  }
  beam::MemberLoad load;
  load.member = members.find(in, "member", in.text("member"));
  if (in.has("preload")) at->preloads.emplace_back(load.member, in.quantity("preload"));
  load.load.at_1 = load.load.at_2 = pair_of(in, "line_force", "line_moment");
  if (in.has("line_force_2")) load.load.at_2.head<3>() = in.vector3("line_force_2");
  if (in.has("line_moment_2")) load.load.at_2.tail<3>() = in.vector3("line_moment_2");
  load.element_axes = in.text("axes") == "member";
  if (!in.has("preload") || in.has("line_force") || in.has("line_moment") || in.has("line_force_2") ||
      in.has("line_moment_2"))
    at->members.push_back(load);
}

}  // namespace flexura::reduce
