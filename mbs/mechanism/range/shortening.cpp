// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/range/shortening.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mbs/superelement/superelement.hpp"

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kStations = 24;       // along a line: 1/2 int w'^2 of a sine's three waves is right to 2 %
constexpr double kStraight = 0.25;  // farthest from the chord, by its length
constexpr std::size_t kMostLines = 15;

// Vertices next to evenly spaced points of the chord, at growing distances from its start; fewer than three: none.
std::vector<Index> stations(const superelement::Surface& surface, const Vector3d& from,
                            const Vector3d& along) {
  const double length = along.norm();
  const Vector3d e = along / length;
  std::vector<Index> out;
  double last = -HUGE_VAL;
  for (int k = 0; k <= kStations; ++k) {
    const Eigen::RowVector3d at = (from + along * k / kStations).transpose();
    Index nearest = 0;
    (surface.vertices.rowwise() - at).rowwise().squaredNorm().minCoeff(&nearest);
    const Vector3d x = surface.vertices.row(nearest).transpose() - from;
    if ((x - e * e.dot(x)).norm() > kStraight * length) return {};
    // Nearer ones would take a turn of the section for one of the line.
    if (e.dot(x) < last + 0.5 * length / kStations) continue;
    last = e.dot(x);
    out.push_back(nearest);
  }
  if (out.size() < 3) out.clear();
  return out;
}

// Row of the pair's work: what the boundary coordinates do to the distance; empty without all translations.
VectorXd pair_of_forces(const superelement::Superelement& se, const superelement::Interface& from,
                        const superelement::Interface& to, const Vector3d& e) {
  VectorXd d = VectorXd::Zero(se.n());
  const auto put = [&](const superelement::Interface& interface, double sign) {
    const MatrixXd rows = superelement::interface_motion(se, interface);
    for (int axis = 0; axis < 3; ++axis) {
      if (rows.row(axis).isZero(0.0) && std::abs(e(axis)) > 1e-6) return false;
      d += sign * e(axis) * rows.row(axis).transpose();
    }
    return true;
  };
  return put(from, -1.0) && put(to, 1.0) ? d : VectorXd();
}

// d^T K^-1 d for forces in balance, beside the rigid motions R of a free body.
double compliance_of(const MatrixXd& K, const MatrixXd& R, const VectorXd& d) {
  MatrixXd A = K;
  // Rigid motions get the stiffness of the others, so that forces in balance, which do not move them, see K alone.
  for (Index k = 0; k < R.cols(); ++k)
    A.noalias() += K.diagonal().maxCoeff() / R.col(k).squaredNorm() * R.col(k) * R.col(k).transpose();
  const VectorXd scale = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<MatrixXd> factor(scale.asDiagonal() * A * scale.asDiagonal());
  const VectorXd scaled = scale.cwiseProduct(d);
  return scaled.dot(factor.solve(scaled));
}

}  // namespace

std::vector<BendingLine> bending_lines(const superelement::Superelement& se, const ModalData& data) {
  std::vector<BendingLine> out;
  const auto& x = se.surface.vertices;
  if (x.rows() == 0 || se.shapes.rows() != 3 * x.rows() || data.Y.rows() != se.n()) return out;
  const MatrixXd R = superelement::rigid_motions(se);
  const auto node_of = [&](const std::string& name) {
    const auto at = std::ranges::find(data.nodes, name, &FlexibleNode::name);
    return at == data.nodes.end() ? -1 : static_cast<int>(at - data.nodes.begin());
  };
  for (std::size_t i = 0; i < se.interfaces.size(); ++i)
    for (std::size_t j = i + 1; j < se.interfaces.size() && out.size() < kMostLines; ++j) {
      BendingLine line{.from = node_of(se.interfaces[i].name), .to = node_of(se.interfaces[j].name)};
      const Vector3d along = se.interfaces[j].p_BoN_B - se.interfaces[i].p_BoN_B;
      if (line.from < 0 || line.to < 0 || !(along.norm() > 0.0)) continue;
      const Vector3d e = along.normalized();
      const VectorXd pair = pair_of_forces(se, se.interfaces[i], se.interfaces[j], e);
      const std::vector<Index> places = stations(se.surface, se.interfaces[i].p_BoN_B, along);
      if (pair.size() == 0 || places.empty()) continue;
      line.compliance = compliance_of(se.K_se, R, pair);
      if (!(line.compliance > 0.0) || !std::isfinite(line.compliance)) continue;
      line.pull = data.Y.transpose() * pair;
      const Matrix3d across = Matrix3d::Identity() - e * e.transpose();
      const auto displacement = [&](Index v) -> Eigen::Matrix3Xd {
        return se.shapes.middleRows(3 * v, 3).cast<double>() * data.Y;
      };
      const auto add = [&](Index a, Index b, const Eigen::Matrix3Xd& by, double sign) {
        const double dx = e.dot((x.row(b) - x.row(a)).transpose());
        line.Q.noalias() += sign * 0.5 / dx * by.transpose() * across * by;
      };
      line.Q = MatrixXd::Zero(data.Y.cols(), data.Y.cols());
      const Eigen::Matrix3Xd first = displacement(places.front());
      Eigen::Matrix3Xd before = first;
      for (std::size_t k = 1; k < places.size(); ++k) {
        const Eigen::Matrix3Xd now = displacement(places[k]);
        add(places[k - 1], places[k], now - before, 1.0);
        before = now;
      }
      add(places.front(), places.back(), before - first, -1.0);
      out.push_back(std::move(line));
    }
  return out;
}

double how_held(const Mechanism& mechanism, int body, const BendingLine& line, const State& s, double span) {
  const ModalData& data = *mechanism.deforming(body)->modal();
  const double c = line.pull.cwiseAbs2().cwiseQuotient(data.stiffness).sum();
  const int at = mechanism.modal_position(body);
  if (at < 0 || !(c > 1e-3 * line.compliance)) return 0.0;
  const Sizes n = mechanism.sizes();
  const auto scratch = mechanism.make_scratch();
  // What holds is stiffness: without velocities and reactions.
  State rest = s;
  rest.v.setZero();
  rest.lambda.setZero();
  TangentMatrices tangents;
  const int n_z = n.n_v + n.n_dyn + n.n_alg;
  tangents.z_p.setZero(n_z, n.n_p);
  tangents.z_v.setZero(n_z, n.n_v);
  tangents.z_c.setZero(n_z, n.n_dyn);
  tangents.z_a.setZero(n_z, n.n_alg);
  tangents.h_p.setZero(n.n_lambda, n.n_p);
  if (!mechanism.tangents(rest, VectorXd::Zero(n.n_v), TangentScope::everything, *scratch, tangents))
    return 0.0;
  MatrixXd T(n.n_p, n.n_v), M(n.n_v, n.n_v);
  VectorXd column(n.n_p);
  for (int i = 0; i < n.n_v; ++i) {
    mechanism.kinematic(s.p, VectorXd::Unit(n.n_v, i), column);
    T.col(i) = column;
  }
  const MatrixXd z_v = tangents.z_p.topRows(n.n_v) * T;
  mechanism.mass_matrix(s.p, *scratch, M);
  const double omega2 =
      span > 0.0 ? std::pow(2.0 * std::numbers::pi / span, 2) : 1e-6 * data.stiffness.minCoeff();
  MatrixXd A = MatrixXd::Zero(n.n_v + n.n_lambda, n.n_v + n.n_lambda);
  A.topLeftCorner(n.n_v, n.n_v) = 0.5 * (z_v + z_v.transpose()) + omega2 * M;
  if (n.n_lambda > 0) {
    MatrixXd G(n.n_lambda, n.n_v);
    mechanism.constraint_matrix(s, s.p, *scratch, G);
    A.bottomLeftCorner(n.n_lambda, n.n_v) = G;
    A.topRightCorner(n.n_v, n.n_lambda) = G.transpose();
  }
  // Rows of unlike units.
  VectorXd scale = VectorXd::Ones(A.rows());
  for (Index i = 0; i < n.n_v; ++i) scale(i) = 1.0 / std::sqrt(std::max(std::abs(A(i, i)), 1e-300));
  for (Index i = n.n_v; i < A.rows(); ++i)
    scale(i) =
        1.0 / std::max((A.row(i).head(n.n_v).transpose().cwiseProduct(scale.head(n.n_v))).norm(), 1e-300);
  VectorXd load = VectorXd::Zero(A.rows());
  for (int i = 0; i < n.n_v; ++i) {
    int i_p = -1;
    double k = 0.0, d = 0.0;
    if (mechanism.elastic_coordinate(i, i_p, k, d) && i_p >= at && i_p < at + line.pull.size())
      load(i) = line.pull(i_p - at);
  }
  const VectorXd x = scale.cwiseProduct(
      (scale.asDiagonal() * A * scale.asDiagonal()).partialPivLu().solve(scale.cwiseProduct(load)));
  const double c_m = load.dot(x);
  return std::isfinite(c_m) ? std::clamp(1.0 - c_m / c, 0.0, 1.0) : 0.0;
}

}  // namespace flexura::mbs
