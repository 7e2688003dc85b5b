// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/beam_curves.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/file/beam_loads.hpp"
#include "reduce/file/beam_sections.hpp"
#include "reduce/file/part_modes.hpp"

namespace flexura::reduce {

using input::TableSchema;
namespace dim = input::dim;

namespace {

TableSchema member_schema() {
  TableSchema s{.name = "member", .doc = "A straight member between two nodes."};
  s.keys = {
      input::texts("nodes", "its two nodes; x runs from the first to the second").required().sized(2),
      input::text("section", "name of a section; may be left out where there is only one"),
      input::text("section_at_end", "tapered: the section at the second node, of the same type"),
      input::choice("theory", {"timoshenko", "euler_bernoulli"}, "with or without shear deformation")
          .or_default("timoshenko"),
      input::vector3(
          "direction", dim::none,
          "points to the side of the section's +y (width); default: height as near to the part's z as can "
          "be, members along z have their width along y"),
      input::text("direction_node", "instead: a node on that side"),
      input::vector3("offset_1", dim::length, "rigid arm from the first node to the member's end"),
      input::vector3("offset_2", dim::length, "rigid arm from the second node to the member's end"),
      input::texts("release_1",
                   "released at the first end: some of x, y, z, rx, ry, rz, in the member's axes"),
      input::texts("release_2", "released at the second end"),
      input::flag("warping_free", "the joints let both ends warp").or_default("false"),
      input::integer("elements", "number of elements; default: by [mesh]").at_least(1).at_most(100000),
  };
  return s;
}

TableSchema mesh_schema() {
  TableSchema s{.name = "mesh",
                .doc = "How members are divided into elements; the finest of the rules counts."};
  s.keys = {
      input::integer("elements", "elements of each member at least")
          .or_default("4")
          .at_least(1)
          .at_most(100000),
      input::quantity("size", dim::length, "greatest length of an element").above(0),
      input::quantity("frequency", dim::frequency, "resolve all waves up to this frequency").above(0),
      input::quantity("frequency_error", dim::none, "relative error wanted there")
          .or_default("0.001")
          .above(0),
  };
  return s;
}

TableSchema link_schema() {
  TableSchema s{.name = "link",
                .doc =
                    "A spring, a damper or both between two nodes, along the line that joins them; alike in "
                    "all directions "
                    "where they lie in one place. There is none to the ground: give the node an interface "
                    "and the mechanism a "
                    "force element between it and the ground."};
  s.keys = {
      input::texts("nodes", "its two nodes; those of a solid are \"NAME.INTERFACE\"").required().sized(2),
      input::quantity("stiffness", dim::stiffness, "of the spring").or_default("0").at_least(0),
      input::quantity("damping", dim::damping, "of the damper; goes into D_se").or_default("0").at_least(0),
  };
  return s;
}

TableSchema solid_schema() {
  TableSchema s{
      .name = "solid",
      .doc =
          "A solid in the structure. Each of its interfaces becomes a node \"NAME.INTERFACE\", tied to the "
          "faces as its part file says; members and interfaces take hold there. Solid and beams share "
          "one frame. Its modes limit what the structure can show of its vibration."};
  s.keys = {
      input::text("part", "part file of the solid, relative to this file; it is reduced first"),
      input::text("superelement", "instead: a superelement that `flexura reduce` made"),
      input::integer("modes", "number of its modes, instead of what its part file says")
          .at_least(0)
          .at_most(20000),
  };
  return s;
}

}  // namespace

const TableSchema& beam_schema() {
  static const TableSchema schema = [] {
    TableSchema node{.name = "node", .doc = "A point of the structure."};
    node.keys = {input::vector3("position", dim::length, "in the part's frame").required()};
    TableSchema mass{.name = "mass", .doc = "A rigid body on a node."};
    mass.keys = {
        input::text("node", "where").required(),
        input::quantity("mass", dim::mass, "mass").required().at_least(0),
        input::vector3("center", dim::length, "from the node to the centre of mass"),
        input::vector3("inertia", dim::inertia, "I_xx, I_yy, I_zz about the centre of mass"),
        input::vector3("products", dim::inertia, "I_xy, I_yz, I_zx (entries of the inertia tensor)"),
    };
    TableSchema interface {
      .name = "interface", .doc = "A node where other bodies, joints and forces take hold."
    };
    interface.keys = {input::text("node", "name of the node; default: the interface's own name"),
                      input::texts("directions", "kept: some of x, y, z, rx, ry, rz; default: all")};
    TableSchema s{.name = "beam part file",
                  .doc =
                      "A structure of beams for `flexura reduce`. Quantities carry their unit (\"210 GPa\", "
                      "\"12 mm\"); plain numbers are SI. A file with a table [member.NAME] or [curves.NAME] "
                      "is read as a beam part."};
    s.keys = {
        input::text("name", "name of the part; default: the file's name"),
        input::flag("stiffening",
                    "keep the geometric stiffening terms: what axial forces of loads and rotation add to the "
                    "stiffness")
            .or_default("false"),
        input::table_map("material", beam_material_schema(), "material by name"),
        input::table_map("section", beam_section_schema(), "cross-section by name").required(),
        input::table_map("node", node, "node by name"),
        input::table_map("member", member_schema(), "member by name"),
        input::table_map("curves", curves_schema(), "members from a file of curves"),
        input::table_map("solid", solid_schema(), "solids that members hold on to"),
        input::table_map("mass", mass, "point masses by name"),
        input::table_map("interface", interface, "interfaces by name"),
        input::table_map("link", link_schema(), "springs and dampers by name"),
        input::table_map("load", load_schema(), "loads by name"),
        input::table("mesh", mesh_schema(), "division into elements"),
        input::table("modes", modes_schema(), "modes"),
        input::table("damping", damping_schema(), "damping"),
        input::table("recovery", recovery_schema(), "stresses"),
    };
    return s;
  }();
  return schema;
}

}  // namespace flexura::reduce
