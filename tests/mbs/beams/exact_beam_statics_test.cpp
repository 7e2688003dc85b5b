// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/LU>
#include <numbers>

#include "beam/section/section.hpp"
#include "beam/section/shapes.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/mbs/beams/cosserat_rod.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/reference.hpp"

/// Cantilevers of geometrically exact beams from mechanism files, bent far at rest: against published numbers, and against the
/// differential equations of the rod (cosserat_rod.hpp).
namespace flexura::mbs::beams {
namespace {

using Eigen::VectorXd;
using std::numbers::pi;

class ExactBeamStatics : public cases::TextCase {
 protected:
  struct Tip {
    Vector3d u;
    Matrix3d R;
  };
  /// Of a beam along x, clamped at the origin.
  Tip tip(const std::string& fidelity, double length, int elements, const std::string& section,
          const std::string& load) const {
    std::string text = fmt::format(
        "gravity = [0, 0, 0]\n[body.beam]\nfidelity = \"{}\"\n[body.beam.beam]\nto = [{}, 0, 0]\nelements = "
        "{}\n{}\n[joint.clamp]\ntype = \"fixed\"\nfrom = \"ground\"\nto = \"beam.root\"\n[force.load]\n"
        "marker = \"beam.tip\"\n{}\n",
        fidelity, length, elements, section, load);
    for (int i = 0; i < 3; ++i)
      text += fmt::format(
          "[measure.{0}]\ntype = \"position\"\nfrom = \"ground\"\nto = \"beam.tip\"\ndirection = {1}\n"
          "[measure.turn_{0}]\ntype = \"rotation_angle\"\nfrom = \"ground\"\nto = \"beam.tip\"\nangle = "
          "{2}\n",
          "xyz"[i],
          i == 0   ? "[1, 0, 0]"
          : i == 1 ? "[0, 1, 0]"
                   : "[0, 0, 1]",
          i + 1);
    PreparedMechanism p = prepared(text);
    find_equilibrium(*p.mechanism, p.state);
    const VectorXd at = cases::now(p, {"x", "y", "z", "turn_x", "turn_y", "turn_z"});
    Matrix3d R = Matrix3d::Identity();
    for (int i = 0; i < 3; ++i) R = R * Eigen::AngleAxisd(at(3 + i), Vector3d::Unit(i));
    return {at.head<3>() - length * Vector3d::UnitX(), R};
  }
  static std::string force(const Vector3d& F) {
    return fmt::format("type = \"force\"\nx = {:.17g}\ny = {:.17g}\nz = {:.17g}", F.x(), F.y(), F.z());
  }
  /// Of any mass: nothing moves.
  static std::string matrices(const Matrix6d& C) {
    std::string rows;
    for (int i = 0; i < 6; ++i) {
      rows += i ? ", [" : "[";
      for (int j = 0; j < 6; ++j) rows += fmt::format("{}{:.17g}", j ? ", " : "", C(i, j));
      rows += "]";
    }
    return fmt::format(
        "stiffness = [{}]\nmass = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], "
        "[0, 0, 0, 0.02, 0, 0], [0, 0, 0, 0, 0.01, 0], [0, 0, 0, 0, 0, 0.01]]",
        rows);
  }
};

// M = 2 pi n EI / L at the tip of a straight beam: one circle, and two, of which neither shear nor stretch takes part; the root
// of each element is the tip of the one before, and the angle between them 4 pi / 8 at most.  A quarter of a circle stands
// beside them as one that does not close.
TEST_F(ExactBeamStatics, MomentBendsBeamToOneCircleAndToTwo) {
  const double L = 3.0, EI = 7.0;
  const std::string section = fmt::format(
      "EA = 1e4\nGA_y = 1e4\nGA_z = 1e4\nGI_t = 5\nEI_y = {0}\nEI_z = {0}\nmass_per_length = 1\nrho_I_y = "
      "1e-4\nrho_I_z = 1e-4",
      EI);
  for (const char* const fidelity : {"beam", "rod"})
    for (const double turns : {0.25, 1.0, 2.0}) {
      SCOPED_TRACE(fmt::format("{}, {} turns", fidelity, turns));
      const double angle = 2.0 * pi * turns;
      const Tip at =
          tip(fidelity, L, 8, section, fmt::format("type = \"torque\"\nz = {:.17g}", angle * EI / L));
      const Vector3d exact(L * std::sin(angle) / angle - L, L * (1.0 - std::cos(angle)) / angle, 0.0);
      // The chord of an element by four of Gauss' points: (angle of an element)^8 5e-10 (element_test.cpp) of its length.
      const double error = L * (6e-10 * std::pow(angle / 8, 8) + 1e-12);
      flexura::test::expect_reference(
          fmt::format("pure bending to {} circles, {}: place of the tip off by", turns, fidelity), "m",
          (at.u - exact).norm(), 0.0, error, {"an arc of the radius E I / M", "quadrature of the chord"});
      EXPECT_LT((at.R - Matrix3d(Eigen::AngleAxisd(angle, Vector3d::UnitZ()))).norm(), 1e-11);
    }
}

// E. H. Dowell, J. Traybar, Princeton AMS reports 1194 and 1257, 1975: 1, 2 and 3 pounds at the tip of a slender cantilever, in
// between its stiff (0) and its soft direction.  O. A. Bauchau, S. Han, A. Mikkola, M. K. Matikainen, Multibody Syst. Dyn. 37 (2016)
// 29 have the beam's data.  Published numbers: tests/beam/ancf/data/README.md.
TEST_F(ExactBeamStatics, PrincetonBeamBendsAndTwists) {
  const double L = 0.508;
  const CosseratRod rod(L, beam::make_section("section", beam::Rectangle{12.3777e-3, 3.2024e-3},
                                              beam::isotropic("7075", 71.7e9, 0.31, 2800))
                               .stiffness());
  const std::string section =
      "young = \"71.7 GPa\"\npoisson = 0.31\ndensity = 2800\nwidth = \"12.3777 mm\"\nheight = \"3.2024 mm\"";
  for (const double P : {4.448, 8.896, 13.345})
    for (const double angle_deg : {0.0, 45.0, 75.0, 90.0}) {
      SCOPED_TRACE(fmt::format("{} N, {} deg", P, angle_deg));
      const double angle = angle_deg * pi / 180.0;
      const Vector3d F(0.0, P * std::cos(angle), P * std::sin(angle));
      const Tip at = tip("beam", L, 8, section, force(F));
      const CosseratRod::Section exact = rod.tip(F);
      // Errors of fourth order: 4 and 8 elements differ by 7e-7 m at 45 degrees and 8.896 N.
      const Vector3d u = exact.r - L * Vector3d::UnitX();
      EXPECT_LT((at.u - u).norm(), 5e-6 * L);
      EXPECT_LT((at.R - exact.R).norm(), 2e-5);
      flexura::test::expect_reference(
          fmt::format("Princeton beam, {} N at {} deg: tip", P, angle_deg), "m", at.u.norm(), u.norm(),
          5e-6 * L, {"the rod's differential equations, by Kutta's method and shooting", "eight elements"});
    }
  struct {
    double angle_deg, y, z;
  } constexpr published[] = {{0.0, 0.0107141763, 0.0},
                             {45.0, 0.008837226265, 0.108987937},
                             {75.0, 0.003538889001, 0.14219437},
                             {90.0, 0.0, 0.146245978}};
  for (const auto& [angle_deg, y, z] : published) {
    const double angle = angle_deg * pi / 180.0, P = 8.896;
    const Tip at = tip("beam", L, 8, section, force({0.0, P * std::cos(angle), P * std::sin(angle)}));
    const flexura::test::Reference of = {"Princeton beam, 8.896 N, exact beams: published beam solution",
                                         "1 %; published beams and solids differ by 1.5 to 2.5 %"};
    flexura::test::expect_reference(fmt::format("stiff direction at {} deg", angle_deg), "m", at.u.y(), y,
                                    0.01 * y + 1e-9, of);
    flexura::test::expect_reference(fmt::format("soft direction at {} deg", angle_deg), "m", at.u.z(), z,
                                    0.01 * z + 1e-9, of);
  }
}

/// Of a thin-walled composite blade that couples twist with bending (W. Yu, M. Blair, Compos. Struct. 94 (2012) 2677), in lb and in.
Matrix6d composite() {
  Matrix6d C = Vector6d(1368.17e3, 88.56e3, 38.78e3, 16.96e3, 59.12e3, 141.47e3).asDiagonal();
  C(3, 4) = C(4, 3) = 17.61e3;
  C(3, 5) = C(5, 3) = -0.351e3;
  C(4, 5) = C(5, 4) = -0.37e3;
  return C;
}

// Q. Wang, M. A. Sprague, J. Jonkman, N. Johnson, B. Jonkman, Wind Energy 20 (2017) 1439: 10 in of it under 150 lb across.  Numbers:
// BeamDyn with one spectral element, as Kynema's documentation prints them, converged to 13 digits.
TEST_F(ExactBeamStatics, CompositeBeamTwistsAsItBends) {
  const Vector3d published(-9.02726627566299e-2, -6.47488486259036e-2, 1.22973648292371);
  const std::string load = force({0, 0, 150});
  const Vector3d coarse = tip("beam", 10.0, 4, matrices(composite()), load).u,
                 fine = tip("beam", 10.0, 8, matrices(composite()), load).u;
  for (const int i : {0, 1, 2})
    flexura::test::expect_reference(
        fmt::format("composite beam under 150 lb, tip along {}", "xyz"[i]), "in", fine(i), published(i), 5e-6,
        {"BeamDyn, of Wang, Sprague, Jonkman, Johnson, Jonkman 2017, by Kynema's documentation",
         "eight elements' own error"});
  EXPECT_GT((coarse - published).norm(),
            4.0 * (fine - published).norm());  // shears that vary: 4 in the limit
  const CosseratRod rod(10.0, composite());
  EXPECT_LT((rod.tip({0, 0, 150}).r - Vector3d(10, 0, 0) - published).norm(), 1e-9);  // who checks whom
}

// Little of it follows from the inverse f of the 6 x 6: a force P along z at the tip is the moment -P (L - x) about y, so that
// strains are P (f_.Vz - (L - x) f_.My); u' = gamma + theta x e_x and theta' = kappa give what stands below.
TEST_F(ExactBeamStatics, LittleBendingOfACompositeIsThatOfItsCompliance) {
  Matrix6d C = composite();
  C(1, 2) = C(2, 1) = 12e3;  // the shears, stretch and twist, shear and twist
  C(0, 3) = C(3, 0) = 9e3;
  C(1, 3) = C(3, 1) = -4e3;
  const Matrix6d f = C.inverse();
  const double L = 10.0, P = 1e-4;
  const Vector3d theta = P * (L * f.col(2) - L * L / 2.0 * f.col(4)).tail<3>();
  const Vector3d u = P * Vector3d(L * f(0, 2) - L * L / 2.0 * f(0, 4),
                                  L * f(1, 2) + L * L / 2.0 * (f(5, 2) - f(1, 4)) - L * L * L / 3.0 * f(5, 4),
                                  L * f(2, 2) - L * L * f(4, 2) + L * L * L / 3.0 * f(4, 4));
  ASSERT_GT(std::abs(theta.x()), 0.2 * std::abs(theta.y()));  // twist by a force through the axis
  for (const int elements : {1, 4}) {
    SCOPED_TRACE(elements);
    const Tip at = tip("beam", L, elements, matrices(C), force({0, 0, P}));
    // Rotations of 1e-7 enter squared; 1e-16 of the length is lost where the displacement is taken.
    EXPECT_LT((at.u - u).norm(), 1e-6 * u.norm());
    EXPECT_LT((Vector3d(at.R(2, 1), at.R(0, 2), at.R(1, 0)) - theta).norm(), 1e-6 * theta.norm());
    for (const int i : {0, 1, 2})
      flexura::test::expect_reference(
          fmt::format("composite beam, {} elements: twist and turns of the tip about {}", elements, "xyz"[i]),
          "rad", Vector3d(at.R(2, 1), at.R(0, 2), at.R(1, 0))(i), theta(i), 1e-6 * theta.norm(),
          {"closed form by the inverse of the 6 x 6", "rotations of 1e-7 enter squared"});
  }
}

// The same authors: a rectangle of 0.5 x 0.25 whose axes turn by 90 degrees along 10, under 4e6 across.  BeamDyn as above; ANSYS'
// solids -1.134192, -1.714467, -3.58423 (0.6 % away).  The moments' slopes are mostly those of the axes' turning, kappa x M: bound
// to the shear forces they left errors of 3e-3 that more elements hardly made less.
TEST_F(ExactBeamStatics, TwistedBeamLeavesThePlaneOfItsLoad) {
  const Matrix6d C =
      Vector6d(2.5e10, 8.2604167e9, 8.2604167e9, 1.41872656e8, 5.20833e8, 1.30208333e8).asDiagonal();
  const Vector3d published(-1.14152599953942, -1.71805334646388, -3.59321324026952),
      solid(-1.134192, -1.714467, -3.58423);
  const auto at = [&](int elements) {
    return tip("beam", 10.0, elements, matrices(C) + fmt::format("\ncurvature = [{:.17g}, 0, 0]", pi / 20.0),
               force({0, 0, -4e6}))
        .u;
  };
  const Vector3d coarse = at(8), fine = at(16);
  for (const int i : {0, 1, 2}) {
    flexura::test::expect_reference(
        fmt::format("twisted beam, tip along {}", "xyz"[i]), "", fine(i), published(i), 2e-5,
        {"BeamDyn, of Wang, Sprague, Jonkman, Johnson, Jonkman 2017, by Kynema's tests",
         "sixteen elements' own error"});
    EXPECT_NEAR(fine(i), solid(i), 0.007 * std::abs(solid(i)));
  }
  EXPECT_GT((coarse - published).norm(), 10.0 * (fine - published).norm());
}

}  // namespace
}  // namespace flexura::mbs::beams
