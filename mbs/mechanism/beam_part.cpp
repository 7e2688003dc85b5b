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
#include "mbs/bodies/beams/planar_beam.hpp"
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
  if (part.is_planar) {
    if (const char* const reason = beam::exact::why_not_planar(part.C, part.section_inertia()))
      throw std::invalid_argument(fmt::format(
          "cannot be planar: {}; take planar away, or turn y_axis to where the section is symmetric",
          reason));
    beam::ancf::LineSection line;
    line.EA = part.C(0, 0);
    line.EI = part.C(5, 5);
    line.mass_per_length = part.mass_per_length;
    line.damping_time_axial = line.damping_time_bending = part.damping_time;
    return planar_ancf_part(line, part.from_B, part.R_BE(), part.length(), part.elements, part.points);
  }
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

namespace {

// Matrices of the mechanism are dense within a body; a tree of pieces solves for accelerations in O(pieces).
constexpr int kMostOfPiece = 64;  // coordinates

/// What one body of a chain holds: elements of the same length, from `first` on.
struct Piece {
  int first = 0, elements = 1;
};

/// A station: element, and distance from its start.
struct Station {
  int element = 0;
  double x = 0.0;
};

std::vector<Station> stations_of(const BeamPart& part, double l) {
  const int n = part.elements;
  std::vector<Station> out = {{0, 0.0}, {n - 1, l}};
  for (const auto& [name, x] : part.points) {
    const int k = std::clamp(static_cast<int>(std::ceil(x / l - 1e-9)) - 1, 0, n - 1);
    out.push_back({k, std::clamp(x - k * l, 0.0, l)});
  }
  return out;
}

/// `make` gives the body of a piece for its start in its own frame and its stations, the first of them its end.
template <class Make>
Segments add_chain(MechanismDescription& d, int root, const BeamPart& part, double l,
                   const std::vector<Piece>& pieces, const Make& make) {
  const std::vector<Station> at = stations_of(part, l);
  Segments out;
  out.root_B = part.from_B;
  out.axis_B = part.R_BE().col(0);
  out.element_length = l;
  out.seats.resize(at.size());
  const std::string name = d.bodies[static_cast<std::size_t>(root)].name;
  Pose start{part.R_BE(), part.from_B};
  Vector3d origin_B = Vector3d::Zero();
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const Piece& piece = pieces[k];
    const int body = k == 0 ? root : d.add_body({.name = fmt::format("{}.{}", name, k)});
    std::vector<std::pair<std::string, Station>> stations = {{"end", {piece.elements - 1, l}}};
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Station own{at[i].element - piece.first, at[i].x};
      if (own.element < 0 || own.element >= piece.elements) continue;
      if (own.element == 0 && own.x == 0.0) {
        out.seats[i] = {body, -1, start.p};
        continue;
      }
      const bool is_end = own.element == piece.elements - 1 && own.x > (1.0 - 1e-9) * l;
      out.seats[i] = {body, is_end ? 0 : static_cast<int>(stations.size())};
      if (!is_end) stations.emplace_back(fmt::format("at_{}", stations.size()), own);
    }
    const std::shared_ptr<const FlexibleBody> flexible = make(piece, start, stations);
    BodyDescription& description = d.bodies[static_cast<std::size_t>(body)];
    description.inertia = flexible->undeformed_inertia();
    description.flexible = flexible;
    if (k > 0) {
      const int before = out.bodies.back();
      d.add_joint(fmt::format("{}.weld_{}", name, k), "fixed",
                  d.add_marker(before, fmt::format("weld_{}_from", k), {}, 0),
                  d.add_marker(body, fmt::format("weld_{}_to", k)));
      d.joints.back().keep_in_tree = true;
    }
    out.bodies.push_back(body);
    out.origins_B.push_back(origin_B);
    origin_B += flexible->nodes().front().p_BoN_B;
    // The next frame stands at this one's end, parallel to it where nothing is strained.
    start = {part.section_at((piece.first + piece.elements) * l).R, Vector3d::Zero()};
  }
  return out;
}

Segments add_planar_pieces(MechanismDescription& d, int root, const BeamPart& part, beam::exact::Kind kind) {
  const double l = part.length() / part.elements;
  if (const char* const reason = beam::exact::why_not_planar(part.C, part.section_inertia()))
    throw std::invalid_argument(fmt::format(
        "cannot be planar: {}; take planar away, or turn y_axis to where the section is symmetric", reason));
  if (part.curvature.head<2>().norm() > 0.0)
    throw std::invalid_argument(
        "cannot be planar: its curvature has parts about x and y; keep the third number alone, about z, or "
        "take planar away");
  const beam::exact::PlanarField field = beam::exact::planar_field(kind, part.C, l);
  const int most = std::max(1, kMostOfPiece / field.n());
  const int n =
      (part.elements + most - 1) / most;  // pieces, of as many elements each as the others but for one
  std::vector<Piece> pieces;
  for (int k = 0, first = 0; k < n; ++k) {
    const int elements = (part.elements - first) / (n - k);
    pieces.push_back({first, elements});
    first += elements;
  }
  return add_chain(
      d, root, part, l, pieces, [&](const Piece& piece, const Pose& start, const auto& stations) {
        std::vector<PlanarBeam::Station> places;
        for (const auto& [name, at] : stations) places.push_back({name, at.element, at.x});
        return std::make_shared<const PlanarBeam>(
            beam::exact::PlanarChain(field, piece.elements, l, part.section_inertia(), part.curvature.z()),
            start, part.damping_time, places);
      });
}

}  // namespace

Segments add_exact_elements(MechanismDescription& d, int root, const BeamPart& part, beam::exact::Kind kind) {
  if (part.is_planar) return add_planar_pieces(d, root, part, kind);
  const double l = part.length() / part.elements;
  Vector6d rest = Vector6d::Zero();
  rest.tail<3>() = part.curvature;
  const beam::exact::Element element(beam::exact::strain_field(kind, part.C, l), l, part.section_inertia(),
                                     rest);
  std::vector<Piece> pieces;
  for (int k = 0; k < part.elements; ++k) pieces.push_back({k, 1});
  return add_chain(d, root, part, l, pieces, [&](const Piece&, const Pose& start, const auto& stations) {
    std::vector<ExactElement::Station> places;
    for (const auto& [name, at] : stations) places.push_back({name, at.x});
    return std::make_shared<const ExactElement>(element, start, part.damping_time, places);
  });
}

}  // namespace flexura::mbs
