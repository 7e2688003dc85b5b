// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "beam/model/mesh.hpp"

namespace flexura::beam {
namespace {

// The part of a member's load that falls on one element, in the element's axes.
Vector12d element_displacements(const MeshElement& record, const Eigen::VectorXd& u) {
  Vector12d nodal;
  nodal << u.segment<6>(6 * record.node[0]), u.segment<6>(6 * record.node[1]);
  return record.placement.transform() * nodal;
}

}  // namespace

LineLoad load_on(const MeshElement& record, const std::vector<MemberLoad>& loads) {
  LineLoad total;
  for (const MemberLoad& member_load : loads) {
    if (member_load.member != record.member) continue;
    Vector6d p_1 = member_load.load.at_1, p_2 = member_load.load.at_2;
    if (!member_load.element_axes) {
      const Eigen::Matrix3d R_EB = record.placement.R_BE.transpose();
      for (Vector6d* p : {&p_1, &p_2}) {
        p->head<3>() = (R_EB * p->head<3>()).eval();
        p->tail<3>() = (R_EB * p->tail<3>()).eval();
      }
    }
    total.at_1 += (1.0 - record.t_1) * p_1 + record.t_1 * p_2;
    total.at_2 += (1.0 - record.t_2) * p_1 + record.t_2 * p_2;
  }
  return total;
}

Eigen::VectorXd load_vector(const BeamMesh& mesh, const std::vector<MemberLoad>& loads) {
  Eigen::VectorXd p = Eigen::VectorXd::Zero(mesh.n_dofs());
  for (const MeshElement& record : mesh.elements()) {
    const LineLoad load = load_on(record, loads);
    if (load.at_1.isZero(0.0) && load.at_2.isZero(0.0)) continue;
    const Vector12d nodal = record.placement.transform().transpose() * mesh.element(record).load(load);
    p.segment<6>(6 * record.node[0]) += nodal.head<6>();
    p.segment<6>(6 * record.node[1]) += nodal.tail<6>();
  }
  return p;
}

std::vector<MemberResult> member_results(const BeamMesh& mesh, int member, const Eigen::VectorXd& u,
                                         int places, const std::vector<MemberLoad>& loads) {
  if (member < 0 || member >= static_cast<int>(mesh.model().members.size()))
    throw std::invalid_argument(fmt::format("there is no member number {}", member));
  if (u.size() != mesh.n_dofs())
    throw std::invalid_argument(
        fmt::format("{} displacements given, the beam mesh has {} dofs", u.size(), mesh.n_dofs()));
  std::vector<MemberResult> results;
  int next = 0;
  for (const MeshElement& record : mesh.elements()) {
    if (record.member != member) continue;
    const Element element = mesh.element(record);
    const LineLoad load = load_on(record, loads);
    const Vector12d q = element_displacements(record, u);
    const double l = record.placement.length, total = l / (record.t_2 - record.t_1);
    for (; next < places; ++next) {
      const double t = places > 1 ? static_cast<double>(next) / (places - 1) : 0.5;
      if (t > record.t_2 * (1.0 + 1e-12)) break;
      const double x = std::min(l, std::max(0.0, (t - record.t_1) * total));
      results.push_back({t * total, element.section_forces(x, q, load), element.displacement(x, q, load)});
    }
  }
  return results;
}

namespace {

// Every k-th corner of the round loops, so that about `corners` are left.
std::vector<Loop> thinned(const std::vector<Loop>& outline, int corners) {
  std::vector<Loop> result;
  for (const Loop& loop : outline) {
    const int n = static_cast<int>(loop.rows()), step = std::max(1, n / std::max(3, corners));
    Loop thin((n + step - 1) / step, 2);
    for (int k = 0; k < thin.rows(); ++k) thin.row(k) = loop.row(k * step);
    result.push_back(thin);
  }
  return result;
}

// Four pieces of each side of a box.
std::vector<Loop> divided(const std::vector<Loop>& outline) {
  constexpr int kPieces = 4;
  std::vector<Loop> result;
  for (const Loop& loop : outline) {
    if (loop.rows() != 4) {
      result.push_back(loop);
      continue;
    }
    Loop fine(4 * kPieces, 2);
    for (int side = 0; side < 4; ++side)
      for (int k = 0; k < kPieces; ++k) {
        const double t = static_cast<double>(k) / kPieces;
        fine.row(kPieces * side + k) = (1.0 - t) * loop.row(side) + t * loop.row((side + 1) % 4);
      }
    result.push_back(fine);
  }
  return result;
}

}  // namespace

ExtrudedSurface extruded_surface(const BeamMesh& mesh, int slices, int most_vertices, bool fine) {
  const Model& model = mesh.model();
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  std::vector<std::array<int, 2>> edges;
  ExtrudedSurface surface;

  // Large models get fewer slices first, then fewer corners on round sections.
  const auto corners_of = [&](int most) {
    double count = 0.0;
    for (const Member& member : model.members)
      for (const Loop& loop : thinned(model.sections[member.section].section.outline, most))
        count += static_cast<double>(loop.rows());
    return count;
  };
  int corners = std::numeric_limits<int>::max();
  while (corners > 8 && 2.0 * corners_of(corners) > most_vertices) corners = corners > 48 ? 24 : corners / 2;
  const double per_slice = std::max(1.0, corners_of(corners));
  slices = std::clamp(static_cast<int>(most_vertices / per_slice) - 1, 1, std::max(1, slices));

  std::size_t e = 0;
  while (e < mesh.elements().size()) {
    const int member_index = mesh.elements()[e].member;
    const Member& member = model.members[member_index];
    const SectionEntry& first = model.sections[member.section];
    std::size_t end = e;  // a member's elements follow each other
    while (end < mesh.elements().size() && mesh.elements()[end].member == member_index) ++end;
    int previous = -1;
    for (int slice = 0; slice <= slices && !first.section.outline.empty(); ++slice) {
      const double s = static_cast<double>(slice) / slices;
      while (e + 1 < end && mesh.elements()[e].t_2 < s) ++e;
      const MeshElement& record = mesh.elements()[e];
      const double x =
          std::clamp((s - record.t_1) / (record.t_2 - record.t_1), 0.0, 1.0) * record.placement.length;
      const Eigen::Matrix3d& R = record.placement.R_BE;
      std::vector<Loop> outline = first.section.outline;
      if (member.section_at_end >= 0)
        outline = outline_of(interpolate(*first.shape, *model.sections[member.section_at_end].shape, s));
      outline = thinned(outline, corners);
      if (fine && first.shape) outline = divided(outline);
      const Matrix6x12d d = mesh.element(record).shape(x) * record.placement.transform();
      const int base = static_cast<int>(vertices.size());
      int start = base;
      for (const Loop& loop : outline) {
        const int m = static_cast<int>(loop.rows());
        for (int k = 0; k < m; ++k) {
          const double y = loop(k, 0), z = loop(k, 1);
          vertices.push_back(record.placement.p_Bo1_B + R * Eigen::Vector3d(x, y, z));
          Eigen::Matrix<double, 3, 12> at;
          at.row(0) = d.row(0) + z * d.row(4) - y * d.row(5);
          at.row(1) = d.row(1) - z * d.row(3);
          at.row(2) = d.row(2) + y * d.row(3);
          surface.at.push_back(R * at);
          surface.x.push_back(x);
          surface.across.emplace_back(y, z);
          surface.element.push_back(static_cast<int>(e));
          const int here = start + k, right = start + (k + 1) % m;
          if (slice > 0) {
            const int back = previous + (here - base), back_right = previous + (right - base);
            // Loops run counter-clockwise about x, so this order faces away from the material.
            triangles.push_back({back, back_right, right});
            triangles.push_back({back, right, here});
          }
          if (slice == 0 || slice == slices) edges.push_back({here, right});
        }
        start += m;
      }
      previous = base;
    }
    e = end;
  }
  surface.vertices.resize(vertices.size(), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) surface.vertices.row(v) = vertices[v].transpose();
  surface.triangles.resize(triangles.size(), 3);
  for (std::size_t k = 0; k < triangles.size(); ++k)
    surface.triangles.row(k) << triangles[k][0], triangles[k][1], triangles[k][2];
  surface.edges.resize(edges.size(), 2);
  for (std::size_t k = 0; k < edges.size(); ++k) surface.edges.row(k) << edges[k][0], edges[k][1];
  return surface;
}

}  // namespace flexura::beam
