// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

#include "beam/model/model.hpp"

/// The beam model divided into elements, its matrices, and what is recovered from its displacements.
/// Six dofs a node: u_x, u_y, u_z, theta_x, theta_y, theta_z in B, dof 6 n + k.
namespace flexura::beam {

using SparseMatrix = Eigen::SparseMatrix<double>;

struct MeshElement {
  int member = -1;
  std::array<int, 2> node = {-1, -1};  ///< of the mesh
  double t_1 = 0.0, t_2 = 1.0;         ///< the part of the member it covers
  Placement placement;
  Releases releases;
};

/// Nodes 0 .. model.nodes.size() - 1 are the model's, the others lie inside members.
class BeamMesh {
 public:
  /// Checks the model (see check) and divides it.
  BeamMesh(Model model, const Subdivision& rule);

  const Model& model() const { return model_; }
  const std::vector<Eigen::Vector3d>& points() const { return points_; }  ///< p_BoN_B of each node
  const std::vector<MeshElement>& elements() const { return elements_; }
  int n_dofs() const { return 6 * static_cast<int>(points_.size()); }
  Element element(const MeshElement& record) const;

 private:
  Model model_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<MeshElement> elements_;
};

/// Lower and upper triangle, n_dofs x n_dofs.
SparseMatrix stiffness_matrix(const BeamMesh& mesh);
/// U^T K U (U n_dofs x k) summed from the stretch of each element instead of from K: eigenvalues by
/// Rayleigh's quotient keep eps n^2 where K leaves eps n^4, n the number of elements on half a wave.
Eigen::MatrixXd strain_energy(const BeamMesh& mesh, const Eigen::MatrixXd& U);

/// Where round-off becomes noticeable (figures: EXTREMES.md), in sentences: members of 1,000 elements and
/// more, and elements that meet with stiffnesses 1e8 times apart.
std::vector<std::string> accuracy_warnings(const BeamMesh& mesh);

SparseMatrix mass_matrix(const BeamMesh& mesh, bool rotary_inertia = true);

/// Integrals of products of position and displacement over all beams and point masses, dof by dof: a reducer
/// contracts them with its shapes (S_phi = S_u T, S_phiphi(ab) = T^T S_uu(ab) T; names as in
/// mbs/superelement/superelement.hpp).
struct InertiaSums {
  double mass = 0.0;
  Eigen::Vector3d S_x = Eigen::Vector3d::Zero();
  Eigen::Matrix3d S_xx = Eigen::Matrix3d::Zero();
  Eigen::Matrix3Xd S_u;              ///< 3 x n_dofs
  Eigen::MatrixXd S_xu;              ///< 9 x n_dofs, row 3 a + b
  std::array<SparseMatrix, 6> S_uu;  ///< (a, b) = xx, yy, zz, xy, yz, zx
};
InertiaSums inertia_sums(const BeamMesh& mesh);

/// Loads along members, linear over the whole member.
struct MemberLoad {
  int member = -1;
  LineLoad load;             ///< at the member's two ends
  bool element_axes = true;  ///< false: components in B
};
Eigen::VectorXd load_vector(const BeamMesh& mesh, const std::vector<MemberLoad>& loads);
/// What of them lies on the element, in its axes.
LineLoad load_on(const MeshElement& record, const std::vector<MemberLoad>& loads);

/// Resultants at places along a member: exact for nodal displacements u under end and line loads.
struct MemberResult {
  double x = 0.0;         ///< along the member [m]
  Vector6d resultants;    ///< N, V_y, V_z, T, M_y, M_z in the member's axes [N, N m]
  Vector6d displacement;  ///< of the axis, in the member's axes [m, rad]
};
std::vector<MemberResult> member_results(const BeamMesh& mesh, int member, const Eigen::VectorXd& u,
                                         int places, const std::vector<MemberLoad>& loads = {});

/// The extruded surface of all members with an outline.  Vertex displacement = at[v] * (12 nodal dofs of
/// element[v]).
struct ExtrudedSurface {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> vertices;  ///< [m] in B
  Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor> triangles;    ///< counter-clockwise from outside
  Eigen::Matrix<int, Eigen::Dynamic, 2, Eigen::RowMajor> edges;        ///< outlines at the members' ends
  std::vector<int> element;
  std::vector<Eigen::Matrix<double, 3, 12>> at;
  std::vector<double> x;                ///< of each vertex in its element [m]
  std::vector<Eigen::Vector2d> across;  ///< y, z in the member's axes [m]
};
/// `slices` along each member, fewer (and fewer corners on round sections) where the vertices would exceed
/// `most_vertices`.  `fine`: straight sides of standard sections have points between their corners.
ExtrudedSurface extruded_surface(const BeamMesh& mesh, int slices = 8, int most_vertices = 40000,
                                 bool fine = false);

}  // namespace flexura::beam
