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
  // Integral of x_a x_b dm about the left end: m L^2 / 3 along the axis, m (R^2 + r^2) / 4 across.
  const double across = se.inertia.mass * (tube_radius * tube_radius + tube_bore * tube_bore) / 4.0;
  se.inertia.S_xx.diagonal() << se.inertia.mass * tube_length * tube_length / 3.0, across, across;
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

void add_stress(superelement::Superelement& tube) {
  superelement::StressModes& stress = tube.stress.emplace();
  const Eigen::Index n_v = tube.surface.vertices.rows();
  stress.S.setZero(6 * n_v, tube.n());
  for (Eigen::Index v = 0; v < n_v; ++v) {
    stress.vertices.push_back(static_cast<std::int32_t>(v));
    const Eigen::Vector3d p = tube.surface.vertices.row(v);
    for (int k = 0; k < tube.n_q; ++k) {
      const double wave = (k / 2 + 1) * pi / tube_length;
      stress.S(6 * v, 12 + k) = tube_young * wave * wave * std::sin(wave * p.x()) * p[k % 2 == 0 ? 1 : 2];
    }
  }
}

void add_sections(superelement::Superelement& tube) {
  superelement::SectionForces& sections = tube.sections.emplace();
  constexpr int places = 5;
  sections.members = {"tube"};
  sections.member.assign(places, 0);
  sections.positions.setZero(places, 3);
  sections.axes.setZero(places, 9);
  sections.S.setZero(6 * places, tube.n());
  for (int p = 0; p < places; ++p) {
    const double x = tube_length * p / (places - 1);
    sections.positions(p, 0) = x;
    for (int a = 0; a < 3; ++a) sections.axes(p, 4 * a) = 1.0;
    for (int k = 0; k < tube.n_q; ++k) {
      const double wave = (k / 2 + 1) * pi / tube_length;
      const double bending = tube_bending_stiffness * wave * wave * std::sin(wave * x);
      const double shear = tube_bending_stiffness * std::pow(wave, 3) * std::cos(wave * x);
      sections.S(6 * p + (k % 2 == 0 ? 5 : 4), 12 + k) = k % 2 == 0 ? -bending : bending;
      sections.S(6 * p + (k % 2 == 0 ? 1 : 2), 12 + k) = shear;
    }
  }
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
    mode.can_strike = true;
    // Of a uniform beam with shape sin(j pi x / L): 8 / (j pi)^2 of the mass for odd j, none for even j.
    const int j = k / 2 + 1;
    mode.effective_mass[k % 2 == 0 ? 1 : 2] = j % 2 == 1 ? se.inertia.mass * 8.0 / std::pow(j * pi, 2) : 0.0;
    page.modes.push_back(mode);
    page.columns(12 + k, k) = 1.0;
  }
  return page;
}

EnginePose engine_pose(double t) {
  const double crank = 2.0 * pi * t;
  const double rod = -std::asin(crank_radius * std::sin(crank) / tube_length);
  return {crank, rod, crank_radius * std::cos(crank) + tube_length * std::cos(rod)};
}

double rod_modal(int j, double t) {
  return 0.002 / (j + 1) * std::sin(2.0 * pi * (2 + j) * t);
}

results::Results engine(Pictures& pictures) {
  results::Results all;
  all.model.name = "slider-crank";
  all.model.created_by = "flexura tests";
  all.model.bodies = {
      {"ground", "ground", "", R"([{"type": "box", "size": [0.9, 0.3, 0.04], "position": [1.0, 0, -0.12]}])"},
      {"crank", "rigid", "",
       R"([{"type": "cylinder", "radius": 0.31, "length": 0.05, "position": [0, 0.1, 0], "axis": [0, 1, 0]},
           {"type": "cylinder", "radius": 0.035, "length": 0.2, "position": [0.25, 0.03, 0], "axis": [0, 1, 0]}])"},
      {"rod", "flexible", "tube.se.h5", ""},
      {"slider", "rigid", "", R"([{"type": "box", "size": [0.2, 0.2, 0.18]}])"}};
  all.model.connections_json = R"([
    {"name": "main", "kind": "revolute", "body_1": "ground", "p_1": [0, 0, 0], "body_2": "crank", "p_2": [0, 0, 0],
     "axis_1": [0, 1, 0]},
    {"name": "pin", "kind": "revolute", "body_1": "crank", "p_1": [0.25, 0, 0], "body_2": "rod", "p_2": [0, 0, 0],
     "axis_1": [0, 1, 0]},
    {"name": "cross", "kind": "revolute", "body_1": "rod", "p_1": [1, 0, 0], "body_2": "slider", "p_2": [0, 0, 0],
     "axis_1": [0, 1, 0]},
    {"name": "load", "kind": "spring_damper", "body_1": "slider", "p_1": [0.1, 0, 0], "body_2": "ground",
     "p_2": [1.7, 0, 0]},
    {"name": "push", "kind": "force", "body_2": "slider", "p_2": [0, 0, 0],
     "axes": {"body": "crank", "rotation": [1, 0, 0, 0]}}])";
  auto rod = tube(32, 40, rod_modes);
  add_stress(rod);
  add_sections(rod);
  pictures["rod"] = std::make_shared<const superelement::Superelement>(std::move(rod));
  for (const bool flexible : {false, true}) {
    results::Run run;
    run.name = flexible ? "flexible" : "rigid";
    run.complete = flexible;
    run.stopped_because = flexible ? "" : "end of the test's patience";
    run.summary_json = R"({"energy error": 3.2e-7, "steps": 812, "warnings": ["one <b>warning</b>"]})";
    run.quantities = {{"crank.speed", "rad/s", "angular speed of the crank"},
                      {"slider.position", "m", "place of the slider along x"},
                      {"rod.deflection", "m", "displacement of the rod's middle along y"},
                      {"energy.kinetic", "J", ""},
                      {"energy.strain", "J", ""},
                      {"push.x", "N", "along the crank"},
                      {"push.y", "N", ""},
                      {"push.z", "N", ""}};
    run.time = Eigen::VectorXd::LinSpaced(engine_rows, 0.0, engine_time);
    run.values.resize(engine_rows, 8);
    run.bodies.resize(3);
    const char* names[] = {"crank", "rod", "slider"};
    for (int b = 0; b < 3; ++b) {
      run.bodies[static_cast<std::size_t>(b)].name = names[b];
      run.bodies[static_cast<std::size_t>(b)].pose.resize(engine_rows, 7);
    }
    auto& rod_run = run.bodies[1];
    if (flexible) {
      rod_run.modal.resize(engine_rows, rod_modes);
      rod_run.basis.setZero(12 + rod_modes, rod_modes);
      rod_run.basis.bottomRows(rod_modes).setIdentity();
    }
    for (int i = 0; i < engine_rows; ++i) {
      const double t = run.time[i];
      const EnginePose p = engine_pose(t);
      run.bodies[0].pose.row(i) << 0, 0, 0, std::cos(p.crank / 2), 0, -std::sin(p.crank / 2), 0;
      run.bodies[1].pose.row(i) << crank_radius * std::cos(p.crank), 0, crank_radius * std::sin(p.crank),
          std::cos(p.rod / 2), 0, -std::sin(p.rod / 2), 0;
      run.bodies[2].pose.row(i) << p.slider, 0, 0, 1, 0, 0, 0;
      double deflection = 0.0;
      for (int j = 0; flexible && j < rod_modes; ++j) {
        rod_run.modal(i, j) = rod_modal(j, t);
        deflection += rod_modal(j, t) * tube_displacement(j, {tube_length / 2, 0.0, 0.0}).y();
      }
      run.values.row(i) << 2.0 * pi + (flexible ? 0.2 * std::sin(2.0 * pi * 8.0 * t) : 0.0), p.slider,
          deflection, 120.0 + 30.0 * std::cos(4.0 * pi * t), 4e4 * deflection * deflection, push_force, 0.0,
          0.0;
    }
    all.runs.push_back(std::move(run));
  }
  return all;
}

}  // namespace flexura::view::synthetic
