// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mesh/model/mesh.hpp"

/// A model as another finite-element program wrote it.  Numbers are as in the file, which has no
/// unit of its own.
namespace flexura::mesh {

/// A layer of a shell's section.
struct ImportedPly {
  Index material = -1;
  double thickness = 0;
};

struct ImportedMaterial {
  std::string name;
  double E = 0, nu = 0, rho = 0;
  double G = 0;              ///< of beams and rods, where the deck gives one that E and nu do not; 0: theirs
  bool orthotropic = false;  ///< it has directions: those of `engineering` or of `stiffness`
  Eigen::Matrix<double, 9, 1> engineering =
      Eigen::Matrix<double, 9, 1>::Zero();  ///< E1 E2 E3 nu12 nu13 nu23 G12 G13 G23
  /// Instead of `engineering`: stresses by strains (xx, yy, zz, xy, yz, zx), shear strains as angles, in the axes R.
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< columns: the axes 1, 2, 3 of an orthotropic one
  double alpha = 0, beta = 0, loss = 0;  ///< damping: alpha M + beta K, and the loss factor of its stiffness
  /// Unlike layers of a shell, from the side against its normal, instead of all constants; R: the axes of the section.
  std::vector<ImportedPly> plies = {};
};

/// A tie between nodes: RBE2 (dependent nodes follow the reference node) or RBE3 (the reference follows the
/// mean).
struct ImportedTie {
  enum class Kind { rigid, average } kind = Kind::rigid;
  std::int64_t label = 0;
  Index reference = -1;                                          ///< node index
  std::array<bool, 6> dofs{true, true, true, true, true, true};  ///< of the dependent side
  std::vector<Index> nodes;
  std::vector<double> weights;  ///< RBE3 only, one for each node
  /// Columns: the directions of each node's dofs where `dofs` names some of the three alone; none: the model's axes.
  std::vector<Eigen::Matrix3d> axes = {};
};

struct ImportedMass {
  std::int64_t label = 0;
  Index node = -1;
  double mass = 0;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();   ///< from the node to the mass centre
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the mass centre
  double alpha = 0;                                   ///< damping: alpha times the mass
};

/// A straight beam (CBAR, CBEAM, B31) or, without moments of inertia, a rod (CROD, T3D2): section constants in the element frame, x from node 0 to node 1, y in
/// the plane of x and `orientation`.
struct ImportedBar {
  std::int64_t label = 0;
  std::array<Index, 2> nodes{-1, -1};
  Eigen::Vector3d orientation = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, 2> offset{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  double A = 0, I_yy = 0, I_zz = 0, I_yz = 0, J = 0;  ///< I_zz resists bending in the x-y plane
  double kappa_y = 0, kappa_z = 0;                    ///< shear factors; 0 = no shear deformation
  /// From the axis, which is the line of shear centres (CBEAM): of the centroid, about which the moments are, and of the
  /// extra mass.  y, z of the element.
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero(), extra_mass_at = Eigen::Vector2d::Zero();
  double extra_mass_per_length = 0;
  /// Points (y, z) from the centroid where its stresses are largest, around the section; none: stresses are not known.
  std::vector<Eigen::Vector2d> outline = {};
  Index material = 0;
  double G = 0;  ///< shear modulus; 0: the material's
  std::array<std::array<bool, 6>, 2>
      released{};  ///< at each end: u, v, w and rotations in the element's axes
};

/// Springs and dampers between two nodes (CBUSH, CELAS, SPRINGA, SPRING2; CDAMP, CVISC, DASHPOTA, DASHPOT2), six of them along
/// and about axes at a place between them.
struct ImportedSpring {
  std::int64_t label = 0;
  std::array<Index, 2> nodes{-1, -1};
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< columns: the axes
  std::array<double, 6> stiffness{};                ///< of displacements, then rotations
  std::array<double, 6> damping{};                  ///< the same, times a time
  double loss = 0;                                  ///< loss factor of the stiffness
  double place = 0.5;                               ///< of the springs between the nodes, from the first
  std::optional<Eigen::Vector3d> at = {};           ///< of the springs, where they stand off that line
};

/// sum of row . (u, theta)(node) over the terms = 0: *EQUATION, MPC, one direction of a node that *TIE binds between others.
/// The first term names the dependent dof.
struct ImportedEquation {
  struct Term {
    Index node = -1;
    Eigen::Matrix<double, 6, 1> row = Eigen::Matrix<double, 6, 1>::Zero();  ///< axes of the file
  };
  std::vector<Term> terms;
  std::string of;  ///< "*EQUATION in deck.inp, line 12"
};

/// Dofs that the file fixes (SPC) or keeps (ASET).
struct ImportedDofs {
  Index node = -1;
  std::array<bool, 6> dofs{};
};

struct ImportedModel {
  Mesh
      mesh;  ///< solids[].material and shells[].material index `materials`; element sets become node sets of their names
  std::vector<ImportedMaterial> materials;
  std::vector<ImportedTie> ties;
  std::vector<ImportedMass> masses;
  std::vector<ImportedBar> bars;
  std::vector<ImportedSpring> springs;
  std::vector<ImportedEquation> equations;
  std::vector<ImportedDofs> fixed, kept;
  std::vector<std::string> messages;  ///< cards not used, with count and first line number; other remarks
  std::vector<std::string> warnings;  ///< elements not used: the body is not the one that the deck describes
};

/// Converts a model whose file is in other consistent units: `length`, `mass` and `time` are those of the
/// file in SI. Decks in mm, t, s (so MPa and t/mm^3): scale_to_si(model, 1e-3, 1e3, 1).  E and G scale with M
/// L^-1 T^-2, densities with M L^-3, areas with L^2, second moments with L^4, inertias with M L^2. Throws
/// std::invalid_argument unless all three are greater than zero.
void scale_to_si(ImportedModel& model, double length, double mass, double time);

}  // namespace flexura::mesh
