// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string>
#include <vector>

#include "beam/model/mesh.hpp"
#include "reduce/cms/result/reduction.hpp"

/// A structure of beams, and of solids that hang on its nodes.
///
/// A solid comes as its own Craig-Bampton reduction, u = T u_se with u_se = (u_b, eta): its interface nodes
/// are nodes of the beam model (six dofs each, tied to faces), its modes are dofs of the structure.  So
///
///     K = sum of beams + K_se,   M = sum of beams + M_se
///
/// on the dofs (6 for each node, then the modes of each solid).  Static behaviour is that of the solid's
/// mesh, exactly; frequencies converge from above with the number of its modes (R. R. Craig, M. C. C.
/// Bampton, AIAA J. 6 (1968) 1313, for whom this coupling was the purpose).
namespace flexura::reduce {

/// Vertices, triangles and edges of a picture.
struct Picture {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> vertices;  ///< [m] in B
  Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor> triangles;
  Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor> edges;
};

struct AttachedSolid {
  std::string name;
  Reduction reduction;    ///< every interface with all six directions; `shapes` at the picture's vertices
  std::vector<int> node;  ///< node of the beam model at each interface
  Picture picture;
};

/// A spring and a damper between two nodes of the beam model, along the line that joins them; where they lie in one place,
/// alike in all directions.
struct NodeLink {
  std::string name;
  std::array<int, 2> node{-1, -1};
  double stiffness = 0.0;  ///< [N/m]
  double damping = 0.0;    ///< [N s/m]
};

class Structure {
 public:
  /// Throws std::invalid_argument for solids whose interfaces lack directions or lie elsewhere than their
  /// node.
  Structure(beam::BeamMesh mesh, std::vector<AttachedSolid> solids = {}, std::vector<NodeLink> links = {},
            bool fine_outlines = false);  // beams alone are a structure

  const beam::BeamMesh& mesh() const { return mesh_; }
  const std::vector<AttachedSolid>& solids() const { return solids_; }
  int n_dofs() const { return n_dofs_; }
  /// Dofs that something is attached to; the others (nodes that only show a direction) have no stiffness.
  const std::vector<bool>& used() const { return used_; }
  /// Dof of the structure at each dof of a solid's reduction.
  const std::vector<int>& dofs_of_solid(int solid) const { return dofs_[solid]; }

  beam::SparseMatrix stiffness() const;
  beam::SparseMatrix mass(bool rotary_inertia = true) const;
  beam::InertiaSums inertia() const;
  /// U^T K U without the round-off that K itself brings (beam::strain_energy).
  Eigen::MatrixXd strain_energy(const Eigen::MatrixXd& U) const;
  /// U^T D U of dampers, those of solids among them; empty where there are none.
  Eigen::MatrixXd damping(const Eigen::MatrixXd& U) const;

  /// "node \"a\", about x" for messages.
  std::string describe(int dof) const;

  /// Beams and solids together, and the displacements of their vertices: rows 3 v + a of shapes(U), U n_dofs
  /// x k.
  const Picture& picture() const { return picture_; }
  /// The members' share of it, which comes first.
  const beam::ExtrudedSurface& outlines() const { return beams_; }
  Eigen::MatrixXf shapes(const Eigen::MatrixXd& U) const;

 private:
  /// Those in which a link acts, 3 x 3.
  Eigen::Matrix3d directions(const NodeLink& link) const;
  /// The relative displacement of a link's nodes that it resists: 3 x k of the rows of U.
  Eigen::MatrixXd stretch(const NodeLink& link, const Eigen::MatrixXd& U) const;

  beam::BeamMesh mesh_;
  std::vector<AttachedSolid> solids_;
  std::vector<NodeLink> links_;
  int n_dofs_ = 0;
  std::vector<bool> used_;
  std::vector<std::vector<int>> dofs_;
  beam::ExtrudedSurface beams_;
  Picture picture_;
};

}  // namespace flexura::reduce
