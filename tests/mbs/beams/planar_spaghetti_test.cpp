// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <map>
#include <numbers>

#include "tests/mbs/beams/planar_rod.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/reference.hpp"

/// The flying spaghetti in its plane (J. C. Simo, L. Vu-Quoc, J. Appl. Mech. 53 (1986) 849 and 855): a rod of 10 m, free, that a
/// force of 8 N and a torque of -80 N m at one end bend and throw for 2.5 s; against a spectral solution (planar_rod.hpp).  Once
/// with their abrupt pulse, whose fronts no polynomials follow fast (sqrt(EI / rho I) = 3.2 m/s, so they are there for long: 48 and
/// 64 points still differ by 0.5 % in energy at 1 s, by 1e-4 m in places); and with one of the same impulse that rises and falls
/// smoothly, whose solution 29 points have to 1e-5.
namespace flexura::mbs::beams {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPushed = 2.5;
enum class Pulse { abrupt, smooth };

/// Kinetic and strain energy, places of the first end and of the last.
struct Instant {
  double kinetic, strain;
  Eigen::Vector2d first, last;
  double total() const { return kinetic + strain; }
};

// At whole and half seconds.
std::map<double, Instant> spectral(Pulse pulse, int N, double end) {
  PlanarRod rod({.L = 10.0, .EA = 1e4, .GA = 1e4, .EI = 100.0, .rho_A = 1.0, .rho_I = 10.0}, N);
  rod.place({6.0, 0.0}, std::atan2(0.8, -0.6));
  const auto load = [&](double t) -> Vector3d {
    const double s = std::sin(std::numbers::pi * t / kPushed);
    const double size = t >= kPushed ? 0.0 : pulse == Pulse::abrupt ? 1.0 : 2.0 * s * s;
    return size * Vector3d(8.0, 0.0, -80.0);
  };
  std::map<double, Instant> out;
  for (double t = 0.5; t < end + 0.1; t += 0.5) {
    rod.run(t, 0.25 / (N * N), load);  // a fifth of what is stable
    out[t] = {rod.kinetic(), rod.strain(), rod.first().head<2>(), rod.last().head<2>()};
  }
  return out;
}

class PlanarSpaghetti : public cases::TextCase {
 protected:
  std::map<double, Instant> fly(Pulse pulse, int elements, double tolerance, double end,
                                bool is_planar = false) const {
    const char* const shape = pulse == Pulse::abrupt ? "1" : "2*sin(pi*t/2.5)^2";
    const PreparedMechanism p = prepared(fmt::format(
        R"toml(
gravity = [0, 0, 0]
[body.beam]
fidelity = "beam"
[body.beam.beam]
from = [6, 0, 0]
to = [0, 8, 0]
y_axis = [-0.8, -0.6, 0]
elements = {}
EA = 1e4
GA_y = 1e4
GA_z = 1e4
GI_t = 100
EI_y = 100
EI_z = 100
mass_per_length = 1
rho_I_y = 10
rho_I_z = 10
planar = {}
[force.push]
type = "force"
marker = "beam.root"
x = "t < 2.5 ? 8*{} : 0"
[force.turn]
type = "torque"
marker = "beam.root"
z = "t < 2.5 ? -80*{} : 0"
[measure.x_first]
type = "position"
from = "ground"
to = "beam.root"
direction = [1, 0, 0]
[measure.y_first]
type = "position"
from = "ground"
to = "beam.root"
direction = [0, 1, 0]
[measure.x_last]
type = "position"
from = "ground"
to = "beam.tip"
direction = [1, 0, 0]
[measure.y_last]
type = "position"
from = "ground"
to = "beam.tip"
direction = [0, 1, 0]
[solver]
end_time = {}
output_step = 0.5
tolerance = {}
)toml",
        elements, is_planar, shape, shape, end, tolerance));
    const cases::Series run =
        cases::simulate(p, {"energy.kinetic", "energy.strain", "x_first", "y_first", "x_last", "y_last"});
    EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-4);
    std::map<double, Instant> out;
    for (std::size_t i = 1; i < run.t.size(); ++i) {
      const VectorXd& v = run.values[i];
      out[0.5 * std::round(2.0 * run.t[i])] = {v(0), v(1), v.segment<2>(2), v.segment<2>(4)};
    }
    return out;
  }
};

// The reference by other numbers of points, and by what no load is left to change.
TEST_F(PlanarSpaghetti, SpectralSolutionIsConverged) {
  const auto fine = spectral(Pulse::smooth, 28, 5.0), coarse = spectral(Pulse::smooth, 24, 5.0);
  const double total = fine.at(kPushed).total();
  for (const auto& [t, now] : fine) {
    SCOPED_TRACE(t);
    EXPECT_NEAR(coarse.at(t).kinetic, now.kinetic, 5e-5 * total);
    EXPECT_NEAR(coarse.at(t).strain, now.strain, 5e-5 * total);
    EXPECT_LT((coarse.at(t).last - now.last).norm(), 4e-4);
    if (t >= kPushed) EXPECT_NEAR(now.total(), total, 1e-6 * total);
  }
}

// Eight elements: within 0.1 % in energy, at the end of the pulse and for ever after.  Errors fall with the fourth power of the
// elements' length: 2^4 = 16 from four elements to eight (measured: 20 in place, 40 in energy; 12 to 15 from eight to sixteen).
TEST_F(PlanarSpaghetti, FliesAsTheSpectralSolutionSays) {
  const double end = 5.0;
  const auto exact = spectral(Pulse::smooth, 28, end), few = fly(Pulse::smooth, 4, 1e-4, end),
             more = fly(Pulse::smooth, 8, 1e-4, end), planar = fly(Pulse::smooth, 8, 1e-4, end, true);
  const flexura::test::Reference spectra = {
      "flying spaghetti in its plane, smooth pulse: spectral solution of 29 points by Kutta's method",
      "eight elements' own error"};
  for (const double t : {2.5, 5.0}) {
    const Instant &ours = more.at(t), &right = exact.at(t);
    flexura::test::expect_reference(fmt::format("energy at {} s", t), "J", ours.total(), right.total(),
                                    1e-3 * right.total(), spectra);
    flexura::test::expect_reference(fmt::format("kinetic energy at {} s", t), "J", ours.kinetic,
                                    right.kinetic, 2e-3 * right.kinetic, spectra);
    flexura::test::expect_reference(fmt::format("energy at {} s, planar", t), "J", planar.at(t).total(),
                                    right.total(), 1e-3 * right.total(), spectra);
    EXPECT_LT((planar.at(t).last - right.last).norm(), 3e-2);
    EXPECT_LT((ours.first - right.first).norm(), 1.2e-2);
    EXPECT_LT((ours.last - right.last).norm(), 3e-2);
    EXPECT_GT((few.at(t).last - right.last).norm(), 12.0 * (ours.last - right.last).norm());
    EXPECT_GT(std::abs(few.at(t).total() - right.total()), 12.0 * std::abs(ours.total() - right.total()));
  }
}

// Fronts take the order away: first in energy, which is what the torque finds at its end.
TEST_F(PlanarSpaghetti, IsThrownByTheAbruptPulse) {
  const auto exact = spectral(Pulse::abrupt, 48, kPushed), ours = fly(Pulse::abrupt, 8, 1e-4, kPushed);
  for (const double t : {1.0, 2.0, 2.5}) {
    SCOPED_TRACE(t);
    const Instant &is = ours.at(t), &right = exact.at(t);
    flexura::test::expect_reference(
        fmt::format("energy at {} s", t), "J", is.total(), right.total(), 0.02 * right.total(),
        {"flying spaghetti in its plane (Simo, Vu-Quoc 1986): spectral solution of 49 points by Kutta's "
         "method",
         "fronts: neither eight elements nor 49 points converge faster than with their number"});
    EXPECT_LT((is.first - right.first).norm(), 1e-2);
    EXPECT_LT((is.last - right.last).norm(), 1e-2);
  }
}

}  // namespace
}  // namespace flexura::mbs::beams
