// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/read_reaction.hpp"

#include <fmt/format.h>

#include "mbs/measures/reaction.hpp"

namespace flexura::mbs {
namespace {

/// One number that can be read: by what, which of its outputs.
struct Readable {
  std::string name;
  Exerted by;
  int output;
  input::Dimension dimension;
};

void add_outputs(const std::string& element, const std::vector<OutputInfo>& outputs, Exerted by,
                 std::vector<Readable>& all) {
  for (std::size_t i = 0; i < outputs.size(); ++i)
    all.push_back({element + "." + outputs[i].name, by, static_cast<int>(i), outputs[i].dimension});
}

// As results name them (list_quantities).
std::vector<Readable> all_readable(const MechanismDescription& d) {
  using By = Exerted::By;
  std::vector<Readable> all;
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    const JointDescription& joint = d.joints[j];
    const int k = static_cast<int>(j);
    if (joint.joint->n_rows() > 0) add_outputs(joint.name, wrench_outputs(true, true), {By::joint, k}, all);
    const auto speeds = joint.joint->speeds();
    for (const int index : joint.driven()) {
      const bool is_angle = speeds[static_cast<std::size_t>(index)].dimension == input::dim::angular_velocity;
      all.push_back({joint.name + "." + joint.drive_force_name(index),
                     {By::drive, k, index},
                     0,
                     is_angle ? input::dim::torque : input::dim::force});
    }
  }
  for (std::size_t k = 0; k < d.constraints.size(); ++k)
    add_outputs(d.constraints[k]->name(), d.constraints[k]->outputs(), {By::constraint, static_cast<int>(k)},
                all);
  for (std::size_t f = 0; f < d.forces.size(); ++f)
    add_outputs(d.forces[f]->name(), d.forces[f]->outputs(), {By::force, static_cast<int>(f)}, all);
  return all;
}

std::shared_ptr<const Measure> read(const std::string& name, const input::Section& s, const ReadContext& c) {
  const std::string wanted = c.prefix() + s.text("quantity");
  std::vector<std::string> known;
  for (const Readable& r : all_readable(c.description())) {
    if (r.name == wanted)
      return std::make_shared<Reaction>(name, r.by, r.output, r.dimension, s.quantity("guess"));
    if (r.name.starts_with(c.prefix())) known.push_back(r.name.substr(c.prefix().size()));
  }
  s.refuse("quantity",
           fmt::format("\"{}\" is nothing that a joint, a drive, a constraint or a force exerts{}",
                       s.text("quantity"), input::suggestion(s.text("quantity"), known)),
           "name one of theirs as results do, for example \"JOINT.force_z\" or \"CONSTRAINT.force\"");
}

}  // namespace

MeasureType reaction_type() {
  using namespace input;
  MeasureType type;
  type.name = "reaction";
  type.doc =
      "What a joint, a drive, a constraint or a force element exerts, one of the numbers that results show "
      "of "
      "it. Formulas may read it, and are then solved for together with it: see `load_cell`, which takes any "
      "direction of a joint's.";
  type.keys = {text("quantity",
                    "as results name it: \"JOINT.force_z\", \"JOINT.drive_force\", \"CONSTRAINT.force\", "
                    "\"FORCE.force\"")
                   .required(),
               quantity("guess", dim::none,
                        "near which it is sought at the start, in SI: for formulas that have no value at 0")
                   .or_default("0")};
  type.gives = {{"", "that of the quantity", ""}};
  type.read = read;
  type.is_read_last = true;
  return type;
}

}  // namespace flexura::mbs
