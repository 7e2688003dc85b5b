// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/element_types.hpp"
#include "mbs/forces/surfaces/surface_contact.hpp"
#include "mbs/forces/surfaces/touched_shape.hpp"

/// Surfaces in contact, in a mechanism file.
namespace flexura::mbs {
namespace {

using namespace input;

/// Of the part of a surface that is meant, read by read_surface_patch; `prefix`: before the names.
std::vector<Key> part_keys(const std::string& prefix, const std::string& does) {
  return {texts(prefix + "interfaces", "only the faces of these interfaces " + does),
          vectors3(prefix + "box", dim::length,
                   "only facets between these two opposite corners " + does +
                       ", in the body's frame, undeformed; beside the other keys: what lies in all of them"),
          vector3(prefix + "facing", dim::none,
                  "only facets that look in this direction " + does +
                      ", in the body's frame, undeformed: what lies beside an edge then has no part of what "
                      "is at its "
                      "corners"),
          quantity(prefix + "facing_angle", dim::angle, "within this angle around it")
              .or_default("45 deg")
              .above(0.0)
              .at_most(3.2)};
}

/// Per area; what is given for all of the patch is spread over it.
double read_stiffness(const input::Section& s, const ReadContext& context, const SurfacePatch& patch) {
  const bool is_total = s.has("total_stiffness");
  if (is_total == s.has("stiffness")) {
    if (is_total) s.refuse("total_stiffness", "stands beside stiffness", "keep one of them");
    s.refuse("", "stiffness is missing", "give stiffness (per area) or total_stiffness");
  }
  const char* key = is_total ? "total_stiffness" : "stiffness";
  const double k = context.number(s, key);
  if (!(k > 0.0)) s.refuse(key, "must be above 0", "a surface resists what goes into it");
  return is_total ? k / patch.total_area() : k;
}

ContactSurface read_shape(const Section& s) {
  ContactSurface shape;
  const std::string kind = s.text("surface");
  shape.kind = kind == "plane"    ? ContactSurface::Kind::plane
               : kind == "sphere" ? ContactSurface::Kind::sphere
                                  : ContactSurface::Kind::cylinder;
  shape.inside = s.flag("inside");
  if (kind == "plane") {
    if (s.has("surface_radius")) s.refuse("surface_radius", "a plane has none", "take the key away");
    if (shape.inside) s.refuse("inside", "a plane has no inside", "turn its marker round");
    return shape;
  }
  if (!s.has("surface_radius")) s.refuse("", "surface_radius is missing", "a " + kind + " needs it");
  shape.radius = s.quantity("surface_radius");
  return shape;
}

struct Touched {
  SurfaceContact::Side side;
  std::shared_ptr<const TouchedSurface> surface;
};

/// The surface of another body, or a shape at a marker of one.
Touched read_touched(const Section& s, const ReadContext& context, int body) {
  if (s.has("from_body")) {
    for (const char* key : {"from", "surface", "surface_radius", "inside"})
      if (s.has(key))
        s.refuse(key, "is of a shape, and from_body names a body whose own surface is touched",
                 "keep one of them");
    const int other = context.body(s, "from_body");
    if (other == body)
      s.refuse("from_body", "is the body that touches",
               "name another body: the surface of one body is not held against itself");
    const auto surface = context.touched(s, "from_body", "from_", other);
    return {{other, context.marker(s, "from_body")}, surface};
  }
  for (const char* key : {"from_interfaces", "from_box", "from_facing", "from_facing_angle"})
    if (s.has(key)) s.refuse(key, "is a part of the surface of from_body", "give from_body, too");
  if (!s.has("from"))
    s.refuse(
        "", "from is missing",
        "give from (a marker that carries a plane, sphere or cylinder) or from_body (a body whose surface is "
        "touched)");
  const int F = context.marker(s, "from");
  if (context.description().markers[static_cast<std::size_t>(F)].body == body)
    s.refuse("from", "is on the body that touches", "name a marker of another body");
  return {{-1, F}, std::make_shared<TouchedShape>(read_shape(s))};
}

ForceType surface_contact() {
  std::vector<Key> keys = {
      text("body",
           "whose surface touches: made of a superelement with pictures, of any fidelity (a rigid body "
           "touches with its undeformed surface)")
          .required()};
  const auto add = [&](std::vector<Key> more) {
    for (Key& key : more) keys.push_back(std::move(key));
  };
  add(part_keys("", "touch"));
  add({text("from_body",
            "another such body: its surface, as it is deformed, is touched; instead of from and surface")});
  add(part_keys("from_", "are touched"));
  add({text("from", "marker F of another body that carries the plane, sphere or cylinder that is touched"),
       choice("surface", {"plane", "sphere", "cylinder"},
              "what is touched: the xy plane of F from above, a sphere about F, a cylinder about the z "
              "axis of F")
           .or_default("plane"),
       quantity("surface_radius", dim::length, "of the sphere or cylinder").above(0.0),
       flag("inside", "the body lies inside the sphere or cylinder").or_default("false"),
       expression("stiffness", "Pa per m^exponent: pressure = stiffness * penetration^exponent"),
       expression("total_stiffness",
                  "instead: N per m^exponent of all that may touch, where all of it goes in alike"),
       quantity("exponent", dim::none, "1 is linear; above 1 the stiffness begins softly")
           .or_default("1")
           .at_least(1.0),
       expression("damping",
                  "s/m: the pressure grows by the factor 1 + damping * rate of penetration, and never pulls")
           .or_default("0"),
       quantity("friction", dim::none, "coefficient of sliding friction").or_default("0").at_least(0.0),
       quantity("transition_speed", dim::velocity, "sliding speed over which friction sets in")
           .or_default("1 mm/s")
           .above(0.0),
       flag("pressures",
            "give the pressure at every node among the results, which the page of the run then colours")
           .or_default("false")});
  return {
      "surface_contact",
      "The surface of a body, as its modes deform it, touches the surface of another one (from_body), or a "
      "plane, a sphere or a cylinder of another body (from): every node of it bears a pressure on its share "
      "of the area. The first touch and the last are located by the integrator.",
      std::move(keys),
      {{"gap", "m", "least distance of a node; negative: penetration"},
       {"normal_force", "N", "sum of the sizes of the pressures' forces"},
       {"friction_force", "N", "size of the sum"},
       {"force_x, force_y, force_z", "N", "on the body, in the axes of `from`, or of the body `from_body`"},
       {"area", "m^2", "of the nodes that touch"},
       {"pressure", "Pa", "the greatest"},
       {"nodes", "", "how many touch"},
       {"pressure_at_N", "Pa", "with `pressures`: at the vertex N of the body's surface"}},
      [](const std::string& name, const Section& s,
         const ReadContext& context) -> std::shared_ptr<const ForceElement> {
        const int body = context.body(s, "body");
        const auto patch = context.surface(s, body);
        const double k = read_stiffness(s, context, *patch), damping = context.number(s, "damping");
        if (damping < 0.0) s.refuse("damping", "must not be negative");
        const Touched touched = read_touched(s, context, body);
        return std::make_shared<SurfaceContact>(
            name, SurfaceContact::Side{body, context.marker(s, "body")}, patch, touched.side, touched.surface,
            PressureLaw(k, s.quantity("exponent"), damping),
            SurfaceContact::Friction{s.quantity("friction"), s.quantity("transition_speed")},
            s.flag("pressures"));
      },
      {"body", "from_body"}};
}

}  // namespace

std::vector<ForceType> surface_contact_types() {
  return {surface_contact()};
}

}  // namespace flexura::mbs
