// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/tree.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace flexura::import::urdf {
namespace {

Link& link_of(Robot& robot, int index) {
  return robot.links[static_cast<std::size_t>(index)];
}

void find_parents(Robot& robot, Findings& findings) {
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& joint = robot.joints[j];
    Link& child = link_of(robot, joint.child);
    if (child.parent_joint >= 0)
      findings.fault(
          fmt::format("link \"{}\" is the child of joint \"{}\" and of joint \"{}\": a URDF is a "
                      "tree, each link has one parent; close loops by a joint in the mechanism file",
                      shown(child.name),
                      shown(robot.joints[static_cast<std::size_t>(child.parent_joint)].name),
                      shown(joint.name)),
          joint.line);
    child.parent_joint = static_cast<int>(j);
  }
}

std::vector<int> roots_of(const Robot& robot) {
  std::vector<int> roots;
  for (std::size_t l = 0; l < robot.links.size(); ++l)
    if (robot.links[l].parent_joint < 0) roots.push_back(static_cast<int>(l));
  return roots;
}

// Where one root has joints and the others none, those others are left out.
void leave_out_loose_links(Robot& robot, Findings& findings) {
  std::vector<bool> is_loose(robot.links.size());
  std::size_t n_roots = 0, n_loose = 0;
  for (const int l : roots_of(robot)) {
    ++n_roots;
    is_loose[static_cast<std::size_t>(l)] = true;
  }
  for (const Joint& joint : robot.joints) is_loose[static_cast<std::size_t>(joint.parent)] = false;
  n_loose = static_cast<std::size_t>(std::ranges::count(is_loose, true));
  if (n_roots < 2 || n_loose + 1 != n_roots) return;
  std::vector<int> number(robot.links.size());
  std::vector<Link> kept;
  for (std::size_t l = 0; l < robot.links.size(); ++l) {
    number[l] = static_cast<int>(kept.size());
    Link& link = robot.links[l];
    if (!is_loose[l]) {
      kept.push_back(std::move(link));
      continue;
    }
    const std::string text = fmt::format("no joint names link \"{}\": it is left out", shown(link.name));
    if (link.inertial)
      findings.repair("links that no joint names", fmt::format("{}, with {} kg", text, link.inertial->mass),
                      link.line);
    else
      findings.note("links that no joint names", text, link.line);
  }
  robot.links = std::move(kept);
  for (Joint& joint : robot.joints)
    for (int* end : {&joint.parent, &joint.child}) *end = number[static_cast<std::size_t>(*end)];
}

void fault_of_roots(Robot& robot, const std::vector<int>& roots, Findings& findings) {
  std::string names;
  for (std::size_t i = 0; i < std::min<std::size_t>(roots.size(), 5); ++i)
    names += (i > 0 ? ", " : "") + ('"' + shown(link_of(robot, roots[i]).name) + '"');
  findings.fault(fmt::format("{} links have no parent ({}{}); a URDF has one root: join the others to it",
                             roots.size(), names, roots.size() > 5 ? ", ..." : ""),
                 link_of(robot, roots[1]).line);
}

}  // namespace

void order_tree(Robot& robot, Findings& findings) {
  find_parents(robot, findings);
  leave_out_loose_links(robot, findings);
  const std::vector<int> roots = roots_of(robot);
  if (roots.empty())
    return findings.fault("the joints form a ring and no link is the root; take one of them away",
                          robot.joints.front().line);
  if (roots.size() > 1) return fault_of_roots(robot, roots, findings);
  robot.root = roots.front();
  std::vector<std::vector<int>> below(robot.links.size());
  for (std::size_t j = 0; j < robot.joints.size(); ++j)
    below[static_cast<std::size_t>(robot.joints[j].parent)].push_back(static_cast<int>(j));
  std::vector<int> links = {robot.root};
  std::vector<bool> reached(robot.links.size());
  // A link with two parents would come twice.
  for (std::size_t i = 0; i < links.size(); ++i)
    for (const int j : below[static_cast<std::size_t>(links[i])])
      if (const int child = robot.joints[static_cast<std::size_t>(j)].child;
          !reached[static_cast<std::size_t>(child)]) {
        reached[static_cast<std::size_t>(child)] = true;
        robot.order.push_back(j);
        links.push_back(child);
      }
  if (links.size() == robot.links.size()) return;
  for (const Joint& joint : robot.joints)
    if (!reached[static_cast<std::size_t>(joint.child)])
      return findings.fault(
          fmt::format(
              "joint \"{}\" belongs to a ring of joints that the root \"{}\" does not reach; take one "
              "of the ring's joints away",
              shown(joint.name), shown(link_of(robot, robot.root).name)),
          joint.line);
}

}  // namespace flexura::import::urdf
