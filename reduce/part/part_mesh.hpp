// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mesh/gmsh/cad.hpp"
#include "mesh/import/imported.hpp"
#include "reduce/assembly/input/part.hpp"
#include "reduce/part/part_input.hpp"
#include "reduce/part/read_matrices.hpp"

/// What a part is reduced from, wherever it came from: a CAD file meshed here, or a mesh or deck of another
/// program with its materials, ties and masses.
namespace flexura::reduce {

/// A tie of the deck: an interface if the part file takes it as one, otherwise a rigid piece of the part.
struct DeckTie {
  std::int64_t label = 0;  ///< element number in the deck
  std::int64_t node = 0;   ///< number of its reference node
  InterfaceSpec spec;      ///< named "tie LABEL"; turning_node: the index of the reference node
  std::array<bool, 6> dofs{true, true, true,
                           true, true, true};  ///< of the reference node that an average gives
  /// Rigid ties whose reference node is this one's or follows it: one piece with it, each known by its own number and node.
  struct Joined {
    std::int64_t label, node;
    Eigen::Vector3d point;  ///< of its reference node
  };
  std::vector<Joined> joined;
};

struct PartMesh {
  mesh::Mesh mesh;
  std::vector<mesh::Face> faces;  ///< of the CAD part; empty for meshes
  std::vector<Material> materials;
  std::optional<GivenMatrices> matrices;  ///< instead of elements and materials
  std::vector<DeckTie> ties;
  std::vector<mesh::ImportedBar> bars;
  std::vector<mesh::ImportedSpring> springs;
  std::vector<mesh::ImportedEquation> equations;
  std::vector<PointMass> masses;       ///< on nodes of the mesh
  std::vector<PointMass> tied_masses;  ///< on reference nodes of ties: `node` is the place in `ties`
  mesh::MeshReport report;             ///< cad_volume is 0 for meshes
  std::vector<std::string> messages;   ///< from readers and meshers
  std::vector<std::string> warnings;   ///< from readers: the mesh is not all that the file describes
};

/// Meshes or reads.  Materials of the part file replace those of the deck that have the same name; where the
/// deck has none, the part file must give exactly one.  Throws input::InputError and what the readers throw.
PartMesh load_part_mesh(const PartInput& input, const mesh::Progress& progress);

/// The nodes alone of a mesh file or a table, in m, whatever else it lacks.
mesh::Mesh load_nodes(const PartInput& input);

}  // namespace flexura::reduce
