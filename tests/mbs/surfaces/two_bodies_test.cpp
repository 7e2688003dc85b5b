// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "mbs/solver/statics/statics.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/moving/girder.hpp"
#include "tests/mbs/surfaces/faced_bar.hpp"
#include "tests/mbs/surfaces/plate.hpp"
#include "tests/reference.hpp"

/// The surface of one superelement against that of another: bars end on end, free impacts, and what is flat against planes.
namespace flexura::mbs::surfaces {
namespace {

using cases::Series;
using cases::simulate;

constexpr double kL = 0.5, kEA = 2e6, kLine = 0.8, kSide = 0.02;

beams::StraightBeam bar() {
  beams::StraightBeam beam;
  beam.length = kL;
  beam.elements = 8;
  beam.EA = kEA;
  beam.EI_y = beam.EI_z = 60.0;
  beam.GI_t = 50.0;
  beam.mass_per_length = kLine;
  beam.rho_I_y = beam.rho_I_z = 3e-5;
  return beam;
}

class Bars : public cases::TextCase {
 protected:
  void SetUp() override {
    cases::TextCase::SetUp();
    // Meshes that do not match.
    superelement::write(folder_ / "one.se.h5", faced_bar(bar(), kSide, 5));
    superelement::write(folder_ / "other.se.h5", faced_bar(bar(), kSide, 7));
  }
  static std::string bodies(const std::string& one, const std::string& other) {
    return "gravity = [0, 0, 0]\n[body.one]\nsuperelement = \"one.se.h5\"\n" + one +
           "[body.other]\nsuperelement = \"other.se.h5\"\n" + other;
  }
  static constexpr const char* kEnds =
      "[force.touch]\ntype = \"surface_contact\"\nbody = \"one\"\ninterfaces = [\"tip\"]\nfrom_body = "
      "\"other\"\n"
      "from_interfaces = [\"root\"]\n";
};

// Pushed together by d between two walls: F (2 L / EA + 1 / K) = d, the same pressure at every node, though their meshes do not
// match.
TEST_F(Bars, PressedEndOnEndAreSpringsInARow) {
  const double K = 4e7, d = 1e-4, F = d / (2.0 * kL / kEA + 1.0 / K), area = kSide * kSide;
  const auto p =
      prepared(bodies("fidelity = \"modal\"\n",
                      fmt::format("fidelity = \"modal\"\nposition = [{:.15g}, 0, 0]\n", kL - d)) +
               "[joint.wall]\ntype = \"fixed\"\nfrom = \"ground\"\nto = \"one.root\"\n"
               "[joint.far]\ntype = \"fixed\"\nfrom = \"ground.far\"\nto = \"other.tip\"\n" +
               fmt::format("[ground.marker.far]\nposition = [{:.15g}, 0, 0]\n", 2.0 * kL - d) + kEnds +
               "total_stiffness = \"4e7 N/m\"\npressures = true\n[solver]\nend_time = 0.01\noutput_step = "
               "0.01\ninitial_deformation = \"quasi_static\"\n");
  const Series run =
      simulate(p, {"touch.normal_force", "touch.force_x", "touch.area", "touch.pressure", "touch.nodes",
                   "touch.pressure_at_36", "touch.pressure_at_57", "touch.pressure_at_71"});
  const flexura::test::Reference springs = {
      "two bars pressed end on end by surface_contact: springs in a row", "single precision of the shapes"};
  for (const auto& row : run.values) {
    flexura::test::expect_reference("force", "N", row(0), F, 1e-6 * F, springs);
    EXPECT_NEAR(row(1), -F, 1e-6 * F);
    EXPECT_NEAR(row(2), area, 1e-12);
    flexura::test::expect_reference("greatest pressure", "Pa", row(3), F / area, 1e-6 * F / area, springs);
    EXPECT_EQ(row(4), 36.0);
    // Vertices of the end: a corner, one within, the corner across.
    for (int k = 5; k < 8; ++k) EXPECT_NEAR(row(k), F / area, 1e-6 * F / area);
  }
}

// One of them slides freely, from where nothing touches yet, also from farther than the contact is deep: the equilibrium is the same.
TEST_F(Bars, PushedFromAfarComeToRestEndOnEnd) {
  const double K = 4e7, F = 100.0, closed = F * (2.0 * kL / kEA + 1.0 / K);
  for (const double gap : {0.0, 1e-4, 0.3}) {
    auto p = prepared(
        bodies("fidelity = \"modal\"\n",
               fmt::format("fidelity = \"modal\"\nposition = [{:.15g}, 0, 0]\n", kL + gap)) +
        "[joint.wall]\ntype = \"fixed\"\nfrom = \"ground\"\nto = \"one.root\"\n"
        "[body.other.marker.end]\non = \"tip\"\naxis = [1, 0, 0]\n"
        "[joint.far]\ntype = \"prismatic\"\nfrom = \"ground.far\"\nto = \"other.end\"\n" +
        fmt::format("position = {:.15g}\n[ground.marker.far]\naxis = [1, 0, 0]\nposition = [{:.15g}, 0, 0]\n",
                    gap, 2.0 * kL) +
        kEnds + "total_stiffness = \"4e7 N/m\"\n" +
        fmt::format("[force.push]\ntype = \"force\"\nmarker = \"other.tip\"\nx = {}\n", -F) +
        "[solver]\nend_time = 0.01\noutput_step = 0.01\n");
    State state = p.state;
    solve_statics(*p.mechanism, state);
    const auto scratch = p.mechanism->make_scratch();
    Eigen::VectorXd found(1);
    const std::vector<int> which = select_quantities(*p.mechanism, {"far.position"});
    p.mechanism->evaluate(which, state, Eigen::VectorXd::Zero(p.mechanism->sizes().n_v), *scratch, found);
    EXPECT_NEAR(found(0), -closed, 1e-6 * closed) << gap;  // single precision of the shapes
  }
}

/// The same bars and the contact as one chain: two-node elements with their consistent mass, by Kutta's method.
struct Chain {
  static constexpr int kN = 9;
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(2 * kN, 2 * kN), K = M, inverse;
  double stiffness, gap;
  Chain(double k, double g) : stiffness(k), gap(g) {
    const double h = kL / (kN - 1);
    for (int b = 0; b < 2; ++b)
      for (int e = 0; e < kN - 1; ++e) {
        const int i = b * kN + e;
        M.block<2, 2>(i, i) += kLine * h / 6.0 * (Eigen::Matrix2d() << 2, 1, 1, 2).finished();
        K.block<2, 2>(i, i) += kEA / h * (Eigen::Matrix2d() << 1, -1, -1, 1).finished();
      }
    inverse = M.inverse();
  }
  Eigen::VectorXd operator()(double, const Eigen::VectorXd& y) const {
    Eigen::VectorXd f = -K * y.head(2 * kN), rate(4 * kN);
    const double push = stiffness * std::max(0.0, y(kN - 1) - y(kN) - gap);
    f(kN - 1) -= push;
    f(kN) += push;
    rate << y.tail(2 * kN), inverse * f;
    return rate;
  }
};

// One bar flies into another at rest: as the chain of their elements, and with all of its momentum and energy.
TEST_F(Bars, FlyingOnEndOnEndMoveAsAChain) {
  const double v = 3.0, gap = 1e-4, end = 1.2e-3;
  const int rows = 12;
  const auto p =
      prepared(bodies(fmt::format("fidelity = \"modal\"\nmax_frequency = 1e9\nvelocity = [{}, 0, 0]\n", v),
                      fmt::format("fidelity = \"modal\"\nmax_frequency = 1e9\nposition = [{:.15g}, 0, 0]\n",
                                  kL + gap)) +
               kEnds + "total_stiffness = \"4e7 N/m\"\n" + moving::solve(end, rows, 1e-8));
  const Series run =
      simulate(p, {"momentum.linear_x", "momentum.linear_y", "momentum.angular_z", "touch.normal_force"});
  const Chain chain(4e7, gap);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(4 * Chain::kN);
  y.segment(2 * Chain::kN, Chain::kN).setConstant(v);
  double t = 0.0, greatest = 0.0;
  const double P = kLine * kL * v;
  for (int row = 1; row <= rows; ++row) {
    for (int i = 0; i < 2000; ++i) moving::kutta(chain, t, y, end / rows / 2000);
    const Eigen::VectorXd& ours = run.values[static_cast<std::size_t>(row)];
    const double push = chain.stiffness * std::max(0.0, y(Chain::kN - 1) - y(Chain::kN) - gap);
    greatest = std::max(greatest, push);
    EXPECT_NEAR(ours(3), push, 1e-3 * 2000.0) << t;
    EXPECT_NEAR(ours(0), P, 1e-12 * P);
    EXPECT_NEAR(ours(1), 0.0, 1e-12 * P);
    EXPECT_NEAR(ours(2), 0.0, 1e-12 * P);
  }
  EXPECT_GT(greatest, 1500.0);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
}

// Askew, past its middle and turning, with friction and damping or without: what the mechanism has of momentum stays, and of energy.
TEST_F(Bars, MeetAskewAndKeepTheirMomenta) {
  for (const char* law : {"", "damping = \"0.2 s/m\"\nfriction = 0.3\n"}) {
    SCOPED_TRACE(law);
    const auto p =
        prepared(bodies("fidelity = \"modal\"\nmax_frequency = 20000\nvelocity = [5, 0.5, "
                        "-0.2]\nangular_velocity = [20, 0, 0]\n",
                        fmt::format("fidelity = \"modal\"\nmax_frequency = 20000\nposition = "
                                    "[{:.15g}, 0.004, 0.003]\nrotation = [0, 0.02, -0.03]\n",
                                    kL + 5e-4)) +
                 kEnds + "total_stiffness = \"4e7 N/m\"\n" + law + moving::solve(1.2e-3, 12, 1e-8));
    const std::vector<std::string> names = {"momentum.linear_x",  "momentum.linear_y",   "momentum.linear_z",
                                            "momentum.angular_x", "momentum.angular_y",  "momentum.angular_z",
                                            "touch.normal_force", "touch.friction_force"};
    const Series run = simulate(p, names);
    double greatest = 0.0, friction = 0.0;
    for (const auto& row : run.values) {
      greatest = std::max(greatest, row(6));
      friction = std::max(friction, row(7));
      // The integrator's tolerance, over some ten thousand steps of its errors.
      for (int i = 0; i < 6; ++i)
        EXPECT_NEAR(row(i), run.values.front()(i), 1e-6 * run.values.front()(0))
            << names[static_cast<std::size_t>(i)];
    }
    EXPECT_GT(greatest, 500.0);
    EXPECT_EQ(friction > 0.0, *law != 0);
    EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
  }
}

constexpr double kPlate = 0.2, kMass = 3.0, kG = 9.81;

/// A plate on a larger one, which lies on its back; `surface`: from_body, or the plane of it.
class PlateOnPlate : public cases::TextCase {
 protected:
  void SetUp() override {
    cases::TextCase::SetUp();
    superelement::write(folder_ / "plate.se.h5", plate(kPlate, 8, kMass));
    superelement::write(folder_ / "table.se.h5", plate(0.6, 11, 10.0));
  }
  static std::string text(const std::string& body, const std::string& surface, const std::string& contact,
                          double end, int rows) {
    return "[body.plate]\nsuperelement = \"plate.se.h5\"\nfidelity = \"rigid\"\n" + body +
           "[body.table]\nsuperelement = \"table.se.h5\"\nfidelity = "
           "\"rigid\"\n[body.table.marker.top]\nrotation = [3.14159265358979324, 0, 0]\n"
           "[joint.legs]\ntype = \"fixed\"\nfrom = \"ground\"\nto = \"table.top\"\n"
           "[force.touch]\ntype = \"surface_contact\"\nbody = \"plate\"\n" +
           surface + contact + moving::solve(end, rows, 1e-8);
  }
  static constexpr const char *kBody = "from_body = \"table\"\n", *kPlane = "from = \"table.top\"\n";
};

// A flat surface is a plane: the same motion, whatever facets lie below.
TEST_F(PlateOnPlate, MovesAsOnAPlane) {
  const std::string
      body = "position = [0.013, 0.017, 0.01]\nvelocity = [0.5, 0.2, -0.3]\nrotation = [0.05, 0.02, 0.3]\n",
      law = "stiffness = 1e8\ndamping = \"0.2 s/m\"\nfriction = 0.2\ntransition_speed = \"10 mm/s\"\n";
  const std::vector<std::string> names = {"plate.position_x",   "plate.position_y",     "plate.position_z",
                                          "touch.normal_force", "touch.friction_force", "touch.nodes",
                                          "touch.gap"};
  const Series by_body = simulate(prepared(text(body, kBody, law, 0.08, 8)), names),
               by_plane = simulate(prepared(text(body, kPlane, law, 0.08, 8)), names);
  double greatest = 0.0;
  for (std::size_t i = 0; i < by_body.t.size(); ++i) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(by_body.values[i](k), by_plane.values[i](k), 1e-7) << k;
    EXPECT_NEAR(by_body.values[i](3), by_plane.values[i](3), 1e-3 * kMass * kG) << by_body.t[i];
    greatest = std::max(greatest, by_plane.values[i](3));
  }
  EXPECT_GT(greatest, 0.5 * kMass * kG);
  // No facet costs a step.
  EXPECT_LT(by_body.result.counts.steps, by_plane.result.counts.steps * 11 / 10 + 20);
}

// A plate rides on a drum that turns below it, twelve facets of 1.4 degrees: it stands still but for what the smoothed facets leave
// of their corners, and no facet is felt as a blow.
TEST_F(PlateOnPlate, RidesOnATurningDrumWithoutChatter) {
  const double R = 1.0;
  superelement::Superelement drum = plate(0.6, 24, 10.0);
  for (Eigen::Index v = 0; v < drum.surface.vertices.rows(); ++v) {
    auto x = drum.surface.vertices.row(v);
    x.z() = R * std::cos(x.x() / R);
    x.x() = R * std::sin(x.x() / R);
  }
  drum.surface.triangles.col(1).swap(drum.surface.triangles.col(2));  // seen from outside
  superelement::write(folder_ / "drum.se.h5", drum);
  superelement::write(folder_ / "rider.se.h5", plate(0.1, 8, kMass));
  const auto text = [&](const std::string& surface) {
    return fmt::format(R"toml(
[body.plate]
superelement = "rider.se.h5"
fidelity = "rigid"
position = [0, 0, {:.12g}]
[body.drum]
superelement = "drum.se.h5"
fidelity = "rigid"
[body.drum.marker.axis]
axis = [0, 1, 0]
[ground.marker.axis]
axis = [0, 1, 0]
[joint.axle]
type = "revolute"
from = "ground.axis"
to = "drum.axis"
drive = "t - 0.15"
[joint.up]
type = "prismatic"
from = "ground"
to = "plate"
[force.touch]
type = "surface_contact"
body = "plate"
stiffness = 5e6
damping = 20
{}
)toml",
                       R - 1e-3, surface) +
           moving::solve(0.3, 60, 1e-5);
  };
  const std::vector<std::string> names = {"touch.normal_force", "plate.position_z"};
  const Series facets = simulate(prepared(text("from_body = \"drum\"\n")), names),
               round = simulate(
                   prepared(text("from = \"drum.axis\"\nsurface = \"cylinder\"\nsurface_radius = 1\n")),
                   names);
  double most = 0.0, off = 0.0;
  for (std::size_t i = 20; i < facets.t.size(); ++i) {
    most = std::max(most, std::abs(facets.values[i](0) / (kMass * kG) - 1.0));
    off = std::max(off, std::abs(facets.values[i](1) - round.values[i](1)));
  }
  EXPECT_LT(most, 0.01);
  // Facets of the side h leave their drum by h^2 / (8 R); smoothed, by less than a hundredth of that.
  EXPECT_LT(off, 0.01 * 0.025 * 0.025 / (8.0 * R));
}

// It slides over the edge, tips and falls: as the table ends, its pressure does, without loss.
TEST_F(PlateOnPlate, SlidesOverTheEdgeWithoutLoss) {
  const double depth = kMass * kG / (1e8 * kPlate * kPlate);
  const auto p = prepared(
      text(fmt::format("position = [0.15, 0.003, {:.15g}]\nvelocity = [0.7, 0, 0]\nrotation = [0, 0, 0.4]\n",
                       -depth),
           kBody, "stiffness = 1e8\n", 0.6, 120));
  const Series run = simulate(p, {"plate.position_x", "plate.position_z", "touch.normal_force"});
  EXPECT_GT(run.values.back()(0), 0.5);
  EXPECT_LT(run.values.back()(1), -0.1);
  EXPECT_EQ(run.values.back()(2), 0.0);
  for (std::size_t i = 0; i < run.t.size() && run.values[i](0) < 0.19; ++i)
    EXPECT_NEAR(run.values[i](2), kMass * kG, 1e-3 * kMass * kG);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-5);
}

}  // namespace
}  // namespace flexura::mbs::surfaces
