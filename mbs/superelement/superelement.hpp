// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mbs/superelement/mesh_error.hpp"

/// The superelement: the one thing that passes from the reduction program to the runtime.
///
/// A body is described by n = n_b + n_q shape functions phi_k (the columns of the recovery matrix T): n_b
/// constraint modes, one for each interface degree of freedom, then n_q fixed-interface normal modes.
///
///     u(x) = sum_k phi_k(x) u_se,k,     u_se = (u_b, eta),     K_se = T^T K T,   M_se = T^T M T
///
/// Everything is SI and expressed in the superelement frame B, the coordinate system of the part's CAD file
/// or mesh. The file layout is described in FORMAT.md beside this header.
namespace flexura::superelement {

/// Directions of an interface node, in the order of its columns.
enum class Direction : std::uint8_t { u_x, u_y, u_z, theta_x, theta_y, theta_z };

/// An interface node: the point to which a face, an edge or a node of the mesh is tied.
struct Interface {
  std::string name;
  std::string tie;                                    ///< "rigid" (RBE2), "average" (RBE3), "node", "elastic"
  Eigen::Vector3d p_BoN_B = Eigen::Vector3d::Zero();  ///< [m]
  std::vector<Direction>
      directions;     ///< retained directions, usually all six; displacement [m], rotation [rad]
  int first_dof = 0;  ///< column of directions[0] in the matrices
  /// Directions that move but are no coordinates, as the shapes of a body of few modes do not move them independently of the
  /// others: (u, theta)(following[k]) = follow.row(k) u_se.  They are held where the others are.
  std::vector<Direction> following = {};
  Eigen::MatrixXd follow = {};  ///< following.size() x n
  /// Directions that the interface does not keep: the deformation of the part moves them, (u, theta)(free[k]) = free_motion.row(k)
  /// u_se, whatever the interface does.
  std::vector<Direction> free = {};
  Eigen::MatrixXd free_motion = {};  ///< free.size() x n
};

/// Integrals over the undeformed body of products of position x and shapes phi, taken from the consistent
/// mass matrix. They are complete: every inertia coupling term of the floating frame is a combination of them
/// (theory: Wallrapp's standard input data mdCM, J, Ct, Cr, Me, Gr, Ge, Oe).  a, b run over x, y, z; k, l
/// over the n shapes.
struct InertiaIntegrals {
  double mass = 0.0;                               ///< integral of dm [kg]
  Eigen::Vector3d S_x = Eigen::Vector3d::Zero();   ///< integral of x_a dm [kg m], about Bo
  Eigen::Matrix3d S_xx = Eigen::Matrix3d::Zero();  ///< integral of x_a x_b dm [kg m^2], about Bo
  Eigen::Matrix3Xd S_phi;                          ///< (a, k): integral of phi_k,a dm
  Eigen::MatrixXd S_xphi;                          ///< 9 x n, row 3 a + b: integral of x_a phi_k,b dm
  /// integral of phi_k,a phi_l,b dm for (a, b) = xx, yy, zz, xy, yz, zx; each n x n.  (b, a) is the
  /// transpose.
  std::array<Eigen::MatrixXd, 6> S_phiphi;
};

/// What a picture needs: the outer surface and the shapes on its vertices.
struct Surface {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> vertices;  ///< n_v x 3 [m], frame B
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>
      triangles;  ///< n_t x 3, counter-clockwise outside
  Eigen::Matrix<std::int32_t, Eigen::Dynamic, 2, Eigen::RowMajor> edges;  ///< n_e x 2, feature edges
  std::vector<std::int32_t>
      triangle_interface;  ///< n_t; index of the interface the triangle belongs to, or -1
};

/// Geometric stiffening: stiffness matrices (each n x n, in the shapes) for unit values of what stresses the
/// body (Wallrapp's K0t, K0r, K0omega, K0F).  All of them, or the whole group absent.
struct StiffeningTerms {
  std::array<Eigen::MatrixXd, 3> K0t;  ///< for unit acceleration of B along x, y, z [m/s^2]
  std::array<Eigen::MatrixXd, 3> K0r;  ///< for unit angular acceleration about x, y, z [rad/s^2]
  std::array<Eigen::MatrixXd, 6>
      K0omega;  ///< for unit omega_a omega_b, (a, b) = xx, yy, zz, xy, yz, zx [rad^2/s^2]
  std::vector<Eigen::MatrixXd> K0F;       ///< for a unit load on each interface dof [N or N m]
  std::vector<Eigen::MatrixXd> K0p = {};  ///< for each load case; empty where they are not known
};

/// Stress modes: the nodal stresses of every shape at vertices of the surface, so that at run time
///
///     sigma(v) = sum_k S_k(v) u_se,k      (u_se of the elastic deformation: a rigid motion gives none)
///
/// A nodal value is the mean over the cells of one material that share the node.
struct StressModes {
  std::vector<std::int32_t> vertices;  ///< n_s: index of each place among the surface's vertices, ascending
  Eigen::MatrixXd
      S;  ///< 6 n_s x n [Pa per unit of the shape]: rows xx, yy, zz, xy, yz, zx of place 0, then 1
  /// Of each material there [1/Pa]: (e_xx, e_yy, e_zz, g_xy, g_yz, g_zx) = compliance sigma, shears as
  /// angles; empty where it is not known.
  std::vector<Eigen::Matrix<double, 6, 6>> compliance = {};
  std::vector<std::int32_t> material = {};  ///< n_s: index of each place's compliance
  bool double_precision = false;            ///< of the file; float32 otherwise
  /// 6 n_s x load cases [Pa]: what each adds to the shapes' stress: a preload that of the body with every node held, the
  /// others that of the deformation which the shapes lack (F_rs p, see of_acceleration); empty: nothing.
  Eigen::MatrixXd of_loads = {};
  /// 6 n_s x (6 + n_b): what the body's own inertia adds, the stress of F_rs times the load of -1 times these fields of
  /// acceleration, F_rs = K_ii^-1 - Phi Omega^-2 Phi^T what the modes left out give way: the six e_a x_b (a = b) and
  /// e_a x_b + e_b x_a for (a, b) = xx, yy, zz, xy, yz, zx [Pa s^2], then the constraint shapes phi_k [Pa per unit of
  /// the shape over s^2].  Uniform and angular acceleration are the shapes' rigid motions.  Empty: not known.
  Eigen::MatrixXd of_acceleration = {};
};

/// Section forces of every shape at places along the members of a beam part, so that at run time
///
///     (N, V_y, V_z, T, M_y, M_z)(place) = sum_k S_k(place) u_se,k
///
/// on the section that looks along +x of the member, in the member's axes: those that the sections'
/// elasticity asks for where the member is deformed so.  That is not all: what acts along a member, its own inertia and
/// load cases, bears on the cut by itself and deforms the part beyond what the shapes show.  With the acceleration of the
/// particle at x, less gravity, in B
///
///     a(x) = sum_j a_j(x) c_j + sum_k,a,b B_k,ba phi_k,a(x) e_b,    a_j = e_b, then x_a e_b (row 3 + 3 a + b)
///
/// the section forces have of_acceleration c + of_deformation B in addition, and of_loads times the factors of the cases.
struct SectionForces {
  std::vector<std::string> members;
  std::vector<std::int32_t> member;  ///< n_p: index of each place's member; a member's places follow along it
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> positions;  ///< n_p x 3 [m], frame B
  /// n_p x 9: R_BS row by row; columns of R_BS are the member's axes x, y, z in B.
  Eigen::Matrix<double, Eigen::Dynamic, 9, Eigen::RowMajor> axes;
  Eigen::MatrixXd
      S;  ///< 6 n_p x n [N, N m per unit of the shape]: N, V_y, V_z, T, M_y, M_z of place 0, then 1
  Eigen::MatrixXd of_loads = {};         ///< 6 n_p x load cases: what each adds; empty: nothing
  Eigen::MatrixXd of_acceleration = {};  ///< 6 n_p x 12 [N s^2/m, ...]; empty: not known
  Eigen::MatrixXf of_deformation = {};   ///< 6 n_p x 9 n, column 9 k + 3 a + b; with of_acceleration
  Eigen::MatrixXd turning =
      {};  ///< 3 n_p x n: rotation of the section by shape k, in B; with of_acceleration
  /// 6 n_p x (loads) n, column k n + j: what shape j adds under unit load k, the loads of StiffeningTerms in the order K0t, K0r,
  /// K0omega, K0F, K0p.  With it the section forces are those in the member's axes that are in balance with loads on the
  /// deformed part.  Empty: not known.
  Eigen::MatrixXf of_stiffening = {};
};

/// The whole of T: the six motions of every node of the mesh, so that at run time
///
///     (u, theta)(node) = sum_k T_k(node) u_se,k
///
/// Nodes of shells and beams turn by themselves.  Solids have displacements alone; there theta is half the curl of u, the mean
/// of the elements that share the node.
struct NodalMotions {
  enum class Rotation : std::int8_t {
    unknown,  ///< zero in T: nothing of the mesh turns with the node
    own,      ///< a dof of the finite element model
    curl,     ///< half the curl of the displacements
  };
  std::vector<std::int32_t> numbers;  ///< n_k: numbers of the mesh file; from 1 where it has none
  std::vector<Rotation> rotations;    ///< n_k
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> positions;  ///< n_k x 3 [m], frame B
  Eigen::MatrixXd T;              ///< 6 n_k x n: u_x, u_y, u_z, theta_x, theta_y, theta_z of node 0, then 1
  bool double_precision = false;  ///< of the file; float32 otherwise
};

/// Vectors p_se = T^T p of load cases kept for run time (gravity needs none: it follows from the integrals).
struct LoadCase {
  std::string name;
  Eigen::VectorXd p_se;  ///< n
  /// 3 x n [N m per unit of the shape]: torque of the load about Bo by the displacement of what it acts on,
  /// sum of phi_k x p; empty where it is not known.
  Eigen::Matrix3Xd moment = {};
  bool is_preload = false;  ///< its forces hold each other in balance
};

struct Superelement {
  std::string name;
  std::string created_by;   ///< program and version
  std::string source;       ///< the part file, as text: what made this
  std::string report_json;  ///< the reduction's report: mesh, quality, times, residuals, estimates

  std::vector<Interface> interfaces;
  int n_b = 0;  ///< boundary (interface) degrees of freedom
  int n_q = 0;  ///< fixed-interface normal modes
  int n() const { return n_b + n_q; }

  Eigen::MatrixXd K_se;        ///< n x n
  Eigen::MatrixXd M_se;        ///< n x n
  Eigen::MatrixXd D_se;        ///< n x n, or empty
  Eigen::VectorXd omega2;      ///< n_q [rad^2/s^2], eigenvalues of the fixed-interface problem
  double modal_damping = 0.0;  ///< ratio of the body's modes where there is no D_se
  InertiaIntegrals inertia;

  std::optional<StiffeningTerms> stiffening;
  std::vector<LoadCase> load_cases;
  std::optional<StressModes> stress;      ///< read on demand
  std::optional<SectionForces> sections;  ///< of beam parts, read on demand
  std::optional<MeshError> mesh_error;    ///< absent where it was not judged; read on demand
  std::optional<NodalMotions> nodes;      ///< where the part file asks for them; read on demand

  // Only for pictures; read on demand.
  Surface surface;
  Eigen::MatrixXf shapes;  ///< 3 n_v x n: rows x, y, z of vertex 0, then vertex 1, ...
};

/// (u, theta) of an interface node by the coordinates u_se: 6 x n.  Rows of directions of which nothing is known are zero.
Eigen::MatrixXd interface_motion(const Superelement& se, const Interface& interface);

/// The six rigid motions (translations along and rotations about the axes of B, at Bo) in the n coordinates:
/// u_b = R_b z, eta = 0.  Returns n x 6.
Eigen::MatrixXd rigid_motions(const Superelement& se);

/// Throws std::invalid_argument, naming the check and the figures, unless: sizes agree, nothing is NaN or
/// infinite, K_se and M_se are symmetric, rigid motions are strain-free, M_se and the integrals give the same
/// mass, centre and inertia, S_phiphi sums to M_se.  Tolerances are stated where they stand.
void validate(const Superelement& se);

}  // namespace flexura::superelement
