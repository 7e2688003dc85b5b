// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/kinematics/smoothed_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <limits>
#include <numbers>

namespace flexura::mbs {
namespace {

// A facet sees p and its corners by d = p - (y_1 + y_2 + y_3) / 3, e_1 = y_2 - y_1, e_2 = y_3 - y_1: how each follows these.
constexpr double kFollows[3][4] = {
    {1.0, -1.0 / 3.0, -1.0 / 3.0, -1.0 / 3.0}, {0.0, -1.0, 1.0, 0.0}, {0.0, -1.0, 0.0, 1.0}};

// Adds what (d, e_1, e_2) has of a gradient to that by z; `at`: where p and the corners stand in z.
void add_gradient(const Vector3d (&by)[3], const int (&at)[4], Eigen::VectorXd& to) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 4; ++k)
      if (kFollows[i][k] != 0.0) to.segment<3>(at[k]) += kFollows[i][k] * by[i];
}

// The same of the gradient by d alone.
template <class To>
void add_by_d(const Vector3d& by, const int (&at)[4], To&& to) {
  for (int k = 0; k < 4; ++k) to.template segment<3>(at[k]) += kFollows[0][k] * by;
}

void add_by_dd(const Matrix3d& by, const int (&at)[4], Eigen::MatrixXd& to) {
  for (int k = 0; k < 4; ++k)
    for (int l = 0; l < 4; ++l) to.block<3, 3>(at[k], at[l]) += kFollows[0][k] * kFollows[0][l] * by;
}

// by[i][j]: of (d, e_1, e_2)_i by (d, e_1, e_2)_j, i <= j.
void add_second(const Matrix3d (&by)[3][3], const int (&at)[4], Eigen::MatrixXd& to) {
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      for (int k = 0; k < 4; ++k)
        for (int l = 0; l < 4; ++l) {
          const double factor = kFollows[i][k] * kFollows[j][l];
          if (factor == 0.0) continue;
          to.block<3, 3>(at[k], at[l]) += factor * by[i][j];
          if (i != j) to.block<3, 3>(at[l], at[k]) += factor * by[i][j].transpose();
        }
}

std::atomic<long> n_surfaces = 0;

}  // namespace

// What was asked for of the surface and coordinates that were started last: facets, and the balls around groups.
struct SmoothedSurface::Placed {
  long of = -1;
  const double* s = nullptr;
  long now = 0;
  std::vector<long> when, when_ball;
  std::vector<Facet> facets;
  std::vector<SurfaceMesh::Ball> balls;
};

SmoothedSurface::Placed& SmoothedSurface::placed() {
  thread_local Placed last;
  return last;
}

void SmoothedSurface::start(const double* s) const {
  Placed& at = placed();
  at.of = number_;
  at.s = s;
  ++at.now;
  const auto grow = [](std::vector<long>& when, auto& what, int n) {
    if (when.size() >= static_cast<std::size_t>(n)) return;
    when.resize(static_cast<std::size_t>(n), 0);
    what.resize(static_cast<std::size_t>(n));
  };
  grow(at.when, at.facets, mesh_->n_triangles());
  grow(at.when_ball, at.balls, mesh_->n_groups());
}

SmoothedSurface::Placed& SmoothedSurface::place(const double* s) const {
  Placed& at = placed();
  if (at.of == number_ && at.s == s) return at;
  // Of one point that is asked for by itself.
  start(s);
  at.of = -1;
  return at;
}

const SmoothedSurface::Facet& SmoothedSurface::facet(int t, const double* s, Placed& at) const {
  const auto k = static_cast<std::size_t>(t);
  Facet& facet = at.facets[k];
  if (at.when[k] == at.now) return facet;
  at.when[k] = at.now;
  const Eigen::Vector3i& f = mesh_->triangle(t);
  const Vector3d y[3] = {mesh_->vertex(f[0], s), mesh_->vertex(f[1], s), mesh_->vertex(f[2], s)};
  facet.c = (y[0] + y[1] + y[2]) / 3.0;
  facet.e_1 = y[1] - y[0];
  facet.e_2 = y[2] - y[0];
  facet.a = 0.5 * facet.e_1.cross(facet.e_2);
  return facet;
}

template <class Enter, class Take>
void SmoothedSurface::visit(const double* s, Placed& at, const Enter& enter, const Take& take) const {
  mesh_->visit(
      [&](int group) -> const SurfaceMesh::Ball& {
        const auto k = static_cast<std::size_t>(group);
        if (at.when_ball[k] != at.now) {
          at.when_ball[k] = at.now;
          at.balls[k] = mesh_->ball(group, s);
        }
        return at.balls[k];
      },
      enter, take);
}

SmoothedSurface::SmoothedSurface(std::shared_ptr<const SurfaceMesh> mesh)
    : mesh_(std::move(mesh)),
      area_(mesh_->n_triangles()),
      reach_(mesh_->n_triangles()),
      number_(n_surfaces++) {
  for (int t = 0; t < mesh_->n_triangles(); ++t) {
    const Eigen::Vector3i& f = mesh_->triangle(t);
    const Vector3d y[3] = {mesh_->vertex(f[0], nullptr), mesh_->vertex(f[1], nullptr),
                           mesh_->vertex(f[2], nullptr)};
    const Vector3d c = (y[0] + y[1] + y[2]) / 3.0;
    area_(t) = 0.5 * (y[1] - y[0]).cross(y[2] - y[0]).norm();
    reach_(t) = 2.0 * std::max({(y[0] - c).norm(), (y[1] - c).norm(), (y[2] - c).norm()});
  }
}

bool SmoothedSurface::look(const Vector3d& p, int t, const double* s, Placed& at, Near& near) const {
  const Facet& of = facet(t, s, at);
  near.t = t;
  near.facet = &of;
  near.d = p - of.c;
  near.rest = 1.0 - near.d.squaredNorm() / (reach(t) * reach(t));
  near.h = of.a.dot(near.d);
  return near.rest > 0.0;
}

double SmoothedSurface::bound(const Vector3d& c, const double* s, double enough) const {
  double best = enough;
  Placed& at = place(s);
  visit(
      s, at,
      [&](const Vector3d& middle, double r, double longest) {
        return (c - middle).norm() - r - 2.0 * longest < best;
      },
      [&](int t) {
        Near near;
        look(c, t, s, at, near);
        best = std::min(best, near.d.norm() - reach(t));
      });
  return best;
}

// The greater of the gap and the way into the reach of the nearest facet: below 0 where there are both a gap below 0 and a facet
// to have it from.  Out of reach the height over the nearest facet's plane stands for the gap.
double SmoothedSurface::separation(const Vector3d& p, const double* s) const {
  double N = 0.0, D = 0.0, nearest = std::numeric_limits<double>::infinity(), height = 0.0;
  Placed& at = place(s);
  visit(
      s, at,
      [&](const Vector3d& middle, double r, double longest) {
        return (p - middle).norm() - r - 2.0 * longest < std::max(nearest, 0.0);
      },
      [&](int t) {
        Near near;
        const bool is_near = look(p, t, s, at, near);
        if (const double way = near.d.norm() - reach(t); way < nearest) {
          nearest = way;
          height = near.h / area_(t);
        }
        if (!is_near) return;
        N += near.w() * near.h;
        D += near.w() * area_(t);
      });
  return std::max(nearest, D > 0.0 ? N / D : height);
}

bool SmoothedSurface::find_foot(const Vector3d& p, const double* s, bool second, Foot& foot) const {
  thread_local std::vector<Near> nears;  // nothing is allocated in a run
  nears.clear();
  double N = 0.0, D = 0.0, C = 0.0;
  const auto cover_of = [this](int t) { return 4.0 * area_(t) / (std::numbers::pi * reach(t) * reach(t)); };
  Placed& placed_at = place(s);
  visit(
      s, placed_at,
      [&](const Vector3d& middle, double r, double longest) {
        return (p - middle).norm() < r + 2.0 * longest;
      },
      [&](int t) {
        Near near;
        if (!look(p, t, s, placed_at, near)) return;
        nears.push_back(near);
        N += near.w() * near.h;
        D += near.w() * area_(t);
        C += near.w() * cover_of(t);
      });
  if (!(D > 0.0) || N > 0.0) return false;
  foot.start();
  foot.gap = N / D;
  const double tau = C / kWhole;
  foot.is_at_end = tau < 1.0;
  foot.cover = foot.is_at_end ? tau * tau * (3.0 - 2.0 * tau) : 1.0;

  const auto place_of = [&](int vertex) {
    const auto found = std::ranges::find(foot.vertices, vertex);
    const int k = static_cast<int>(found - foot.vertices.begin());
    if (found == foot.vertices.end()) foot.vertices.push_back(vertex);
    return k;
  };
  thread_local std::vector<Eigen::Vector3i> corners;
  corners.clear();
  for (const Near& near : nears) {
    const Eigen::Vector3i& f = mesh_->triangle(near.t);
    corners.emplace_back(place_of(f[0]), place_of(f[1]), place_of(f[2]));
  }
  const int n = foot.n();
  const auto V = static_cast<Eigen::Index>(foot.vertices.size());
  thread_local Eigen::VectorXd D_z, C_z;
  foot.gap_z.setZero(n);
  foot.share.setZero(V);
  D_z.setZero(n);
  C_z.setZero(n);
  if (second) foot.share_z.setZero(V, n);
  const auto at_of = [&](std::size_t i, int(&at)[4]) {
    at[0] = 0;
    for (int k = 0; k < 3; ++k) at[k + 1] = 3 + 3 * corners[i][k];
  };
  const auto w_d_of = [this](const Near& near) {
    return Vector3d(-6.0 * near.rest * near.rest / (reach(near.t) * reach(near.t)) * near.d);
  };
  for (std::size_t i = 0; i < nears.size(); ++i) {
    const Near& near = nears[i];
    int at[4];
    at_of(i, at);
    const Vector3d w_d = w_d_of(near);
    // N and gap D at once: gap_z = (N_z - gap D_z) / D.
    const double alpha = area_(near.t), w = near.w();
    const Vector3d by[3] = {w * near.facet->a + (near.h - foot.gap * alpha) * w_d,
                            0.5 * w * near.facet->e_2.cross(near.d), 0.5 * w * near.d.cross(near.facet->e_1)};
    add_gradient(by, at, foot.gap_z);
    add_by_d(alpha * w_d, at, D_z);
    if (foot.is_at_end) add_by_d(cover_of(near.t) * w_d, at, C_z);
    for (int k = 0; k < 3; ++k) {
      foot.share(corners[i][k]) += w * alpha / (3.0 * D);
      if (second) add_by_d(alpha / (3.0 * D) * w_d, at, foot.share_z.row(corners[i][k]).transpose());
    }
  }
  foot.gap_z /= D;
  if (foot.is_at_end) foot.cover_z = 6.0 * tau * (1.0 - tau) / kWhole * C_z;
  if (!second) return true;

  foot.share_z.noalias() -= foot.share * (D_z / D).transpose();
  foot.gap_zz.setZero(n, n);
  if (foot.is_at_end) foot.cover_zz.setZero(n, n);
  for (std::size_t i = 0; i < nears.size(); ++i) {
    const Near& near = nears[i];
    int at[4];
    at_of(i, at);
    const double r_2 = reach(near.t) * reach(near.t), w = near.w();
    const Vector3d w_d = w_d_of(near), h_1 = 0.5 * near.facet->e_2.cross(near.d),
                   h_2 = 0.5 * near.d.cross(near.facet->e_1);
    const Matrix3d w_dd = -6.0 * near.rest * near.rest / r_2 * Matrix3d::Identity() +
                          24.0 * near.rest / (r_2 * r_2) * near.d * near.d.transpose();
    const Matrix3d a_w = near.facet->a * w_d.transpose();
    const Matrix3d by[3][3] = {{a_w + a_w.transpose() + (near.h - foot.gap * area_(near.t)) * w_dd,
                                -0.5 * w * skew(near.facet->e_2) + w_d * h_1.transpose(),
                                0.5 * w * skew(near.facet->e_1) + w_d * h_2.transpose()},
                               {Matrix3d::Zero(), Matrix3d::Zero(), -0.5 * w * skew(near.d)},
                               {Matrix3d::Zero(), Matrix3d::Zero(), Matrix3d::Zero()}};
    add_second(by, at, foot.gap_zz);
    if (foot.is_at_end) add_by_dd(cover_of(near.t) * w_dd, at, foot.cover_zz);
  }
  foot.gap_zz /= D;
  const Eigen::VectorXd D_of = D_z / D;
  foot.gap_zz.noalias() -= foot.gap_z * D_of.transpose();
  foot.gap_zz.noalias() -= D_of * foot.gap_z.transpose();
  if (foot.is_at_end) {
    foot.cover_zz *= 6.0 * tau * (1.0 - tau) / kWhole;
    foot.cover_zz.noalias() += 6.0 * (1.0 - 2.0 * tau) / (kWhole * kWhole) * C_z * C_z.transpose();
  }
  return true;
}

std::pair<int, int> SmoothedSurface::opposed() const {
  std::pair<int, int> found{-1, -1};
  start(nullptr);
  Placed& at = place(nullptr);
  for (int t = 0; t < mesh_->n_triangles() && found.first < 0; ++t) {
    const Facet one = facet(t, nullptr, at);
    visit(
        nullptr, at,
        [&](const Vector3d& middle, double r, double longest) {
          return found.first < 0 && (one.c - middle).norm() < r + 2.0 * longest;
        },
        [&](int other) {
          Near near;
          if (!look(one.c, other, nullptr, at, near)) return;
          // Opposite within 60 degrees.
          const Vector3d& a = near.facet->a;
          if (a.dot(one.a) < -0.5 * a.norm() * one.a.norm()) found = {t, other};
        });
  }
  return found;
}

}  // namespace flexura::mbs
