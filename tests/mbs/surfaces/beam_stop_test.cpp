// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/mbs/moving/girder.hpp"
#include "tests/mbs/surfaces/ribbon.hpp"

/// A beam that falls on a stop against its own series of modes, and what the stop is told by.
namespace flexura::mbs::surfaces {
namespace {

using cases::Series;
using cases::simulate;
using moving::kEI;
using moving::kL;
using moving::kMass;
using Sines = moving::Series;

constexpr double kG = 9.81, kGap = 6e-3, kK = 4e6, kWidth = 0.02;

/// The girder of moving/girder.hpp.
superelement::Superelement girder_with_ribbon() {
  beams::StraightBeam beam;
  beam.length = kL;
  beam.elements = 16;
  beam.between = 7;
  beam.EA = 1e10;
  beam.EI_y = beam.EI_z = kEI;
  beam.GI_t = 1e7;
  beam.mass_per_length = kMass;
  beam.rho_I_y = beam.rho_I_z = 1e-3;
  return ribbon(beam, kWidth);
}

/// q_n'' + w_n^2 q_n = 2 / (m L) int p phi_n dx for the weight and the stop under x_j = 3 L / 8, L / 2, 5 L / 8, which bear a
/// quarter, half and a quarter of its stiffness, by Kutta's method.
struct BeamOnStop {
  static constexpr int kModes = 4;  // 1, 3, 5, 7: the others stay at rest
  static int n(int i) { return 2 * i + 1; }
  static double deflection(const Eigen::VectorXd& y, double x) {
    double w = 0.0;
    for (int i = 0; i < kModes; ++i) w += Sines::phi(n(i), x) * y(i);
    return w;
  }
  static double force(const Eigen::VectorXd& y, int j) {
    const double share[] = {0.25, 0.5, 0.25};
    return share[j] * kK * std::max(0.0, -kGap - deflection(y, kL * (3 + j) / 8));
  }
  static Eigen::VectorXd rate(double, const Eigen::VectorXd& y) {
    Eigen::VectorXd f(2 * kModes);
    for (int i = 0; i < kModes; ++i) {
      const double w = Sines::omega(n(i));
      double load = -kMass * kG * 2.0 / Sines::k(n(i));
      for (int j = 0; j < 3; ++j) load += force(y, j) * Sines::phi(n(i), kL * (3 + j) / 8);
      f(i) = y(kModes + i);
      f(kModes + i) = 2.0 / (kMass * kL) * load - w * w * y(i);
    }
    return f;
  }
};

class BeamStop : public moving::GirderTest {
 protected:
  std::string text(const std::string& contact) const {
    std::string girder_of_beam = girder("modal");
    superelement::write(folder_ / "girder.se.h5", girder_with_ribbon());
    return girder_of_beam + fmt::format("[ground.marker.stop]\nposition = [0, 0, {}]\n", -kGap) +
           "[force.stop]\ntype = \"surface_contact\"\nbody = \"girder\"\n" + contact;
  }
};

const char* const kMiddle =
    "from = \"ground.stop\"\nbox = [[3.74, -1, -1], [6.26, 1, 1]]\ntotal_stiffness = \"4e6 N/m\"\n";

// From rest, undeformed, it falls under its weight and meets the stop three times or so within two of its periods.
TEST_F(BeamStop, FallsAsItsSeriesSays) {
  const int rows = 100;
  const double end = 0.25;
  // The stop excites modes that Radau damps: of the energy 5e-6 are lost at 1e-5, 1.8e-6 at 1e-7, 1.9e-7 here.
  const auto p = prepared(text(kMiddle) + moving::solve(end, rows, 1e-8));
  const Series run = simulate(p, {"z", "stop.normal_force", "stop.nodes"});
  Eigen::VectorXd y = Eigen::VectorXd::Zero(2 * BeamOnStop::kModes);
  double t = 0.0, highest = 0.0, worst = 0.0, worst_force = 0.0, lowest = 0.0;
  int touches = 0;
  for (int row = 1; row <= rows; ++row) {
    for (int i = 0; i < 100; ++i) moving::kutta(BeamOnStop::rate, t, y, end / rows / 100);
    const Eigen::VectorXd& values = run.values[static_cast<std::size_t>(row)];
    double force = 0.0;
    for (int j = 0; j < 3; ++j) force += BeamOnStop::force(y, j);
    highest = std::max(highest, force);
    worst = std::max(worst, std::abs(values(0) - BeamOnStop::deflection(y, 0.5 * kL)));
    worst_force = std::max(worst_force, std::abs(values(1) - force));
    lowest = std::min(lowest, values(0));
    touches += values(1) > 0.0;
  }
  // 16 elements have the seventh mode to 0.1 %, its phase after 0.25 s (80 turns) to 0.5 rad of a few tenths of a millimetre.
  EXPECT_LT(worst, 0.02 * std::abs(lowest));
  EXPECT_LT(worst_force, 0.05 * highest);
  EXPECT_GT(touches, 10);
  EXPECT_LT(touches, 90);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
}

// The same stop, as a cylinder of 1 km under it and as a large sphere, is flat to 3 nm over the ribbon's middle.
TEST_F(BeamStop, RoundStopsOfAKilometreAreFlat) {
  const auto depth = [&](const std::string& contact, const std::string& more) {
    const auto p = prepared(text(contact) + more + moving::solve(0.06, 6, 1e-8));
    return simulate(p, {"stop.gap", "stop.normal_force"}).values.back();
  };
  const Eigen::VectorXd flat = depth(kMiddle, "");
  EXPECT_GT(flat(1), 1000.0);
  for (const char* surface : {"sphere", "cylinder"}) {
    std::string contact = kMiddle;
    contact.replace(contact.find("ground.stop"), 11, "ground.centre");
    contact += std::string("surface = \"") + surface + "\"\nsurface_radius = 1e6\n";
    const Eigen::VectorXd round =
        depth(contact, fmt::format("[ground.marker.centre]\nposition = [{}, 0, {}]\naxis = [0, 1, 0]\n",
                                   0.5 * kL, -kGap - 1e6));
    EXPECT_NEAR(round(0), flat(0), 2e-6);
    EXPECT_NEAR(round(1), flat(1), 2e-6 * kK);
  }
}

// A hole of 6 mm above and below around the beam's line: the same fall, seen from inside.
TEST_F(BeamStop, HangsInsideAWideTube) {
  std::string contact = kMiddle;
  contact.replace(contact.find("ground.stop"), 11, "ground.tube");
  contact += "surface = \"cylinder\"\nsurface_radius = 0.5\ninside = true\n";
  const auto p =
      prepared(text(contact) +
               fmt::format("[ground.marker.tube]\nposition = [0, 0, {}]\naxis = [1, 0, 0]\n", 0.5 - kGap) +
               moving::solve(0.06, 6, 1e-8));
  // The vertices 10 mm beside the line touch 0.1 mm earlier than one below it.
  const auto flat = prepared(text(kMiddle) + moving::solve(0.06, 6, 1e-8));
  EXPECT_NEAR(simulate(p, {"z"}).values.back()(0), simulate(flat, {"z"}).values.back()(0) + 1e-4, 5e-5);
}

// Without eigenmodes the body follows its loads: those of the patch are among them.  Damped, both come to rest on a stop that
// stands 2 mm high under the middle.
TEST_F(BeamStop, StaticBodiesKnowTheLoadOfThePatch) {
  const auto rest = [&](const std::string& fidelity) {
    std::string with =
        text("from = \"ground.push\"\nbox = [[3.74, -1, -1], [6.26, 1, 1]]\ntotal_stiffness = \"4e6 N/m\"\n");
    with.replace(with.find("\"modal\""), 7, fidelity + "\ncritical_above = 1");
    const auto p = prepared("gravity = [0, 0, 0]\n" + with +
                            "[ground.marker.push]\nposition = [0, 0, 2e-3]\n" + moving::solve(1.0, 4, 1e-6));
    return Eigen::VectorXd(simulate(p, {"z", "stop.normal_force"}).values.back());
  };
  const Eigen::VectorXd all = rest("\"modal\""), by_loads = rest("\"static\"");
  // 48 E I / L^3 under the middle alone, softer where the load is spread: in series with the stop.
  const double beam = 48.0 * kEI / (kL * kL * kL), series = beam * kK / (beam + kK);
  EXPECT_NEAR(all(1), 2e-3 * series, 0.15 * 2e-3 * series);
  EXPECT_NEAR(by_loads(1), all(1), 0.01 * all(1));
  EXPECT_NEAR(by_loads(0), all(0), 0.01 * all(0));
}

}  // namespace
}  // namespace flexura::mbs::surfaces
