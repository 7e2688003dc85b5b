// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "beam/ancf/block_tridiagonal.hpp"
#include "beam/ancf/element/ancf_element.hpp"

/// A chain of ANCF elements as one body:
///
///     M v' + f(q, v) = loads,   v = q',   M constant
///
/// q holds the nodes one after another, each as its vectors (r, r_x [, r_y, r_z]) in an inertial frame W.
/// Element k joins nodes k and k + 1, so its coordinates are contiguous in q and all matrices are block
/// tridiagonal: evaluation and mass solves cost O(elements).  Branches and loops are several bodies joined by
/// constraints.
namespace flexura::beam::ancf {

/// Where the nodes lie and how the sections stand in the stress-free shape; one column for each node.
struct ReferenceCurve {
  Eigen::VectorXd s;          ///< unstretched arc length at the nodes, increasing [m]
  Eigen::Matrix3Xd position;  ///< [m]
  Eigen::Matrix3Xd tangent;   ///< unit
  Eigen::Matrix3Xd y_axis;    ///< unit, normal to the tangent; only beams use it
};

/// n_elements equal elements from `start` to `end`.  The section's y axis is `y_axis` made normal to the
/// line.  Throws std::invalid_argument for coincident ends, a y axis along the line or fewer than one
/// element.
ReferenceCurve straight_curve(const Eigen::Vector3d& start, const Eigen::Vector3d& end, int n_elements,
                              const Eigen::Vector3d& y_axis = Eigen::Vector3d::UnitY());

struct Momentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [kg m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< about the origin of W [kg m^2/s]
};

/// A point of the axis.
struct MaterialPoint {
  int element = 0;
  double xi = 0.0;  ///< in [0, 1]
};

class AncfBody {
 public:
  /// Work space of one thread.
  struct Scratch {
    Eigen::MatrixXd K_e, D_e;
  };

  /// Elements of one kind; `q_rest` holds elements.size() + 1 nodes.  Throws std::invalid_argument when sizes
  /// or kinds do not fit.
  AncfBody(std::vector<std::unique_ptr<Element>> elements, Eigen::VectorXd q_rest);

  int dim() const { return elements_.front()->dim(); }
  int vectors() const { return elements_.front()->vectors(); }
  int node_coordinates() const { return elements_.front()->node_coordinates(); }
  int n_elements() const { return static_cast<int>(elements_.size()); }
  int n_nodes() const { return n_elements() + 1; }
  int n_q() const { return n_nodes() * node_coordinates(); }
  const Element& element(int k) const { return *elements_[k]; }
  /// Unstretched length.
  double length() const { return length_; }
  /// The configuration the body was made in (stress-free, except for a spatial line made in another shape).
  const Eigen::VectorXd& rest() const { return q_rest_; }

  /// q of the rest configuration after r -> p + R r (planar: R turns about z).
  Eigen::VectorXd placed(const Eigen::Matrix3d& R, const Eigen::Vector3d& p) const;
  /// v of the rigid motion of configuration q: v_0 the velocity of the body's material at W's origin, w the
  /// spin.
  Eigen::VectorXd rigid_velocity(const Eigen::VectorXd& q, const Eigen::Vector3d& v_0,
                                 const Eigen::Vector3d& w) const;

  /// First coordinate of a node's vector: 0 r, 1 r_x, 2 r_y, 3 r_z.
  int index(int node, int vector) const { return node * node_coordinates() + vector * dim(); }

  Scratch make_scratch() const;

  /// f = internal force (elastic and viscous); v may be nullptr where the body is at rest.
  void force(const Eigen::VectorXd& q, const Eigen::VectorXd* v, VectorRef f) const;
  /// The same with K = df/dq and D = df/dv, exact.  Nothing allocates when K and D have the body's size.
  /// With `q_before` the geometric part of K belongs to the extrapolated stress (Element::add_force); statics
  /// use it.
  void force_and_tangents(const Eigen::VectorXd& q, const Eigen::VectorXd* v, Scratch& scratch, VectorRef f,
                          BlockTridiagonal& K, BlockTridiagonal& D,
                          const Eigen::VectorXd* q_before = nullptr) const;

  const BlockTridiagonal& mass() const { return mass_; }
  /// m (x) W for any dim x dim matrix W: M for the identity, Coriolis and centrifugal matrices for spins.
  BlockTridiagonal mass_times(const Eigen::MatrixXd& W) const;
  /// x <- M^-1 x.
  void solve_mass(VectorRef x) const { mass_factor_.solve(x); }

  /// Generalised force of a uniform acceleration field (gravity) [m/s^2].
  Eigen::VectorXd gravity_force(const Eigen::Vector3d& g) const;

  double strain_energy(const Eigen::VectorXd& q) const;
  double kinetic_energy(const Eigen::VectorXd& v) const;
  double dissipation(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const;
  double total_mass() const { return total_mass_; }
  Momentum momentum(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const;

  /// The point at unstretched arc length s from the first node.  Throws std::invalid_argument outside [0,
  /// length].
  MaterialPoint locate(double s) const;

 private:
  std::vector<std::unique_ptr<Element>> elements_;
  Eigen::VectorXd q_rest_;
  BlockTridiagonal mass_;
  BlockCholesky mass_factor_;
  double length_ = 0.0, total_mass_ = 0.0;
};

/// Bodies of equal section along a curve; errors as the elements'.  A planar line lies in the x-y plane of W.
AncfBody planar_line(const LineSection& section, const ReferenceCurve& curve);
AncfBody spatial_line(const LineSection& section, const ReferenceCurve& curve);
AncfBody spatial_beam(const BeamSection& section, const ReferenceCurve& curve);
AncfBody solid_beam(const SolidSection& section, const ReferenceCurve& curve);

}  // namespace flexura::beam::ancf
