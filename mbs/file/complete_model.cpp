// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/complete_model.hpp"

#include <algorithm>

#include "mbs/bodies/modal_basis.hpp"
#include "mbs/file/bodies/read_flexible_body.hpp"
#include "mbs/file/bodies/read_pose.hpp"
#include "mbs/file/bodies/read_section_points.hpp"
#include "mbs/file/bodies/read_surface_patch.hpp"

namespace flexura::mbs {

using input::Section;

bool is_placed(const Section& body) {
  return has_pose(body);
}

void add_free_joints(ReadModel& model) {
  MechanismDescription& d = model.description;
  // A chain of segments is held where one of its pieces is; the pieces of a free one go along with its root.
  std::set<int> go_along;
  for (const auto& [b, chain] : model.segments) {
    const bool held =
        std::ranges::any_of(chain.bodies, [&](int piece) { return model.joined.contains(piece); });
    for (const int piece : chain.bodies)
      if (piece != b || held) model.joined.insert(piece);
    for (const int piece : chain.bodies)
      if (piece != b && !held) go_along.insert(piece);
  }
  for (std::size_t i = 1; i < d.bodies.size(); ++i) {
    const int b = static_cast<int>(i);
    if (go_along.contains(b)) continue;
    const Section& s = model.sections.at(b);
    const bool moves = s.has("velocity") || s.has("angular_velocity");
    if (model.joined.contains(b)) {
      // Where nothing says where it starts its joint does, in a subsystem as in a file by itself: the pose of the subsystem, of which
      // a free body takes its own, is none of its own.
      if (!is_placed(s)) d.bodies[i].X_WB.reset();
      if (moves)
        s.refuse(s.has("velocity") ? "velocity" : "angular_velocity", "the body has a joint",
                 "give the joint's speed instead");
      continue;
    }
    const int F = d.add_marker(0, "origin_of_" + d.bodies[i].name), M = d.add_marker(b, "frame");
    const int j = d.add_joint(d.bodies[i].name, "six_dof", F, M);
    for (int k = 0; k < 3; ++k) {
      if (s.has("angular_velocity")) d.joints[j].initial_speeds[k] = s.vector3("angular_velocity")(k);
      if (s.has("velocity")) d.joints[j].initial_speeds[3 + k] = s.vector3("velocity")(k);
    }
  }
}

void prepare_bodies(ReadModel& model) {
  MechanismDescription& d = model.description;
  for (const auto& [b, se] : model.to_prepare) {
    const Section& s = model.sections.at(b);
    const auto [first, last] = model.patches.equal_range(b);
    Eigen::MatrixXd on_surface(se->n(), 0);
    for (auto patch = first; patch != last; ++patch) {
      const Eigen::MatrixXd loads = tractions(patch->second, *se);
      on_surface.conservativeResize(Eigen::NoChange, on_surface.cols() + loads.cols());
      on_surface.rightCols(loads.cols()) = loads;
    }
    const auto body =
        prepare_flexible_body(s, *se, model.linked[b], on_surface, d, b, model.notes, model.cache);
    const ModalData& data = *body->modal();
    for (auto patch = first; patch != last; ++patch)
      patch->second.set_shapes(shapes_of(patch->second, *se) * data.Y);
    const auto [first_mesh, last_mesh] = model.meshes.equal_range(b);
    for (auto mesh = first_mesh; mesh != last_mesh; ++mesh)
      mesh->second->set_shapes(se->shapes.cast<double>() * data.Y);
    std::vector<BodyNode> nodes;  // all that is loaded; none where loads are on the surface, too
    if (first == last && first_mesh == last_mesh) {
      nodes = interface_nodes(*se);
      nodes.insert(nodes.end(), model.linked[b].begin(), model.linked[b].end());
    }
    if (wants_stress(s)) d.bodies[b].stress = read_stress_field(s, se, data, nodes);
    if (wants_surface_points(s)) d.bodies[b].surface_points = read_surface_points(s, *se, &data);
    if (wants_sections(s)) d.bodies[b].sections = read_section_points(s, *se, data, nodes, model.notes);
    d.bodies[b].flexible = body;
    d.bodies[b].loads = body_loads(*se, data.Y);
  }
}

}  // namespace flexura::mbs
