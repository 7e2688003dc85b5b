// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Natural frequencies of beams against exact solutions and published tables.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "beam/model/mesh.hpp"
#include "tests/beam/common.hpp"
#include "tests/beam/exact/timoshenko.hpp"
#include "tests/beam/models.hpp"
#include "tests/beam/vibration.hpp"
#include "tests/reference.hpp"

namespace flexura::beam {
namespace {

using std::numbers::pi;
using testing::all_but_bending_z;
using testing::divided;
using testing::entry;
using testing::kSteel;
using testing::lowest_modes;
using testing::straight;

double hz(double omega2) {
  return std::sqrt(omega2) / (2.0 * pi);
}

struct Shaft {
  double first, second;
};

// Free shaft of the source's table: d = 0.25 m, 60 elements; bending in one plane, two rigid modes below.
Shaft simpack_shaft(double length, Theory theory, bool rotary) {
  const BeamMesh mesh(straight(entry("shaft", Circle{0.25}, kSteel), length, theory), divided(60));
  const auto modes =
      lowest_modes(stiffness_matrix(mesh), mass_matrix(mesh, rotary), all_but_bending_z(mesh), 4, 1e6);
  return {hz(modes.omega2(2)), hz(modes.omega2(3))};
}

TEST(SimpackShaft, PrintedDigitsWithoutAndWithRotaryInertia) {
  // The source prints integers; the decimals are those of the printed matrices.
  const test::Reference simbeam = {"SIMBEAM's free circular shaft, d = 0.25 m, 60 elements",
                                   "the last digit of the printed matrices' frequencies"};
  Shaft shaft = simpack_shaft(1.0, Theory::euler_bernoulli, false);
  test::expect_reference("shaft 1 m, no rotary inertia, mode 1", "Hz", shaft.first, 1151.08, 0.005, simbeam);
  test::expect_reference("shaft 1 m, no rotary inertia, mode 2", "Hz", shaft.second, 3172.99, 0.005, simbeam);
  shaft = simpack_shaft(1.0, Theory::euler_bernoulli, true);
  test::expect_reference("shaft 1 m, rotary inertia, mode 1", "Hz", shaft.first, 1053.42, 0.005, simbeam);
  test::expect_reference("shaft 1 m, rotary inertia, mode 2", "Hz", shaft.second, 2655.14, 0.005, simbeam);
  shaft = simpack_shaft(2.0, Theory::euler_bernoulli, false);
  test::expect_reference("shaft 2 m, no rotary inertia, mode 1", "Hz", shaft.first, 287.77, 0.005, simbeam);
  test::expect_reference("shaft 2 m, no rotary inertia, mode 2", "Hz", shaft.second, 793.25, 0.005, simbeam);
  shaft = simpack_shaft(2.0, Theory::euler_bernoulli, true);
  test::expect_reference("shaft 2 m, rotary inertia, mode 1", "Hz", shaft.first, 281.05, 0.005, simbeam);
  test::expect_reference("shaft 2 m, rotary inertia, mode 2", "Hz", shaft.second, 754.07, 0.005, simbeam);
  shaft = simpack_shaft(2.0, Theory::timoshenko, true);
  test::expect_reference("shaft 2 m, Timoshenko, mode 1", "Hz", shaft.first, 276.65, 0.005, simbeam);
  test::expect_reference("shaft 2 m, Timoshenko, mode 2", "Hz", shaft.second, 715.32, 0.005, simbeam);
}

exact::Beam exact_beam(const Section& section, double length, bool shear, bool rotary) {
  const Constants& c = *section.constants;
  const Material& m = *section.material;
  return {length, m.E * c.I_y, m.rho * c.A, rotary ? m.rho * c.I_y : 0.0, shear ? 1.0 / (m.G * c.A_sz) : 0.0};
}

struct EndCase {
  const char* name;
  exact::End left, right;
  std::vector<int> left_dofs, right_dofs;  // w 2, theta_y 4
  int rigid;
};

const std::vector<EndCase> kEnds = {
    {"free", exact::End::free, exact::End::free, {}, {}, 2},
    {"pinned", exact::End::pinned, exact::End::pinned, {2}, {2}, 0},
    {"clamped", exact::End::clamped, exact::End::clamped, {2, 4}, {2, 4}, 0},
    {"cantilever", exact::End::clamped, exact::End::free, {2, 4}, {}, 0},
};

std::vector<double> computed(const SectionEntry& section, double length, Theory theory, bool rotary,
                             const EndCase& ends, int elements, int count, double shift) {
  const BeamMesh mesh(straight(section, length, theory), divided(elements));
  std::vector<int> fixed = all_but_bending_z(mesh);
  for (const int dof : ends.left_dofs) fixed.push_back(dof);
  for (const int dof : ends.right_dofs) fixed.push_back(6 + dof);
  const auto modes = lowest_modes(stiffness_matrix(mesh), mass_matrix(mesh, rotary), fixed,
                                  count + ends.rigid, ends.rigid > 0 ? shift : 0.0);
  std::vector<double> omega;
  for (int k = 0; k < count; ++k) omega.push_back(std::sqrt(modes.omega2(ends.rigid + k)));
  return omega;
}

TEST(BeamFrequencies, ConvergeToExactSolutionsWithTheirOrders) {
  // A short, thick beam (l/h = 8) in four theories and four end conditions; modes 1 to 3 with 16 and 32 elements.
  const SectionEntry section = entry("r", Rectangle{0.1, 0.25}, kSteel);
  const double length = 2.0;
  for (const EndCase& ends : kEnds)
    for (const auto& [theory, rotary, order] :
         {std::tuple{Theory::euler_bernoulli, false, 4.0}, std::tuple{Theory::euler_bernoulli, true, 4.0},
          std::tuple{Theory::timoshenko, true, 2.0}, std::tuple{Theory::timoshenko, false, 2.0}}) {
      const bool shear = theory == Theory::timoshenko;
      const auto reference = exact::bending_frequencies(exact_beam(section.section, length, shear, rotary),
                                                        ends.left, ends.right, 3);
      const double shift = 0.1 * reference[0] * reference[0];
      const auto coarse = computed(section, length, theory, rotary, ends, 8, 3, shift);
      const auto fine = computed(section, length, theory, rotary, ends, 16, 3, shift);
      const auto finest = computed(section, length, theory, rotary, ends, 64, 3, shift);
      for (int k = 0; k < 3; ++k) {
        const double error_1 = coarse[k] / reference[k] - 1.0, error_2 = fine[k] / reference[k] - 1.0;
        const double measured = std::log2(error_1 / error_2);
        EXPECT_GT(error_2, 0.0) << ends.name << k;  // consistent mass: from above
        // Halving is asymptotic to the next even order: h^2 of mode 3 with 8 elements, (3 pi/8)^2/12 = 0.12.
        EXPECT_NEAR(measured, order, 0.35)
            << ends.name << " mode " << k + 1 << (shear ? " Timoshenko" : " Bernoulli")
            << (rotary ? " rotary" : "");
        // 64 elements: (k l)^4/1440/64^4 and, with shear, (k l)^2 phi/24/64^2.
        EXPECT_NEAR(finest[k] / reference[k], 1.0, shear ? 6e-4 : 3e-6) << ends.name << k;
      }
    }
}

TEST(BeamFrequencies, NafemsFV5DeepBeam) {
  // 10 m, 2 x 2 m, E = 2e11, nu = 0.3, rho = 8000; simply supported.  Tolerance 0.1 %
  // (nafems_free_vibration.md), torsion and bending on a mesh fine enough for it: linear elements (pi n h / 2
  // l)^2/24.
  const Material material = isotropic("fv5", 2e11, 0.3, 8000.0);
  const BeamMesh mesh(straight(entry("2x2", Rectangle{2.0, 2.0}, material), 10.0), divided(80));
  const std::vector<int> fixed = {0, 1, 2, 3, 6 + 1, 6 + 2};
  const auto modes = lowest_modes(stiffness_matrix(mesh), mass_matrix(mesh), fixed, 9);
  const double nafems[] = {42.650, 42.650, 71.20, 125.00, 148.15, 148.15, 213.61, 283.47, 283.47};
  for (int k = 0; k < 9; ++k)
    test::expect_reference("deep beam, mode " + std::to_string(k + 1), "Hz", hz(modes.omega2(k)), nafems[k],
                           1e-3 * nafems[k], {"NAFEMS FV5", "the benchmark's own, 0.1 %"});
}

TEST(BeamFrequencies, ShaftWithDiscIsARotorOfTheTextbooks) {
  // Massless shaft, pinned, disc m at mid-span: omega^2 = 48 EI/(m l^3); its tilting about y: omega^2 = 12
  // EI/(I_d l).
  const Material massless = isotropic("massless", 2.1e11, 0.3, 0.0);
  Model model = straight(entry("shaft", Circle{0.05}, massless), 1.0, Theory::euler_bernoulli);
  model.nodes = {{"A", {0, 0, 0}}, {"B", {1, 0, 0}}, {"disc", {0.5, 0, 0}}};
  Member right = model.members[0];
  model.members[0].end[1].node = 2;
  right.name = "right";
  right.end[0].node = 2;
  model.members.push_back(right);
  PointMass disc;
  disc.node = 2;
  disc.mass = 40.0;
  disc.I_C_B = Eigen::Vector3d(1.6, 0.8, 0.8).asDiagonal();
  model.point_masses = {disc};
  const BeamMesh mesh(model, divided(1));
  std::vector<int> fixed = all_but_bending_z(mesh);
  fixed.insert(fixed.end(), {2, 8});
  // M is singular with massless shaft: subspace of the two disc modes.
  const auto modes = lowest_modes(stiffness_matrix(mesh), mass_matrix(mesh), fixed, 2);
  const double EI = 2.1e11 * pi * std::pow(0.05, 4) / 64;
  EXPECT_NEAR(modes.omega2(0), 48 * EI / 40.0, 1e-10 * modes.omega2(0));
  EXPECT_NEAR(modes.omega2(1), 12 * EI / 0.8, 1e-10 * modes.omega2(1));
}

TEST(BeamFrequencies, FrequencyRuleMeetsItsErrorOnEveryModeBelow) {
  const SectionEntry section = entry("r", Rectangle{0.1, 0.2}, kSteel);
  for (const auto theory : {Theory::euler_bernoulli, Theory::timoshenko}) {
    Subdivision rule;
    rule.max_frequency_hz = 1500.0;
    rule.frequency_error = 2e-3;
    const Model model = straight(section, 3.0, theory);
    const BeamMesh mesh(model, rule);
    std::vector<int> fixed = all_but_bending_z(mesh);
    fixed.insert(fixed.end(), {2, 8});
    const auto reference =
        exact::bending_frequencies(exact_beam(section.section, 3.0, theory == Theory::timoshenko, true),
                                   exact::End::pinned, exact::End::pinned, 8);
    const auto modes = lowest_modes(stiffness_matrix(mesh), mass_matrix(mesh), fixed, 8);
    int below = 0;
    for (int k = 0; k < 8; ++k)
      if (reference[k] < 2 * pi * 1500.0) {
        ++below;
        EXPECT_NEAR(std::sqrt(modes.omega2(k)) / reference[k], 1.0, 2e-3) << k;
      }
    EXPECT_GE(below, 5);
    // Stretch: fixed-free rod, (2k-1)/(4l) sqrt(E/rho).
    std::vector<int> rod;
    for (int dof = 0; dof < mesh.n_dofs(); ++dof)
      if (dof % 6 != 0 || dof == 0) rod.push_back(dof);
    const auto stretch = lowest_modes(stiffness_matrix(mesh), mass_matrix(mesh), rod, 2);
    EXPECT_NEAR(std::sqrt(stretch.omega2(1)) / (3 * pi / 6.0 * std::sqrt(kSteel.E / kSteel.rho)), 1.0, 2e-3);
  }
}

}  // namespace
}  // namespace flexura::beam
