// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/solver.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "beam/section/saint_venant.hpp"
#include "beam/section/section_mesh.hpp"

namespace flexura::beam {

namespace {

// Integrals of 1, y, z, y^2, z^2, y z with a weight for each cell.
struct Moments {
  double o = 0, y = 0, z = 0, yy = 0, zz = 0, yz = 0;
};

Moments moments(const SectionMesh& mesh, const std::vector<double>& weight) {
  Moments m;
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (const QuadraturePoint& q : triangle_quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      const double w = weight[cell] * q.weight * p.det;
      m.o += w;
      m.y += w * p.y;
      m.z += w * p.z;
      m.yy += w * p.y * p.y;
      m.zz += w * p.z * p.z;
      m.yz += w * p.y * p.z;
    }
  return m;
}

void find_principal_axes(SectionProperties& s) {
  const double mean = 0.5 * (s.I_y + s.I_z), difference = 0.5 * (s.I_y - s.I_z);
  const double radius = std::hypot(difference, s.I_yz);
  s.I_1 = mean + radius;
  s.I_2 = mean - radius;
  // Moment about the axis at phi from y: mean + difference cos 2phi + I_yz sin 2phi (I_yz = -int y z dA).
  s.principal_angle = radius > 1e-12 * mean ? 0.5 * std::atan2(s.I_yz, difference) : 0.0;
  if (s.principal_angle <= -0.5 * std::numbers::pi) s.principal_angle += std::numbers::pi;
}

void find_warping(SectionProperties& s, const SectionMesh& mesh, const SaintVenantFields& solution,
                  const std::vector<double>& weight) {
  // u_x of a unit torque per unit twist rate; the part linear in (1, y, z), weighted by E, is no warping:
  // taking it out moves the pole to the shear centre (V. Z. Vlasov, Thin-walled elastic beams, 1961).
  const int n = static_cast<int>(mesh.points.rows());
  Eigen::VectorXd omega(n);
  for (int k = 0; k < n; ++k) omega(k) = solution.X(3 * k, T) / solution.f(T, T);
  Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto value = [&](int cell, const Place& p) {
    double sum = 0.0;
    for (int k = 0; k < 6; ++k) sum += p.N(k) * omega(mesh.triangles(cell, k));
    return sum;
  };
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (const QuadraturePoint& q : triangle_quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      const double w = weight[cell] * q.weight * p.det;
      const Eigen::Vector3d basis(1.0, p.y, p.z);
      gram += w * basis * basis.transpose();
      right += w * value(cell, p) * basis;
    }
  const Eigen::Vector3d linear = gram.ldlt().solve(right);
  for (int k = 0; k < n; ++k)
    omega(k) -= linear(0) + linear(1) * mesh.points(k, 0) + linear(2) * mesh.points(k, 1);
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (const QuadraturePoint& q : triangle_quadrature()) {
      const Place p = place_in(mesh, cell, q.r, q.s);
      s.I_w += weight[cell] * q.weight * p.det * std::pow(value(cell, p), 2);
    }
  s.warping = omega;
}

// Stresses at the boundary nodes, mean over the triangles that meet there; points are those furthest out in eight directions.
void find_stresses(SectionProperties& s, const SectionMesh& mesh, const std::vector<Matrix6d>& Q_of_cell,
                   const SaintVenantFields& solution, const std::vector<int>& boundary) {
  static const std::array<const char*, 8> names = {"+y", "+y+z", "+z", "-y+z", "-y", "-y-z", "-z", "+y-z"};
  constexpr double corner_r[] = {0, 1, 0, 0.5, 0.5, 0}, corner_s[] = {0, 0, 1, 0, 0.5, 0.5};
  std::vector<int> place(static_cast<std::size_t>(mesh.points.rows()), -1), meeting(boundary.size(), 0);
  for (std::size_t k = 0; k < boundary.size(); ++k)
    if (int& first = place[static_cast<std::size_t>(boundary[k])]; first < 0) first = static_cast<int>(k);
  std::vector<Eigen::Matrix<double, 3, 6>>& S = s.outline_stress;
  S.assign(boundary.size(), Eigen::Matrix<double, 3, 6>::Zero());
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (int k = 0; k < 6; ++k) {
      const int at = place[static_cast<std::size_t>(mesh.triangles(cell, k))];
      if (at < 0) continue;
      const Operators o = operators_at(place_in(mesh, cell, corner_r[k], corner_s[k]));
      Eigen::Matrix<double, 18, 6> X, X_1;
      for (int j = 0; j < 18; ++j) {
        X.row(j) = solution.X.row(3 * mesh.triangles(cell, j / 3) + j % 3);
        X_1.row(j) = solution.X_1.row(3 * mesh.triangles(cell, j / 3) + j % 3);
      }
      const Matrix6d stress = Q_of_cell[cell] * (o.Phi * solution.Y + o.B * X + o.S * X_1);
      auto& sum = S[static_cast<std::size_t>(at)];
      sum.row(0) += stress.row(0);
      sum.row(1) += stress.row(5);
      sum.row(2) += stress.row(4);
      ++meeting[static_cast<std::size_t>(at)];
    }
  for (std::size_t k = 0; k < boundary.size(); ++k) {
    const auto first = static_cast<std::size_t>(place[static_cast<std::size_t>(boundary[k])]);
    S[k] = k == first ? Eigen::Matrix<double, 3, 6>(S[k] / meeting[k]) : S[first];
  }
  for (int direction = 0; direction < 8; ++direction) {
    const double phi = 0.25 * std::numbers::pi * direction;
    std::size_t chosen = 0;
    double best = -std::numeric_limits<double>::infinity();
    for (std::size_t candidate = 0; candidate < boundary.size(); ++candidate) {
      // Of a flat side its middle: a little is taken off for the distance from the ray through the centroid.
      const Eigen::RowVector2d d = mesh.points.row(boundary[candidate]) - s.centroid.transpose();
      const double reach = std::cos(phi) * d(0) + std::sin(phi) * d(1) -
                           1e-6 * std::abs(std::cos(phi) * d(1) - std::sin(phi) * d(0));
      if (reach > best + 1e-9 * s.size) {
        best = reach;
        chosen = candidate;
      }
    }
    const StressPoint point{names[direction], mesh.points(boundary[chosen], 0),
                            mesh.points(boundary[chosen], 1), S[chosen]};
    const bool known = std::any_of(
        s.section.points.begin(), s.section.points.end(),
        [&](const StressPoint& p) { return std::hypot(p.y - point.y, p.z - point.z) < 1e-9 * s.size; });
    if (!known) s.section.points.push_back(point);
  }
}

}  // namespace

SectionProperties solve_section(const std::string& name, const SectionMesh& mesh,
                                const std::vector<Ply>& plies) {
  check_section_mesh(name, mesh, plies);
  const int cells = static_cast<int>(mesh.triangles.rows());
  std::vector<Matrix6d> Q(cells);
  std::vector<double> one(cells, 1.0), density(cells), stiffness(cells);
  SectionProperties s;
  for (int cell = 0; cell < cells; ++cell) {
    const Ply& ply = plies[mesh.ply.empty() ? 0 : mesh.ply[cell]];
    Q[cell] = stiffness_of(ply, mesh.plane_angle.empty() ? 0.0 : mesh.plane_angle[cell]);
    density[cell] = ply.material.rho;
    // E along the beam with free sides: 1 / (Q^-1)_xx.
    stiffness[cell] = 1.0 / inverse_spd(Q[cell], fmt::format("material \"{}\"", ply.material.name))(0, 0);
  }
  s.E_ref = stiffness[0];
  const Matrix6d compliance =
      inverse_spd(stiffness_of(plies[mesh.ply.empty() ? 0 : mesh.ply[0]]), "the first ply");
  s.G_ref = 2.0 / (compliance(4, 4) + compliance(5, 5));
  for (double& E : stiffness) E /= s.E_ref;

  const Moments area = moments(mesh, one), mass = moments(mesh, density), elastic = moments(mesh, stiffness);
  s.area = area.o;
  s.centroid = Eigen::Vector2d(area.y, area.z) / area.o;
  s.mass_centre = mass.o > 0.0 ? Eigen::Vector2d(mass.y / mass.o, mass.z / mass.o) : s.centroid;
  s.A = elastic.o;
  s.tension_centre = Eigen::Vector2d(elastic.y, elastic.z) / elastic.o;
  s.I_y = elastic.zz - elastic.z * elastic.z / elastic.o;
  s.I_z = elastic.yy - elastic.y * elastic.y / elastic.o;
  s.I_yz = -(elastic.yz - elastic.y * elastic.z / elastic.o);
  find_principal_axes(s);
  s.size = (mesh.points.colwise().maxCoeff() - mesh.points.colwise().minCoeff()).maxCoeff();

  const SaintVenantFields solution = solve_saint_venant(name, mesh, Q);
  const Matrix6d& f = solution.f;
  // T about the shear centre is T + V_y z_cs - V_z y_cs: f_{V_y T} = z_cs f_TT, f_{V_z T} = -y_cs f_TT.
  s.shear_centre = Eigen::Vector2d(-f(V_z, T), f(V_y, T)) / f(T, T);
  s.I_t = 1.0 / (s.G_ref * f(T, T));
  const double f_y = f(V_y, V_y) - f(V_y, T) * f(V_y, T) / f(T, T);
  const double f_z = f(V_z, V_z) - f(V_z, T) * f(V_z, T) / f(T, T);
  s.A_sy = 1.0 / (s.G_ref * f_y);
  s.A_sz = 1.0 / (s.G_ref * f_z);
  s.shear_coupling = (f(V_y, V_z) - f(V_y, T) * f(V_z, T) / f(T, T)) / std::sqrt(f_y * f_z);
  for (const int axial : {N, M_y, M_z})
    for (const int shear : {V_y, V_z, T})
      s.couples =
          s.couples || std::abs(f(axial, shear)) > 1e-6 * std::sqrt(f(axial, axial) * f(shear, shear));
  find_warping(s, mesh, solution, stiffness);
  s.decay_length = std::sqrt(s.E_ref * s.I_w / (s.G_ref * s.I_t));

  Section& section = s.section;
  section.name = name;
  section.f = f;
  section.f_shear_rigid = without_shear_flexibility(f);
  section.inertia = {mass.o, mass.y, mass.z, mass.yy, mass.zz, mass.yz};
  section.I_w = s.I_w;
  section.open_thin_walled = s.decay_length > s.size;
  section.material = Material{plies[0].material.name, s.E_ref, s.G_ref, mass.o / area.o};
  Constants constants;
  constants.A = s.A;
  constants.I_y = elastic.zz;
  constants.I_z = elastic.yy;
  constants.I_yz = -elastic.yz;
  constants.S_y = elastic.z;
  constants.S_z = elastic.y;
  constants.I_t = s.I_t;
  constants.A_sy = s.A_sy;
  constants.A_sz = s.A_sz;
  constants.y_cs = s.shear_centre.x();
  constants.z_cs = s.shear_centre.y();
  constants.y_cg = s.mass_centre.x();
  constants.z_cg = s.mass_centre.y();
  section.constants = constants;
  std::vector<int> boundary;
  section.outline = boundary_loops(mesh, boundary);
  find_stresses(s, mesh, Q, solution, boundary);
  return s;
}

}  // namespace flexura::beam
