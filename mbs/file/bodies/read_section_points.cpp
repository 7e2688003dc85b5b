// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/read_section_points.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace flexura::mbs {

using input::Section;
namespace dim = input::dim;

input::TableSchema section_point_table() {
  using namespace input;
  TableSchema table;
  table.name = "section_point";
  table.doc =
      "A place on a member of a beam part, or on a beam or rod of a deck (by the element's number), whose "
      "section "
      "forces are stored: N, V_y, V_z, T, M_y, M_z on the "
      "section that looks along the member, from its first node to its second. What bears on the part "
      "between "
      "its interfaces counts: weight, inertia, load cases.";
  table.keys = {
      vector3("position", dim::length,
              "in the body's frame, undeformed: the nearest place of all members, or of `member`"),
      text("member",
           "the member (\"101\": element 101 of a deck); it must be named where position is on several, as "
           "at a node"),
      quantity("along", dim::length, "instead of position: from the member's first node").at_least(0.0),
      quantity("share", dim::none,
               "instead of position: of the member's length, 0 at its first node, 1 at its second")
          .at_least(0.0)
          .at_most(1.0),
      choice("axes", {"section", "member"},
             "x along the member, y along its width, z along its height: of the section as it has turned "
             "with the "
             "deformation; or of the undeformed member, which goes along with the body's frame")
          .or_default("section")};
  return table;
}

bool wants_sections(const Section& s) {
  return !s.table_map("section_point").empty();
}

namespace {

int member_named(const Section& point, const SectionPoints& points) {
  if (!point.has("member")) return -1;
  const std::vector<std::string>& known = points.members();
  const std::string name = point.text("member");
  const auto found = std::ranges::find(known, name);
  if (found == known.end())
    point.refuse("member",
                 fmt::format("the superelement has no member \"{}\"{}", name, input::suggestion(name, known)),
                 "name one of the part's file");
  return static_cast<int>(found - known.begin());
}

// Of a member's length: further away from it a position is told, or refused.
constexpr double kOffToTell = 0.01, kOffToRefuse = 1.0;

SectionPoints::Wanted wanted_section(const std::string& name, const Section& point,
                                     const SectionPoints& points, std::vector<std::string>& notes) {
  SectionPoints::Wanted wanted{.name = name, .member = member_named(point, points)};
  wanted.axes = point.text("axes") == "member" ? SectionPoints::Axes::member : SectionPoints::Axes::section;
  if (point.has("position") + point.has("along") + point.has("share") != 1)
    point.refuse("", "wants one of position, along and share", "keep one of them");
  if (!point.has("position")) {
    if (wanted.member < 0)
      point.refuse(point.has("along") ? "along" : "share", "is counted from a member's first node",
                   "name the member: member = \"NAME\"");
    const double length = points.length(wanted.member);
    wanted.share = point.has("share") ? point.quantity("share") : point.quantity("along") / length;
    if (wanted.share > 1.0 + 1e-6)  // the digits of a file's length
      point.refuse(
          "along",
          fmt::format("{:.6g} m is more than the member's length, {:.6g} m", wanted.share * length, length),
          "stay on the member");
    wanted.share = std::min(1.0, wanted.share);
    return wanted;
  }
  const Eigen::Vector3d position = point.vector3("position");
  const std::vector<SectionPoints::Near> near = points.nearest(position, wanted.member);
  if (near.size() > 1) {
    std::vector<std::string> names;
    bool is_on = true;
    for (const SectionPoints::Near& place : near) {
      is_on = is_on && place.distance <= kOffToTell * points.length(place.member);
      names.push_back(fmt::format("\"{}\"", points.members()[static_cast<std::size_t>(place.member)]));
    }
    point.refuse(
        "position",
        fmt::format(
            "({:.6g}, {:.6g}, {:.6g}) m is {} members {}{}, and the section forces of each are its own",
            position.x(), position.y(), position.z(),
            is_on ? "on" : fmt::format("equally far, {:.4g} m, from", near.front().distance),
            fmt::join(names, ", "), is_on ? " alike" : ""),
        fmt::format("name one: member = {}", names.front()));
  }
  wanted.member = near.front().member;
  wanted.share = near.front().share;
  const double off = near.front().distance, length = points.length(wanted.member);
  const std::string& member = points.members()[static_cast<std::size_t>(wanted.member)];
  if (off > kOffToRefuse * length)
    point.refuse(
        "position",
        fmt::format("({:.6g}, {:.6g}, {:.6g}) m is {:.4g} m from member \"{}\", which is {:.4g} m long{}",
                    position.x(), position.y(), position.z(), off, member, length,
                    point.has("member") ? "" : " and the nearest"),
        "give a place on a member in the part's frame, undeformed, or name member and share");
  if (off > kOffToTell * length)
    notes.push_back(
        fmt::format("{}: {:.4g} m from member \"{}\"; its section force is that at {:.4g} m of it",
                    point.where("position"), off, member, wanted.share * length));
  return wanted;
}

}  // namespace

std::shared_ptr<const SectionPoints> read_section_points(const Section& s,
                                                         const superelement::Superelement& se,
                                                         const ModalData& body,
                                                         const std::vector<BodyNode>& nodes,
                                                         std::vector<std::string>& notes) {
  if (!se.sections || se.sections->members.empty())
    s.refuse("section_point", "the superelement has no section forces",
             "reduce a beam part (members with sections) or a deck with beams or rods; solid parts have "
             "stress_point");
  auto out = std::make_shared<SectionPoints>(*se.sections, body, left_out_modes(se, body, nodes),
                                             StiffeningLoads(se, nodes));
  for (const auto& [name, point] : s.table_map("section_point"))
    out->add_point(wanted_section(name, point, *out, notes));
  if (!out->is_whole())
    notes.push_back(fmt::format(
        "{}: the superelement does not know what weight, inertia and load cases bear on a section within a "
        "member, so the section forces lack that, and each is of the nearest place known; reduce the part "
        "again, as a craig_bampton set where it is a deck",
        s.where("section_point")));
  return out;
}

}  // namespace flexura::mbs
