// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/element_types.hpp"
#include "mbs/forces/surfaces/surface_contact.hpp"

/// Surfaces in contact, in a mechanism file.
namespace flexura::mbs {
namespace {

/// What touches, read by read_surface_patch.
std::vector<input::Key> patch_keys() {
  using namespace input;
  return {text("body",
               "whose surface touches: made of a superelement with pictures, of any fidelity (a rigid body "
               "touches with its "
               "undeformed surface)")
              .required(),
          texts("interfaces", "only the faces of these interfaces touch"),
          vectors3("box", dim::length,
                   "only facets between these two opposite corners touch, in the undeformed body; beside "
                   "interfaces and facing: what "
                   "lies in all of them"),
          vector3("facing", dim::none,
                  "only facets that look in this direction touch, in the undeformed body: what lies beside "
                  "an edge then has no part "
                  "of the areas around its corners"),
          quantity("facing_angle", dim::angle, "within this angle around it")
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

ContactSurface read_shape(const input::Section& s) {
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

ForceType surface_contact() {
  using namespace input;
  std::vector<Key> keys = patch_keys();
  for (Key& key : std::vector<Key>{
           text("from", "marker F of another body that carries what is touched").required(),
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
           expression(
               "damping",
               "s/m: the pressure grows by the factor 1 + damping * rate of penetration, and never pulls")
               .or_default("0"),
           quantity("friction", dim::none, "coefficient of sliding friction").or_default("0").at_least(0.0),
           quantity("transition_speed", dim::velocity, "sliding speed over which friction sets in")
               .or_default("1 mm/s")
               .above(0.0)})
    keys.push_back(std::move(key));
  return {"surface_contact",
          "The surface of a body, as its modes deform it, touches a plane, a sphere or a cylinder of another "
          "body: every node of "
          "it bears a pressure on its share of the area. The first touch and the last are located by the "
          "integrator.",
          std::move(keys),
          {{"gap", "m", "least distance of a node; negative: penetration"},
           {"normal_force", "N", "sum of the sizes of the pressures' forces"},
           {"friction_force", "N", "size of the sum"},
           {"force_x, force_y, force_z", "N", "on the body, in the axes of `from`"},
           {"area", "m^2", "of the nodes that touch"},
           {"pressure", "Pa", "the greatest"},
           {"nodes", "", "how many touch"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const int body = context.body(s, "body"), F = context.marker(s, "from");
            if (context.description().markers[static_cast<std::size_t>(F)].body == body)
              s.refuse("from", "is on the body that touches", "name a marker of another body");
            const auto patch = context.surface(s, body);
            const double k = read_stiffness(s, context, *patch), damping = context.number(s, "damping");
            if (damping < 0.0) s.refuse("damping", "must not be negative");
            return std::make_shared<SurfaceContact>(
                name, body, context.marker(s, "body"), patch, F, read_shape(s),
                PressureLaw(k, s.quantity("exponent"), damping),
                SurfaceContact::Friction{s.quantity("friction"), s.quantity("transition_speed")});
          },
          "body"};
}

}  // namespace

std::vector<ForceType> surface_contact_types() {
  return {surface_contact()};
}

}  // namespace flexura::mbs
