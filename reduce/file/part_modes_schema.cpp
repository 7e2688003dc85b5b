// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/part_file.hpp"
#include "reduce/file/part_modes.hpp"

/// The keys of modes: what is kept of a part's shapes, or brought along finished.
namespace flexura::reduce {

using input::Key;
using input::TableSchema;
namespace dim = input::dim;

TableSchema modes_schema() {
  TableSchema s{.name = "modes",
                .doc =
                    "Which shapes stand beside the interface's own. May be left out. Where materials of a "
                    "deck or a damping "
                    "matrix bring the part's damping, `damping` is 0 unless it is given."};
  s.keys = {
      input::choice(
          "set", {"craig_bampton", "craig_chang", "guyan"},
          "`craig_bampton`: fixed-interface modes. `craig_chang`: free-free modes and inertia-relief "
          "attachment modes. `guyan`: none; MotionSolve takes `mass = \"lumped\"` with it")
          .or_default("craig_bampton"),
      input::integer("count", "number of modes").or_default("20").at_least(0).at_most(20000),
      input::quantity("up_to", dim::frequency, "keep all modes up to this frequency instead of a fixed count")
          .above(0),
      input::quantity("damping", dim::none,
                      "modal damping ratio proposed to the runtime (diagonal in modal space)")
          .or_default("0.01")
          .at_least(0),
      input::quantity(
          "accuracy", dim::none,
          "choose mesh and modes so that the body's frequencies below `up_to` (without it the first "
          "six of the free body) and the static compliance between the interfaces are within this "
          "(\"1 %\") by their estimates; CAD parts are meshed anew, finer where the error is, until "
          "they are. Members of beams get as many elements as that takes; a mesh that comes with the part "
          "stays: its share is "
          "reported")
          .above(0)
          .below(1),
      input::quantity(
          "compliance_accuracy", dim::none,
          "accuracy of the static compliance between the interfaces where another one than that of the "
          "frequencies is wanted (default: `accuracy`)")
          .above(0)
          .below(1),
      input::quantity("effective_mass", dim::none,
                      "keep modes until they hold this fraction of the interior's mass and inertia in every "
                      "direction")
          .above(0)
          .below(1),
      input::quantities("response_at", dim::frequency,
                        "add frequency response modes: the part's exact answer to loads at its interfaces at "
                        "these frequencies (0: slow acceleration)"),
      input::integers("strike_modes",
                      "natural modes of the free body to strike out, by number as `flexura modes --free` "
                      "prints them"),
      input::flag("certify", "prove by Sylvester's law that no mode was missed; takes another factorisation")
          .or_default("true"),
  };
  return s;
}

TableSchema solid_modes_schema() {
  TableSchema s = modes_schema();
  const std::vector<Key> more = {
      input::integer("interface_count",
                     "elastic ties: number of interface modes (characteristic constraint modes)")
          .or_default("20")
          .at_least(0)
          .at_most(20000),
      input::quantity("interface_up_to", dim::frequency,
                      "elastic ties: keep all interface modes up to this frequency instead")
          .above(0),
      input::quantity("interface_accuracy", dim::none,
                      "elastic ties: or as many as bring the static stiffness between the interfaces to this "
                      "accuracy (\"1 %\") of the averaging tie's")
          .above(0)
          .below(1),
  };
  s.keys.insert(s.keys.end(), more.begin(), more.end());
  return s;
}

TableSchema mode_vectors_schema() {
  TableSchema s{
      .name = "mode_vectors",
      .doc =
          "Finished modes: vectors that another FE program has computed (free modes, constraint or "
          "attachment modes, in any mixture), with their reduced matrices, instead of a reduction here. They "
          "are orthonormalised together with the six rigid motions; the interfaces' dofs become coordinates "
          "as usual. The geometry file gives the nodes: a mesh, or a table (.csv, .txt). Dense matrices: "
          "Matrix Market, or text with a row in each line, also gzipped, or OUTPUT4 of Nastran (.op4). Of "
          "[modes] only `damping` and "
          "`strike_modes` apply."};
  s.keys = {
      input::text(
          "vectors",
          "file of the displacements: a column for each vector, rows by ascending node number, three "
          "directions each, or six with the rotations of the nodes, by which interfaces of one node or on a "
          "line turn; displacements free of unit, or all in the length unit of the file (rotations per unit)")
          .required(),
      input::text("stiffness", "file of the reduced stiffness, V^T K V").required(),
      input::text("mass",
                  "file of the part's mass matrix by nodes, as in [matrices], which the inertia integrals "
                  "need; a lumped (diagonal) one will do")
          .required(),
      input::text("damping", "file of the reduced damping, V^T D V"),
      input::text("reduced_mass", "file of V^T M V as the FE program has it, for comparison"),
      input::text("stress",
                  "file of stress modes: a column for each vector, rows xx, yy, zz, xy, yz, zx of each node "
                  "by ascending "
                  "number, or of what `stress_at` says"),
      input::choice(
          "stress_at", {"nodes", "elements", "corners"},
          "`elements`: six rows for each element by ascending number; `corners`: for each node of each "
          "element, by ascending numbers. A node's stress is then the mean of those of all elements that "
          "have it")
          .or_default("nodes"),
  };
  return s;
}

TableSchema damping_schema() {
  TableSchema s{.name = "damping",
                .doc =
                    "Damping beyond the one ratio of [modes]: it becomes the matrix D_se, and the ratio of "
                    "[modes] is not used."};
  s.keys = {
      input::quantities("frequencies", dim::frequency, "frequencies of a table, ascending"),
      input::quantities("ratios", dim::none, "ratio to critical at each; linear between, constant beyond"),
      input::quantity(
          "critical_above", dim::frequency,
          "modes from this frequency are damped critically: they follow without ringing; without a "
          "table those below keep the ratio of [modes]")
          .above(0),
      input::quantity("alpha", dim::frequency,
                      "Rayleigh: times the mass matrix [1/s], less what resists rigid motion: drag of a free "
                      "part is a force of the mechanism (or rayleigh_alpha of its body)")
          .or_default("0")
          .at_least(0),
      input::quantity("beta", dim::time, "Rayleigh: times the stiffness matrix").or_default("0").at_least(0),
  };
  return s;
}

TableSchema recovery_schema() {
  TableSchema s{.name = "recovery",
                .doc = "What the superelement keeps besides the displacements of its surface."};
  s.keys = {
      input::flag(
          "stress",
          "stress modes: nodal stresses of every shape on the surface, for von Mises stress and the "
          "like at run time. Each element's stress is taken at the node itself; the node has the mean of the "
          "elements that share it, where materials meet of those of the material with most of them. Shells "
          "have them on both sides, of membrane and bending")
          .or_default("false"),
      input::choice("nodes", {"surface", "all"},
                    "`all`: the whole of T, all six motions of every node of the mesh or of the beams, "
                    "interior ones too "
                    "(group `nodes` of the superelement, `flexura export --format nodes`). Rotations are "
                    "those of shells and beams; "
                    "of solids half the curl of their displacements")
          .or_default("surface"),
      input::choice("precision", {"single", "double"}, "how stress modes and motions of all nodes are stored")
          .or_default("single"),
  };
  return s;
}

TableSchema solid_recovery_schema() {
  TableSchema s = recovery_schema();
  s.keys.push_back(input::texts(
      "groups", "stress modes only at the nodes of these named sets; default: the whole surface"));
  return s;
}

}  // namespace flexura::reduce
