// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

/// Two-node elements of the absolute nodal coordinate formulation.
///
/// Nodal coordinates are positions and slopes in one inertial frame, r(x) = S(x) e, so that the mass matrix
/// is constant and there are no Coriolis or centrifugal terms; all geometric nonlinearity sits in the elastic
/// force. Every shape function multiplies the directions alike, M_e = m (x) 1_dim, and only the compact m is
/// kept.
///
/// | kind         | node             | coordinates | strains                                        |
/// |--------------|------------------|-------------|------------------------------------------------|
/// | planar line  | r, r_x (2-D)     | 8           | stretch, curvature (PlanarStrain)              |
/// | spatial line | r, r_x           | 12          | stretch, curvature vector (CableStrain)        |
/// | spatial beam | r, r_x, r_y, r_z | 24          | AxisStrain, in-plane SectionStrain             |
/// | solid beam   | r, r_x, r_y, r_z | 24          | GreenStrain of points: Chrono's element 3243   |
///
/// Cures for locking.  Lines and spatial beam: the axis strains at the three Lobatto points, both nodes and
/// the middle, just enough to see every axial mode.  Neighbours share the points at the nodes, so in the
/// limit of no stretch (and no shear) an element brings two conditions (four, and one for the length of r_y)
/// for its four (six) freedoms in a plane.  Measured at EA L^2/EI = 1e8: tip errors fall with order 4 (lines)
/// and 2 (beams, whose curvature is constant in an element); with three Gauss points the same elements lock.
/// Spatial beam: it is Reissner's, whose strains are those of the section frame, which r_y and r_z give however
/// they shorten between the nodes; their own, in-plane strains are held at the two nodes only.  An element bent
/// by theta has the energy of theta^2 (1 + theta^4/32) and stiffens without bound towards half a turn.
///
/// Solid beam: the "enhanced continuum mechanics" of K. Nachbagauer, P. Gruber, J. Gerstmayr, J. Comput.
/// Nonlinear Dyn. 8 (2012) 021004: Poisson's coupling only on the axis.  It twists with
/// G (I_y + I_z), not G I_t, and locks where slender elements turn far (its section strains are taken between
/// the nodes too); it serves compact sections and comparisons, the spatial beam everything else.
namespace flexura::beam::ancf {

using VectorRef = Eigen::Ref<Eigen::VectorXd>;
using ConstVectorRef = Eigen::Ref<const Eigen::VectorXd>;

/// Constants of an elastic line.  EI = 0 is allowed: an ideally flexible string.
struct LineSection {
  double EA = 0.0;                    ///< [N]
  double EI = 0.0;                    ///< [N m^2]
  double mass_per_length = 0.0;       ///< [kg/m]
  double damping_time_axial = 0.0;    ///< Kelvin-Voigt: N = EA (eps + time * eps_dot) [s]
  double damping_time_bending = 0.0;  ///< [s]
};

/// Constants of a beam section about its origin, in the order (N, V_y, V_z, T, M_y, M_z) of beam/section:
/// x along the axis, y and z in the section, M_y = int z sigma dA, M_z = -int y sigma dA.
struct BeamSection {
  Eigen::Matrix<double, 6, 6> C = Eigen::Matrix<double, 6, 6>::Zero();  ///< symmetric positive definite
  double m = 0.0;                                                       ///< int dm [kg/m]
  double m_y = 0.0, m_z = 0.0;                                          ///< int y dm, int z dm [kg]
  double m_yy = 0.0, m_zz = 0.0, m_yz = 0.0;  ///< int y^2 dm, int z^2 dm, int y z dm [kg m]
  double damping_time = 0.0;                  ///< Kelvin-Voigt: s = C (e + time * e_dot) [s]
  /// Stiffness against in-plane deformation of the section [N], a penalty; 0 takes EA = C(0, 0).
  double section_stiffness = 0.0;
};

/// C = diag(EA, G A_sy, G A_sz, G I_t, E I_y, E I_z).
BeamSection uncoupled_section(double EA, double GA_sy, double GA_sz, double GI_t, double EI_y, double EI_z,
                              double rho_A, double rho_I_y, double rho_I_z);

/// A solid rectangular section as Chrono's MaterialBeamANCF: k are the shear factors.
struct SolidSection {
  double E = 0.0, nu = 0.0, rho = 0.0;  ///< [Pa], [], [kg/m^3]
  double width = 0.0, height = 0.0;     ///< along y and z [m]
  double k_y = 1.0, k_z = 1.0;
  double damping_time = 0.0;
};

/// One element: constant, shared by threads.  e and e_dot hold n() coordinates; K and D are n() x n()
/// column-major and may be nullptr.  Nothing allocates.
class Element {
 public:
  virtual ~Element() = default;

  int dim() const { return dim_; }
  /// Vectors for each node: 2 (r, r_x) or 4 (r, r_x, r_y, r_z).
  int vectors() const { return vectors_; }
  int node_coordinates() const { return dim_ * vectors_; }
  int n() const { return 2 * node_coordinates(); }
  double length() const { return length_; }

  /// m in M_e = m (x) 1_dim, 2 vectors() x 2 vectors().
  const Eigen::MatrixXd& compact_mass() const { return mass_; }
  /// w in the generalised force w (x) a of a uniform acceleration field a: integral of the shape functions
  /// over dm.
  const Eigen::VectorXd& compact_weight() const { return weight_; }

  /// Points at which resultants() gives section forces: the three Lobatto points, 0 for a solid beam.
  virtual int resultant_points() const = 0;
  /// (N, V_y, V_z, T, M_y, M_z) at lobatto_rule()[k]; of a spatial line N, 0, 0 and the moment's components
  /// in W. They are conjugate to the element's strains: of a spatial beam those in the section's own axes.
  virtual Eigen::Matrix<double, 6, 1> resultants(const double* e, const double* e_dot, int k) const = 0;

  virtual double strain_energy(const double* e) const = 0;
  virtual double dissipation(const double* e, const double* e_dot) const = 0;
  /// Adds the internal force (elastic and viscous: gradient of energy, M e_ddot + f = external) to f, its
  /// derivatives by e to K and by e_dot to D.
  /// With `e_before` (else nullptr) the geometric part of K takes the stress extrapolated linearly from
  /// e_before to e. Newton's iteration then converges as that of a mixed formulation, in a handful of large
  /// steps, where the plain tangent of a slender beam sees only the enormous spurious tension of its last
  /// step (D. Magisano, L. Leonetti, G. Garcea, Comput. Methods Appl. Mech. Eng. 313 (2017) 986); f does not
  /// change.
  virtual void add_force(const double* e, const double* e_dot, const double* e_before, double* f, double* K,
                         double* D) const = 0;

 protected:
  Element(int dim, int vectors, double length) : dim_(dim), vectors_(vectors), length_(length) {}

  Eigen::MatrixXd mass_;
  Eigen::VectorXd weight_;

 private:
  int dim_, vectors_;
  double length_;
};

/// `length` is the unstretched length.  `e_0` (n() coordinates) is the stress-free shape; for a spatial line
/// that is always straight.  All throw std::invalid_argument naming the constant, its value and the rule.
std::unique_ptr<Element> make_planar_line(const LineSection& section, double length, const double* e_0);
std::unique_ptr<Element> make_spatial_line(const LineSection& section, double length);
std::unique_ptr<Element> make_spatial_beam(const BeamSection& section, double length, const double* e_0);
std::unique_ptr<Element> make_solid_beam(const SolidSection& section, double length, const double* e_0);

}  // namespace flexura::beam::ancf
