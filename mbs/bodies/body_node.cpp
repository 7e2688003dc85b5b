// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/body_node.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <stdexcept>

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using superelement::Superelement;

// Places whose spread across their longest direction is below a thousandth of it lie on a line: what they say
// about the turn around it is noise (shapes of the surface are stored in single precision).
constexpr double kLeastSpread = 1e-3;

double weight_of(const NodePlaces& places, std::size_t k) {
  return places.weights.empty() ? 1.0 : places.weights[k];
}

Vector3d position_of(const Superelement& se, const NodePlaces& places, std::size_t k) {
  const std::size_t n = places.interfaces.size();
  return k < n ? se.interfaces.at(places.interfaces[k]).p_BoN_B
               : Vector3d(se.surface.vertices.row(places.vertices[k - n]).transpose());
}

/// Displacement (and rotation, of an interface) of a place for a rigid motion about the centre, r from there.
Matrix6d rigid_motion(const Vector3d& r) {
  Matrix6d D = Matrix6d::Identity();
  D.topRightCorner<3, 3>() = -skew(r);
  return D;
}

/// The longest distance of a place from the centre; 1 where all are at one point.
double radius_of(const Superelement& se, const NodePlaces& places, const Vector3d& centre) {
  double radius = 0.0;
  for (std::size_t k = 0; k < places.interfaces.size() + places.vertices.size(); ++k)
    radius = std::max(radius, (position_of(se, places, k) - centre).norm());
  return radius > 0.0 ? radius : 1.0;
}

}  // namespace

BodyNode interface_node(const Superelement& se, int interface) {
  const superelement::Interface& i = se.interfaces.at(interface);
  return {i.name, i.p_BoN_B, superelement::interface_motion(se, i)};
}

std::vector<BodyNode> interface_nodes(const Superelement& se) {
  std::vector<BodyNode> nodes;
  for (std::size_t i = 0; i < se.interfaces.size(); ++i)
    nodes.push_back(interface_node(se, static_cast<int>(i)));
  return nodes;
}

Vector3d centre_of(const Superelement& se, const NodePlaces& places) {
  Vector3d sum = Vector3d::Zero();
  double weights = 0.0;
  for (std::size_t k = 0; k < places.interfaces.size() + places.vertices.size(); ++k) {
    sum += weight_of(places, k) * position_of(se, places, k);
    weights += weight_of(places, k);
  }
  return sum / weights;
}

BodyNode interpolated_node(const Superelement& se, const std::string& name, const NodePlaces& places) {
  const Vector3d centre = centre_of(se, places);
  // Rotations count in units of the radius, so that the 6 x 6 system does not know the unit of length.
  const double radius = radius_of(se, places, centre);
  Vector6d scale = Vector6d::Ones();
  scale.tail<3>().setConstant(1.0 / radius);
  Matrix6d gram = Matrix6d::Zero();
  MatrixXd sum = MatrixXd::Zero(6, se.n());
  const std::size_t n_i = places.interfaces.size(), n = n_i + places.vertices.size();
  Eigen::Matrix3Xd u(3, se.n());
  for (std::size_t k = 0; k < n; ++k) {
    Eigen::Matrix<double, 3, 6> D = rigid_motion(position_of(se, places, k) - centre).topRows<3>();
    D = D * scale.asDiagonal();
    if (k < n_i) {
      u = interface_node(se, places.interfaces[k]).rows.topRows<3>();
      // Directions that the interface does not keep say nothing.
      for (int a = 0; a < 3; ++a)
        if (u.row(a).isZero(0.0)) D.row(a).setZero();
    } else {
      u = se.shapes.middleRows(3 * static_cast<Index>(places.vertices[k - n_i]), 3).cast<double>();
    }
    gram += weight_of(places, k) * D.transpose() * D;
    sum += weight_of(places, k) * D.transpose() * u;
  }
  Eigen::ColPivHouseholderQR<Matrix6d> qr(gram);
  qr.setThreshold(kLeastSpread * kLeastSpread);
  if (qr.rank() != 6)
    throw std::invalid_argument(fmt::format(
        "the displacements of its {} places determine {} of its six motions; give at least three places that "
        "are not on one line",
        n, qr.rank()));
  BodyNode node{name, centre, scale.asDiagonal() * qr.solve(sum)};
  node.is_on_interfaces = places.vertices.empty();
  return node;
}

BodyNode rigidly_linked_node(const Superelement& se, const std::string& name,
                             const std::vector<int>& interfaces) {
  const NodePlaces places{interfaces, {}, {}};
  const Vector3d centre = centre_of(se, places);
  const double radius = radius_of(se, places, centre);
  // Every direction that an interface keeps: motion of it, and for a rigid motion about the centre, rotations
  // times the radius.
  Index n = 0;
  for (const int i : interfaces) {
    const superelement::Interface& at = se.interfaces.at(i);
    n += static_cast<Index>(at.directions.size() + at.following.size());
  }
  MatrixXd D(n, 6), L = MatrixXd::Zero(n, se.n());
  Vector6d scale = Vector6d::Ones();
  scale.tail<3>().setConstant(1.0 / radius);
  Index row = 0;
  for (const int i : interfaces) {
    const superelement::Interface& at = se.interfaces[i];
    const Matrix6d motion = rigid_motion(at.p_BoN_B - centre);
    const MatrixXd own = superelement::interface_motion(se, at);
    for (const auto* directions : {&at.directions, &at.following})
      for (const superelement::Direction d : *directions) {
        const int direction = static_cast<int>(d);
        const double length = direction < 3 ? 1.0 : radius;
        D.row(row) = length * (motion.row(direction) * scale.asDiagonal());
        L.row(row) = length * own.row(direction);
        ++row;
      }
  }
  Eigen::ColPivHouseholderQR<MatrixXd> qr(D);
  qr.setThreshold(kLeastSpread);
  if (qr.rank() != 6)
    throw std::invalid_argument(fmt::format(
        "the directions that its interfaces keep determine {} of its six motions; link interfaces with all "
        "six directions, or three that are not on one line",
        qr.rank()));
  BodyNode node{name, centre, scale.asDiagonal() * qr.solve(L)};
  const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(n, n);
  node.ties = L.transpose() * Q.rightCols(n - 6);
  return node;
}

BodyNode beam_node(const Superelement& se, const std::string& name, int i, int j, const Vector3d& point) {
  const superelement::Interface &from = se.interfaces.at(i), &to = se.interfaces.at(j);
  for (const superelement::Interface* end : {&from, &to})
    if (end->directions.size() + end->following.size() < 6)
      throw std::invalid_argument(
          fmt::format("interface \"{}\" does not keep all six directions, which the end of a beam has; keep "
                      "them when the part is "
                      "reduced",
                      end->name));
  const Vector3d between = to.p_BoN_B - from.p_BoN_B;
  const double length = between.norm();
  if (!(length > 0.0))
    throw std::invalid_argument("its two interfaces are at one point; name two ends of a beam");
  const Vector3d e = between / length;
  const double x = e.dot(point - from.p_BoN_B) / length;
  constexpr double kRoundOff = 1e-9;
  if (x < -kRoundOff || x > 1.0 + kRoundOff)
    throw std::invalid_argument(fmt::format(
        "its position lies {:.4g} of the length beyond \"{}\"; give one between the two interfaces",
        x < 0.0 ? -x : x - 1.0, x < 0.0 ? from.name : to.name));
  // Values and slopes over length of Hermite's cubics.
  const double x2 = x * x, x3 = x2 * x;
  const double h[] = {1.0 - 3.0 * x2 + 2.0 * x3, length * (x - 2.0 * x2 + x3), 3.0 * x2 - 2.0 * x3,
                      length * (x3 - x2)},
               slope[] = {6.0 * (x2 - x) / length, 1.0 - 4.0 * x + 3.0 * x2, 6.0 * (x - x2) / length,
                          3.0 * x2 - 2.0 * x};
  const Matrix3d along = e * e.transpose(), across = Matrix3d::Identity() - along, turned = skew(e);
  const MatrixXd a = superelement::interface_motion(se, from), b = superelement::interface_motion(se, to);
  // The slope of the axis at an end is theta x e = -e x theta.
  const auto cubic = [&](const double* f) -> MatrixXd {
    return across * (f[0] * a.topRows<3>() + f[2] * b.topRows<3>()) -
           turned * (f[1] * a.bottomRows<3>() + f[3] * b.bottomRows<3>());
  };
  BodyNode node{name, point, MatrixXd(6, se.n())};
  node.rows.topRows<3>() = along * ((1.0 - x) * a.topRows<3>() + x * b.topRows<3>()) + cubic(h);
  node.rows.bottomRows<3>() =
      along * ((1.0 - x) * a.bottomRows<3>() + x * b.bottomRows<3>()) + turned * cubic(slope);
  node.rows.topRows<3>() -= skew(point - from.p_BoN_B - x * between) * node.rows.bottomRows<3>();
  return node;
}

BodyNode surface_node(const Superelement& se, const std::string& name, int vertex) {
  BodyNode node{name, se.surface.vertices.row(vertex).transpose(), MatrixXd::Zero(6, se.n())};
  node.is_on_interfaces = false;
  if (se.shapes.rows() == 0) return node;
  node.rows.topRows<3>() = se.shapes.middleRows(3 * static_cast<Index>(vertex), 3).cast<double>();
  return node;
}

MatrixXd node_loads(const BodyNode& node, const Vector3d& offset) {
  // Torque t and force f at the offset: t + offset x f about the node.
  Matrix6d to_node = Matrix6d::Zero();  // rows: force, torque at the node; columns: torque, force
  to_node.topRightCorner<3, 3>().setIdentity();
  to_node.bottomLeftCorner<3, 3>().setIdentity();
  to_node.bottomRightCorner<3, 3>() = skew(offset);
  return node.rows.transpose() * to_node;
}

}  // namespace flexura::mbs
