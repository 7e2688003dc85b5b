// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/beam_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "mesh/gmsh/curves.hpp"

namespace flexura::reduce {

using input::InputError;
using input::Section;
namespace dim = input::dim;

input::TableSchema curves_schema() {
  input::TableSchema s{.name = "curves",
                       .doc =
                           "Members along the curves of a CAD file or gmsh model. Ends that meet are joined; "
                           "one that lies at a "
                           "[node.NAME] is that node."};
  s.keys = {
      input::text("file",
                  "STEP, IGES or BREP file of curves, or gmsh's .msh; its scripts (.geo) by --run-scripts "
                  "alone; relative to the "
                  "part file")
          .required(),
      input::choice("unit", {"m", "mm", "cm", "um", "inch", "ft"},
                    "length unit of the file; overrides what it says; gmsh's files say nothing: m"),
      input::text("group", "only the curves of this physical group (gmsh's files)"),
      input::integers("curves", "only the curves of these numbers, as gmsh counts them"),
      input::text("section", "name of a section; may be left out where there is only one"),
      input::choice("theory", {"timoshenko", "euler_bernoulli"}, "with or without shear deformation")
          .or_default("timoshenko"),
      input::vector3("direction", dim::none,
                     "points to the side of the section's +y (width), as for members"),
      input::quantity("turn", dim::angle,
                      "bent curves become straight members that turn by no more than this")
          .or_default("5 deg")
          .above(0),
      input::flag("warping_free", "the joints let the ends warp").or_default("false"),
      input::integer("elements", "elements of each straight member; default: by [mesh]")
          .at_least(1)
          .at_most(100000),
  };
  return s;
}

namespace {

// The curves that the table asks for.
std::set<int> chosen_curves(const Section& in, const mesh::CurveSet& set) {
  std::set<int> all, chosen;
  for (const mesh::CurvePiece& piece : set.pieces) all.insert(piece.curve);
  if (in.has("group") && in.has("curves"))
    in.refuse("curves", "stands beside `group`", "keep one of the two");
  if (in.has("group")) {
    std::vector<std::string> names;
    for (const mesh::CurveGroup& group : set.groups) {
      names.push_back(group.name);
      if (group.name == in.text("group")) chosen.insert(group.curves.begin(), group.curves.end());
    }
    if (std::find(names.begin(), names.end(), in.text("group")) == names.end())
      in.refuse("group", fmt::format("the file has no physical group of curves \"{}\"{}", in.text("group"),
                                     input::suggestion(in.text("group"), names)));
    return chosen;
  }
  if (!in.has("curves")) return all;
  for (const int curve : in.integers("curves")) {
    if (!all.count(curve))
      in.refuse("curves", fmt::format("the file has no curve {}; it has {} curves, {} to {}", curve,
                                      all.size(), *all.begin(), *all.rbegin()));
    chosen.insert(curve);
  }
  return chosen;
}

}  // namespace

void read_curve_members(const std::string& name, const Section& in, const Names& sections, bool run_scripts,
                        beam::Model& model) {
  mesh::CurveOptions options;
  options.path = in.file("file");
  if (!std::filesystem::exists(options.path))
    in.refuse("file", "there is no such file", "relative names start at the part file's folder");
  if (in.has("unit")) options.unit = in.text("unit");
  options.turn = in.quantity("turn");
  options.run_scripts = run_scripts;
  mesh::CurveSet set;
  try {
    set = mesh::read_curves(options);
  } catch (const std::invalid_argument& error) {
    throw InputError(in.where("file") + ": " + error.what());
  }
  const std::set<int> curves = chosen_curves(in, set);

  beam::Member pattern;
  pattern.section = sections.find_or_only(in, "section");
  pattern.theory =
      in.text("theory") == "timoshenko" ? beam::Theory::timoshenko : beam::Theory::euler_bernoulli;
  if (in.has("direction")) pattern.direction_B = in.vector3("direction");
  if (in.has("elements")) pattern.elements = in.integer("elements");
  for (beam::MemberEnd& end : pattern.end) end.warping_free = in.flag("warping_free");

  // Nodes by their height along an oblique direction, where little but what coincides is near.
  const Eigen::Vector3d oblique = Eigen::Vector3d(0.53, 0.61, 0.59).normalized();
  std::multimap<double, int> by_height;
  for (std::size_t k = 0; k < model.nodes.size(); ++k)
    by_height.insert({oblique.dot(model.nodes[k].p_BoN_B), static_cast<int>(k)});
  const double near = 1e-6 * (set.points.colwise().maxCoeff() - set.points.colwise().minCoeff()).norm();
  std::map<int, int> node_of;  // point of the set -> node of the model
  int added = 0;
  const auto node = [&](int point) {
    const auto [it, is_new] = node_of.insert({point, -1});
    if (!is_new) return it->second;
    const Eigen::Vector3d p = set.points.row(point).transpose();
    const double height = oblique.dot(p);
    for (auto at = by_height.lower_bound(height - near); at != by_height.end() && at->first <= height + near;
         ++at)
      if ((model.nodes[at->second].p_BoN_B - p).norm() <= near) return it->second = at->second;
    it->second = static_cast<int>(model.nodes.size());
    model.nodes.push_back({fmt::format("{}.{}", name, ++added), p});
    return it->second;
  };
  std::map<int, int> pieces_of;
  for (const mesh::CurvePiece& piece : set.pieces) ++pieces_of[piece.curve];
  std::map<int, int> count;
  for (const mesh::CurvePiece& piece : set.pieces) {
    if (!curves.count(piece.curve)) continue;
    beam::Member member = pattern;
    member.name = pieces_of[piece.curve] == 1
                      ? fmt::format("{}.{}", name, piece.curve)
                      : fmt::format("{}.{}.{}", name, piece.curve, ++count[piece.curve]);
    member.end[0].node = node(piece.first);
    member.end[1].node = node(piece.second);
    model.members.push_back(member);
  }
}

}  // namespace flexura::reduce
