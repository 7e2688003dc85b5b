// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/beam_part.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "beam/section/shapes.hpp"
#include "mbs/bodies/ancf_part.hpp"
#include "mbs/forces/bushing.hpp"

namespace flexura::mbs {
namespace {

/// Mass, centre and inertia of the piece of the axis from x_1 to x_2 about the point p_B, in axes parallel to
/// B.
RigidInertia piece(const BeamPart& part, double x_1, double x_2, const Vector3d& p_B) {
  const Matrix3d R = part.R_BE();
  const double l = x_2 - x_1, m = part.mass_per_length * l, across = m * l * l / 12.0;
  const Matrix3d I =
      Vector3d((part.rho_I_y + part.rho_I_z) * l, across + part.rho_I_y * l, across + part.rho_I_z * l)
          .asDiagonal();
  const Vector3d center = part.from_B + 0.5 * (x_1 + x_2) * R.col(0) - p_B;
  return RigidInertia::from_center(m, center, R * I * R.transpose());
}

}  // namespace

Matrix3d BeamPart::R_BE() const {
  const Vector3d axis = to_B - from_B;
  if (!(axis.norm() > 0.0))
    throw std::invalid_argument("the beam's two ends are the same point; give it a length");
  Matrix3d R;
  R.col(0) = axis.normalized();
  const Vector3d y = y_axis_B - R.col(0) * R.col(0).dot(y_axis_B);
  if (!(y.norm() > 1e-6 * y_axis_B.norm()))
    throw std::invalid_argument("the beam's y axis lies along the beam; give another direction");
  R.col(1) = y.normalized();
  R.col(2) = R.col(0).cross(R.col(1));
  return R;
}

std::vector<std::pair<std::string, Vector3d>> BeamPart::stations() const {
  const Vector3d axis = R_BE().col(0);
  std::vector<std::pair<std::string, Vector3d>> out = {{"root", from_B}, {"tip", to_B}};
  for (const auto& [name, x] : points) out.emplace_back(name, from_B + x * axis);
  return out;
}

RigidInertia rigid_inertia(const BeamPart& part) {
  return piece(part, 0.0, part.length(), Vector3d::Zero());
}

std::shared_ptr<const FlexibleBody> ancf_body(const BeamPart& part) {
  beam::ancf::BeamSection section;
  section.C = part.C;
  section.m = part.mass_per_length;
  section.m_zz = part.rho_I_y;
  section.m_yy = part.rho_I_z;
  section.damping_time = part.damping_time;
  return straight_ancf_part(section, part.from_B, part.to_B, part.R_BE().col(1), part.elements, part.points);
}

int Segments::piece_at(const Vector3d& p_B) const {
  const double x = axis_B.dot(p_B - root_B) / element_length;
  return std::clamp(static_cast<int>(std::lround(x)), 0, static_cast<int>(bodies.size()) - 1);
}

Segments add_segments(MechanismDescription& d, int root, const BeamPart& part) {
  const int n = part.elements;
  const double L = part.length(), l = L / n;
  const Matrix3d R = part.R_BE();
  const Matrix6d f = part.C.inverse();
  Matrix6d D = Matrix6d::Zero();
  D(4, 2) = 1.0;
  D(5, 1) = -1.0;
  const Matrix6d F = l * f + l * l * l / 12.0 * D.transpose() * f * D;
  Matrix6d K = F.inverse();
  K = (0.5 * (K + K.transpose())).eval();

  const std::string name = d.bodies[root].name;
  Segments out;
  out.root_B = part.from_B;
  out.axis_B = R.col(0);
  out.element_length = l;
  for (int k = 0; k <= n; ++k) {
    // The first piece keeps the body's own frame; the others have theirs at their nodes.
    const Vector3d node = part.from_B + k * l * R.col(0), origin = k == 0 ? Vector3d::Zero() : node;
    const RigidInertia inertia =
        piece(part, std::max(0.0, (k - 0.5) * l), std::min(L, (k + 0.5) * l), origin);
    out.origins_B.push_back(origin);
    if (k == 0) {
      d.bodies[root].inertia = inertia;
      out.bodies.push_back(root);
      continue;
    }
    const int before = out.bodies.back();
    const int body = d.add_body({.name = fmt::format("{}.{}", name, k), .inertia = inertia});
    // A joint may hold the beam at any piece: where the body is said to start, each of them does.
    if (const std::optional<Pose>& X_WB = d.bodies[root].X_WB)
      d.bodies[body].X_WB = *X_WB * Pose{Matrix3d::Identity(), origin};
    out.bodies.push_back(body);
    const Vector3d middle = part.from_B + (k - 0.5) * l * R.col(0);
    const int F_marker =
        d.add_marker(before, fmt::format("joint_{}_from", k), {R, middle - out.origins_B[k - 1]});
    const int M_marker = d.add_marker(body, fmt::format("joint_{}_to", k), {R, middle - origin});
    // In the tree, where what moves the pieces apart is a coordinate: a loop closes elsewhere.
    d.add_joint(fmt::format("{}.joint_{}", name, k), "six_dof", F_marker, M_marker);
    d.joints.back().keep_in_tree = d.joints.back().bends = true;
    d.forces.push_back(std::make_shared<Bushing>(fmt::format("{}.spring_{}", name, k), F_marker, M_marker, K,
                                                 part.damping_time * K));
  }
  return out;
}

}  // namespace flexura::mbs
