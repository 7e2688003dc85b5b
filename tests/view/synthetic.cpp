// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/view/synthetic.hpp"

#include <cmath>
#include <numbers>

namespace flexura::view::synthetic {

using std::numbers::pi;

Eigen::Vector3d tube_displacement(int k, const Eigen::Vector3d& p) {
  const double wave = (k / 2 + 1) * pi / tube_length;
  const int axis = k % 2 == 0 ? 1 : 2;
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  u[axis] = std::sin(wave * p.x());
  u.x() = -wave * std::cos(wave * p.x()) * p[axis];
  return u;
}

superelement::Superelement tube(int around, int along, int n_q) {
  superelement::Superelement se;
  se.name = "tube";
  se.created_by = "flexura tests";
  se.n_b = 12;
  se.n_q = n_q;
  se.inertia.mass = 7850.0 * pi * (tube_radius * tube_radius - tube_bore * tube_bore) * tube_length;
  se.inertia.S_x = Eigen::Vector3d(se.inertia.mass * tube_length / 2, 0.0, 0.0);
  for (int end = 0; end < 2; ++end) {
    superelement::Interface item;
    item.name = end == 0 ? "left end" : "right end";
    item.tie = "rigid";
    item.p_BoN_B = Eigen::Vector3d(end * tube_length, 0.0, 0.0);
    for (int d = 0; d < 6; ++d) item.directions.push_back(static_cast<superelement::Direction>(d));
    item.first_dof = 6 * end;
    se.interfaces.push_back(item);
  }
  // Vertices: outer wall, then inner wall, each `along` + 1 rings of `around`.
  const int rings = along + 1, wall = rings * around;
  se.surface.vertices.resize(2 * wall, 3);
  for (int inner = 0; inner < 2; ++inner) {
    for (int i = 0; i < rings; ++i) {
      for (int j = 0; j < around; ++j) {
        const double r = inner ? tube_bore : tube_radius, angle = 2.0 * pi * j / around;
        se.surface.vertices.row(inner * wall + i * around + j) << tube_length * i / along,
            r * std::cos(angle), r * std::sin(angle);
      }
    }
  }
  const int n_t = 4 * along * around + 4 * around;
  se.surface.triangles.resize(n_t, 3);
  int t = 0;
  const auto quad = [&](int a, int b, int c, int d, int interface) {
    se.surface.triangles.row(t++) << a, b, c;
    se.surface.triangles.row(t++) << a, c, d;
    se.surface.triangle_interface.insert(se.surface.triangle_interface.end(), 2, interface);
  };
  for (int j = 0; j < around; ++j) {
    const int k = (j + 1) % around;
    for (int i = 0; i < along; ++i) {
      const int a = i * around + j, b = i * around + k, c = (i + 1) * around + k, d = (i + 1) * around + j;
      quad(a, b, c, d, -1);
      quad(wall + a, wall + d, wall + c, wall + b, -1);
    }
    quad(k, j, wall + j, wall + k, 0);
    const int last = along * around;
    quad(last + j, last + k, wall + last + k, wall + last + j, 1);
  }
  se.surface.edges.resize(4 * around, 2);
  for (int j = 0; j < around; ++j) {
    for (int ring = 0; ring < 4; ++ring) {
      const int start = (ring % 2) * along * around + (ring / 2) * wall;
      se.surface.edges.row(4 * j + ring) << start + j, start + (j + 1) % around;
    }
  }
  se.shapes.setZero(3 * se.surface.vertices.rows(), se.n());
  for (Eigen::Index v = 0; v < se.surface.vertices.rows(); ++v) {
    for (int k = 0; k < n_q; ++k) {
      se.shapes.block<3, 1>(3 * v, 12 + k) = tube_displacement(k, se.surface.vertices.row(v)).cast<float>();
    }
  }
  return se;
}

ModesPage tube_modes(const superelement::Superelement& se) {
  ModesPage page;
  page.columns.setZero(se.n(), se.n_q);
  for (int k = 0; k < se.n_q; ++k) {
    PageMode mode;
    mode.number = k + 1;
    mode.kind = k % 2 == 0 ? "bending y" : "bending z";
    mode.frequency_hz = 100.0 * std::pow(k / 2 + 1, 2) * (k % 2 == 0 ? 1.0 : 1.01);
    mode.damping = 0.01;
    // Of a uniform beam with shape sin(j pi x / L): 8 / (j pi)^2 of the mass for odd j, none for even j.
    const int j = k / 2 + 1;
    mode.effective_mass[k % 2 == 0 ? 1 : 2] = j % 2 == 1 ? se.inertia.mass * 8.0 / std::pow(j * pi, 2) : 0.0;
    page.modes.push_back(mode);
    page.columns(12 + k, k) = 1.0;
  }
  return page;
}

}  // namespace flexura::view::synthetic
