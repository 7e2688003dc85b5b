// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/contact_keys.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/read_curve.hpp"
#include "mbs/forces/contacts/clearance.hpp"
#include "mbs/forces/contacts/contact.hpp"

/// What touches and lets go, in a mechanism file.
namespace flexura::mbs {
namespace {

/// Far enough to be no limit, near enough for differences.
constexpr double nowhere = 1e12;

}  // namespace

std::vector<input::Key> contact_law_keys() {
  using namespace input;
  std::vector<Key> keys = {
      expression("stiffness", "N per m^exponent: force = stiffness * penetration^exponent").required(),
      quantity("exponent", dim::none, "1 is linear, 1.5 Hertz's law").or_default("1").at_least(1.0)};
  for (Key& key : impact_keys()) keys.push_back(std::move(key));
  return keys;
}

std::vector<input::Key> impact_keys() {
  using namespace input;
  return {
      expression("damping", "force per rate of penetration; it never pulls").or_default("0"),
      quantity("restitution", dim::none,
               "instead of damping: rate after over rate before an impact, exact where nothing else acts")
          .above(0.0)
          .at_most(1.0),
      expression("slowest_impact", "beside restitution: slower impacts count as if they had this rate, m/s")
          .or_default("1e-6")};
}

ContactLaw read_contact_law(const input::Section& s, const ReadContext& context) {
  const double k = context.number(s, "stiffness");
  if (!(k > 0.0)) s.refuse("stiffness", "must be above 0");
  return read_impact(s, context, k, s.quantity("exponent"));
}

ContactLaw read_impact(const input::Section& s, const ReadContext& context, double stiffness,
                       double exponent) {
  const double d = context.number(s, "damping");
  if (d < 0.0) s.refuse("damping", "must not be negative");
  if (s.has("restitution") && d > 0.0) s.refuse("damping", "stands beside restitution", "keep one of them");
  const double slowest = context.number(s, "slowest_impact");
  if (!(slowest > 0.0)) s.refuse("slowest_impact", "must be above 0");
  return ContactLaw(stiffness, exponent, d, s.has("restitution") ? s.quantity("restitution") : 1.0, slowest);
}

namespace {

ForceType contact() {
  using namespace input;
  std::vector<Key> keys = {
      text("from", "marker F that carries the surface").required(),
      text("to", "marker M at the centre of the sphere").required(),
      quantity("radius", dim::length, "of the sphere; 0: a point").required().at_least(0.0),
      choice("surface", {"plane", "sphere", "cylinder", "curve"},
             "what it touches: the xy plane of F from above, a sphere about F, a cylinder about the z axis "
             "of F, or a curve in the xy plane of F drawn out along z, on its left side as one walks from "
             "point to point")
          .or_default("plane"),
      quantity("surface_radius", dim::length, "of the sphere or cylinder").above(0.0),
      vectors3("points", dim::length, "of the curve in F, z = 0; a cubic spline runs through them"),
      flag("closed", "the curve runs from the last point back to the first").or_default("false"),
      flag("inside", "the sphere rolls inside the surface; of a curve: on its right side")
          .or_default("false")};
  for (Key& key : contact_law_keys()) keys.push_back(std::move(key));
  keys.push_back(
      quantity("friction", dim::none, "coefficient of sliding friction").or_default("0").at_least(0.0));
  keys.push_back(quantity("transition_speed", dim::velocity, "sliding speed over which friction sets in")
                     .or_default("1 mm/s")
                     .above(0.0));
  return {"contact",
          "A sphere touches a plane, a sphere, a cylinder or a curve and lets go of it: an elastic law with "
          "damping or restitution, touch and release located by the integrator.",
          std::move(keys),
          {{"gap", "m", "between the surfaces; negative: penetration"},
           {"normal_force", "N", "between the surfaces"},
           {"friction_force", "N", "size"},
           {"sliding_speed", "m/s", "size, at the point of contact"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            ContactSurface surface;
            const std::string kind = s.text("surface");
            surface.kind = kind == "plane"    ? ContactSurface::Kind::plane
                           : kind == "sphere" ? ContactSurface::Kind::sphere
                           : kind == "curve"  ? ContactSurface::Kind::curve
                                              : ContactSurface::Kind::cylinder;
            surface.inside = s.flag("inside");
            const double radius = s.quantity("radius");
            if (kind != "curve" && s.has("points"))
              s.refuse("points", "a " + kind + " has none", "write surface = \"curve\"");
            if (kind == "plane" || kind == "curve") {
              if (s.has("surface_radius"))
                s.refuse("surface_radius", "a " + kind + " has none", "take the key away");
              if (kind == "curve") {
                if (!s.has("points")) s.refuse("", "points is missing", "a curve needs it");
                for (const Vector3d& point : s.vectors3("points"))
                  if (point.z() != 0.0)
                    s.refuse("points", "do not all have z = 0",
                             "turn the marker so that its z axis stands on the curve");
                surface.curve = std::make_shared<SpaceCurve>(read_space_curve(s));
              } else if (surface.inside)
                s.refuse("inside", "a plane has no inside", "turn its marker round");
            } else {
              if (!s.has("surface_radius"))
                s.refuse("", "surface_radius is missing", "a " + kind + " needs it");
              surface.radius = s.quantity("surface_radius");
              if (surface.inside && radius >= surface.radius)
                s.refuse("radius", "the sphere does not fit inside", "make it smaller than surface_radius");
            }
            return std::make_shared<Contact>(
                name, context.marker(s, "from"), context.marker(s, "to"), radius, std::move(surface),
                read_contact_law(s, context),
                Contact::Friction{s.quantity("friction"), s.quantity("transition_speed")});
          }};
}

ForceType bump_stop() {
  using namespace input;
  std::vector<Key> keys = {
      text("joint", "the joint").required(),
      text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
      expression("lower", "least coordinate that moves freely (m or rad); without it no limit"),
      expression("upper", "greatest coordinate that moves freely; without it no limit")};
  for (Key& key : contact_law_keys()) keys.push_back(std::move(key));
  return {"bump_stop",
          "Elastic ends of a joint's travel, touched and left at switches.",
          std::move(keys),
          {{"position", "m or rad", "the coordinate"},
           {"force", "N or N*m", "along it, positive away from the lower side"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            if (!s.has("lower") && !s.has("upper"))
              s.refuse("", "has neither lower nor upper", "give at least one");
            const double lower = s.has("lower") ? context.number(s, "lower") : -nowhere;
            const double upper = s.has("upper") ? context.number(s, "upper") : nowhere;
            if (!(lower < upper)) s.refuse("lower", "is not below upper");
            const CoordinateRef c = context.speed(s, "joint", "coordinate");
            return std::make_shared<Clearance>(name, "bump_stop", std::vector<Clearance::Term>{{c, 1.0}},
                                               lower, upper, read_contact_law(s, context),
                                               Clearance::Ripple{}, context.coordinate_info(c).dimension,
                                               context.force_along(c));
          }};
}

}  // namespace

std::vector<ForceType> contact_types() {
  return {also_called(contact(), {"sphere_contact"}), also_called(bump_stop(), {"end_stop", "joint_stop"})};
}

}  // namespace flexura::mbs
