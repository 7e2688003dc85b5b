// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "mbs/forces/applied.hpp"
#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/accuracy/mechanism_scales.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/statics/statics.hpp"
#include "tests/reference.hpp"

/// Geometrically exact beams and cables against published numbers and closed solutions, and how they converge.
namespace flexura::mbs {
namespace {

using beam::exact::Kind;
using Eigen::VectorXd;
using std::numbers::pi;

int marker_on(MechanismDescription& d, const Segments& beam, int station, const std::string& name) {
  const Segments::Seat& seat = beam.seats[static_cast<std::size_t>(station)];
  return d.add_marker(seat.body, name, {Matrix3d::Identity(), seat.p}, seat.node);
}

std::shared_ptr<const Expression> formula(const std::string& text) {
  return std::make_shared<Expression>("load", text, SignalNames(), std::map<std::string, double>{});
}

Vector3d place_of(const Mechanism& mechanism, const Segments& beam, int station, const State& s) {
  const Segments::Seat& seat = beam.seats[static_cast<std::size_t>(station)];
  std::vector<Pose> poses;
  mechanism.body_poses(s, *mechanism.make_scratch(), poses);
  const FlexibleBody& body = *mechanism.description().bodies[static_cast<std::size_t>(seat.body)].flexible;
  const double* coordinates = s.p.data() + mechanism.modal_position(seat.body);
  return poses[static_cast<std::size_t>(seat.body)] * body.node_pose(seat.node, coordinates).p;
}

double root_of(const std::function<double(double)>& f, double a, double b) {
  const bool rises = f(b) > f(a);
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (a + b);
    (f(middle) > 0.0) == rises ? b = middle : a = middle;
  }
  return 0.5 * (a + b);
}

// A cable of the weight w = 1 per length between two hooks of one height, 1 apart (H. M. Irvine, Cable Structures, 1981, 2.2):
// with its length L as made, the tension H in the middle and V = w L / 2
//     span = H L / EA + 2 H/w asinh(V/H),    sag = L/2 (V - w L/4) / EA + H/w (sqrt(1 + (V/H)^2) - 1).
struct Catenary {
  static constexpr double EA = 1e5;
  double H, L, sag;

  /// The tension is that of an inextensible cable with this sag.
  explicit Catenary(double ratio) {
    H = root_of([&](double c) { return ratio - c * (std::cosh(0.5 / c) - 1.0); }, 1e-2, 1e4);
    L = root_of([&](double l) { return H * l / EA + 2.0 * H * std::asinh(0.5 * l / H) - 1.0; }, 0.5, 20.0);
    const double V = 0.5 * L;
    sag = 0.5 * L * (V - 0.25 * L) / EA + H * (std::sqrt(1.0 + V * V / (H * H)) - 1.0);
  }
};

struct Hung {
  double sag, H;
};

// Starts with the curvature that the closed form has in the middle of each element: a hanging cable has other equilibria, folded ones.
Hung hang(const Catenary& exact, int elements) {
  const double slope = 0.5 * exact.L / exact.H;
  const Vector3d along = Vector3d(1.0, -slope, 0.0).normalized();
  BeamPart part;
  part.elements = elements;
  part.to_B = exact.L * along;
  part.y_axis_B = Vector3d::UnitZ().cross(along);
  part.C.setZero();
  part.C(0, 0) = Catenary::EA;
  part.mass_per_length = 1.0 / 9.81;
  part.rho_I_y = part.rho_I_z = 1e-8;
  part.points = {{"middle", 0.5 * exact.L}};
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  const Segments cable = add_exact_elements(d, d.add_body({.name = "cable"}), part, Kind::cable);
  const Pose right{Matrix3d::Identity(), Vector3d::UnitX()};
  d.add_joint("left", "spherical", d.add_marker(0, "left"), marker_on(d, cable, 0, "root"));
  d.add_joint("right", "spherical", d.add_marker(0, "right", right), marker_on(d, cable, 1, "tip"));
  Mechanism mechanism(d);
  State s = mechanism.initial_state();
  const double l = exact.L / elements;
  for (int k = 0; k < elements; ++k) {
    const double tangent = ((k + 0.5) * l - 0.5 * exact.L) / exact.H, secant2 = 1.0 + tangent * tangent;
    double* strain = s.p.data() + mechanism.modal_position(cable.bodies[static_cast<std::size_t>(k)]);
    strain[2] = l / (exact.H * secant2);  // curvature times the length
  }
  assemble_positions(mechanism, s);
  mechanism.drop_redundant(0.0, s.p);
  s.lambda = VectorXd::Zero(mechanism.sizes().n_lambda);
  solve_statics(mechanism, s);
  return {-place_of(mechanism, cable, 2, s).y(), std::abs(s.lambda(0))};
}

// From a taut wire to a loop that hangs twice as deep as it is wide: errors fall with the fourth power of the elements' length
// where these bend by little each, 2^4 = 16 from 8 to 16 of them.
TEST(ExactBeamPublished, CableHangsAsACatenary) {
  struct {
    double ratio, error, order;  // of 16 elements
  } const cases[] = {{1e-3, 1e-9, 3.0}, {1e-2, 2e-8, 3.5}, {0.1, 2e-6, 3.5},
                     {0.5, 2e-4, 3.5},  {1.0, 2e-3, 3.0},  {2.0, 2e-2, 1.9}};
  for (const auto& [ratio, error, order] : cases) {
    SCOPED_TRACE(ratio);
    const Catenary exact(ratio);
    const Hung coarse = hang(exact, 8), fine = hang(exact, 16);
    constexpr flexura::test::Reference irvine{
        "Elastic catenary (Irvine, Cable Structures, 1981), 16 elements of cable",
        "interpolation, with the fourth power of the elements' length"};
    const std::string of = ", sag " + std::to_string(ratio) + " of the span";
    flexura::test::expect_reference("sag" + of, "m", fine.sag, exact.sag, error * exact.sag, irvine);
    flexura::test::expect_reference("tension in the middle" + of, "N", fine.H, exact.H, 2.0 * error * exact.H,
                                    irvine);
    EXPECT_GT(std::abs(coarse.sag - exact.sag), std::pow(2.0, order) * std::abs(fine.sag - exact.sag));
  }
}

// A cable with bending stiffness, clamped, under its weight: 32 elements ANCFCable2D of Exudyn (J. Gerstmayr; its mini example of
// ObjectANCFCable2D) say u_x = -0.5013058140308901 m, converged to four digits.  Ours err with the second power.
TEST(ExactBeamPublished, ClampedCableBendsAsAnotherProgramSays) {
  const auto shortening = [](int elements) {
    BeamPart part;
    part.elements = elements;
    part.to_B = {2.0, 0.0, 0.0};
    const double EI = 833.3333333333333;
    part.C = Vector6d(1e6, 1.0, 1.0, 1.0, EI, EI).asDiagonal();
    part.mass_per_length = 78.0;
    part.rho_I_y = part.rho_I_z = 1e-6;
    MechanismDescription d;
    d.gravity = {0.0, -9.81, 0.0};
    const Segments cable = add_exact_elements(d, d.add_body({.name = "cable"}), part, Kind::cable);
    d.add_joint("clamp", "fixed", d.add_marker(0, "wall"), marker_on(d, cable, 0, "root"));
    const Mechanism mechanism(d);
    State s = mechanism.initial_state();
    solve_statics(mechanism, s);
    return place_of(mechanism, cable, 1, s).x() - 2.0;
  };
  const double published = -0.5013058140308901, coarse = shortening(16), fine = shortening(32);
  EXPECT_NEAR(fine, published, 5e-4 * std::abs(published));
  flexura::test::expect_reference(
      "tip along the cable, extrapolated from 16 and 32 elements", "m", fine + (fine - coarse) / 3.0,
      published, 1e-4 * std::abs(published),
      {"Exudyn's example of ObjectANCFCable2D, a clamped cable with bending stiffness",
       "its four converged digits"});
}

// K.-J. Bathe, S. Bolourchi, Int. J. Numer. Meth. Eng. 14 (1979) 961: an arc of 45 degrees and radius 100, a unit square with
// E = 1e7, nu = 0, 600 at its tip across its plane.  What the tip does along the start, to the inside and across, of others with
// the section EI = GI_t = 8.333e5, GA = 41.6667e5.
TEST(ExactBeamPublished, ArcBendsOutOfItsPlane) {
  const auto tip = [](int elements) -> Vector3d {
    BeamPart part;
    part.elements = elements;
    part.to_B = {0.0, 100.0 * pi / 4.0, 0.0};
    part.y_axis_B = {1.0, 0.0, 0.0};
    part.curvature = {0.0, 0.0, 0.01};
    part.C = Vector6d(1e7, 1e7 / 2.4, 1e7 / 2.4, 1e7 / 12.0, 1e7 / 12.0, 1e7 / 12.0).asDiagonal();
    part.rho_I_y = part.rho_I_z = 0.1;
    MechanismDescription d;
    d.gravity.setZero();
    const Segments arc = add_exact_elements(d, d.add_body({.name = "arc"}), part, Kind::beam);
    const int wall = d.add_marker(0, "wall");
    d.add_joint("clamp", "fixed", wall, marker_on(d, arc, 0, "root"));
    Applied::Components force;
    force[2] = formula("600");
    d.forces.push_back(
        std::make_shared<Applied>("pull", false, marker_on(d, arc, 1, "tip"), wall, -1, force));
    const Mechanism mechanism(d);
    State s = mechanism.initial_state();
    solve_statics(mechanism, s);
    const Vector3d u = place_of(mechanism, arc, 1, s) - part.section_at(part.length()).p;
    return {u.y(), -u.x(), u.z()};
  };
  struct {
    const char* who;
    Vector3d u;
    double digits;  // what their elements and their rounding leave
  } const published[] = {
      {"Bathe, Bolourchi 1979, eight elements", {-23.5, 13.4, 53.4}, 0.25},
      {"Simo, Vu-Quoc, Comput. Methods Appl. Mech. Eng. 58 (1986) 79", {-23.48, 13.50, 53.37}, 0.15},
      {"Wang, Sprague, Jonkman, Johnson, NREL/CP-5000-63165 (2015), BeamDyn", {-23.7, 13.5, 53.4}, 0.2},
      {"Kynema's documentation, one spectral element of 12 nodes", {-23.64597, 13.72080, 53.57765}, 0.12},
  };
  const Vector3d coarse = tip(2), middle = tip(4), fine = tip(8);
  for (const auto& [who, u, digits] : published) {
    SCOPED_TRACE(who);
    const char* const along[] = {"along the start", "to the inside", "across"};
    for (int i = 0; i < 3; ++i)
      flexura::test::expect_reference(std::string("45-degree bend, tip ") + along[i], "", fine(i), u(i),
                                      digits, {who, "what their elements and their rounding leave"});
  }
  EXPECT_GT((coarse - middle).norm(), 8.0 * (middle - fine).norm());  // 16 in the limit
}

struct Thrown {
  double kinetic[3], total[3];  // at 5, 6 and 7 s
};

// J. C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Eng. 66 (1988) 125: the flying spaghetti in space.  A force T/10 along x, a
// torque T about y and T/2 about z at one end, T rising to 200 at 2.5 s and back to 0 at 5 s.
Thrown throw_in_space(int elements) {
  BeamPart part;
  part.elements = elements;
  part.to_B = {10.0, 0.0, 0.0};
  part.C = Vector6d(1e4, 1e4, 1e4, 500.0, 500.0, 500.0).asDiagonal();
  part.rho_I_y = part.rho_I_z = 10.0;
  MechanismDescription d;
  d.gravity.setZero();
  const Segments beam = add_exact_elements(d, d.add_body({.name = "beam"}), part, Kind::beam);
  Matrix3d R;
  R << -0.6, 0.0, -0.8, 0.0, 1.0, 0.0, 0.8, 0.0, -0.6;
  const int root = marker_on(d, beam, 0, "root"), ground = d.add_marker(0, "ground");
  d.add_joint("free", "six_dof", d.add_marker(0, "start", {R, {6.0, 0.0, 0.0}}), root);
  const std::string T = "(t < 2.5 ? 80*t : t < 5 ? 80*(5 - t) : 0)";
  Applied::Components force, torque;
  force[0] = formula("0.1*" + T);
  torque[1] = formula(T);
  torque[2] = formula("0.5*" + T);
  d.forces.push_back(std::make_shared<Applied>("force", false, root, ground, -1, force));
  d.forces.push_back(std::make_shared<Applied>("torque", true, root, ground, -1, torque));
  Mechanism mechanism(d);
  State s = mechanism.initial_state();
  VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  SolverOptions solver;
  solver.method = "radau";
  solver.end_time = 7.0;
  solver.output_step = 1.0;
  solver.tolerance = 1e-5;
  solver.scales = std::make_shared<Scales>(scales_of(mechanism, s));
  Thrown out{};
  const auto scratch = mechanism.make_scratch();
  RunCallbacks callbacks;
  callbacks.row = [&](const State& row, const VectorXd& a, const EnergyAccount&) {
    const long i = std::lround(row.t) - 5;
    if (i < 0) return;
    const EnergyReport e = mechanism.energy(row, a, *scratch);
    out.kinetic[i] = e.kinetic;
    out.total[i] = e.kinetic + e.strain;
  };
  const RunResult result = run(mechanism, s, v_dot, solver, callbacks);
  EXPECT_TRUE(result.complete) << result.stopped_because;
  return out;
}

TEST(ExactBeamPublished, SpaghettiFliesInSpace) {
  // Of 20 and 40 rigid segments on springs (fidelity "segments", 693.352 and 692.812 at 5 s), extrapolated by their order, 2.
  const double segments[] = {692.632, 694.763, 662.913};
  const Thrown few = throw_in_space(4), more = throw_in_space(8);
  for (const int i : {0, 1, 2}) {
    SCOPED_TRACE(i);
    flexura::test::expect_reference(
        "flying spaghetti in space (Simo, Vu-Quoc 1988), kinetic energy at " + std::to_string(i + 5) + " s",
        "J", more.kinetic[i], segments[i], 1e-3 * segments[i],
        {"20 and 40 rigid segments, extrapolated by their order", "eight elements' own error"});
    EXPECT_NEAR(few.total[i], more.total[i], 1e-3 * more.total[i]);
    EXPECT_NEAR(more.total[i], more.total[0], 1e-4 * more.total[0]);  // no load is left
  }
}

}  // namespace
}  // namespace flexura::mbs
