// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/joints/decide.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "import/cad/joints/joint_freedom.hpp"
#include "import/cad/threads.hpp"

namespace flexura::import::cad {
namespace {

using Type = JointForm::Type;

// Of every instance the first of those that it is fixed to.
std::vector<int> groups_of(const Assembly& assembly, const Proposal& proposal) {
  std::vector<int> group(assembly.instances.size());
  std::iota(group.begin(), group.end(), 0);
  for (const ProposedJoint& joint : proposal.joints) {
    if (joint.form.type != Type::fixed) continue;
    const int a = group[static_cast<std::size_t>(joint.a)], b = group[static_cast<std::size_t>(joint.b)];
    std::ranges::replace(group, std::max(a, b), std::min(a, b));
  }
  return group;
}

// Of the coarse thread of the diameter of a cylinder that it sits on.
double lead_of_seat(const Assembly& assembly, const ProposedJoint& joint) {
  for (const auto& [instance, number] : joint.faces) {
    const auto part = static_cast<std::size_t>(assembly.instances[static_cast<std::size_t>(instance)].part);
    const mesh::Face& face = assembly.parts[part].faces[static_cast<std::size_t>(number - 1)].shape;
    if (face.kind == mesh::FaceKind::cylinder) return coarse_lead(2.0 * face.radius);
  }
  return 1e-3;
}

}  // namespace

void count_again(const Assembly& assembly, Proposal& proposal) {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Instance& instance : assembly.instances)
    for (const Vector3d& v : assembly.parts[static_cast<std::size_t>(instance.part)].surface.vertices) {
      low = low.cwiseMin(instance.X_WP * v);
      high = high.cwiseMax(instance.X_WP * v);
    }
  const std::vector<int> group = groups_of(assembly, proposal);
  for (ProposedJoint& joint : proposal.joints) joint.redundant = 0;
  proposal.freedom = count_freedom(proposal.joints, group, group[static_cast<std::size_t>(proposal.ground)],
                                   0.5 * (low + high), std::max(1e-9, 0.5 * (high - low).norm()));
}

void change_type(const Assembly& assembly, ProposedJoint& joint, JointForm::Type type) {
  if (joint.form.type == Type::fixed && type != Type::fixed) {
    const mesh::Face* seat = nullptr;
    const Instance* of = nullptr;
    for (const auto& [instance, number] : joint.faces) {
      const Instance& i = assembly.instances[static_cast<std::size_t>(instance)];
      const mesh::Face& face =
          assembly.parts[static_cast<std::size_t>(i.part)].faces[static_cast<std::size_t>(number - 1)].shape;
      const bool is_round = face.kind == mesh::FaceKind::cylinder;
      if (!is_round && (seat != nullptr || face.kind != mesh::FaceKind::plane)) continue;
      seat = &face;
      of = &i;
      if (is_round) break;
    }
    if (seat != nullptr && seat->kind == mesh::FaceKind::cylinder) {
      joint.form.axis = of->X_WP.R * seat->axis;
      joint.form.point = of->X_WP * seat->axis_point;
    } else if (seat != nullptr) {
      joint.form.axis = of->X_WP.R * seat->normal;
    }
  }
  joint.form.type = type;
  if (type == Type::screw && joint.form.lead == 0.0) joint.form.lead = lead_of_seat(assembly, joint);
}

}  // namespace flexura::import::cad
