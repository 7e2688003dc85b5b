// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <iterator>

#include "mbs/file/elements/contact_keys.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/forces/contacts/clearance.hpp"
#include "mbs/forces/gears/involute_mesh.hpp"

/// Teeth in mesh, in a mechanism file.
namespace flexura::mbs {
namespace {

ForceType gear_mesh() {
  using namespace input;
  std::vector<Key> keys = {
      text("joint_1", "joint of the first wheel, or \"joint.coordinate\"").required(),
      text("joint_2", "joint of the second wheel, on the same carrier").required(),
      quantity("radius_1", dim::length, "base radius of the first wheel; for a rack's joint write 1")
          .required()
          .above(0.0),
      quantity("radius_2", dim::length, "base radius of the second wheel").required().above(0.0),
      flag("internal", "one of the wheels has its teeth inside").or_default("false"),
      quantity("backlash", dim::length, "play along the line of action").or_default("0 m").at_least(0.0),
      quantity("teeth_1", dim::none, "teeth of the first wheel, for the stiffness' ripple").at_least(1.0),
      quantity("ripple", dim::none, "part by which the stiffness changes as teeth come and go")
          .or_default("0")
          .at_least(0.0)
          .below(1.0)};
  for (Key& key : contact_law_keys()) keys.push_back(std::move(key));
  return {
      "gear_mesh",
      "Teeth of two wheels in mesh with backlash and tooth stiffness: they touch on either flank and part at "
      "switches. x = radius_1 q_1 + radius_2 q_2 is free within half the backlash on both sides.",
      std::move(keys),
      {{"position", "m", "x, between the flanks"},
       {"force", "N", "along the line of action, positive away from the lower flank"}},
      [](const std::string& name, const Section& s,
         const ReadContext& context) -> std::shared_ptr<const ForceElement> {
        Clearance::Ripple ripple{s.quantity("ripple"), 0.0};
        if (ripple.amplitude > 0.0 && !s.has("teeth_1"))
          s.refuse("ripple", "needs teeth_1", "say how often it comes");
        if (s.has("teeth_1")) ripple.count = s.quantity("teeth_1");
        const double half = 0.5 * s.quantity("backlash"), sign = s.flag("internal") ? -1.0 : 1.0;
        return std::make_shared<Clearance>(
            name, "gear_mesh",
            std::vector<Clearance::Term>{
                {context.coordinate(s, "joint_1", s.text("joint_1")), s.quantity("radius_1")},
                {context.coordinate(s, "joint_2", s.text("joint_2")), sign * s.quantity("radius_2")}},
            -half, half, read_contact_law(s, context), ripple, dim::length, dim::force);
      }};
}

ForceType involute_mesh() {
  using namespace input;
  std::vector<Key> keys = {
      text("from",
           "marker F at the centre of wheel 1, its z axis that of the wheel, its x axis through the middle "
           "of a tooth")
          .required(),
      text("to",
           "marker M at the centre of wheel 2, its z axis the same way, its x axis through the middle of a "
           "space")
          .required(),
      quantity("module", dim::length, "of the normal section").required().above(0.0),
      integer("teeth_1", "of wheel 1").required().at_least(5),
      integer("teeth_2", "of wheel 2").required().at_least(5),
      quantity("width", dim::length, "of the faces that meet").required().above(0.0),
      quantity("pressure_angle", dim::angle, "of the normal section").or_default("20 deg"),
      quantity("helix_angle", dim::angle, "of wheel 1 at the reference circle; positive: right-handed")
          .or_default("0 deg"),
      quantity("shift_1", dim::none, "profile shift of wheel 1 over the module").or_default("0"),
      quantity("shift_2", dim::none, "of wheel 2").or_default("0"),
      quantity("addendum", dim::none, "over the module").or_default("1").above(0.0),
      quantity("backlash", dim::length,
               "play along the line of action that thinner teeth give; axes further apart than the shifts "
               "ask for give more")
          .or_default("0 m")
          .at_least(0.0),
      quantity("tooth_stiffness", dim::pressure,
               "c' of one pair of teeth, force per deflection and width: 14 GPa is 14 N/(mm um); without it "
               "that of ISO 6336-1")
          .above(0.0),
      integer("harmonics", "of the tooth frequency, in the stiffness; 0: constant")
          .or_default("5")
          .at_least(0)
          .at_most(50)};
  std::vector<Key> impact = impact_keys();
  std::move(impact.begin(), impact.end(), std::back_inserter(keys));
  return {"involute_mesh",
          "Involute teeth of two external cylindrical wheels in mesh, spur or helical, wherever their shafts "
          "take them: "
          "backlash by the distance of the axes and the profile shifts, stiffness along the path of contact, "
          "radial, "
          "tangential and axial forces. Flanks touch and part at switches.",
          std::move(keys),
          {{"position", "m", "of the teeth between the flanks, along the line of action"},
           {"play", "m", "between the flanks, along the line of action"},
           {"force", "N", "along the line of action, positive where wheel 1 drives turning positively"},
           {"stiffness", "N/m", "of the teeth in mesh on the flank that carries"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const InvoluteData data{
                .module = s.quantity("module"),
                .teeth_1 = s.integer("teeth_1"),
                .teeth_2 = s.integer("teeth_2"),
                .pressure_angle = s.quantity("pressure_angle"),
                .helix_angle = s.quantity("helix_angle"),
                .shift_1 = s.quantity("shift_1"),
                .shift_2 = s.quantity("shift_2"),
                .addendum = s.quantity("addendum"),
                .width = s.quantity("width"),
                .backlash = s.quantity("backlash"),
                .tooth_stiffness = s.has("tooth_stiffness") ? s.quantity("tooth_stiffness") : 0.0,
                .harmonics = s.integer("harmonics")};
            try {
              Involute gears(data);
              const double k = gears.mean_stiffness;
              return std::make_shared<InvoluteMesh>(name, context.marker(s, "from"), context.marker(s, "to"),
                                                    std::move(gears), read_impact(s, context, k, 1.0));
            } catch (const input::InputError&) {
              throw;
            } catch (const std::invalid_argument& error) {
              s.refuse("", error.what(), "correct module, teeth, angles, shifts or addendum");
            }
          }};
}

}  // namespace

std::vector<ForceType> gear_types() {
  return {gear_mesh(), involute_mesh()};
}

}  // namespace flexura::mbs
