// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/deformation_probes.hpp"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int kSpread = 24;  // points that know nothing of the shapes

// Points far from one another: each the one farthest from those before.
std::vector<Index> spread_points(const superelement::Surface& surface) {
  const Index n = surface.vertices.rows();
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  std::vector<Index> out;
  Index next = 0;
  for (int k = 0; k < std::min<Index>(kSpread, n); ++k) {
    out.push_back(next);
    const Eigen::RowVector3d x = surface.vertices.row(next);
    nearest = nearest.cwiseMin((surface.vertices.rowwise() - x).rowwise().squaredNorm());
    if (!(nearest.maxCoeff(&next) > 0.0)) break;
  }
  return out;
}

}  // namespace

DeformationProbes probes_of(const superelement::Superelement& se, const MatrixXd& Y) {
  DeformationProbes out;
  const auto& x = se.surface.vertices;
  const Index n = x.rows(), n_se = se.shapes.cols();
  if (n == 0 || se.shapes.rows() != 3 * n || Y.rows() != n_se) return out;
  out.size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();

  std::set<Index> points;
  for (const Index v : spread_points(se.surface)) points.insert(v);
  for (Index k = 0; k < n_se; ++k) {
    Index v = 0;
    Eigen::Map<const Eigen::Matrix3Xf>(se.shapes.col(k).data(), 3, n).colwise().squaredNorm().maxCoeff(&v);
    points.insert(v);
  }
  out.points.resize(3, static_cast<Index>(points.size()));
  MatrixXd rows(3 * out.points.cols(), n_se);
  Index at = 0;
  for (const Index v : points) {
    out.points.col(at) = x.row(v).transpose();
    rows.middleRows(3 * at++, 3) = se.shapes.middleRows(3 * v, 3).cast<double>();
  }
  out.displacements = rows * Y;

  // Edges, each once; those far shorter than the others would show the round-off of the shapes.
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  for (Index t = 0; t < se.surface.triangles.rows(); ++t)
    for (int i = 0; i < 3; ++i) {
      const auto a = se.surface.triangles(t, i), b = se.surface.triangles(t, (i + 1) % 3);
      pairs.insert({std::min(a, b), std::max(a, b)});
    }
  const std::vector<std::pair<std::int32_t, std::int32_t>> edges(pairs.begin(), pairs.end());
  std::set<std::size_t> chosen;
  const auto strain = [&](std::size_t e, Index k) {
    const auto [a, b] = edges[e];
    const Vector3d along = (x.row(b) - x.row(a)).transpose();
    const Vector3d by =
        (se.shapes.col(k).segment<3>(3 * b) - se.shapes.col(k).segment<3>(3 * a)).cast<double>();
    return along.dot(by) / along.squaredNorm();
  };
  for (Index k = 0; k < n_se; ++k) {
    double most = 0.0;
    std::size_t which = 0;
    for (std::size_t e = 0; e < edges.size(); ++e) {
      if ((x.row(edges[e].first) - x.row(edges[e].second)).norm() < 1e-4 * out.size) continue;
      if (const double s = std::abs(strain(e, k)); s > most) most = s, which = e;
    }
    if (most > 0.0) chosen.insert(which);
  }
  out.strain_places.resize(3, static_cast<Index>(chosen.size()));
  MatrixXd strains(static_cast<Index>(chosen.size()), n_se);
  at = 0;
  for (const std::size_t e : chosen) {
    out.strain_places.col(at) = 0.5 * (x.row(edges[e].first) + x.row(edges[e].second)).transpose();
    for (Index k = 0; k < n_se; ++k) strains(at, k) = strain(e, k);
    ++at;
  }
  out.strains = strains * Y;
  return out;
}

}  // namespace flexura::mbs
