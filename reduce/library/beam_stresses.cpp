// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/beam_stresses.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "beam/section/outline_stress.hpp"
#include "reduce/library/section_forces.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using PointMatrix = Eigen::Matrix<double, 3, 6>;

// (sigma_xx, tau_xy, tau_xz) of the resultants at a vertex; empty: not known.
std::optional<PointMatrix> point_matrix(const beam::BeamMesh& mesh, const beam::ExtrudedSurface& surface,
                                        std::size_t vertex) {
  const beam::MeshElement& record = mesh.elements()[static_cast<std::size_t>(surface.element[vertex])];
  const beam::Member& member = mesh.model().members[static_cast<std::size_t>(record.member)];
  const beam::SectionEntry& entry = mesh.model().sections[static_cast<std::size_t>(member.section)];
  const Eigen::Vector2d& at = surface.across[vertex];
  if (entry.shape) {
    beam::Shape shape = *entry.shape;
    if (member.section_at_end >= 0) {
      const double t = record.t_1 + (record.t_2 - record.t_1) * surface.x[vertex] / record.placement.length;
      shape = beam::interpolate(
          shape, *mesh.model().sections[static_cast<std::size_t>(member.section_at_end)].shape, t);
    }
    const beam::Constants constants = beam::constants_of(shape, entry.section.material->nu(), entry.formula);
    return beam::stress_on_outline(shape, constants, at(0), at(1));
  }
  std::size_t point = 0, nearest = 0;
  double distance = std::numeric_limits<double>::infinity();
  for (const beam::Loop& loop : entry.section.outline)
    for (Index k = 0; k < loop.rows(); ++k, ++point)
      if (const double d = (loop.row(k).transpose() - at).norm(); d < distance) distance = d, nearest = point;
  if (entry.outline_stress.size() != point || point == 0) return {};
  return entry.outline_stress[nearest];
}

// Rows (xx, yy, zz, xy, yz, zx) in the axes of B by (sigma_xx, tau_xy, tau_xz) in the member's, columns of R.
Eigen::Matrix<double, 6, 3> to_B(const Eigen::Matrix3d& R) {
  constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  Eigen::Matrix<double, 6, 3> out;
  for (int k = 0; k < 6; ++k) {
    const auto [a, b] = pairs[k];
    out(k, 0) = R(a, 0) * R(b, 0);
    for (int side = 1; side < 3; ++side) out(k, side) = R(a, 0) * R(b, side) + R(a, side) * R(b, 0);
  }
  return out;
}

// of_acceleration of StressModes by the resultants': the fields e_a x_b (+ e_b x_a), then the shapes.
MatrixXd by_fields(const superelement::SectionForces& forces, Index n_b) {
  constexpr int pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  MatrixXd out(forces.S.rows(), 6 + n_b);
  for (int k = 0; k < 6; ++k) {
    const auto [a, b] = pairs[k];
    out.col(k) = forces.of_acceleration.col(3 + 3 * b + a);  // x_b e_a
    if (a != b) out.col(k) += forces.of_acceleration.col(3 + 3 * a + b);
  }
  for (Index k = 0; k < n_b; ++k) {
    out.col(6 + k).setZero();
    for (int a = 0; a < 3; ++a) out.col(6 + k) += forces.of_deformation.col(9 * k + 4 * a).cast<double>();
  }
  return out;
}

Eigen::Matrix<double, 6, 6> compliance_of(const beam::Material& material) {
  Eigen::Matrix<double, 6, 6> C = Eigen::Matrix<double, 6, 6>::Zero();
  C.topLeftCorner<3, 3>().setConstant(-material.nu() / material.E);
  C.diagonal().head<3>().setConstant(1.0 / material.E);
  C.diagonal().tail<3>().setConstant(1.0 / material.G);
  return C;
}

}  // namespace

std::optional<superelement::StressModes> beam_stresses(const Structure& structure, const BeamReduction& beams,
                                                       const std::vector<LoadCase>& cases,
                                                       bool double_precision,
                                                       std::vector<std::string>& notes) {
  const beam::BeamMesh& mesh = structure.mesh();
  const beam::ExtrudedSurface& surface = structure.outlines();
  superelement::StressModes out;
  std::vector<PointMatrix> points;
  std::vector<CutPlace> places;
  std::vector<Index> place_of;
  std::vector<char> known(mesh.model().members.size(), 0);
  for (std::size_t v = 0; v < surface.element.size(); ++v) {
    const std::optional<PointMatrix> S = point_matrix(mesh, surface, v);
    if (!S) continue;
    if (places.empty() || places.back().element != surface.element[v] || places.back().x != surface.x[v])
      places.push_back({surface.element[v], surface.x[v]});
    out.vertices.push_back(static_cast<std::int32_t>(v));
    points.push_back(*S);
    place_of.push_back(static_cast<Index>(places.size()) - 1);
    known[static_cast<std::size_t>(mesh.elements()[static_cast<std::size_t>(surface.element[v])].member)] = 1;
  }
  const auto unknown = std::count(known.begin(), known.end(), 0);
  if (unknown > 0)
    notes.push_back(
        fmt::format("warning: the stresses of {} member{} are not known: sections of the types basic, "
                    "advanced and matrix have no "
                    "outline, and those of files have stresses since `flexura section` writes them; solve "
                    "the section anew",
                    unknown, unknown == 1 ? "" : "s"));
  if (!structure.solids().empty())
    notes.push_back("stresses are those of the members: solids have theirs in parts of their own");
  if (points.empty()) return {};

  const Index n = beams.T.cols(), n_s = static_cast<Index>(points.size()),
              n_p = static_cast<Index>(places.size());
  // What inertia adds takes nine columns for each shape: 100 MB at most.
  const bool with_inertia = 6.0 * 9.0 * static_cast<double>(n_p * n) * sizeof(float) < 1e8;
  const superelement::SectionForces forces = section_forces_at(structure, beams, cases, places, with_inertia);
  const MatrixXd fields = with_inertia ? by_fields(forces, beams.reduction.n_b) : MatrixXd();
  const auto spread = [&](const MatrixXd& resultants) {
    MatrixXd stress(6 * n_s, resultants.cols());
    for (Index s = 0; s < n_s; ++s) {
      const Index place = place_of[static_cast<std::size_t>(s)];
      const Eigen::Matrix3d R =
          mesh.elements()[static_cast<std::size_t>(places[static_cast<std::size_t>(place)].element)]
              .placement.R_BE;
      stress.middleRows<6>(6 * s) =
          (to_B(R) * points[static_cast<std::size_t>(s)]) * resultants.middleRows<6>(6 * place);
    }
    return stress;
  };
  out.S = spread(forces.S);
  out.double_precision = double_precision;
  if (!cases.empty()) out.of_loads = spread(forces.of_loads);
  if (with_inertia) out.of_acceleration = spread(fields);
  bool materials = true;
  for (const beam::SectionEntry& entry : mesh.model().sections)
    materials = materials && entry.shape.has_value();
  if (!materials) return out;  // layers have more than one
  for (const beam::SectionEntry& entry : mesh.model().sections)
    out.compliance.push_back(compliance_of(*entry.section.material));
  for (const std::int32_t v : out.vertices) {
    const int member =
        mesh.elements()[static_cast<std::size_t>(surface.element[static_cast<std::size_t>(v)])].member;
    out.material.push_back(mesh.model().members[static_cast<std::size_t>(member)].section);
  }
  return out;
}

}  // namespace flexura::reduce
