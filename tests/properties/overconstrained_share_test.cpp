// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What the integrator costs linkages whose rows follow from each other, told by the run itself, against Bennett's closed form.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>

#include "mbs/mechanism/describe.hpp"
#include "mbs/study/estimate/global_error.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/properties/bennett.hpp"
#include "tests/properties/one_freedom.hpp"

namespace flexura::properties {
namespace {

using Eigen::VectorXd;
using mbs::chance::Chance;

struct Told {
  study::IntegratorEstimate estimate;
  VectorXd off;  // of each output, in parts of its rms
};

// `exact` gives the outputs asked for at a time.
Told tell(const std::filesystem::path& file, const std::function<VectorXd(double)>& exact) {
  const mbs::PreparedMechanism p = mbs::prepare(file);
  const auto which = mbs::select_quantities(*p.mechanism, p.file.outputs);
  const auto scratch = p.mechanism->make_scratch();
  const auto error = study::GlobalError::make(p);
  VectorXd y(static_cast<Eigen::Index>(which.size())), squares = VectorXd::Zero(y.size()), sizes = squares;
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount&) {
    p.mechanism->evaluate(which, s, v_dot, *scratch, y);
    const VectorXd right = exact(s.t);
    squares += (y - right).cwiseAbs2();
    sizes += right.cwiseAbs2();
  };
  error->watch(callbacks);
  const mbs::RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(run.complete) << run.stopped_because;
  return {error->estimate(), squares.cwiseQuotient(sizes).cwiseSqrt()};
}

// phi = 2 atan2(K cos(theta / 2), sin(theta / 2)): phi' = -K / D, D = sin^2 + K^2 cos^2.
VectorXd outputs_of(const Bennett& linkage, double angle, double rate, double bend) {
  const double K = linkage.product(), s = std::sin(0.5 * angle), c = std::cos(0.5 * angle),
               D = s * s + K * K * c * c, D_slope = s * c * (1.0 - K * K);
  return VectorXd{{-K / D * rate, K * D_slope / (D * D) * rate * rate - K / D * bend, -rate, -bend}};
}

std::string asks(double tolerance, const std::string& method) {
  return fmt::format(
      "[output]\nquantities = [\"j1.speed\", \"j1.acceleration\", \"j2.speed\", \"j2.acceleration\"]\n"
      "[solver]\nend_time = 2\noutput_step = 0.01\ntolerance = {}\nmethod = \"{}\"\n",
      tolerance, method);
}

// The rows of a run are closed to 1e-11 of what a motion changes in them, and it keeps rows down to sigma = 0.03: what that
// leaves open of rates, 1e-11 / sigma^2, belongs to no step.
constexpr double kOpen = 1e-11 / (0.03 * 0.03);

// Never less than a third of what is true; counts those that are told more than three times as much, or unknown where it is
// small.
void expect_told(const Told& told, int& above) {
  const double off = told.off.maxCoeff();
  if (told.estimate.is_whole) EXPECT_GT(told.estimate.error, off / 3.0 - kOpen) << told.estimate.output;
  above += told.estimate.is_whole ? told.estimate.error > 3.0 * off + kOpen : off < 0.3 * 0.05;
}

// Its drive and its rows leave it no freedom: what integrators lose is closed at each row, also where the rows of the start
// depend on each other. Of 1e-9 that are true up to 1e-3 were told.
TEST(OverconstrainedShare, OfDrivenBennettLinkagesIsWhatTheirLoopsAreOpenBy) {
  const test::Folder folder;
  int above = 0;
  for (int seed = 0; seed < 100; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 4001);
    const Bennett linkage{chance.between(0.3, 0.9), chance.between(1.0, 1.5), chance.between(0.1, 1.0)};
    const double theta = chance.between(0.3, 2.8), w = chance.either_sign(1.0, 10.0),
                 A = chance.between(0.0, 0.5), W = chance.between(1.0, 5.0);
    const double tolerance = std::pow(10.0, chance.between(-8.0, -4.0));
    const std::string method = kMethods[seed % 4];
    const std::string text =
        text_of(linkage, theta, fmt::format("drive = \"{} + {}*t + {}*sin({}*t)\"\n", theta, w, A, W)) +
        asks(tolerance, method);
    SCOPED_TRACE(fmt::format("seed {} by {} to {}\n{}", seed, method, tolerance, text));
    expect_told(tell(folder.write("linkage.toml", text),
                     [&](double t) {
                       return outputs_of(linkage, theta + w * t + A * std::sin(W * t),
                                         w + A * W * std::cos(W * t), -A * W * W * std::sin(W * t));
                     }),
                above);
  }
  // Where a long step leads across the place at which the rows change.
  EXPECT_LE(above, 3);
}

// No force acts: I theta'' = -I' theta'^2 / 2. Of 3e-7 that are true 4e-4 were told.
TEST(OverconstrainedShare, OfFreeBennettLinkagesIsWithinAFactorOfThree) {
  const test::Folder folder;
  int above = 0;
  for (int seed = 0; seed < 100; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 5001);
    const Bennett linkage{chance.between(0.3, 0.9), chance.between(1.0, 1.5), chance.between(0.1, 1.0)};
    const double theta = chance.between(0.3, 2.8), speed = chance.either_sign(1.0, 6.0);
    const double tolerance = std::pow(10.0, chance.between(-6.5, -4.5));
    const std::string method = kMethods[seed % 4];
    const std::string text =
        text_of(linkage, theta, fmt::format("angle = \"{} rad\"\nspeed = {}\n", theta, speed)) +
        asks(tolerance, method);
    SCOPED_TRACE(fmt::format("seed {} by {} to {}\n{}", seed, method, tolerance, text));
    const Law law = [&](double q, double w) {
      constexpr double h = 1e-4;  // the square of it is lost, and 1e-12 / h of the differences' round-off
      return -0.25 * (linkage.inertia(q + h) - linkage.inertia(q - h)) / h / linkage.inertia(q) * w * w;
    };
    // By the classical Runge-Kutta method in steps of 5 ms, of order 4: 1e-9 of a turn here.
    double at = 0.0, angle = theta, rate = speed;
    expect_told(tell(folder.write("linkage.toml", text),
                     [&](double t) {
                       for (const double h = 0.5 * (t - at); h > 0.0 && at < t - 0.5 * h; at += h) {
                         const double a1 = law(angle, rate), v2 = rate + 0.5 * h * a1;
                         const double a2 = law(angle + 0.5 * h * rate, v2), v3 = rate + 0.5 * h * a2;
                         const double a3 = law(angle + 0.5 * h * v2, v3), v4 = rate + h * a3;
                         const double a4 = law(angle + h * v3, v4);
                         angle += h / 6.0 * (rate + 2.0 * v2 + 2.0 * v3 + v4);
                         rate += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
                       }
                       at = t;
                       return outputs_of(linkage, angle, rate, law(angle, rate));
                     }),
                above);
  }
  // Where a long step leads across the place at which the rows change.
  EXPECT_LE(above, 3);
}

}  // namespace
}  // namespace flexura::properties
