// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/beam_part.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "beam/section/shapes.hpp"
#include "mbs/bodies/beams/ancf_part.hpp"
#include "mbs/bodies/beams/exact_element.hpp"
#include "mbs/forces/bushing.hpp"

namespace flexura::mbs {
namespace {

/// Mass, first moment and inertia of the piece of a straight axis from x_1 to x_2 about the point p_B, in axes parallel
/// to B.
RigidInertia piece(const BeamPart& part, double x_1, double x_2, const Vector3d& p_B) {
  const Matrix3d R = part.R_BE(), one = Matrix3d::Identity();
  const double l = x_2 - x_1, m = part.mass_per_length * l;
  Matrix3d section;
  section << part.rho_I_y + part.rho_I_z, 0, 0, 0, part.rho_I_y, -part.m_yz, 0, -part.m_yz, part.rho_I_z;
  const Vector3d axis = R.col(0), middle = part.from_B + 0.5 * (x_1 + x_2) * axis - p_B,
                 S = l * (R * Vector3d(0.0, part.m_y, part.m_z));
  // Of the axis, the section about it, and both together: int |u + rho|^2 1 - (u + rho)(u + rho)^T dm.
  Matrix3d I = m * (middle.squaredNorm() * one - middle * middle.transpose()) +
               m * l * l / 12.0 * (one - axis * axis.transpose()) + l * R * section * R.transpose();
  I += 2.0 * middle.dot(S) * one - middle * S.transpose() - S * middle.transpose();
  return {m, m * middle + S, I};
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

Pose BeamPart::section_at(double x) const {
  const Matrix3d R = R_BE();
  // exp(x k^) and its integral along x, applied to e_1.
  const double k = curvature.norm(), angle = k * x;
  if (angle == 0.0) return {R, from_B + x * R.col(0)};
  const Vector3d u = curvature / k, e = Vector3d::UnitX(), along = u.x() * u;
  return {R * Eigen::AngleAxisd(angle, u).toRotationMatrix(),
          from_B +
              R * (x * along + std::sin(angle) / k * (e - along) + (1.0 - std::cos(angle)) / k * u.cross(e))};
}

beam::SectionInertia BeamPart::section_inertia() const {
  return {.m = mass_per_length, .m_y = m_y, .m_z = m_z, .m_yy = rho_I_z, .m_zz = rho_I_y, .m_yz = m_yz};
}

std::vector<std::pair<std::string, Vector3d>> BeamPart::stations() const {
  std::vector<std::pair<std::string, Vector3d>> out = {{"root", from_B}, {"tip", section_at(length()).p}};
  for (const auto& [name, x] : points) out.emplace_back(name, section_at(x).p);
  return out;
}

RigidInertia rigid_inertia(const BeamPart& part) {
  return piece(part, 0.0, part.length(), Vector3d::Zero());
}

std::shared_ptr<const FlexibleBody> ancf_body(const BeamPart& part) {
  beam::ancf::BeamSection section;
  section.C = part.C;
  section.m = part.mass_per_length;
  section.m_y = part.m_y;
  section.m_z = part.m_z;
  section.m_zz = part.rho_I_y;
  section.m_yy = part.rho_I_z;
  section.m_yz = part.m_yz;
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

Segments add_exact_elements(MechanismDescription& d, int root, const BeamPart& part, beam::exact::Kind kind) {
  const int n = part.elements;
  const double l = part.length() / n;
  const beam::exact::StrainField field = beam::exact::strain_field(kind, part.C, l);
  Vector6d rest = Vector6d::Zero();
  rest.tail<3>() = part.curvature;
  const beam::exact::Element element(field, l, part.section_inertia(), rest);
  const Eigen::VectorXd unstrained = Eigen::VectorXd::Zero(element.n());
  const beam::exact::Element::Motion across =
      element.motion(element.place(l), unstrained.data(), nullptr, nullptr);

  // The stations by element and by distance along it.
  std::vector<std::pair<int, double>> at = {{0, 0.0}, {n - 1, l}};
  for (const auto& [name, x] : part.points) {
    const int k = std::clamp(static_cast<int>(std::ceil(x / l - 1e-9)) - 1, 0, n - 1);
    at.emplace_back(k, std::clamp(x - k * l, 0.0, l));
  }
  Segments out;
  out.root_B = part.from_B;
  out.axis_B = part.R_BE().col(0);
  out.element_length = l;
  out.seats.resize(at.size());
  const std::string name = d.bodies[root].name;
  Pose start{part.R_BE(), part.from_B};  // of an element, in its own frame
  Vector3d origin_B = Vector3d::Zero();
  for (int k = 0; k < n; ++k) {
    const int body = k == 0 ? root : d.add_body({.name = fmt::format("{}.{}", name, k)});
    std::vector<ExactElement::Station> stations = {{"end", l}};
    for (std::size_t i = 0; i < at.size(); ++i) {
      const auto& [of, x] = at[i];
      if (of != k) continue;
      if (x == 0.0) {
        out.seats[i] = {body, -1, start.p};
        continue;
      }
      const bool is_end = x > (1.0 - 1e-9) * l;
      out.seats[i] = {body, is_end ? 0 : static_cast<int>(stations.size())};
      if (!is_end) stations.push_back({fmt::format("at_{}", stations.size()), x});
    }
    const auto piece_of_beam =
        std::make_shared<const ExactElement>(element, start, part.damping_time, stations);
    d.bodies[body].inertia = piece_of_beam->undeformed_inertia();
    d.bodies[body].flexible = piece_of_beam;
    if (k > 0) {
      const int before = out.bodies.back();
      d.add_joint(fmt::format("{}.weld_{}", name, k), "fixed",
                  d.add_marker(before, fmt::format("weld_{}_from", k), {}, 0),
                  d.add_marker(body, fmt::format("weld_{}_to", k)));
      d.joints.back().keep_in_tree = true;
    }
    out.bodies.push_back(body);
    out.origins_B.push_back(origin_B);
    origin_B += start * across.p;
    start = {start.R * across.R, Vector3d::Zero()};
  }
  return out;
}

}  // namespace flexura::mbs
