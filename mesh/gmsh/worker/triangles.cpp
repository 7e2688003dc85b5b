// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/triangles.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <queue>
#include <stdexcept>

#include "mesh/gmsh/worker/worker_describe.hpp"
#include "mesh/model/face.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Files hold seven digits: of the extent, for what a face is.
constexpr double kTolerance = 1e-4;

struct Edge {
  int triangle = 0;
  bool along = false;  // from the lower number to the higher
};

std::array<double, 6> box_of(const std::vector<Vector3d>& points) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : points) box.extend(p);
  return {box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z()};
}

std::string place_mm(const Vector3d& p) {
  char text[80];
  std::snprintf(text, sizeof text, "(%.5g, %.5g, %.5g)", 1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z());
  return text;
}

using Edges = std::map<std::pair<int, int>, std::vector<Edge>>;

Edges edges_of(const Triangles& surface) {
  Edges edges;
  for (std::size_t t = 0; t < surface.corners.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = surface.corners[t][k], b = surface.corners[t][(k + 1) % 3];
      edges[std::minmax(a, b)].push_back({static_cast<int>(t), a < b});
    }
  return edges;
}

void require_closed(const Triangles& surface, const Edges& edges) {
  std::vector<std::pair<double, std::pair<int, int>>> open;
  double total = 0;
  bool branches = false;
  for (const auto& [ends, of] : edges) {
    if (of.size() == 2) continue;
    branches = branches || of.size() > 2;
    const double length = (surface.points[static_cast<std::size_t>(ends.first)] -
                           surface.points[static_cast<std::size_t>(ends.second)])
                              .norm();
    open.emplace_back(length, ends);
    total += length;
  }
  if (open.empty()) return;
  std::sort(open.rbegin(), open.rend());
  char head[160];
  std::snprintf(head, sizeof head, "%zu of its %zu edges belong to one triangle only%s, %.5g mm together",
                open.size(), edges.size(), branches ? " or to more than two" : "", 1e3 * total);
  std::string text = head;
  for (std::size_t k = 0; k < std::min<std::size_t>(2, open.size()); ++k)
    text += (k == 0 ? ": " : "; ") +
            place_mm(surface.points[static_cast<std::size_t>(open[k].second.first)]) + " to " +
            place_mm(surface.points[static_cast<std::size_t>(open[k].second.second)]);
  throw std::runtime_error("is not closed, so that it has no inside: " + text +
                           (open.size() > 2 ? "; ..." : "") +
                           " (coordinates in mm); close it in the program it comes from, or export a solid "
                           "body as STEP");
}

double six_volumes(const Triangles& surface, const std::vector<int>& which) {
  double sum = 0;
  const Vector3d origin = surface.points.front();
  for (const int t : which) {
    const auto& c = surface.corners[static_cast<std::size_t>(t)];
    const auto at = [&](int k) {
      return Vector3d(surface.points[static_cast<std::size_t>(c[static_cast<std::size_t>(k)])] - origin);
    };
    sum += at(0).dot(at(1).cross(at(2)));
  }
  return sum;
}

// How often the triangles go around a point: their solid angle (A. van Oosterom, J. Strackee 1983) over 4 pi.
double winding(const Triangles& surface, const std::vector<int>& which, const Vector3d& x) {
  double sum = 0;
  for (const int t : which) {
    const auto& corners = surface.corners[static_cast<std::size_t>(t)];
    const Vector3d a = surface.points[static_cast<std::size_t>(corners[0])] - x,
                   b = surface.points[static_cast<std::size_t>(corners[1])] - x,
                   c = surface.points[static_cast<std::size_t>(corners[2])] - x;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + a.dot(c) * lb + b.dot(c) * la);
  }
  return sum / (4.0 * std::numbers::pi);
}

// The circle nearest to points of a plane (I. Kasa 1976): centre and radius.
Vector3d fit_circle(const Eigen::MatrixX2d& p) {
  Eigen::MatrixX3d A(p.rows(), 3);
  A << 2.0 * p, Eigen::VectorXd::Ones(p.rows());
  const Vector3d x = A.colPivHouseholderQr().solve(p.rowwise().squaredNorm());
  return {x(0), x(1), std::sqrt(std::max(0.0, x(2) + x(0) * x(0) + x(1) * x(1)))};
}

// A cylinder's facets are along its axis, and its corners on it.
void recognise_cylinder(const std::vector<Vector3d>& points, const std::vector<Vector3d>& normals,
                        double extent, Face& face) {
  Matrix3d moment = Matrix3d::Zero();
  for (const Vector3d& n : normals) moment += n * n.transpose() / static_cast<double>(normals.size());
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(moment);
  if (!(std::sqrt(std::max(0.0, solver.eigenvalues()(0))) < kTolerance)) return;
  const Vector3d a = solver.eigenvectors().col(0), u = solver.eigenvectors().col(1), v = a.cross(u);
  Eigen::MatrixX2d p(static_cast<Eigen::Index>(points.size()), 2);
  Eigen::VectorXd s(p.rows());
  for (Eigen::Index k = 0; k < p.rows(); ++k) {
    const Vector3d& x = points[static_cast<std::size_t>(k)];
    p.row(k) << x.dot(u), x.dot(v);
    s(k) = x.dot(a);
  }
  const Vector3d circle = fit_circle(p);
  const double R = circle(2);
  const Eigen::RowVector2d c = circle.head<2>().transpose();
  const Eigen::VectorXd off = (p.rowwise() - c).rowwise().norm().array() - R;
  if (!(R > 0.0) || R > 10.0 * extent || off.cwiseAbs().maxCoeff() > kTolerance * extent) return;
  face.kind = FaceKind::cylinder;
  face.radius = R;
  face.length = s.maxCoeff() - s.minCoeff();
  face.axis_point = u * c(0) + v * c(1) + a * 0.5 * (s.maxCoeff() + s.minCoeff());
  face.axis = a;
  for (int k = 0; k < 3; ++k)
    if (std::abs(a(k)) > 1e-9) {
      if (a(k) < 0.0) face.axis = -a;
      break;
    }
}

}  // namespace

void orient(Triangles& surface) {
  std::vector<int>& piece = surface.piece;
  const Edges edges = edges_of(surface);
  require_closed(surface, edges);
  const std::size_t n = surface.corners.size();
  std::vector<std::vector<std::pair<int, bool>>> next(n);  // neighbour, and whether it agrees
  for (const auto& [ends, of] : edges) {
    const bool agree = of[0].along != of[1].along;
    next[static_cast<std::size_t>(of[0].triangle)].emplace_back(of[1].triangle, agree);
    next[static_cast<std::size_t>(of[1].triangle)].emplace_back(of[0].triangle, agree);
  }
  piece.assign(n, -1);
  surface.origin.resize(n);
  std::iota(surface.origin.begin(), surface.origin.end(), 0);
  std::vector<bool> turned(n, false);
  std::vector<std::vector<int>> pieces;
  for (std::size_t first = 0; first < n; ++first) {
    if (piece[first] >= 0) continue;
    std::vector<int> all{static_cast<int>(first)};
    piece[first] = static_cast<int>(pieces.size());
    for (std::size_t k = 0; k < all.size(); ++k)
      for (const auto& [other, agrees] : next[static_cast<std::size_t>(all[k])]) {
        const bool wanted = turned[static_cast<std::size_t>(all[k])] != !agrees;
        if (piece[static_cast<std::size_t>(other)] < 0) {
          piece[static_cast<std::size_t>(other)] = static_cast<int>(pieces.size());
          turned[static_cast<std::size_t>(other)] = wanted;
          all.push_back(other);
        } else if (turned[static_cast<std::size_t>(other)] != wanted) {
          throw std::runtime_error(
              "is a surface with one side only (as Moebius' strip): it bounds nothing; export a solid body");
        }
      }
    pieces.push_back(std::move(all));
  }
  for (std::size_t t = 0; t < n; ++t)
    if (turned[t]) std::swap(surface.corners[t][1], surface.corners[t][2]);
  std::vector<double> volume;
  for (const auto& all : pieces) volume.push_back(six_volumes(surface, all));
  const auto outer = static_cast<std::size_t>(
      std::max_element(volume.begin(), volume.end(),
                       [](double a, double b) { return std::abs(a) < std::abs(b); }) -
      volume.begin());
  const std::array<double, 6> box = box_of(surface.points);
  const double size = Vector3d(box[3] - box[0], box[4] - box[1], box[5] - box[2]).norm();
  if (!(std::abs(volume[outer]) > 1e-12 * size * size * size))
    throw std::runtime_error("encloses no volume; export a solid body");
  const auto flip = [&](std::size_t k) {
    for (const int t : pieces[k]) {
      auto& corners = surface.corners[static_cast<std::size_t>(t)];
      std::swap(corners[1], corners[2]);
    }
  };
  if (volume[outer] < 0) flip(outer);
  // Around a vertex of a piece lies the outside, and nothing else: within a cavity there would be a second body.
  const auto is_within = [&](std::size_t k, std::size_t other) {
    const auto& corners = surface.corners[static_cast<std::size_t>(pieces[k].front())];
    return std::abs(winding(surface, pieces[other], surface.points[static_cast<std::size_t>(corners[0])])) >
           0.5;
  };
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (k == outer) continue;
    for (std::size_t other = 0; other < pieces.size(); ++other)
      if (other != k && is_within(k, other) != (other == outer))
        throw std::runtime_error("holds " + std::to_string(pieces.size()) +
                                 (other == outer ? " closed surfaces beside one another"
                                                 : " closed surfaces, one within a cavity") +
                                 "; a part is one body: save each by itself, or join them");
    if (volume[k] > 0) flip(k);  // a cavity looks inwards
  }
  for (int& p : piece) {
    if (p == static_cast<int>(outer))
      p = 0;
    else if (p < static_cast<int>(outer))
      ++p;
  }
}

void refine(Triangles& surface, double longest, std::size_t most) {
  using Ends = std::pair<int, int>;
  std::map<Ends, std::vector<int>> triangles_of;
  std::priority_queue<std::pair<double, Ends>> queue;
  const auto length = [&](const Ends& e) {
    return (surface.points[static_cast<std::size_t>(e.first)] -
            surface.points[static_cast<std::size_t>(e.second)])
        .norm();
  };
  const auto note = [&](int t) {
    const auto& c = surface.corners[static_cast<std::size_t>(t)];
    for (std::size_t k = 0; k < 3; ++k) {
      const Ends ends = std::minmax(c[k], c[(k + 1) % 3]);
      auto& of = triangles_of[ends];
      of.push_back(t);
      if (of.size() == 2 && length(ends) > longest) queue.emplace(length(ends), ends);
    }
  };
  const auto forget = [&](int t) {
    const auto& c = surface.corners[static_cast<std::size_t>(t)];
    for (std::size_t k = 0; k < 3; ++k) std::erase(triangles_of.at(std::minmax(c[k], c[(k + 1) % 3])), t);
  };
  for (std::size_t t = 0; t < surface.corners.size(); ++t) note(static_cast<int>(t));
  while (!queue.empty() && surface.corners.size() + 2 <= most) {
    const Ends ends = queue.top().second;
    queue.pop();
    const auto found = triangles_of.find(ends);
    if (found == triangles_of.end() || found->second.size() != 2) continue;
    const std::vector<int> both = found->second;
    const int middle = static_cast<int>(surface.points.size());
    surface.points.emplace_back(0.5 * (surface.points[static_cast<std::size_t>(ends.first)] +
                                       surface.points[static_cast<std::size_t>(ends.second)]));
    std::vector<int> changed;
    for (const int t : both) {
      forget(t);
      std::array<int, 3> half = surface.corners[static_cast<std::size_t>(t)], other = half;
      std::ranges::replace(half, ends.first, middle);
      std::ranges::replace(other, ends.second, middle);
      surface.corners[static_cast<std::size_t>(t)] = half;
      changed.insert(changed.end(), {t, static_cast<int>(surface.corners.size())});
      surface.corners.push_back(other);
      surface.piece.push_back(surface.piece[static_cast<std::size_t>(t)]);
      surface.origin.push_back(surface.origin[static_cast<std::size_t>(t)]);
    }
    triangles_of.erase(ends);
    for (const int t : changed) note(t);
  }
}

SolidRecord describe_enclosed(const Triangles& surface) {
  // int x x^T dV over tetrahedra (0, a, b, c): V / 20 (sum of products of corners + (a + b + c)(a + b + c)^T), from the box's middle.
  const std::array<double, 6> box = box_of(surface.points);
  const Vector3d middle(0.5 * (box[0] + box[3]), 0.5 * (box[1] + box[4]), 0.5 * (box[2] + box[5]));
  double volume = 0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (const auto& corners : surface.corners) {
    Matrix3d x;
    for (int k = 0; k < 3; ++k)
      x.col(k) = surface.points[static_cast<std::size_t>(corners[static_cast<std::size_t>(k)])] - middle;
    const double V = x.determinant() / 6.0;
    const Vector3d sum = x.rowwise().sum();
    volume += V;
    first += V / 4.0 * sum;
    second += V / 20.0 * (x * x.transpose() + sum * sum.transpose());
  }
  SolidRecord solid;
  solid.number = 1;
  solid.volume = volume;
  const Vector3d c = first / volume;
  const Matrix3d S = second - volume * c * c.transpose(), J = S.trace() * Matrix3d::Identity() - S;
  solid.centroid = as_array(c + middle);
  for (int k = 0; k < 9; ++k) solid.inertia[static_cast<std::size_t>(k)] = J(k / 3, k % 3);
  solid.box = box;
  return solid;
}

FaceRecord describe_facets(const Triangles& surface, const std::vector<int>& which, int number) {
  std::vector<Vector3d> points, normals;
  double area = 0;
  Vector3d moment = Vector3d::Zero(), normal = Vector3d::Zero();
  for (const int t : which) {
    const auto& corners = surface.corners[static_cast<std::size_t>(t)];
    const Vector3d &a = surface.points[static_cast<std::size_t>(corners[0])],
                   &b = surface.points[static_cast<std::size_t>(corners[1])],
                   &c = surface.points[static_cast<std::size_t>(corners[2])];
    const Vector3d n = (b - a).cross(c - a);
    const double twice = n.norm();
    points.insert(points.end(), {a, b, c});
    if (!(twice > 0)) continue;
    normals.push_back(n / twice);
    area += 0.5 * twice;
    moment += 0.5 * twice / 3.0 * (a + b + c);
    normal += 0.5 * n;
  }
  FaceRecord record;
  record.number = number;
  record.solid = 1;
  record.area = area;
  const Vector3d centroid = area > 0 ? Vector3d(moment / area) : points.front();
  record.centroid = as_array(centroid);
  record.box = box_of(points);
  double extent = 0, off = 0;
  const bool is_even = normal.norm() > (1 - kTolerance) * area;  // around a bore the normals cancel
  normal.normalize();
  for (const Vector3d& p : points) {
    extent = std::max(extent, (p - centroid).norm());
    off = std::max(off, std::abs((p - centroid).dot(normal)));
  }
  Face face;
  if (is_even && off < kTolerance * extent) {
    face.kind = FaceKind::plane;
    record.normal = as_array(normal);
  } else if (normals.size() > 3) {
    recognise_cylinder(points, normals, extent, face);
  }
  record.kind = static_cast<int>(face.kind);
  if (face.kind != FaceKind::cylinder) return record;
  record.axis_point = as_array(face.axis_point);
  record.axis = as_array(face.axis);
  record.radius = face.radius;
  record.length = face.length;
  record.sweep = std::min(2 * std::numbers::pi, area / (face.radius * face.length));
  const Vector3d from_axis = points.front() - face.axis_point;
  record.hole = normals.front().dot(from_axis - face.axis * face.axis.dot(from_axis)) < 0;
  return record;
}

}  // namespace flexura::mesh
