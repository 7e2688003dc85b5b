// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>

#include "beam/ancf/ancf_kinematics.hpp"
#include "beam/ancf/ancf_statics.hpp"
#include "beam/ancf/element/section_link.hpp"
#include "beam/section/shapes.hpp"
#include "tests/beam/ancf/exact/catenary.hpp"
#include "tests/beam/ancf/exact/elastica.hpp"
#include "tests/beam/ancf/samples.hpp"
#include "tests/reference.hpp"

namespace flexura::beam::ancf {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

Load end_moment(const AncfBody& body, const Vector3d& M) {
  return [&body, M](double t, const VectorXd& q, VectorRef f, Triplets* df_dq) {
    add_point_moment(body, body.locate(body.length()), q, t * M, f, df_dq);
  };
}

Load end_force(const AncfBody& body, const Vector3d& F) {
  VectorXd f = VectorXd::Zero(body.n_q());
  add_point_force(body, body.locate(body.length()), F, f);
  return proportional_load(f);
}

// All lengths 1, EI = 1; EA = 1e6 makes the shortening by axial force of order alpha/EA = 1e-5, so EA = 1e8
// is taken where finer agreement is asked for.
constexpr LineSection slender{.EA = 1e8, .EI = 1.0, .mass_per_length = 1.0};
BeamSection slender_beam() {
  return uncoupled_section(1e8, 1e8, 1e8, 1.0, 1.0, 1.0, 1.0, 1e-4, 1e-4);
}

struct Cantilever {
  std::string name;
  AncfBody body;
  std::vector<int> fixed;
};

std::vector<Cantilever> cantilevers(int n_elements) {
  const auto curve = straight_curve({0, 0, 0}, {1, 0, 0}, n_elements);
  std::vector<Cantilever> all;
  all.push_back({"planar line", planar_line(slender, curve), clamp_of_line(2)});
  all.push_back({"spatial line", spatial_line(slender, curve), clamp_of_line(3)});
  all.push_back({"spatial beam", spatial_beam(slender_beam(), curve), kBeamClamp});
  return all;
}

Vector3d tip(const AncfBody& body, const VectorXd& q) {
  return evaluate_point(body, body.locate(body.length()), q, VectorXd::Zero(q.size())).p_WoP_W;
}

TEST(AncfStatics, CantileverUnderTipForceFollowsTheElastica) {
  // Lines interpolate the curve with cubics: order 4.  A beam's curvature is constant in each element:
  // order 2.  An element turns by up to kappa l = sqrt(2 alpha) l = 0.28 (alpha = 10, 16 elements), and
  // 0.28^4/120 and 0.28^2/24 are the sizes to expect.  Stretch and shear count alpha/EA = 1e-7.
  for (const double alpha : {1.0, 10.0}) {
    const auto exact = exact::elastica_tip_load(alpha);
    const Vector3d expected(1 - exact.shortening, exact.deflection, 0);
    const double kappa_l = std::sqrt(2 * alpha) / 16;
    std::map<std::string, double> error_8;
    for (const int n : {8, 16})
      for (const auto& [name, body, fixed] : cantilevers(n)) {
        Problem problem = held(body, fixed);
        problem.loads.push_back(end_force(body, {0, alpha, 0}));
        const auto result = solve_static(problem, body.rest(), {.steps = 3});
        const double error = (tip(body, result.q) - expected).norm();
        if (n == 8) {
          error_8[name] = error;
          continue;
        }
        const bool is_line = name != "spatial beam";
        EXPECT_LT(error, error_8[name] / (is_line ? 12 : 3.5)) << name << " " << alpha;
        test::expect_reference(
            "tip of a " + name + ", P L^2/EI = " + std::to_string(static_cast<int>(alpha)) + ", error in L",
            "", error, 0.0, is_line ? std::pow(kappa_l, 4) / 120 : kappa_l * kappa_l / 24,
            {"elastica, elliptic integrals", "interpolation of the curve by 16 elements"});
        // Newton with extrapolated stress at EA/EI = 1e8; the plain iteration takes hundreds.
        EXPECT_LT(result.iterations, 40) << name << " " << alpha;
      }
  }
}

TEST(AncfStatics, EndMomentRollsTheCantileverIntoACircle) {
  // M = 2 pi EI/L closes the circle: the tip comes back to the root.  Same orders; a spatial line's section
  // frame is undefined at half a turn, so it is left out.
  const auto error = [](const AncfBody& body, std::vector<int> fixed) {
    Problem problem = held(body, std::move(fixed));
    problem.loads.push_back(end_moment(body, {0, 0, 2 * M_PI}));
    const auto result = solve_static(problem, body.rest(), {.steps = 10});
    return tip(body, result.q).norm();
  };
  const auto curve = [](int n) { return straight_curve({0, 0, 0}, {1, 0, 0}, n); };
  const double line_16 = error(planar_line(slender, curve(16)), clamp_of_line(2));
  const double line_32 = error(planar_line(slender, curve(32)), clamp_of_line(2));
  EXPECT_LT(line_32, line_16 / 12);
  EXPECT_LT(line_32, std::pow(2 * M_PI / 32, 4) / 120);
  // A beam element that turns by theta has the energy of theta^2 (1 + theta^4/32): it turns by 3 theta^4/32 too little, and
  // the tip by 2 pi of that in angle and in position by as much of the radius.
  const double beam_32 = error(spatial_beam(slender_beam(), curve(32)), kBeamClamp);
  const double beam_64 = error(spatial_beam(slender_beam(), curve(64)), kBeamClamp);
  EXPECT_LT(beam_64, beam_32 / 12);
  EXPECT_LT(beam_64, 1.2 * std::pow(2 * M_PI / 64, 4) * 3 / 32);
}

TEST(AncfStatics, SectionForcesBalanceTheTipLoad) {
  // Small load (P, F) at the tip: N = P, V_y = F, M_z(x) = F (1 - x); lines carry no shear, and a beam's
  // moment is that of the element's middle.  Nonlinear part: F^2 and P of 1e-4 relative; EA = 1e4 keeps the
  // stretch above round-off.
  const double P = 1e-4, F = 1e-4;
  const int n = 4;
  const auto curve = straight_curve({0, 0, 0}, {1, 0, 0}, n);
  const LineSection line{.EA = 1e4, .EI = 1, .mass_per_length = 1};
  std::vector<Cantilever> all;
  all.push_back({"planar line", planar_line(line, curve), clamp_of_line(2)});
  all.push_back({"spatial line", spatial_line(line, curve), clamp_of_line(3)});
  all.push_back({"spatial beam",
                 spatial_beam(uncoupled_section(1e4, 1e4, 1e4, 1, 1, 1, 1, 1e-4, 1e-4), curve), kBeamClamp});
  for (const auto& [name, body, fixed] : all) {
    Problem problem = held(body, fixed);
    problem.loads.push_back(end_force(body, {P, F, 0}));
    const VectorXd q = solve_static(problem, body.rest()).q, still = VectorXd::Zero(body.n_q());
    const bool is_beam = name == "spatial beam";
    for (int e = 0; e < n; ++e) {
      double shear = 0.0;
      for (int k = 0; k < 3; ++k) {
        const SectionForces at = section_forces(body, e, k, q, still);
        const double x = (e + (is_beam ? 0.5 : at.at.xi)) / n;
        EXPECT_NEAR(at.s[0], P, 1e-3 * P) << name << " " << e << " " << k;
        EXPECT_NEAR(at.s[5], F * (1 - x), 1e-3 * F) << name << " " << e << " " << k;
        shear += (k == 1 ? 4.0 : 1.0) / 6.0 * at.s[1];
      }
      EXPECT_NEAR(shear, is_beam ? F : 0.0, 1e-3 * F) << name << " " << e;
    }
  }
}

TEST(AncfStatics, CurvedBeamObeysCastigliano) {
  // Quarter circle of radius 1, clamped at (0, 0) with tangent x; small forces at the end (1, 1).
  //   F_x: u_x = pi/4 F/EI, u_y = -F/(2 EI);   F_z: u_z = F (pi/(4 EI) + (3 pi/4 - 2)/GI_t)
  const double EI = 1.0, GI_t = 0.7, F = 1e-6;
  const BeamSection section = uncoupled_section(1e8, 1e8, 1e8, GI_t, EI, EI, 1.0, 1e-4, 1e-4);
  double errors[2][3];
  for (int k = 0; k < 2; ++k) {
    const int n = k == 0 ? 8 : 16;
    const AncfBody beam = spatial_beam(section, quarter_circle(n));
    const auto deflection = [&](const Vector3d& load) {
      Problem problem = held(beam, kBeamClamp);
      problem.loads.push_back(end_force(beam, load));
      return Vector3d((tip(beam, solve_static(problem, beam.rest()).q) - Vector3d(1, 1, 0)) / F);
    };
    const Vector3d in_plane = deflection({F, 0, 0}), out_of_plane = deflection({0, 0, F});
    errors[k][0] = in_plane[0] / (M_PI / 4 / EI) - 1;
    errors[k][1] = in_plane[1] / (-0.5 / EI) - 1;
    errors[k][2] = out_of_plane[2] / (M_PI / 4 / EI + (3 * M_PI / 4 - 2) / GI_t) - 1;
  }
  // An element turns by theta = pi/32: order 2, constants of one in theta^2; F/EI = 1e-6 is the nonlinear
  // part.
  const double theta2 = std::pow(M_PI / 32, 2);
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(std::abs(errors[1][i]), theta2) << i;
    EXPECT_LT(std::abs(errors[1][i]), std::abs(errors[0][i]) / 3.5) << i;
  }
}

// |r_tip - c|^2 = R^2: a rigid massless link between the tip and the ground, nonlinear in q.
class Link : public Constraint {
 public:
  Link(int first, const Vector3d& c, double R) : first_(first), c_(c), R_(R) {}
  int rows() const override { return 1; }
  void evaluate(double, const VectorXd& q, VectorRef g, Triplets* G) const override {
    const Vector3d d = q.segment<3>(first_) - c_;
    g[0] = 0.5 * (d.squaredNorm() - R_ * R_);
    for (int i = 0; G && i < 3; ++i) G->emplace_back(0, first_ + i, d[i]);
  }
  void add_hessian(double, const VectorXd&, ConstVectorRef lambda, Triplets& K) const override {
    for (int i = 0; i < 3; ++i) K.emplace_back(first_ + i, first_ + i, lambda[0]);
  }

 private:
  int first_;
  Vector3d c_;
  double R_;
};

TEST(AncfStatics, LinkedTipIsPulledByTheForceOfTheLink) {
  const AncfBody body = spatial_beam(slender_beam(), straight_curve({0, 0, 0}, {1, 0, 0}, 8));
  const Vector3d c(1.2, -0.3, 0.1), F(0, 3, 1);
  const double R = (Vector3d(1, 0, 0) - c).norm();
  Problem linked = held(body, kBeamClamp);
  linked.loads.push_back(end_force(body, F));
  linked.constraints.push_back(std::make_shared<Link>(body.index(8, 0), c, R));
  const auto with_link = solve_static(linked, body.rest());
  const Vector3d d = tip(body, with_link.q) - c;
  EXPECT_NEAR(d.norm(), R, 1e-12);

  // G^T lambda stands on the left: the link acts on the tip with -lambda d.
  Problem pulled = held(body, kBeamClamp);
  pulled.loads.push_back(end_force(body, F - with_link.lambda[0] * d));
  const auto with_force = solve_static(pulled, body.rest());
  // Both iterations stop at corrections of 1e-11, or at a round-off floor of eps EA/EI = 2e-8 relative to
  // their size.
  EXPECT_LT((with_force.q - with_link.q).cwiseAbs().maxCoeff(), 2e-8);
  EXPECT_GT(std::abs(with_link.lambda[0]), 0.1);
}

TEST(AncfStatics, SaysAtWhichLoadAMechanismGivesWay) {
  const AncfBody body = planar_line(slender, straight_curve({0, 0, 0}, {1, 0, 0}, 2));
  Problem problem = held(body, {0, 1});  // hinged only
  problem.loads.push_back(end_force(body, {0, 1, 0}));
  EXPECT_THAT([&] { solve_static(problem, body.rest()); },
              testing::ThrowsMessage<std::runtime_error>(testing::HasSubstr("lost at load factor 0 ")));
  EXPECT_THAT([&] { solve_static(problem, VectorXd::Zero(3)); },
              testing::ThrowsMessage<std::invalid_argument>(
                  testing::HasSubstr("has 3 coordinates, but the body has 12")));
}

TEST(AncfStatics, HangingCableTakesTheCatenary) {
  const double L_0 = 3.0, EA = 200.0, w = 2.0, span = 2.5;
  const exact::Catenary exact(L_0, w * L_0, EA, span);
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const int n = k == 0 ? 8 : 16;
    // A cable without bending stiffness is a mechanism while slack, so it starts taut, 5 % too long, and the
    // support moves in.
    const double taut = 1.05 * L_0;
    ReferenceCurve curve = straight_curve({0, 0, 0}, {taut, 0, 0}, n);
    curve.s *= L_0 / taut;
    const AncfBody body = spatial_line({.EA = EA, .EI = 0.0, .mass_per_length = w}, curve);
    const int end = body.index(n, 0);
    Problem problem{
        .body = &body, .fixed = {0, 1, 2, end + 1, end + 2}, .drives = {}, .constraints = {}, .loads = {}};
    problem.drives.push_back({end, [&](double t) { return Vector3d((1 - t) * taut + t * span, 0, 0); }});
    problem.loads.push_back(constant_load(body.gravity_force({0, -1, 0})));
    VectorXd q = body.rest();
    for (int i = 0; i <= n; ++i) q[body.index(i, 1)] = taut / L_0;
    const auto result = solve_static(problem, q, {.steps = 5});
    errors[k] = 0;
    for (int i = 0; i <= n; ++i) {
      const Vector3d expected(exact.x(curve.s[i]), exact.y(curve.s[i]), 0);
      errors[k] = std::max(errors[k], (result.q.segment(body.index(i, 0), 3) - expected).norm());
    }
  }
  // Cubics: order 4.  The tangent turns by 1.9 rad in all, 0.2 an element at the sharpest: (0.2)^4/120 of
  // L_0.
  EXPECT_LT(errors[1], errors[0] / 12);
  test::expect_reference("hanging cable, largest error of a node", "m", errors[1], 0.0,
                         L_0 * std::pow(0.2, 4) / 120,
                         {"elastic catenary", "interpolation of the curve by 16 elements"});
}

struct PrincetonRow {
  double angle_deg, beam_uy, beam_uz, solid_uy, solid_uz;
};

std::vector<PrincetonRow> read_princeton() {
  std::ifstream file(FLEXURA_SOURCE_DIR "/tests/beam/ancf/data/princeton_P2.csv");
  EXPECT_TRUE(file);
  std::string line;
  std::getline(file, line);
  std::vector<PrincetonRow> rows;
  PrincetonRow r;
  while (std::getline(file, line))
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &r.angle_deg, &r.beam_uy, &r.beam_uz, &r.solid_uy,
                    &r.solid_uz) == 5)
      rows.push_back(r);
  return rows;
}

TEST(AncfStatics, PrincetonBeamBendsAndTwists) {
  // 7075 aluminium, height along y: the load at 0 degrees bends about the strong axis.
  const double L = 0.508;
  const BeamSection section =
      beam_section(make_section("Princeton", Rectangle{12.3777e-3, 3.2024e-3},
                                isotropic("7075", 71.7e9, 0.31, 2800), ShearFormula::zero_poisson));
  const AncfBody body = spatial_beam(section, straight_curve({0, 0, 0}, {L, 0, 0}, 16));
  const auto rows = read_princeton();
  ASSERT_EQ(rows.size(), 7u);
  for (const auto& row : rows) {
    const double angle = row.angle_deg * M_PI / 180;
    Problem problem = held(body, kBeamClamp);
    problem.loads.push_back(end_force(body, 8.896 * Vector3d(0, std::cos(angle), std::sin(angle))));
    const auto result = solve_static(problem, body.rest(), {.steps = 2});
    const Vector3d u = tip(body, result.q) - Vector3d(L, 0, 0);
    // 1 % of the beam column (beam and solid differ by 1.5 to 2.5 %); zero by symmetry: cos 90 degrees in
    // floating point, magnified by the load.
    const test::Reference princeton = {"Princeton beam, load 8.896 N: published beam solution",
                                       "1 %; published beams and solids differ by 1.5 to 2.5 %"};
    const std::string at = " at " + std::to_string(static_cast<int>(row.angle_deg)) + " deg";
    test::expect_reference("u_y" + at, "m", u[1], row.beam_uy, 0.01 * row.beam_uy + 1e-9, princeton);
    test::expect_reference("u_z" + at, "m", u[2], row.beam_uz, 0.01 * row.beam_uz + 1e-9, princeton);
  }
}

}  // namespace
}  // namespace flexura::beam::ancf
