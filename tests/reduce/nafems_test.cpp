// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Published free-vibration benchmarks of solids (F. Abbassian, D. J. Dawswell, N. C. Knowles, NAFEMS R0015,
// 1987).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reduce/cms/craig_bampton.hpp"
#include "reduce/cms/shapes/fixed_interface.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "tests/reduce/parts.hpp"
#include "tests/reference.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;

// Bending mode (m, n) of a simply supported square plate after R. D. Mindlin (J. Appl. Mech. 18 (1951), 31),
// with his shear factor pi^2 / 12, the lower root of
//     J rho h w^4 - (rho h (S + D k^2) + J S k^2) w^2 + D S k^4 = 0,   S = kappa G h, J = rho h^3 / 12, k =
//     pi/a (m, n).
// For the plate below it gives the benchmark's targets to their digits: 45.897, 109.44, 167.89 Hz for (1, 1),
// (1, 2), (2, 2); so the fourth bending mode is (2, 2).
double mindlin_plate_hz(int m, int n, double a, double h, double E, double nu, double rho) {
  constexpr double pi = std::numbers::pi;
  const double D = E * h * h * h / (12.0 * (1.0 - nu * nu)), J = rho * h * h * h / 12.0;
  const double S = pi * pi / 12.0 * E / (2.0 * (1.0 + nu)) * h, k2 = (m * m + n * n) * pi * pi / (a * a);
  const double A = J * rho * h, B = rho * h * (S + D * k2) + J * S * k2, C = D * S * k2 * k2;
  return std::sqrt((B - std::sqrt(B * B - 4.0 * A * C)) / (2.0 * A)) / (2.0 * pi);
}

TEST(Nafems, MindlinsPlateGivesFv52sTargets) {
  const auto hertz = [](int m, int n) { return mindlin_plate_hz(m, n, 10.0, 1.0, 2e11, 0.3, 8000.0); };
  // Five printed digits.
  EXPECT_NEAR(hertz(1, 1) / 45.897, 1.0, 5e-5);
  EXPECT_NEAR(hertz(1, 2) / 109.44, 1.0, 5e-5);
  EXPECT_NEAR(hertz(2, 2) / 167.89, 1.0, 5e-5);
}

// The same plate as a solid, its sides held as the plate's are: across each side the displacements along it
// and in z are zero, those normal to it free.  The benchmark holds the lower edges alone; a line of supports
// under a solid gives way without end as the mesh is refined (4.8 % on 8 x 8 x 2 cells, 2.5 % on the
// benchmark's own), so that it has no exact answer. Mindlin's plate lies below three dimensions by 0.1 to 0.6
// % (S. Srinivas, C. V. Joga Rao, A. K. Rao, J. Sound Vib. 12 (1970), 187), the mesh above by less than 0.1
// %.  In the plane the lowest modes are pure shear, u_x = sin(pi y / a): sqrt(G / rho) / (2 a).
TEST(Nafems, SolidPlateOnItsSidesVibratesAsFv52) {
  constexpr double E = 2e11, nu = 0.3, rho = 8000.0, a = 10.0;
  Part part;
  part.mesh = box({a, a, 1.0}, {12, 12, 2}, mesh::CellType::hex20);
  part.materials = {isotropic("plate", E, nu, rho)};
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    const auto at_wall = [&](int d) {
      const double x = part.mesh.points(node, d);
      return std::abs(x) < 1e-9 || std::abs(x - a) < 1e-9;
    };
    std::vector<int> held;
    if (at_wall(1)) held.push_back(0);
    if (at_wall(0)) held.push_back(1);
    if (held.empty()) continue;
    held.push_back(2);
    part.interfaces.push_back({"node" + std::to_string(node), Tie::node, {}, {{node}, {}}, held});
  }
  const TiedModel model(part);
  const TiedSolver solver(model);
  const Eigen::VectorXd omega2 =
      linalg::block_lanczos(fixed_interface_problem(model, solver), {8, 0.0, 1e-8}).omega2;
  const auto hertz = [&](int k) { return frequency_hz(omega2(k)); };
  const auto plate = [](int m, int n) { return mindlin_plate_hz(m, n, a, 1.0, E, nu, rho); };
  const double shear = std::sqrt(E / (2.0 * (1.0 + nu)) / rho) / (2.0 * a);
  const double expected[] = {plate(1, 1), plate(1, 2), plate(2, 1), shear, shear, plate(2, 2)};
  for (int k = 0; k < 6; ++k)
    test::expect_reference("thick plate of hex20, mode " + std::to_string(k + 1), "Hz", hertz(k), expected[k],
                           (k == 3 || k == 4 ? 1e-4 : 7e-3) * expected[k],
                           {"NAFEMS FV52 by Mindlin's plate; exact shear",
                            "Mindlin's plate lies 0.1 to 0.6 % below three dimensions"});
}

}  // namespace
}  // namespace flexura::reduce
