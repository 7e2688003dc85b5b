// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/openings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "mbs/base/documents/units.hpp"
#include "mbs/constraints/constraint.hpp"
#include "mbs/mechanism/elements/constraint_rows.hpp"

/// What residuals of constraints mean: which joints are open, and by how much.
namespace flexura::mbs {
namespace {

std::string length_text(double metres) {
  if (metres >= 1.0) return fmt::format("{:.3g} m", metres);
  if (metres >= 1e-5) return fmt::format("{:.3g} mm", 1e3 * metres);
  return metres >= 1e-6 ? fmt::format("{:.3g} um", 1e6 * metres) : fmt::format("{:.3g} m", metres);
}

input::Dimension dimension_of(const MechanismDescription& d, const Constraint& constraint, int row) {
  switch (constraint.gap_kind(row)) {
    case GapKind::length:
      return input::dim::length;
    case GapKind::angle:
      return input::dim::angle;
    case GapKind::coordinate: {
      const CoordinateRef c = constraint.coordinates().front();
      return d.joints[c.joint].joint->coordinates()[c.index].dimension;
    }
    default:
      return input::dim::none;
  }
}

struct Place {
  std::string name;  // of the joint or constraint
  int marker_F = -1, marker_M = -1;
  input::Dimension dimension = input::dim::none;
  const Constraint* constraint = nullptr;  // of the file
  int row = 0;                             // of it
};

// What row i of the mechanism is.
Place place_of(const Mechanism& mechanism, int i) {
  const MechanismDescription& d = mechanism.description();
  const RowPlace row = mechanism.row_place(i);
  Place place;
  place.row = row.row;
  if (row.constraint >= 0) {
    const Constraint& constraint = *d.constraints[row.constraint];
    place.name = constraint.name();
    place.constraint = &constraint;
    const std::vector<int> markers = constraint.markers();
    if (markers.size() == 2) place.marker_F = markers[0], place.marker_M = markers[1];
    place.dimension = dimension_of(d, constraint, row.row);
    return place;
  }
  const JointDescription& joint = d.joints[row.joint];
  place.name = joint.name;
  if (row.driven >= 0) {
    place.dimension =
        joint.joint->speeds()[row.driven].dimension == input::dim::angular_velocity ? input::dim::angle
        : joint.joint->speeds()[row.driven].dimension == input::dim::velocity       ? input::dim::length
                                                                                    : input::dim::none;
  } else {
    place.marker_F = joint.marker_F, place.marker_M = joint.marker_M;
    place.dimension =
        dimension_of(d, RelativeConstraint(joint.name, joint.marker_F, joint.marker_M, joint.joint), row.row);
  }
  return place;
}

}  // namespace

std::string force_unit_of(const Mechanism& mechanism, int row) {
  const Place place = place_of(mechanism, row);
  if (place.dimension == input::dim::length) return "N";
  return place.dimension == input::dim::angle ? "N m" : "N or N m";
}

std::vector<Opening> openings_of(const Mechanism& mechanism, const Eigen::VectorXd& g) {
  std::vector<Opening> all;
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    const Place place = place_of(mechanism, static_cast<int>(i));
    // A joint's drives hold it beside its rows.
    if (all.empty() || all.back().name != place.name || (all.back().marker_F >= 0) != (place.marker_F >= 0))
      all.push_back({place.name, place.marker_F, place.marker_M});
    Opening& one = all.back();
    double& size = place.dimension == input::dim::length  ? one.length
                   : place.dimension == input::dim::angle ? one.angle
                                                          : one.other;
    size = std::hypot(size, place.constraint ? place.constraint->gap(place.row, g(i)) : g(i));
  }
  const auto width = [](const Opening& o) { return std::max({o.length, o.angle, o.other}); };
  std::ranges::stable_sort(all, std::ranges::greater(), width);
  if (!all.empty()) {
    const double least = 1e-6 * width(all.front());  // lengths beside angles
    std::erase_if(all, [&](const Opening& o) { return !(width(o) > least); });
  }
  return all;
}

std::string sentence_of(const Opening& o, const MechanismDescription& d) {
  std::string text = fmt::format("\"{}\"", o.name);
  if (o.marker_F >= 0 && o.marker_M >= 0)
    text += fmt::format(" (from \"{}\" to \"{}\")", d.markers[o.marker_F].name, d.markers[o.marker_M].name);
  const double widest = std::max({o.length, o.angle, o.other});
  std::vector<std::string> parts;
  // What is round-off beside the rest says nothing.
  if (o.length > 1e-6 * widest) parts.push_back(length_text(o.length));
  if (o.angle > 1e-6 * widest) parts.push_back(fmt::format("{:.3g} deg", o.angle * 180.0 / std::numbers::pi));
  if (o.other > 1e-6 * widest) parts.push_back(fmt::format("{:.3g}", o.other));
  return fmt::format("{} by {}", text, fmt::join(parts, " and "));
}

}  // namespace flexura::mbs
