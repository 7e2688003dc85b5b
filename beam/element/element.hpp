// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <functional>
#include <string>
#include <vector>

#include "beam/section/section.hpp"

/// The straight beam element, 2 nodes x 6 dofs, exact for end loads whatever the section couples.
///
/// Frame: x along the axis, origin at node 1; section axes y and z as in beam/section.  xi = x - l/2.
/// Statics and kinematics of the axis, with D_{M_y,V_z} = 1, D_{M_z,V_y} = -1 and all other entries zero:
///
///     s' = D s - p            s(xi) = b(xi) s_m,  b = I + xi D        (s_m: resultants at mid-span, no load)
///     d' = e - D^T d          d = (u, v, w, theta),  rigid transport R(xi) = I - xi D^T
///
/// Flexibility and stiffness, H = [-R(l/2), R(-l/2)] takes the end displacements to the element's stretch:
///
///     F = int b^T f b dxi,    s_m = F^-1 H q,    K = H^T F^-1 H
///
/// Taking the resultants at mid-span makes F diagonal for an uncoupled uniform section: nothing cancels from
/// psi = 1e-12 to 1, and K is the printed SIMBEAM matrix to round-off.  A uniform section has closed forms:
///
///     F = l f + l^3/12 D^T f D,    G(xi) = xi f + xi^2/2 (f D - D^T f) - xi^3/6 D^T f D
///
/// The shape functions are the exact static field d(xi) = R(xi) d_m + G(xi) s_m, G(xi) = int_0^xi R(xi - t) f
/// b(t) dt; with them M = int Shape^T m Shape dxi.  Varying sections integrate the same formulas by Gauss
/// quadrature. (Flexibility-based elements: E. Spacone, V. Ciampi, F. C. Filippou, Comput. Struct. 58 (1996);
/// static shape functions: J. S. Przemieniecki, Theory of Matrix Structural Analysis, 1968, chapters 5
/// and 11.)
namespace flexura::beam {

using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;
using Matrix6x12d = Eigen::Matrix<double, 6, 12>;

enum class Theory { euler_bernoulli, timoshenko };

/// Released (hinged) element ends: bits 0..5 node 1, 6..11 node 2, in the order u, v, w, theta_x, theta_y,
/// theta_z of the element frame.
using Releases = std::bitset<12>;

/// What the element takes of a section at one place.
struct SectionMatrices {
  Matrix6d f = Matrix6d::Zero();
  SectionInertia inertia;
};

/// f of the section for the theory, with its inertia.
SectionMatrices matrices_of(const Section& section, Theory theory);

/// Distributed load per unit length (force and moment at the axis) in the element frame, linear from node 1
/// to 2.
struct LineLoad {
  Vector6d at_1 = Vector6d::Zero();  ///< [N/m, N m/m]
  Vector6d at_2 = Vector6d::Zero();
};

/// Integrals over the element of products of position x (from Bo) and displacement u of all its material
/// points, in the axes of B; one column for each nodal dof.  The sum over elements is what a superelement's
/// inertia integrals are made of (names as in mbs/superelement/superelement.hpp).
struct InertiaBlocks {
  double mass = 0.0;
  Eigen::Vector3d S_x = Eigen::Vector3d::Zero();
  Eigen::Matrix3d S_xx = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 12> S_phi = Eigen::Matrix<double, 3, 12>::Zero();
  Eigen::Matrix<double, 9, 12> S_xphi =
      Eigen::Matrix<double, 9, 12>::Zero();  ///< row 3 a + b: int x_a u_b dm
  /// int u_a u_b dm for (a, b) = xx, yy, zz, xy, yz, zx: q^T block q' pairs a with the left, b with the right
  /// vector.
  std::array<Matrix12d, 6> S_phiphi = {Matrix12d::Zero(), Matrix12d::Zero(), Matrix12d::Zero(),
                                       Matrix12d::Zero(), Matrix12d::Zero(), Matrix12d::Zero()};
};

/// What fields of acceleration of the piece from node 1 to a section ask of the section, where no force but the section's
/// holds the piece: integrals of W_i . a dm over it, W_i its unit displacements (along x, y, z) and rotations (about them,
/// at the section's axis) in the element's axes, so force [N] and moment [N m] there.
struct CutInertia {
  Eigen::Matrix<double, 6, 12> of_position =
      Eigen::Matrix<double, 6, 12>::Zero();  ///< a = e_b; column 3 + 3 a + b: x_a e_b, in B
  std::array<Eigen::Matrix<double, 6, 12>, 9> of_ends =
      {};  ///< 3 a + b: e_b u_a, u of the dofs of inertia_blocks()
};

/// Where an element's local frame sits: q_local = T q_nodes with rotated axes and rigid end offsets.
struct Placement {
  Eigen::Matrix3d R_BE = Eigen::Matrix3d::Identity();  ///< columns: element axes x, y, z in B
  Eigen::Vector3d p_Bo1_B = Eigen::Vector3d::Zero();   ///< element end 1 in B [m]
  std::array<Eigen::Vector3d, 2> offset_B = {Eigen::Vector3d::Zero(),
                                             Eigen::Vector3d::Zero()};  ///< node to end
  double length = 0.0;

  /// 12 x 12: end displacements in the element frame from nodal displacements in B.
  Matrix12d transform() const;
};

/// Placement of an element between two nodes; `direction` lies in the element's x-y plane on the side of +y
/// (the width), as the orientation vector of Nastran's CBAR.  Throws std::invalid_argument, naming `name`,
/// for ends that coincide (shorter than 1e-9 of the coordinates' size) or a direction within 1e-6 rad of the
/// axis.
Placement place(const std::string& name, const Eigen::Vector3d& p_BoN1_B, const Eigen::Vector3d& p_BoN2_B,
                const Eigen::Vector3d& direction_B,
                const Eigen::Vector3d& offset_1_B = Eigen::Vector3d::Zero(),
                const Eigen::Vector3d& offset_2_B = Eigen::Vector3d::Zero());

/// The direction taken when none is given: +z (height) as near as possible to B's z; members along z take y
/// along B's y.
Eigen::Vector3d default_direction(const Eigen::Vector3d& axis_B);

class Element {
 public:
  /// Uniform element.  Throws std::invalid_argument for a length that is not positive, and for releases that
  /// let the element move by itself (naming the motion).
  Element(double length, const SectionMatrices& section, Releases releases = {});

  /// Varying section: `along(t)`, t from 0 at node 1 to 1 at node 2; `points` Gauss points (2 to 16).
  Element(double length, const std::function<SectionMatrices(double)>& along, Releases releases = {},
          int points = 12);

  double length() const { return length_; }

  /// H (6 x 12): the stretch of the element, zero for rigid motions but for round-off of the displacements.
  const Matrix6x12d& stretch_map() const { return H_; }

  /// F^-1 with the releases: (H q)^T stretch_stiffness() (H q) is twice the strain energy, to round-off of
  /// the stretch, where q^T K q has only round-off of the displacements: l^2/L^2 against l^4/L^4 for a wave
  /// of length L.
  const Matrix6d& stretch_stiffness() const { return F_inverse_; }

  /// 12 x 12 stiffness, dofs (u, v, w, theta) of node 1, then node 2.
  const Matrix12d& stiffness() const { return K_; }

  /// Consistent mass.  `rotary_inertia` = false drops the section's moments of inertia about y and z (and its
  /// static moments' share in them), for comparison with tables that lack them; torsion keeps its polar
  /// moment.
  Matrix12d mass(bool rotary_inertia = true) const;

  /// d(x) = shape(x) q, x from 0 to l.
  Matrix6x12d shape(double x) const;

  /// Nodal loads equivalent to a line load: with them the nodal displacements of any mesh are exact.
  Vector12d load(const LineLoad& load) const;

  /// Resultants (N, V_y, V_z, T, M_y, M_z) at x for end displacements q under a line load: equilibrium holds
  /// at every point, compatibility in the exact integral sense, so they are exact for end and line loads.
  Vector6d section_forces(double x, const Vector12d& q, const LineLoad& load = {}) const;

  /// Displacement at x under end displacements and a line load (the bubble included).
  Vector6d displacement(double x, const Vector12d& q, const LineLoad& load = {}) const;

  /// Integrals of the element placed in B; dofs are the nodal ones of `placement`.
  InertiaBlocks inertia_blocks(const Placement& placement) const;

  /// Of the piece from node 1 to x.
  CutInertia cut_inertia(const Placement& placement, double x) const;

 private:
  struct Station {
    double xi = 0.0, weight = 0.0;
    SectionMatrices section;
    Matrix6x12d shape = Matrix6x12d::Zero();
  };
  void finish(Releases releases);
  Matrix6d transported_flexibility(double xi) const;  // G(xi)
  Matrix6x12d shape_at(double xi, const Matrix6d& G) const;
  Vector6d particular_resultants(double xi, const LineLoad& load) const;
  Vector6d particular_stretch(const LineLoad& load) const;
  Vector6d particular_displacement(double xi, const LineLoad& load) const;
  Vector6d mid_resultants(const Vector12d& q, const LineLoad& load) const;

  double length_ = 0.0;
  bool uniform_ = true;
  SectionMatrices section_;                       // uniform
  std::function<SectionMatrices(double)> along_;  // varying
  std::vector<Station> stations_;
  Matrix6d F_ = Matrix6d::Zero(), G_left_ = Matrix6d::Zero(), G_right_ = Matrix6d::Zero();
  Matrix6x12d H_ = Matrix6x12d::Zero();
  Matrix6d F_inverse_ = Matrix6d::Zero();   // of the element with its releases (Z (Z^T F Z)^-1 Z^T)
  Matrix12d ends_ = Matrix12d::Identity();  // end displacements of the beam from those of the nodes
  Eigen::Matrix<double, 12, 6> slip_ =
      Eigen::Matrix<double, 12, 6>::Zero();  // end slip from an imposed stretch
  Matrix12d K_ = Matrix12d::Zero();
};

/// The printed SIMBEAM matrices for bending in z, dofs (w1, w2, beta1, beta2); theory sheet and SP.
/// psi = 1 / (1 + 12 E I_y / (G A_sz l^2)), 1 for Euler-Bernoulli.  For bending in y negate the blocks
/// between translations and rotations.
namespace simbeam {
double shear_factor(double EI, double GA_s, double l);
Eigen::Matrix4d bending_stiffness(double EI, double l, double psi);
Eigen::Matrix4d bending_mass(double rho_A, double l, double psi);
/// Rotary inertia, Przemieniecki (1968) in psi; rho_I = rho I_y.
Eigen::Matrix4d rotary_mass(double rho_I, double l, double psi);
/// The full 12 x 12 matrices of an uncoupled section, dofs as in Element.
Matrix12d stiffness(const Constants& constants, const Material& material, double l, Theory theory);
Matrix12d mass(const Constants& constants, const Material& material, double l, Theory theory,
               bool rotary_inertia);
}  // namespace simbeam

}  // namespace flexura::beam
