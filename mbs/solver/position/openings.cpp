// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/openings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "mbs/base/documents/units.hpp"
#include "mbs/constraints/constraint.hpp"

/// What residuals of constraints mean: which joints are open, and by how much.
namespace flexura::mbs {
namespace {

std::string length_text(double metres) {
  if (metres >= 1.0) return fmt::format("{:.3g} m", metres);
  if (metres >= 1e-5) return fmt::format("{:.3g} mm", 1e3 * metres);
  return metres >= 1e-6 ? fmt::format("{:.3g} um", 1e6 * metres) : fmt::format("{:.3g} m", metres);
}

// What the rows of one joint or constraint are.
struct JoinedRows {
  std::string name;
  int marker_F = -1, marker_M = -1;
  std::vector<input::Dimension> dimensions;
};

input::Dimension coordinate_dimension(const MechanismDescription& d, CoordinateRef c) {
  return d.joints[c.joint].joint->coordinates()[c.index].dimension;
}

std::vector<input::Dimension> dimensions_of(const MechanismDescription& d, const Constraint& constraint) {
  std::vector<input::Dimension> out;
  for (int i = 0; i < constraint.n_rows(); ++i) {
    const GapKind kind = constraint.gap_kind(i);
    out.push_back(kind == GapKind::length       ? input::dim::length
                  : kind == GapKind::angle      ? input::dim::angle
                  : kind == GapKind::coordinate ? coordinate_dimension(d, constraint.coordinates().front())
                                                : input::dim::none);
  }
  return out;
}

// Of every joint and constraint by its name, the part of a row's name before the last dot.
std::map<std::string, JoinedRows> rows_of(const MechanismDescription& d) {
  std::map<std::string, JoinedRows> out;
  for (const JointDescription& joint : d.joints) {
    const RelativeConstraint closure(joint.name, joint.marker_F, joint.marker_M, joint.joint);
    out[joint.name] = {joint.name, joint.marker_F, joint.marker_M, dimensions_of(d, closure)};
  }
  for (const auto& constraint : d.constraints) {
    JoinedRows rows{constraint->name(), -1, -1, {}};
    const std::vector<int> markers = constraint->markers();
    if (markers.size() == 2) rows.marker_F = markers[0], rows.marker_M = markers[1];
    rows.dimensions = dimensions_of(d, *constraint);
    out[constraint->name()] = std::move(rows);
  }
  return out;
}

struct Place {
  const JoinedRows* rows = nullptr;
  std::string name;
  input::Dimension dimension = input::dim::none;
  const Constraint* constraint = nullptr;  // of the file, and which of its rows
  int row = 0;
};

// What row i of the mechanism is.
Place place_of(const Mechanism& mechanism, const std::map<std::string, JoinedRows>& all, int i) {
  const MechanismDescription& d = mechanism.description();
  const std::string name = mechanism.name_of_constraint(i);
  const std::size_t dot = name.rfind('.');
  Place place{nullptr, name.substr(0, dot)};
  const std::string row = dot == std::string::npos ? "" : name.substr(dot + 1);
  const auto found = all.find(place.name);
  if (found == all.end()) return place;
  for (const JointDescription& joint : d.joints) {
    if (joint.name != place.name) continue;
    if (row.starts_with("drive")) {
      const auto coordinates = joint.joint->coordinates();
      for (const auto* drives : {&joint.drives, &joint.speed_drives, &joint.acceleration_drives})
        for (const auto& [index, motion] : *drives)
          if (row == "drive" || row == "drive_" + coordinates[index].name)
            place.dimension = coordinates[index].dimension;
      return place;
    }
    place.rows = &found->second;
    for (int k = 0; k < joint.joint->n_rows(); ++k)
      if (joint.joint->row_name(k) == row) place.dimension = found->second.dimensions[k];
    return place;
  }
  for (const auto& constraint : d.constraints) {
    if (constraint->name() != place.name) continue;
    place.rows = &found->second;
    for (int k = 0; k < constraint->n_rows(); ++k)
      if (constraint->row_name(k) == row) {
        place.dimension = found->second.dimensions[k];
        place.constraint = constraint.get();
        place.row = k;
      }
  }
  return place;
}

}  // namespace

std::string force_unit_of(const Mechanism& mechanism, int row) {
  const Place place = place_of(mechanism, rows_of(mechanism.description()), row);
  if (place.dimension == input::dim::length) return "N";
  return place.dimension == input::dim::angle ? "N m" : "N or N m";
}

std::vector<Opening> openings_of(const Mechanism& mechanism, const Eigen::VectorXd& g) {
  const std::map<std::string, JoinedRows> rows = rows_of(mechanism.description());
  std::vector<Opening> all;
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    const Place place = place_of(mechanism, rows, static_cast<int>(i));
    if (all.empty() || all.back().name != place.name || (all.back().marker_F >= 0) != (place.rows != nullptr))
      all.push_back(
          {place.name, place.rows ? place.rows->marker_F : -1, place.rows ? place.rows->marker_M : -1});
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
