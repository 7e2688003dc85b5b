// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Rows on and beside dead points, by every method: linkages whose crank turns evenly, so that their forces are closed formulas. A
// force that is wrong is told; ordinary linkages raise no alarm.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "mbs/study/estimate/global_error.hpp"
#include "tests/mbs/planar_links.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/properties/one_freedom.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;
using mbs::test::hinge;
using mbs::test::PlanarLink;
using Real = long double;  // sums that cancel next to a dead point

constexpr Real kGravity = 9.81L;
constexpr const char* kAllMethods[] = {"kinematics", "ida", "radau", "generalised_alpha", "runge_kutta"};

struct Force {
  Real x = 0.0L, y = 0.0L;
};

/// A linkage with an evenly turning crank: its text without [solver], and the force in its last hinge, h4, on the body of `to`, in the axes
/// of `from`, by the crank's angle.
struct Linkage {
  std::string text;
  std::function<Force(Real)> force;
};

std::string head() {
  return "gravity = [0, -9.81, 0]\n";
}
std::string turns(double phi, double w) {
  return fmt::format("drive = \"{:.17g}+{:.17g}*t\"", phi, w);
}
std::string at(double angle) {
  return fmt::format("angle = {:.17g}", angle);
}

// Crank and rod of one length, the rod's end on the line through the crank's pivot: dead at 90 deg.
Linkage scott_russell(Chance& chance, double phi, double w) {
  const double r = chance.between(0.1, 0.5), m = chance.between(0.5, 3.0), c = chance.between(0.2, 0.8),
               M = chance.between(0.5, 3.0);
  Linkage out;
  out.text = head() +
             fmt::format(
                 "[ground.marker.x]\naxis = [1, 0, 0]\n[body.slider]\nmass = {:.17g}\ninertia = [1, "
                 "1, 1]\n[body.slider.marker.x]\naxis = [1, 0, 0]\n",
                 M) +
             text_of(PlanarLink{"a", r, 1.0, 0.5 * r, 0.01}) + text_of(PlanarLink{"b", r, m, c * r, 0.01}) +
             hinge("h1", "ground", "a", turns(phi, w)) + hinge("h2", "a.t", "b", at(-2.0 * phi)) +
             fmt::format(
                 "[joint.s]\ntype = \"prismatic\"\nfrom = \"ground.x\"\nto = \"slider.x\"\nposition = "
                 "{:.17g}\n",
                 2.0 * r * std::cos(phi)) +
             hinge("h4", "slider", "b.t", "cut = true");
  // The rod turns as evenly as the crank: the slider's inertia along the line, moments about the crank's pin.
  out.force = [=](Real q) {
    const Real rw2 = Real(r) * w * w, s = std::sin(q);
    return Force{2 * M * rw2 * std::cos(q), -2 * (M + Real(m) * c) * rw2 * s + Real(c) * m * kGravity};
  };
  return out;
}

// Dead at 0 and 180 deg, where forces grow without bound.
Linkage parallelogram(Chance& chance, double phi, double w) {
  const double r = chance.between(0.1, 0.4), L = chance.between(0.3, 0.8), m = chance.between(0.5, 3.0),
               c = chance.between(0.2, 0.8), m_r = chance.between(0.5, 3.0), c_r = chance.between(0.2, 0.8);
  Linkage out;
  out.text = head() + fmt::format("[ground.marker.far]\nposition = [{:.17g}, 0, 0]\n", L) +
             text_of(PlanarLink{"a", r, 1.0, 0.5 * r, 0.01}) + text_of(PlanarLink{"b", L, m, c * L, 0.01}) +
             text_of(PlanarLink{"c", r, m_r, c_r * r, 0.01}) + hinge("h1", "ground", "a", turns(phi, w)) +
             hinge("h2", "a.t", "b", at(-phi)) + hinge("h3", "ground.far", "c", at(phi)) +
             hinge("h4", "b.t", "c.t", "cut = true");
  out.force = [=](Real q) {
    const Real sq = std::sin(q), cq = std::cos(q);
    const Real y = -Real(c) * m * (kGravity - Real(r) * w * w * sq);
    return Force{(cq * y - Real(m_r) * kGravity * c_r * cq) / sq, y};
  };
  return out;
}

// Crank as long as the ground, rocker as long as the coupler: dead at 0, where the crank's end meets the rocker's pivot.
Linkage kite(Chance& chance, double phi, double w) {
  const double r = chance.between(0.1, 0.3), k = chance.between(1.5, 3.0) * r, I = 0.01,
               m = chance.between(0.5, 3.0), c = chance.between(0.2, 0.8), m_r = chance.between(0.5, 3.0),
               c_r = chance.between(0.2, 0.8);
  const double beta = std::asin(r * std::sin(0.5 * phi) / k);
  Linkage out;
  out.text = head() + fmt::format("[ground.marker.far]\nposition = [{:.17g}, 0, 0]\n", r) +
             text_of(PlanarLink{"a", r, 1.0, 0.5 * r, 0.01}) + text_of(PlanarLink{"b", k, m, c * k, I}) +
             text_of(PlanarLink{"c", k, m_r, c_r * k, I}) + hinge("h1", "ground", "a", turns(phi, w)) +
             hinge("h2", "a.t", "b", at(0.5 * phi - beta - phi)) +
             hinge("h3", "ground.far", "c", at(0.5 * phi + beta)) + hinge("h4", "b.t", "c.t", "cut = true");
  out.force = [=](Real q) {
    const Real h = q / 2, s = std::sin(h), u = Real(w) / 2;
    // Coupler and rocker turn by h -+ b with k sin b = r sin h.
    const Real sb = r * s / k, cb = std::sqrt(1 - sb * sb), b1 = r * std::cos(h) / (k * cb),
               b2 = (-sb + sb * b1 * b1) / cb, b = std::asin(sb);
    const Real coupler = h - b, rocker = h + b, c1 = (1 - b1) * u, c2 = -b2 * u * u, r2 = b2 * u * u;
    const Force e{std::cos(coupler), std::sin(coupler)}, f{std::cos(rocker), std::sin(rocker)};
    const Real ax = -Real(r) * w * w * std::cos(q) + c * k * (-c1 * c1 * e.x - c2 * e.y),
               ay = -Real(r) * w * w * std::sin(q) + c * k * (-c1 * c1 * e.y + c2 * e.x) + kGravity;
    // Moments about the rocker's pivot, f x P = of_rocker, and about the crank's pin, e x P = of_coupler.
    const Real of_rocker = ((I + Real(m_r) * c_r * k * c_r * k) * r2 + m_r * kGravity * c_r * k * f.x) / k,
               of_coupler = -(I * c2 + m * c * k * (e.x * ay - e.y * ax)) / k;
    const Real det = -f.y * e.x + f.x * e.y;
    const Force P{(of_rocker * e.x - of_coupler * f.x) / det, (e.y * of_rocker - f.y * of_coupler) / det};
    return Force{P.x * e.x + P.y * e.y, P.y * e.x - P.x * e.y};  // in the coupler's axes
  };
  return out;
}

struct Told {
  mbs::RunResult result;
  double estimate = 0.0;
  bool is_estimated = true;
  std::vector<double> t;
  std::vector<Force> force;
};

Told run_linkage(const test::Folder& folder, const std::string& text) {
  Told out;
  const mbs::PreparedMechanism p = mbs::prepare(folder.write("linkage.toml", text));
  const auto all = p.mechanism->quantities();
  std::vector<int> which;
  for (const char* name : {"h4.force_x", "h4.force_y"})
    which.push_back(static_cast<int>(std::ranges::find(all, name, &mbs::OutputInfo::name) - all.begin()));
  const auto scratch = p.mechanism->make_scratch();
  Eigen::VectorXd value(2);
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    p.mechanism->evaluate(which, s, v_dot, *scratch, value);
    out.t.push_back(s.t);
    out.force.push_back({value(0), value(1)});
  };
  const auto error = study::GlobalError::make(p);
  if (error) error->watch(callbacks);
  out.result = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  out.estimate = out.result.doubt_of_rows;
  if (!error) return out;
  const study::IntegratorEstimate estimate = error->estimate();
  out.estimate = estimate.error;
  out.is_estimated = estimate.is_whole;
  return out;
}

std::string solver(const char* method, double tolerance, double end, double step) {
  return fmt::format(
      "[solver]\nmethod = \"{}\"\ntolerance = {:.17g}\nend_time = {:.17g}\noutput_step = {:.17g}\n", method,
      tolerance, end, step);
}

TEST(DeadPoints, ForcesInRowsThatAreWrongAreTold) {
  const test::Folder folder;
  int wrong = 0;
  constexpr double kOffsets[] = {0.0, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1};
  for (int seed = 0; seed < 300; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const int kind = seed % 3;
    const char* const method = kAllMethods[(seed / 3) % 5];
    const double w = chance.between(1.0, 5.0), width = chance.between(0.005, 0.1),
                 tolerance = chance.one_of({1e-4, 1e-6, 1e-8, 1e-10});
    const int before = 3 + chance.below(10), rows = 2 * before;
    // A row falls on the dead point but for the offset.
    const double dead = kind == 0   ? 0.5 * std::numbers::pi
                        : kind == 1 ? (chance.flip(0.5) ? std::numbers::pi : 0.0)
                                    : 0.0;
    const double offset = chance.one_of(kOffsets);
    const double phi = dead - width * before + offset * chance.either_sign(0.5, 1.0);
    const Linkage linkage = kind == 0   ? scott_russell(chance, phi, w)
                            : kind == 1 ? parallelogram(chance, phi, w)
                                        : kite(chance, phi, w);
    const std::string text = linkage.text + solver(method, tolerance, rows * width / w, width / w);
    const Told told = run_linkage(folder, text);
    const std::string which =
        fmt::format("seed {}, kind {} by {} to {:g}\n{}", seed, kind, method, tolerance, text);
    EXPECT_EQ(told.result.stopped_because, "") << which;
    std::vector<Real> sizes;
    Real squares = 0.0L;
    for (const double t : told.t) {
      const Force f = linkage.force(phi + w * t);
      sizes.push_back(std::hypot(f.x, f.y));
      // At the very point of a parallelogram and of a kite there is no force: what stands there is to be told.
      if (std::isfinite(sizes.back())) squares += sizes.back() * sizes.back();
    }
    const Real rms = std::sqrt(squares / sizes.size());
    std::vector<Real> sorted = sizes;
    std::ranges::sort(sorted);
    const Real usual = sorted[sorted.size() / 2];
    Real worst = 0.0L;  // in parts of what is allowed
    double worst_t = 0.0;
    for (std::size_t i = 0; i < told.t.size(); ++i) {
      const Force right = linkage.force(phi + w * told.t[i]), is = told.force[i];
      const Real allowed = 3 * (told.estimate * rms + tolerance * std::max(sizes[i], usual)),
                 part = std::hypot(is.x - right.x, is.y - right.y) / allowed;
      if (part <= worst) continue;
      worst = std::isfinite(part) ? part : std::numeric_limits<Real>::max();
      worst_t = told.t[i];
    }
    const bool is_told = !told.result.near_rank_loss.empty() || !told.is_estimated;
    wrong += worst > 1;
    EXPECT_TRUE(is_told || worst <= 1) << "off by " << static_cast<double>(worst)
                                       << " times what is told, at t = " << worst_t << ", " << which;
  }
  EXPECT_GT(wrong, 50);  // the rows hit the places
}

// Transmission angles of 25 deg and more: nothing loses rank.
TEST(DeadPoints, OrdinaryCrankRockersRaiseNoAlarm) {
  const test::Folder folder;
  for (int seed = 0; seed < 60; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 5001);
    double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
    const auto transmission = [&](double x) { return std::acos((b * b + c * c - x * x) / (2.0 * b * c)); };
    const double least = 25.0 * std::numbers::pi / 180.0;
    do {
      a = chance.between(0.1, 0.3), b = chance.between(0.3, 1.0), c = chance.between(0.3, 1.0),
      d = chance.between(0.4, 1.0);
    } while (!(transmission(d - a) > least && transmission(d + a) < std::numbers::pi - least));
    const double m_a = chance.between(0.1, 3.0), m_b = chance.between(0.1, 3.0),
                 m_c = chance.between(0.1, 3.0);
    const double phi = chance.between(-3.0, 3.0), w = chance.either_sign(1.0, 8.0),
                 tolerance = chance.one_of({1e-4, 1e-6, 1e-8, 1e-10});
    // The triangle of crank's end A, rocker's pivot Q and the joint of coupler and rocker, to the left of AQ.
    const double x = d - a * std::cos(phi), y = -a * std::sin(phi), l = std::hypot(x, y),
                 at_A = std::acos((b * b + l * l - c * c) / (2.0 * b * l)), coupler = std::atan2(y, x) + at_A;
    const double rocker =
        std::atan2(a * std::sin(phi) + b * std::sin(coupler), a * std::cos(phi) + b * std::cos(coupler) - d);
    const std::string text =
        head() + fmt::format("[ground.marker.far]\nposition = [{:.17g}, 0, 0]\n", d) +
        text_of(PlanarLink{"a", a, m_a, 0.5 * a, 0.01}) + text_of(PlanarLink{"b", b, m_b, 0.5 * b, 0.01}) +
        text_of(PlanarLink{"c", c, m_c, 0.5 * c, 0.01}) + hinge("h1", "ground", "a", turns(phi, w)) +
        hinge("h2", "a.t", "b", at(coupler - phi)) + hinge("h3", "ground.far", "c", at(rocker)) +
        hinge("h4", "b.t", "c.t", "cut = true") +
        solver(kAllMethods[seed % 5], tolerance, 4.0 * std::numbers::pi / std::abs(w), 0.05 / std::abs(w));
    const Told told = run_linkage(folder, text);
    EXPECT_EQ(told.result.stopped_because, "") << text;
    EXPECT_EQ(told.result.near_rank_loss, "") << text;
    if (seed % 5 == 0) EXPECT_LT(told.estimate, 1e-9) << text;
  }
}

}  // namespace
}  // namespace flexura::properties
