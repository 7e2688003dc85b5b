// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include "mbs/forces/applied.hpp"
#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/accuracy/mechanism_scales.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"

/// Beams that bend far: processor time and accuracy of runs, exact elements beside absolute nodal coordinates.
namespace flexura::mbs {
namespace {

using beam::exact::Kind;

double now() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

std::shared_ptr<const Expression> formula(const std::string& text) {
  return std::make_shared<Expression>("load", text, SignalNames(), std::map<std::string, double>{});
}

struct Scene {
  MechanismDescription d;
  Segments beam;
  double end = 1.0;
};

int marker_on(Scene& scene, int station, const std::string& name) {
  const Segments::Seat& seat = scene.beam.seats[static_cast<std::size_t>(station)];
  return scene.d.add_marker(seat.body, name, {Matrix3d::Identity(), seat.p}, seat.node);
}

// 2 m of cable, let go horizontally.
Scene cable_pendulum(bool is_planar) {
  Scene out;
  BeamPart part;
  part.is_planar = is_planar;
  part.elements = 16;
  part.to_B = {2.0, 0.0, 0.0};
  part.C = Vector6d(1e6, 1e6, 1e6, 1.0, 1.0, 1.0).asDiagonal();
  part.rho_I_y = part.rho_I_z = 1e-6;
  out.d.gravity = {0.0, -9.81, 0.0};
  out.beam = add_exact_elements(out.d, out.d.add_body({.name = "cable"}), part, Kind::cable);
  out.d.add_joint("hook", "revolute", out.d.add_marker(0, "hook"), marker_on(out, 0, "root"));
  return out;
}

// J. C. Simo, L. Vu-Quoc, J. Appl. Mech. 53 (1986) 849 and 855: free, pushed and turned at one end for 2.5 s.
enum class Spaghetti { planar, beam, ancf };
Scene spaghetti(int elements, Spaghetti kind) {
  Scene out;
  BeamPart part;
  part.is_planar = kind == Spaghetti::planar;
  part.elements = elements;
  part.to_B = {10.0, 0.0, 0.0};
  part.C = Vector6d(1e4, 1e4, 1e4, 100.0, 100.0, 100.0).asDiagonal();
  part.rho_I_y = part.rho_I_z = 10.0;
  const int body = out.d.add_body({.name = "beam"});
  int root;
  if (kind == Spaghetti::ancf) {
    BodyDescription& description = out.d.bodies[static_cast<std::size_t>(body)];
    description.flexible = ancf_body(part);
    description.inertia = description.flexible->undeformed_inertia();
    root = out.d.add_marker(body, "root");
  } else {
    out.beam = add_exact_elements(out.d, body, part, Kind::beam);
    root = marker_on(out, 0, "root");
  }
  out.d.gravity.setZero();
  Matrix3d R;
  R << -0.6, -0.8, 0.0, 0.8, -0.6, 0.0, 0.0, 0.0, 1.0;
  const int ground = out.d.add_marker(0, "ground");
  out.d.add_joint("free", "six_dof", out.d.add_marker(0, "start", {R, {6.0, 0.0, 0.0}}), root);
  Applied::Components force, torque;
  force[0] = formula("t < 2.5 ? 8 : 0");
  torque[2] = formula("t < 2.5 ? -80 : 0");
  out.d.forces.push_back(std::make_shared<Applied>("force", false, root, ground, -1, force));
  out.d.forces.push_back(std::make_shared<Applied>("torque", true, root, ground, -1, torque));
  return out;
}

// 0.1 kg, let go on a clamped beam that weighs a hundred thousandth of it.
Scene light_beam() {
  Scene out;
  BeamPart part;
  part.elements = 4;
  part.C = Vector6d(1e5, 4e4, 4e4, 1.0, 1.0, 1.0).asDiagonal();
  part.mass_per_length = 1e-6;
  part.rho_I_y = part.rho_I_z = 1e-11;
  out.beam = add_exact_elements(out.d, out.d.add_body({.name = "beam"}), part, Kind::beam);
  out.d.gravity = {0.0, 0.0, -9.81};
  out.d.add_joint("clamp", "fixed", out.d.add_marker(0, "wall"), marker_on(out, 0, "root"));
  const RigidInertia I = RigidInertia::from_center(0.1, Vector3d::Zero(), 1e-5 * Matrix3d::Identity());
  const int mass = out.d.add_body({.name = "mass", .inertia = I});
  out.d.add_joint("hold", "fixed", marker_on(out, 1, "tip"), out.d.add_marker(mass, "in"));
  out.end = 0.02;
  return out;
}

struct Ran {
  double seconds = 0.0, energy = 0.0;
  long steps = 0;
  std::vector<Vector3d> last;  // the beam's tip (of ancf the body's origin), row by row
};

Ran measure(const Scene& scene, double tolerance) {
  Mechanism mechanism(scene.d);
  State s = mechanism.initial_state();
  Eigen::VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  SolverOptions options;
  options.method = "radau";
  options.end_time = scene.end;
  options.output_step = 0.05 * scene.end;
  options.tolerance = tolerance;
  options.scales = std::make_shared<Scales>(scales_of(mechanism, s));
  Ran out;
  std::vector<Pose> poses;
  const auto places = mechanism.make_scratch(), energies = mechanism.make_scratch();
  RunCallbacks callbacks;
  const bool has_tip = !scene.beam.seats.empty() && scene.beam.seats[1].node >= 0;
  callbacks.row = [&](const State& row, const Eigen::VectorXd& a, const EnergyAccount&) {
    mechanism.body_poses(row, *places, poses);
    Vector3d tip = poses.back().p;
    if (has_tip) {
      const auto& [body, node, p] = scene.beam.seats[1];
      const double* const s_body = row.p.data() + mechanism.modal_position(body);
      tip = poses[static_cast<std::size_t>(body)] * mechanism.deforming(body)->node_pose(node, s_body).p;
    }
    out.last.push_back(tip);
    const EnergyReport e = mechanism.energy(row, a, *energies);
    out.energy = e.kinetic + e.strain;
  };
  const double start = now();
  const RunResult result = run(mechanism, s, v_dot, options, callbacks);
  out.seconds = now() - start;
  out.steps = result.counts.steps;
  if (!result.complete) fmt::print(stderr, "{}\n", result.stopped_because);
  return out;
}

double rms(const Ran& a, const Ran& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.last.size(); ++i) sum += (a.last[i] - b.last[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.last.size()));
}

void print(const std::string& name, const Ran& ran) {
  fmt::print("{}.run = {:.3g} ms\n{}.steps = {} 1\n", name, 1e3 * ran.seconds, name, ran.steps);
}

}  // namespace
}  // namespace flexura::mbs

int main() {
  using namespace flexura::mbs;
  for (const bool is_planar : {true, false}) {
    const Ran exact = measure(cable_pendulum(is_planar), 1e-9);
    for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-6}) {
      const std::string name = fmt::format("{}cable_pendulum_{:.0e}", is_planar ? "planar_" : "", tolerance);
      const Ran ran = measure(cable_pendulum(is_planar), tolerance);
      print(name, ran);
      fmt::print("{}.error = {:.2g} m\n", name, rms(ran, exact));
    }
  }
  // At 1 s; behind a load that jumps energies converge slowly: 80 rigid segments on springs have 158.8 J.
  double of_beam = 0.0;
  const std::pair<const char*, Spaghetti> kinds[] = {
      {"planar", Spaghetti::planar}, {"beam", Spaghetti::beam}, {"ancf", Spaghetti::ancf}};
  for (const auto& [word, kind] : kinds)
    for (const int elements : {4, 8, 16}) {
      const std::string name = fmt::format("spaghetti_{}_{}", word, elements);
      const Ran ran = measure(spaghetti(elements, kind), 1e-3);
      print(name, ran);
      fmt::print("{}.energy = {:.5g} J\n", name, ran.energy);
      if (kind == Spaghetti::beam && elements == 8) of_beam = ran.seconds;
      if (kind == Spaghetti::ancf) fmt::print("{}.over_8_of_beam = {:.3g} 1\n", name, ran.seconds / of_beam);
    }
  for (const double tolerance : {1e-3, 1e-6})
    print(fmt::format("light_beam_{:.0e}", tolerance), measure(light_beam(), tolerance));
  return 0;
}
