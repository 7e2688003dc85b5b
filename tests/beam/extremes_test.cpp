// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What beams are accurate to at the extremes.  Prints the tables of beam/EXTREMES.md; run with
// FLEXURA_EXTREMES=FILE to write them there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include "beam/model/mesh.hpp"
#include "tests/beam/common.hpp"
#include "tests/beam/exact/timoshenko.hpp"
#include "tests/beam/models.hpp"
#include "tests/beam/vibration.hpp"

namespace flexura::beam {
namespace {

using std::numbers::pi;
using testing::all_but_bending_z;
using testing::divided;
using testing::entry;
using testing::kSteel;
using testing::lowest_modes;
using testing::static_solution;
using testing::straight;

const Material kSteelMm = isotropic("steel", 2.1e5, 0.3, 7.85e-9);  // N, mm, t: MPa and t/mm^3

// Collects the page; written when the program ends.
class Page : public ::testing::Environment {
 public:
  static std::string& text() {
    static std::string page =
        "# Beams at the extremes\n\nMade by `tests/beam/extremes_test.cpp` (label `extremes`), which also "
        "holds every row to "
        "a bound. Relative errors; 2e-16 is round-off.\n";
    return page;
  }
  void TearDown() override {
    std::fputs(text().c_str(), stdout);
    if (const char* file = std::getenv("FLEXURA_EXTREMES")) std::ofstream(file) << text();
  }
};
[[maybe_unused]] const auto* const page = ::testing::AddGlobalTestEnvironment(new Page);

void heading(const std::string& title, const std::string& words, const std::vector<std::string>& columns) {
  Page::text() += fmt::format("\n## {}\n{}\n\n|", title, words);
  for (const std::string& column : columns) Page::text() += fmt::format(" {} |", column);
  Page::text() += "\n|";
  for (std::size_t k = 0; k < columns.size(); ++k) Page::text() += "---|";
  Page::text() += "\n";
}

template <class... Cells>
void row(const Cells&... cells) {
  Page::text() += "|";
  ((Page::text() += fmt::format(" {} |", cells)), ...);
  Page::text() += "\n";
}

std::string digits(double x) {
  return fmt::format("{:.1e}", std::abs(x));
}

double scaled_difference(const Matrix12d& a, const Matrix12d& b) {
  double worst = 0.0;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      worst = std::max(worst, std::abs(a(i, j) - b(i, j)) / std::sqrt(b(i, i) * b(j, j)));
  return worst;
}

TEST(BeamExtremes, ShearFactor) {
  heading("Shear factor psi",
          "One element against the printed matrices, largest entry error relative to its diagonals; "
          "tip deflection of a cantilever of one element against l^3/(3 EI) + l/(G A_s).",
          {"psi", "stiffness", "mass", "tip deflection"});
  for (const double psi : {1.0, 0.5, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    Constants c = constants_of(Rectangle{0.1, 0.2}, 0.3);
    const double l = 0.7, EI = kSteel.E * c.I_y;
    if (psi < 1.0) {
      c.A_sz = 12 * EI / (kSteel.G * l * l) * psi / (1 - psi);
      c.A_sy = 12 * kSteel.E * c.I_z / (kSteel.G * l * l) * psi / (1 - psi);
    }
    const Theory theory = psi < 1.0 ? Theory::timoshenko : Theory::euler_bernoulli;
    const Element element(l, matrices_of(make_section("s", c, kSteel), theory));
    const double K = scaled_difference(element.stiffness(), simbeam::stiffness(c, kSteel, l, theory));
    const double M = scaled_difference(element.mass(), simbeam::mass(c, kSteel, l, theory, true));
    const double tip = element.stiffness().bottomRightCorner<6, 6>().llt().solve(Vector6d::Unit(2))(2);
    const double expected = l * l * l / (3 * EI) + (psi < 1.0 ? l / (kSteel.G * c.A_sz) : 0.0);
    row(fmt::format("{:g}", psi), digits(K), digits(M), digits(tip / expected - 1));
    EXPECT_LT(K, 1e-14);
    EXPECT_LT(M, 1e-14);
    EXPECT_LT(std::abs(tip / expected - 1), 1e-14);
  }
}

TEST(BeamExtremes, Slenderness) {
  heading("Slenderness l/d",
          "Circular shaft, Timoshenko. Tip deflection of one element; first pinned frequency of 20 "
          "elements against the exact one (the rest is the element size, (k h)^2/24 phi and less).",
          {"l/d", "psi of the shaft", "tip deflection", "first frequency, 20 elements"});
  const double d = 0.1;
  for (const double ratio : {0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6}) {
    const double l = ratio * d;
    const Model model = straight(entry("shaft", Circle{d}, kSteel), l);
    const Constants& c = *model.sections[0].section.constants;
    const double EI = kSteel.E * c.I_y, GA = kSteel.G * c.A_sz;
    const BeamMesh one(model, divided(1)), twenty(model, divided(20));
    Eigen::VectorXd p = Eigen::VectorXd::Zero(12);
    p(8) = 1.0;
    const double tip = static_solution(stiffness_matrix(one), p, {0, 1, 2, 3, 4, 5})(8);
    const double tip_error = tip / (l * l * l / (3 * EI) + l / GA) - 1;
    std::vector<int> fixed = all_but_bending_z(twenty);
    fixed.insert(fixed.end(), {2, 8});
    const auto modes = lowest_modes(stiffness_matrix(twenty), mass_matrix(twenty), fixed, 1);
    const exact::Beam beam{l, EI, kSteel.rho * c.A, kSteel.rho * c.I_y, 1 / GA};
    // The first mode of a short, thick beam may be the sections' pure rotation at sqrt(G A_s / rho I).
    const auto pair = exact::pinned_frequencies(beam, 1);
    const double thickness_shear = std::sqrt(GA / (kSteel.rho * c.I_y));
    const double expected = std::min(pair.first, thickness_shear);
    const double error = std::sqrt(modes.omega2(0)) / expected - 1;
    row(fmt::format("{:g}", ratio), fmt::format("{:.3g}", simbeam::shear_factor(EI, GA, l)),
        digits(tip_error), digits(error));
    EXPECT_LT(std::abs(tip_error), 1e-13);
    EXPECT_LT(std::abs(error), 2.2e-3);  // (pi/20)^2/24 = 1.0e-3 for each of the two linear fields
  }
}

TEST(BeamExtremes, StiffnessRatios) {
  heading("Section stiffness ratios",
          "A coupled 6x6 section (correlations 0.3) whose diagonal spans the ratio; all six end "
          "displacements under six unit end loads of one element against int b^T f b in closed form, largest "
          "error "
          "relative to the diagonals. Beside it the tip deflection of a soft and a stiff member in series: "
          "stiffnesses that meet in one node add up in one matrix entry, and the program warns from 1e8.",
          {"ratio", "coupled section", "members in series"});
  for (const double ratio : {1.0, 1e3, 1e6, 1e9, 1e12}) {
    Matrix6d C = Matrix6d::Zero();
    C.diagonal() << 1e6 * ratio, 1e6, 1e6 * std::sqrt(ratio), 1e6, 1e6 * ratio, 1e6;
    for (const auto& [i, j] : {std::pair{N, M_z}, std::pair{V_y, T}, std::pair{V_z, M_y}, std::pair{T, M_z}})
      C(i, j) = C(j, i) = 0.3 * std::sqrt(C(i, i) * C(j, j));
    const Section section = matrix_section("ratio", C, Matrix6d::Zero());
    const double l = 1.0;
    const Element element(l, matrices_of(section, Theory::timoshenko));
    const Matrix6d flexibility =
        inverse_spd(Matrix6d(element.stiffness().bottomRightCorner<6, 6>()), "the end stiffness");
    Matrix6d exact = Matrix6d::Zero();
    for (const auto& [x, w] : {std::pair{0.0, l / 6}, std::pair{l / 2, 4 * l / 6}, std::pair{l, l / 6}}) {
      Matrix6d b = Matrix6d::Identity();
      b(M_y, V_z) = -(l - x);
      b(M_z, V_y) = l - x;
      exact += w * b.transpose() * section.f * b;
    }
    double coupled = 0.0;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        coupled = std::max(coupled,
                           std::abs(flexibility(i, j) - exact(i, j)) / std::sqrt(exact(i, i) * exact(j, j)));

    Model model = straight(entry("soft", Circle{0.1}, kSteel), 2.0, Theory::euler_bernoulli);
    Constants stiff = *model.sections[0].section.constants;
    for (double* value : {&stiff.A, &stiff.I_y, &stiff.I_z, &stiff.I_t}) *value *= ratio;
    model.sections.push_back({make_section("stiff", stiff, kSteel), {}, {}});
    model.nodes.push_back({"middle", {1.0, 0, 0}});
    Member second = model.members[0];
    model.members[0].end[1].node = second.end[0].node = 2;
    second.section = 1;
    model.members.push_back(second);
    const BeamMesh mesh(model, divided(1));
    Eigen::VectorXd p = Eigen::VectorXd::Zero(mesh.n_dofs());
    p(8) = 1.0;
    const double tip = static_solution(stiffness_matrix(mesh), p, {0, 1, 2, 3, 4, 5})(8);
    const double EI = kSteel.E * model.sections[0].section.constants->I_y;
    const double expected = (8.0 - 1.0) / (3 * EI) + 1.0 / (3 * EI * ratio);
    row(fmt::format("{:g}", ratio), digits(coupled), digits(tip / expected - 1));
    EXPECT_LT(coupled, 1e-12 + 1e-16 * std::sqrt(ratio));
    EXPECT_LT(std::abs(tip / expected - 1), 1e-12 + 1e-15 * ratio);
  }
}

// First pinned eigenvalue of a slender Euler-Bernoulli beam (l/d = 100) in a system of units.
double first_eigenvalue(const Material& material, double d, double l, int n) {
  const BeamMesh mesh(straight(entry("shaft", Circle{d}, material), l, Theory::euler_bernoulli), divided(n));
  std::vector<int> fixed = all_but_bending_z(mesh);
  fixed.insert(fixed.end(), {2, 8});
  // As the reduction does it: the mode from K, its eigenvalue from the strain energy of the elements.
  return strain_energy(
      mesh, lowest_modes(stiffness_matrix(mesh), mass_matrix(mesh), fixed, 1).shapes.leftCols(1))(0, 0);
}

TEST(BeamExtremes, NumberOfElementsAndUnits) {
  heading("Number of elements, and units",
          "First eigenvalue of a pinned Euler-Bernoulli shaft, l/d = 100, against the exact one: the element "
          "size's share "
          "falls with n^-4, round-off of the mode's strain energy grows with n^2 eps. Beside it the "
          "difference between the same shaft in m-kg-s "
          "and in mm-t-s, and the tip deflection of a cantilever from K itself, where round-off grows with "
          "n^4 eps. The program warns from 1,000 "
          "elements in a row.",
          {"elements", "eigenvalue", "m-kg-s against mm-t-s", "tip deflection"});
  const double d = 0.05, l = 5.0;
  const Constants c = constants_of(Circle{d}, 0.3);
  const double k = pi / l;
  const double exact = kSteel.E * c.I_y * std::pow(k, 4) / (kSteel.rho * c.A + kSteel.rho * c.I_y * k * k);
  for (const int n : {1, 3, 10, 30, 100, 300, 1000, 3000, 10000}) {
    const double in_m = first_eigenvalue(kSteel, d, l, n),
                 in_mm = first_eigenvalue(kSteelMm, 1e3 * d, 1e3 * l, n);
    const BeamMesh mesh(straight(entry("shaft", Circle{d}, kSteel), l, Theory::euler_bernoulli), divided(n));
    Eigen::VectorXd p = Eigen::VectorXd::Zero(mesh.n_dofs());
    p(8) = 1.0;
    const double tip = static_solution(stiffness_matrix(mesh), p, {0, 1, 2, 3, 4, 5})(8);
    const double tip_error = tip / (l * l * l / (3 * kSteel.E * c.I_y)) - 1, difference = in_mm / in_m - 1;
    row(n, digits(in_m / exact - 1), digits(difference), digits(tip_error));
    if (n <= 100) {
      EXPECT_LT(std::abs(difference), 1e-10) << n;
    }
    // Element size: (pi/n)^4/720 of the eigenvalue, 120/pi^4 - 1 for a single element.  Round-off: that of
    // the stretch, eps (n/pi)^2 relative, and the square of the mode's own error, (eps n^4)^2.
    const double size = n == 1 ? 0.25 : 1.3 * std::pow(pi / n, 4) / 720;
    const double bound = size + 10 * 2.2e-16 * n * n + std::pow(2.2e-16 * std::pow(n, 4), 2);
    EXPECT_LT(std::abs(in_m / exact - 1), std::max(bound, 1e-13)) << n;
  }
}

}  // namespace
}  // namespace flexura::beam
