// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "beam/ancf/body.hpp"

/// Kinematics of a point P of the axis with its section frame S, for joints, markers and loads:
///
///     v_WP = J_v v,   w_WS = J_w(q) v,   a_WP = J_v v',   alpha_WS = J_w v' + w_bias(q, v)
///
/// J_v is constant.  Section frame S (columns of R_WS):
///   beams           e_y = r_y/|r_y|, e_x = r_y x r_z/|r_y x r_z|, e_z = e_x x e_y
///   planar lines    e_x along r_x, e_z = W's z
///   spatial lines   e_x along r_x, turned from its direction at rest by the shortest rotation (no
///                   torsion; undefined where the tangent has turned by 180 degrees)
/// A rigid offset d_S is added by the caller: p + R d, v + w x (R d).
///
/// For S with x_dot the slopes' rates, w = A(x) x_dot; the moment M at S gives the generalised force J_w^T M,
/// whose derivative by q is exact.
namespace flexura::beam::ancf {

/// 3 x n_e, n_e = coordinates of one element.
using PointJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 24>;

struct PointKinematics {
  int first = 0;  ///< coordinate of the body that the first column belongs to
  Eigen::Vector3d p_WoP_W = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_WS = Eigen::Matrix3d::Identity();
  Eigen::Vector3d v_WP_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_WS_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d w_bias_W = Eigen::Vector3d::Zero();
  PointJacobian J_v, J_w;
};

/// Throws std::runtime_error where the frame is undefined (a spatial line turned back on itself).
PointKinematics evaluate_point(const AncfBody& body, const MaterialPoint& point, const Eigen::VectorXd& q,
                               const Eigen::VectorXd& v);

/// Section forces in the section frame S at Lobatto point k = 0, 1, 2 of an element (xi = 0, 1/2, 1).
struct SectionForces {
  MaterialPoint at;
  Eigen::Matrix<double, 6, 1> s;  ///< (N, V_y, V_z, T, M_y, M_z) [N, N m]; lines have no shear and no torque
};

/// Throws std::invalid_argument for a solid beam, which has no section forces, or another k.
SectionForces section_forces(const AncfBody& body, int element, int k, const Eigen::VectorXd& q,
                             const Eigen::VectorXd& v);

/// f += J_v^T F, F fixed in W.
void add_point_force(const AncfBody& body, const MaterialPoint& point, const Eigen::Vector3d& F_W,
                     VectorRef f);

/// f += J_w^T M; `df_dq` (unless nullptr) receives its derivative.
void add_point_moment(const AncfBody& body, const MaterialPoint& point, const Eigen::VectorXd& q,
                      const Eigen::Vector3d& M_W, VectorRef f, Triplets* df_dq);

}  // namespace flexura::beam::ancf
