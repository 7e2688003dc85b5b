// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

/// What motion contacts leave to a body.
///
/// A contact at p with the unit normal n, pointing from body A to body B, allows the twists (omega, v at the world's origin)
/// of B relative to A with n . (v + omega x p) >= 0.  All contacts together leave a convex cone. Two subspaces bound the
/// freedom of a joint: the twists that keep every contact (the cone's lineality space, all rows = 0), and the span of the
/// cone, that is all twists along which the body is not held from both sides (Reuleaux's form closure).  Where they
/// agree the contacts alone make the joint; where they do not, something that is not drawn (weight, a spring, a clip)
/// must hold the body against a contact.
namespace flexura::import::cad {

using Vector6d = Eigen::Matrix<double, 6, 1>;

struct Contact {
  Eigen::Vector3d p, n;  ///< in the world
};

/// Twists are (omega, v) at `centre`, lengths over `size`: of one magnitude. Both give orthonormal columns.
/// Those that keep every contact, 6 x k:
Eigen::MatrixXd kept_freedom(const std::vector<Contact>& contacts, const Eigen::Vector3d& centre,
                             double size);
/// and those that no form closure forbids, 6 x m, m >= k (takes a least-squares problem for each contact):
Eigen::MatrixXd open_freedom(const std::vector<Contact>& contacts, const Eigen::Vector3d& centre,
                             double size);

/// Least squares min |A x - b| with x >= 0 (Lawson and Hanson, Solving Least Squares Problems, ch. 23).
Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

/// What kind of joint a space of relative twists is.
struct JointForm {
  enum class Type {
    fixed,
    revolute,
    prismatic,
    screw,
    cylindrical,
    universal,
    planar,
    spherical,
    other
  } type = Type::other;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< on the axis; the centre of a sphere
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< axis, direction of sliding, normal of the plane
  double lead = 0.0;  ///< of a screw: translation in one turn [m], negative: left-hand
};

/// As mechanism files call it; empty where they know none.
const char* name_of(JointForm::Type type);

/// `twists`: 6 x k as above, about `centre` with `size`.
JointForm form_of(const Eigen::MatrixXd& twists, const Eigen::Vector3d& centre, double size);

}  // namespace flexura::import::cad
