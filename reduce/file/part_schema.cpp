// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/part_file.hpp"
#include "reduce/file/part_modes.hpp"

namespace flexura::reduce {

using input::TableSchema;
namespace dim = input::dim;

namespace {

TableSchema geometry_schema() {
  TableSchema s{
      .name = "geometry",
      .doc =
          "The part, relative to the part file: a CAD file (STEP, IGES, BREP) or a closed surface of "
          "triangles (STL), which is meshed, or a "
          "mesh: gmsh (.msh), Abaqus or CalculiX (.inp), Nastran (.bdf, .dat, .nas), I-DEAS "
          "(.unv), with its solids, shells, beams, springs, materials, sets, ties and point masses."};
  s.keys = {
      input::text("file", "CAD file or mesh").required(),
      input::choice(
          "unit", {"m", "mm", "cm", "um", "inch", "ft"},
          "length unit of the file. CAD: overrides what the file says (BREP and STL files say nothing: mm). "
          "Meshes say nothing: m"),
      input::choice("mass_unit", {"kg", "t", "g", "lbf s^2/in", "slug"},
                    "mass unit of a deck with materials or masses, the time being s; default: what goes with "
                    "the length unit (m: kg, mm: t, inch: lbf s^2/in, ft: slug)"),
      input::choice(
          "program", {"abaqus", "calculix"},
          "whose words a deck (.inp) speaks where they differ (*BEAM SECTION, SECTION=CIRC: radius or "
          "diameter); default: what the deck itself tells, else calculix, with a warning"),
      input::quantity("density", dim::density, "of a deck's materials that have none (`--density`)").above(0),
      input::choice("keep", {"largest", "all"},
                    "of a deck that falls into pieces that nothing joins: the largest alone, or all, each "
                    "with the mean motion of its own for an interface where no other interface holds it; "
                    "default: such a deck is refused"),
      input::flag(
          "strict",
          "refuse a deck of which something is left out or repaired that changes the body, instead of "
          "warning (`--strict`)")
          .or_default("false"),
      input::integer("solid", "which solid of the file, counted from 1 as `--list-faces` prints them")
          .at_least(1),
      input::flag("fuse", "join all solids of the file into one").or_default("false"),
      input::flag("heal",
                  "let the CAD kernel repair the shape before meshing; may change its volume slightly")
          .or_default("false"),
  };
  return s;
}

TableSchema mesh_schema() {
  TableSchema s{.name = "mesh", .doc = "How the geometry is meshed. May be left out."};
  s.keys = {
      input::choice(
          "formulation", {"standard", "enhanced"},
          "`enhanced`: eight-node hexahedra of a mesh file with modes that keep them from locking in "
          "bending")
          .or_default("standard"),
      input::integer("order", "1: four-node, 2: ten-node tetrahedra").or_default("2").at_least(1).at_most(2),
      input::quantity("size", dim::length, "element size; chosen from the part's dimensions when left out")
          .above(0),
      input::quantity("elements_per_circle", dim::none,
                      "refine curved faces so that a full circle takes this many elements; 0: no refinement")
          .or_default("8")
          .at_least(0),
      input::quantity("time_limit", dim::time, "give the mesher up after this time")
          .or_default("600 s")
          .above(0),
  };
  return s;
}

TableSchema material_schema() {
  TableSchema s{
      .name = "material",
      .doc =
          "A linear elastic material: isotropic (`young`, `poisson`) or orthotropic (`moduli`, `ratios`, "
          "`shear`). `density` alone: a deck's material of this name, which has none."};
  s.keys = {
      input::quantity("young", dim::pressure, "Young's modulus").above(0),
      input::quantity("poisson", dim::none, "Poisson's ratio").above(-1).below(0.5),
      input::quantities("moduli", dim::pressure, "orthotropic: E_x, E_y, E_z").sized(3),
      input::quantities(
          "ratios", dim::none,
          "orthotropic: nu_xy, nu_yz, nu_zx; nu_xy is the contraction along y when pulled along x, "
          "nu_xy / E_x = nu_yx / E_y")
          .sized(3),
      input::quantities("shear", dim::pressure, "orthotropic: G_xy, G_yz, G_zx").sized(3),
      input::vector3("axis_x", dim::none,
                     "orthotropic: direction of the material's x in the part; default [1, 0, 0]"),
      input::vector3(
          "axis_y", dim::none,
          "orthotropic: a direction in the material's x-y plane, on the side of y; default [0, 1, 0]"),
      input::quantity("density", dim::density, "mass per volume").required().above(0),
  };
  return s;
}

TableSchema interface_schema() {
  TableSchema s{
      .name = "interface",
      .doc =
          "Where other bodies, joints and forces take hold. Each becomes one node of six degrees of "
          "freedom, tied to the chosen faces. A deck with ties (RBE2, RBE3) needs no such table: without "
          "any, each tie becomes an interface called \"tie NUMBER\"."};
  s.selector = "by";
  s.keys = {
      input::choice("by", {"cylinder", "plane", "near", "faces", "group", "nodes", "tie"},
                    "how the faces are chosen")
          .required(),
      input::choice(
          "tie", {"rigid", "average", "node", "elastic"},
          "`rigid`: the faces follow the node as one rigid piece (RBE2). `average`: the node follows the "
          "area-weighted mean motion of the faces and does not stiffen them (RBE3). `node`: a single node of "
          "the mesh, displacements only. `elastic`: every node of the faces moves on its own; the node has "
          "their mean motion, as with `average`, their deformation is reduced to interface modes "
          "(`interface_count` and the like in [modes]), which stand beside the others. Without such modes it "
          "is `rigid`, with all of them `average`")
          .or_default("rigid"),
      input::choice(
          "weights", {"area", "equal"},
          "whose mean an `average` or `elastic` tie takes: every face counts by its area, or every node "
          "alike. Default: `area`, with `by = \"nodes\"` `equal`; nodes that form no faces count alike. "
          "The ties of a deck have weights of their own"),
      input::vector3(
          "reference", dim::length,
          "position of the interface node; default: centre of the chosen faces, for a cylinder the middle "
          "of its axis"),
      input::texts(
          "directions",
          "directions that joints and forces may use, of x, y, z, rx, ry, rz; default: all. The others "
          "stay free inside the part"),
  };
  const auto point = [](const char* doc) { return input::vector3("point", dim::length, doc).required(); };
  s.variants["cylinder"] = {
      .name = "interface by cylinder",
      .keys = {
          point("a point on the axis"), input::vector3("axis", dim::none, "direction of the axis").required(),
          input::quantity("radius", dim::length,
                          "radius; may be left out where only one cylinder has this axis")
              .above(0),
          input::quantities("extent", dim::length,
                            "only faces between these two distances along the axis, counted from `point`")
              .sized(2)}};
  s.variants["plane"] = {.name = "interface by plane",
                         .keys = {point("a point in the plane"),
                                  input::vector3("normal", dim::none, "normal of the plane").required()}};
  s.variants["near"] = {
      .name = "interface by nearness",
      .keys = {
          point("the nearest face is taken"),
          input::quantity("radius", dim::length, "take every face within this distance instead").above(0)}};
  s.variants["faces"] = {
      .name = "interface by face numbers",
      .keys = {input::integers("faces", "face numbers as `--list-faces` prints them").required()}};
  s.variants["group"] = {.name = "interface by group",
                         .keys = {input::text("group", "name of a physical group or named set").required()}};
  s.variants["nodes"] = {.name = "interface by nodes",
                         .keys = {input::integers("nodes", "node numbers of the mesh file").required()}};
  s.variants["tie"] = {.name = "interface by tie of the deck",
                       .keys = {input::integer("element", "number of the RBE2 or RBE3").required()}};
  return s;
}

TableSchema shell_schema() {
  TableSchema s{.name = "shell",
                .doc =
                    "Sheet metal: the faces of a CAD file without solids, or the triangles and "
                    "quadrilaterals of a .msh mesh, are the middle "
                    "surface of a sheet, of shells with six degrees of freedom a node (docs/shells.md). "
                    "Faces that meet are joined. Interfaces are chosen as on solids; where no face "
                    "fits, `by = \"plane\"` takes the free edges in the plane and `by = \"cylinder\"` with "
                    "its radius the edge of a hole."};
  s.keys = {input::quantity("thickness", dim::length, "of the sheet, half of it on either side of the faces")
                .required()
                .above(0)};
  return s;
}

TableSchema matrices_schema() {
  TableSchema s{
      .name = "matrices",
      .doc =
          "Stiffness, mass and damping as another program assembled them, instead of the elements': Matrix "
          "Market, Abaqus' coordinate format or matrix input, DMIG of Nastran (bulk data or .pch), also "
          "gzipped, or its "
          "OUTPUT4 (.op4, binary or not); "
          "of several in a file the one whose name begins with K, M or B. DMIG with scalar points is a body "
          "that is "
          "reduced already: grid points are interfaces, scalar points modes. The geometry file gives "
          "the nodes: a mesh, or a table of node number, x, y, z (.csv, .txt). Rows go by "
          "ascending node number, three directions each, or six where nodes of shells and beams have "
          "rotations: "
          "interfaces of a single node then have all six directions."};
  s.keys = {
      input::text("stiffness", "file of K").required(),
      input::text(
          "mass",
          "file of M; alike in the three directions, as solids, shells and lumped beams have it (not "
          "consistent beams), coupled to rotations by offsets alone, with any rotary inertia; a lumped one "
          "will do")
          .required(),
      input::text("damping",
                  "file of D; becomes D_se = T^T D T. What resists rigid motion, as damping in proportion to "
                  "the mass "
                  "does, is left out: forces of the mechanism stand for what surrounds the body"),
  };
  return s;
}

TableSchema mass_schema() {
  TableSchema s{.name = "mass_point",
                .doc = "A rigid piece of mass on an interface (rigid tie) or on a node of the mesh."};
  s.keys = {
      input::quantity("mass", dim::mass, "its mass").required().above(0),
      input::text("interface", "interface that carries it"),
      input::integer("node", "or the number of a node of the mesh file"),
      input::vector3("offset", dim::length, "from the interface node to its mass centre; default: none"),
      input::quantities("inertia", dim::inertia, "moments of inertia xx, yy, zz about its mass centre")
          .sized(3),
  };
  return s;
}

TableSchema link_schema() {
  TableSchema s{
      .name = "link",
      .doc =
          "A spring, a damper or both between two places of the part, along the line that joins "
          "them; alike in all directions where they coincide. There is none to the ground: it would "
          "resist rigid motion, which belongs to the mechanism and knows no bounds there. Give the "
          "place an interface and the mechanism a force element between it and the ground: "
          "`spring_damper` along a line, `bushing` in all six directions."};
  s.keys = {
      input::texts("interfaces", "two interfaces (rigid ties)").sized(2),
      input::integers("nodes", "or two node numbers of the mesh file").sized(2),
      input::quantity("stiffness", dim::stiffness, "of the spring").or_default("0").at_least(0),
      input::quantity("damping", dim::damping, "of the damper; goes into D_se").or_default("0").at_least(0),
  };
  return s;
}

TableSchema load_schema() {
  TableSchema s{.name = "load",
                .doc =
                    "A distributed load that is kept for run time under its name: forces of the type "
                    "`distributed_load` put it on the body, times a formula."};
  s.selector = "type";
  s.keys = {
      input::choice("type", {"gravity", "rotation", "pressure", "field", "preload"}, "what acts").required(),
      input::flag("keep_shape",
                  "keep the part's static answer to it as a shape, so that this load is exact in statics")
          .or_default("false"),
  };
  s.variants["gravity"] = {
      .name = "load by gravity",
      .keys = {input::vector3("acceleration", dim::acceleration, "that pulls on every mass").required()}};
  s.variants["rotation"] = {
      .name = "load by rotation",
      .keys = {input::vector3("point", dim::length, "a point on the axis").required(),
               input::vector3("axis", dim::none, "direction of the axis").required(),
               input::quantity("speed", dim::angular_velocity, "centrifugal load of this speed").required()}};
  s.variants["pressure"] = {
      .name = "load by pressure",
      .keys = {
          input::text("group", "named set whose faces it pushes on"),
          input::integers("faces", "or face numbers as `--list-faces` prints them"),
          input::quantity("pressure", dim::pressure, "pushes against the faces").required(),
          input::vector3("side", dim::none,
                         "of shells: the pushed side looks this way, in the part's axes (of a closed shell: "
                         "outwards, seen from there); default: the side of their numbering, of which a "
                         "quarter at most may differ")}};
  s.variants["field"] = {
      .name = "load by formulas",
      .keys = {input::text("x", "force per mass along x [m/s^2], a formula of x, y, z [m]").or_default("0"),
               input::text("y", "along y").or_default("0"), input::text("z", "along z").or_default("0")}};
  s.variants["preload"] = {
      .name = "preload inside the part",
      .doc =
          "A preload of the part itself, which holds itself in balance: a bolt that is tightened, a ring "
          "shrunk on, a wire too "
          "short, heat. Its static answer is always kept. With stiffening = true the superelement knows what "
          "it adds to the "
          "stiffness, too.",
      .keys = {input::expression(
                   "strain",
                   "strain that the material would take if it were free, a number or a formula of x, "
                   "y, z [m], taken "
                   "in the middle of each element: below zero it is too short, and pulls. A "
                   "conditional confines it: "
                   "\"x > 0.1 ? -1e-4 : 0\"")
                   .required(),
               input::vector3(
                   "axis", dim::none,
                   "the strain is along this direction alone (a bolt); without it in all (heat: expansion "
                   "coefficient times temperature)"),
               input::text("material", "only the elements of this material")}};
  return s;
}

TableSchema solver_schema() {
  TableSchema s{.name = "solver",
                .doc = "How PETSc and SLEPc compute. May be left out: the defaults are the fast ones."};
  s.keys = {
      input::text("petsc",
                  "options of PETSc and SLEPc as one text, `\"-eps_type krylovschur "
                  "-pc_factor_mat_solver_type mumps\"`; "
                  "those of `--petsc` are added. docs/petsc.md says which make sense"),
  };
  return s;
}

}  // namespace

const TableSchema& part_schema() {
  static const TableSchema schema = [] {
    TableSchema s{.name = "part file",
                  .doc =
                      "What `flexura reduce` takes. Lengths, moduli and the like are written with their unit "
                      "(\"210 GPa\", \"12 mm\"); plain numbers are SI."};
    s.keys = {
        input::text("name", "name of the part; default: the file's name"),
        input::choice("mass", {"consistent", "lumped", "reduced"},
                      "mass matrix of the elements; `reduced`: consistent, but integrated at the stiffness's "
                      "points, as CalculiX does with ten-node tetrahedra")
            .or_default("consistent"),
        input::flag("stiffening",
                    "keep the geometric stiffening terms: what loads and rotation add to the stiffness")
            .or_default("false"),
        input::table("geometry", geometry_schema(), "CAD part").required(),
        input::table("mesh", mesh_schema(), "meshing"),
        input::table_map("material", material_schema(),
                         "material by name: exactly one for a CAD part; for a deck, in place of its own"),
        input::table_map("interface", interface_schema(), "interfaces by name"),
        input::table("shell", shell_schema(), "sheet metal"),
        input::table("matrices", matrices_schema(), "finished matrices"),
        input::table("mode_vectors", mode_vectors_schema(), "finished modes"),
        input::table_map("mass_point", mass_schema(), "point masses by name"),
        input::table_map("link", link_schema(), "springs and dampers by name"),
        input::table_map("load", load_schema(), "load cases by name"),
        input::table("modes", solid_modes_schema(), "modes"),
        input::table("damping", damping_schema(), "damping"),
        input::table("recovery", solid_recovery_schema(), "stresses"),
        input::table("solver", solver_schema(), "solvers"),
    };
    return s;
  }();
  return schema;
}

}  // namespace flexura::reduce
