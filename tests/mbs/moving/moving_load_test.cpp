// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <tuple>

#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/mbs/moving/girder.hpp"
#include "tests/reference.hpp"

/// Loads and masses that cross a beam on two supports (L. Fryba, Vibration of Solids and Structures under Moving Loads, 3rd
/// ed., 1999, chapters 1 and 2; S. P. Timoshenko, Phil. Mag. 43 (1922) 1018).
namespace flexura::mbs::moving {
namespace {

using cases::Series;
using cases::simulate;
using Eigen::VectorXd;
using Beam = moving::Series;
constexpr double kG = 9.81;

class MovingLoads : public GirderTest {};

// A force P at the place v t:  w = 2 P / (m L) sum sin(k_n x) (sin W_n t - W_n / w_n sin w_n t) / (w_n^2 - W_n^2), W_n = k_n v.
double under_force(double x, double t, double v, double P) {
  double w = 0.0;
  for (int n = 1; n <= 40; ++n) {
    const double omega = Beam::omega(n), Omega = Beam::k(n) * v;
    w += Beam::phi(n, x) * (std::sin(Omega * t) - Omega / omega * std::sin(omega * t)) /
         (omega * omega - Omega * Omega);
  }
  return 2.0 * P / (kMass * kL) * w;
}

struct Tolerance {
  const char* fidelity;
  double error;  ///< of the largest deflection
};

// A quarter of the critical speed.  The superelement has the elements' own modes; what is left is that of the line between
// nine markers.  Of the eight elements of the others those of exact beams err by order two in their size, (pi/8)^2 / 12 = 1 %
// at most in the first mode; segments, which lump their masses, by twice that, ANCF elements of constant curvature by more.
TEST_F(MovingLoads, ForceCrossesABeamAsFrybaSays) {
  const double v = 0.25 * Beam::omega(1) / Beam::k(1), P = 1e4;
  for (const auto& [fidelity, error] :
       {Tolerance{"modal", 1e-3}, {"beam", 1e-2}, {"segments", 2e-2}, {"ancf", 3e-2}}) {
    SCOPED_TRACE(fidelity);
    const auto p =
        prepared("gravity = [0, 0, 0]\n" + girder(fidelity) + "[force.load]\ntype = \"moving_load\"\n" +
                 path + fmt::format("place = \"{} * t\"\nz = -{}\n", v, P) + solve(kL / v, 10, 1e-7));
    const Series run = simulate(p, {"z", "load.place"});
    double largest = 0.0, off = 0.0;
    for (std::size_t i = 0; i < run.t.size(); ++i) {
      const double w = under_force(0.5 * kL, run.t[i], v, P);
      largest = std::max(largest, std::abs(w));
      off = std::max(off, std::abs(-run.values[i](0) - w));
      EXPECT_NEAR(run.values[i](1), v * run.t[i], 1e-9);
    }
    EXPECT_GT(largest, 1e-2);
    flexura::test::expect_reference(
        fmt::format("force across a beam, {}: largest error of the deflection in the middle over the largest "
                    "deflection",
                    fidelity),
        "", off / largest, 0.0, error,
        {"L. Fryba, Vibration of Solids and Structures under Moving Loads: the series for a force",
         "nine markers, or eight elements, of the line"});
    EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
  }
}

// A mass that bears on the beam, whose inertia the beam feels, by twelve modes and Kutta's method:
//
//     q_n'' + omega_n^2 q_n = 2 / (m L) phi_n(v t) M (g - w''),   w'' = sum phi_n q_n'' + 2 v phi_n' q_n' + v^2 phi_n'' q_n
//
// w'' is that of the mass: Coriolis' and the centripetal term are what tells it from a force.
TEST_F(MovingLoads, MassCrossesABeamAsItsModesSay) {
  constexpr int N = 12;
  const double v = 0.2 * Beam::omega(1) / Beam::k(1), M = 0.5 * kMass * kL;
  const auto modes = [&](double t, const VectorXd& y) {
    Eigen::MatrixXd A = Eigen::MatrixXd::Identity(N, N);
    VectorXd b(N), out(2 * N);
    const double x = v * t, share = 2.0 * M / (kMass * kL);
    double bias = 0.0;
    for (int n = 1; n <= N; ++n)
      bias += 2.0 * v * Beam::phi_1(n, x) * y(N + n - 1) + v * v * Beam::phi_2(n, x) * y(n - 1);
    for (int n = 1; n <= N; ++n) {
      for (int j = 1; j <= N; ++j) A(n - 1, j - 1) += share * Beam::phi(n, x) * Beam::phi(j, x);
      b(n - 1) = share * Beam::phi(n, x) * (kG - bias) - std::pow(Beam::omega(n), 2) * y(n - 1);
    }
    out << y.tail(N), A.partialPivLu().solve(b);
    return out;
  };
  constexpr int kRows = 10, kSteps = 800;
  std::vector<double> w{0.0};
  VectorXd y = VectorXd::Zero(2 * N);
  double t = 0.0, largest = 0.0;
  for (int row = 0; row < kRows; ++row) {
    for (int i = 0; i < kSteps; ++i) kutta(modes, t, y, kL / v / (kRows * kSteps));
    w.push_back(0.0);
    for (int n = 1; n <= N; ++n) w.back() += Beam::phi(n, 0.5 * kL) * y(n - 1);
    largest = std::max(largest, std::abs(w.back()));
  }
  // Unlike the force it is felt by all: without its inertia it would be off by a tenth at least.
  double without = 0.0;
  for (int row = 0; row <= kRows; ++row)
    without = std::max(without, std::abs(w[static_cast<std::size_t>(row)] -
                                         under_force(0.5 * kL, row * kL / v / kRows, v, M * kG)));
  EXPECT_GT(without, 0.1 * largest);

  // The beam has no weight of its own in this, so that gravity is a force on the mass.  A line through nine markers is off by
  // 2e-4 of the first mode, 2e-3 of the second and 2.5e-2 of the third, which have 1, 1/16 and 1/81 of the deflection; it
  // says where the mass is and shares its force, twice 7e-4, and what that excites.
  //
  // Energy: of the beam's vibrations in stretch and shear the steps take what they meet, so that at tolerances from 0.9e-7 to
  // 1.2e-7 its balance is anything from 1e-10 to 7e-6.
  for (const auto& [fidelity, error, energy] :
       {std::tuple{"modal", 4e-3, 1e-6}, std::tuple{"beam", 1e-2, 2e-5}}) {
    SCOPED_TRACE(fidelity);
    const auto p = prepared(
        "gravity = [0, 0, 0]\n" + girder(fidelity) +
        fmt::format(
            "[body.mass]\nmass = {}\ninertia = [1, 1, 1]\nvelocity = [{}, 0, 0]\n[force.weight]\ntype = "
            "\"force\"\nmarker = \"mass\"\nz = {}\n[constraint.ride]\ntype = \"point_on_path\"\nto = "
            "\"mass\"\nplace = \"{} * t\"\n",
            M, v, -M * kG, v) +
        path + solve(kL / v, kRows, 1e-7));
    const Series run = simulate(p, {"z", "ride.place", "ride.speed", "ride.force_z"});
    double off = 0.0;
    for (std::size_t i = 0; i < run.t.size(); ++i) {
      off = std::max(off, std::abs(-run.values[i](0) - w[i]));
      EXPECT_NEAR(run.values[i](1), v * run.t[i], 1e-9);
      EXPECT_NEAR(run.values[i](2), v, 1e-9);
    }
    EXPECT_LT(off, error * largest);
    EXPECT_LT(std::abs(run.result.energy.relative_error()), energy);
  }
}

// At rest it draws the influence line: P a b (L^2 - a^2 - b^2) / (6 L EI) in the middle, for a load and a place at a, b from
// their ends.  With all modes the line between nine markers is what errs; of four modes as the supports hold the beam,
// response modes for the markers mend what is left out.
TEST_F(MovingLoads, AtRestDrawTheInfluenceLine) {
  const double P = 1e4, middle = P * kL * kL * kL / (48.0 * kEI);
  const auto error = [&](const std::string& keys, const std::string& kind) {
    double off = 0.0;
    for (const double place : {1.25, 2.0, 4.6, 5.0, 8.1}) {
      std::string text = girder("modal", keys);
      text +=
          kind == "load"
              ? fmt::format("[force.load]\ntype = \"moving_load\"\n{}place = {}\nz = -{}\n", path, place, P)
              : fmt::format(
                    "[body.mass]\nmass = 1\ninertia = [1, 1, 1]\nposition = [{}, 0, 0]\n[force.weight]\n"
                    "type = \"force\"\nmarker = \"mass\"\nz = -{}\n[constraint.ride]\ntype = "
                    "\"point_on_path\"\nto = \"mass\"\norientation = \"fixed\"\nplace = {}\n{}",
                    place, P, place, path);
      PreparedMechanism p = prepared("gravity = [0, 0, 0]\n" + text);
      find_equilibrium(*p.mechanism, p.state);
      const double a = std::min(place, kL - place), b = 0.5 * kL;
      const double exact = P * a * b * (kL * kL - a * a - b * b) / (6.0 * kL * kEI);
      off = std::max(off, std::abs(-cases::now(p, {"z"})(0) - exact) / middle);
    }
    return off;
  };
  for (const char* const kind : {"load", "mass"}) {
    SCOPED_TRACE(kind);
    EXPECT_LT(error("", kind), 1e-3);
    const double few = error("frame = \"joints\"\nmodes = 4\n", kind);
    EXPECT_GT(few, 5e-3);
    const std::string mended = kind == std::string("load") ? "all" : "used";
    EXPECT_LT(error("frame = \"joints\"\nmodes = 4\nattachments = \"" + mended + "\"\n", kind), 1e-3);
  }
}

}  // namespace
}  // namespace flexura::mbs::moving
