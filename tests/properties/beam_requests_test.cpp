// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What [modes], [damping] and [link] ask of beam parts, for random frames: beside the same part with all of its modes, which is
// the full model in other coordinates.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/superelement/modes.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/properties/quadratic_problem.hpp"

namespace flexura::properties {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

Superelement reduced(const test::Folder& folder, const std::string& text,
                     const std::vector<std::string>& set) {
  return reduce::reduce(reduce::read_beam_part(folder.write("part.toml", text), set)).superelement;
}

// [1/s], ascending, the six rigid ones left out.
VectorXd elastic(const MatrixXd& K, const MatrixXd& M) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(K, M, Eigen::EigenvaluesOnly);
  return modes.eigenvalues().tail(K.rows() - 6).cwiseMax(0.0).cwiseSqrt();
}

struct Frame {
  std::string text;
  Superelement full;
  VectorXd omega;
};

template <class Judge>
void for_random_frames(int cases, const Judge& judge) {
  const test::Folder folder;
  int judged = 0;
  for (int seed = 1; judged < cases && seed < 4 * cases; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    const RandomPart part =
        random_part(chance, Kind::beams, folder, {.all_directions = true, .fewest_modes = 1});
    if (!part.refused.empty()) continue;
    Frame frame{part.text, reduced(folder, part.text, {"modes.count=1000", "mesh.elements=3"}), {}};
    if (frame.full.n() < 30) continue;
    frame.omega = elastic(frame.full.K_se, frame.full.M_se);
    ++judged;
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, part.text));
    judge(chance, folder, frame);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(judged, cases);
}

// The certificate counts the modes below a frequency between the last kept and the first left out, and there are as many of the
// structure's own eigenvalues.
TEST(BeamRequests, CertificatesCountTheModes) {
  int judged = 0;
  for_random_frames(200, [&](Chance& chance, const test::Folder& folder, const Frame& frame) {
    VectorXd all = frame.full.omega2;
    std::sort(all.begin(), all.end());
    const auto kept = 1 + chance.below(static_cast<int>(all.size()) / 2);
    const Superelement se =
        reduced(folder, frame.text, {fmt::format("modes.count={}", kept), "mesh.elements=3"});
    const auto certificate = nlohmann::json::parse(se.report_json).at("certificate");
    if (certificate.is_null()) return;
    ++judged;
    EXPECT_EQ(certificate.at("modes").get<int>(), se.n_q);
    const double limit = kTwoPi * certificate.at("below_hz").get<double>();
    EXPECT_EQ((all.array() < limit * limit).count(), se.n_q);
  });
  EXPECT_GT(judged, 180);  // the others have no factor to count with, which is said
  const test::Folder folder;
  Chance chance(1);
  const RandomPart part =
      random_part(chance, Kind::beams, folder, {.all_directions = true, .fewest_modes = 1});
  ASSERT_EQ(part.refused, "");
  EXPECT_TRUE(nlohmann::json::parse(reduced(folder, part.text, {"modes.certify=false"}).report_json)

                  .at("certificate")
                  .is_null());
}

// What the interfaces feel of the body at a frequency.
MatrixXd dynamic_stiffness(const Superelement& se, double omega) {
  const MatrixXd Z = se.K_se - omega * omega * se.M_se;
  MatrixXd out = Z.topLeftCorner(se.n_b, se.n_b);
  if (se.n_q > 0)
    out -= Z.topRightCorner(se.n_b, se.n_q) *
           Z.bottomRightCorner(se.n_q, se.n_q).fullPivLu().solve(Z.bottomLeftCorner(se.n_q, se.n_b));
  return out;
}

TEST(BeamRequests, FreeModesOfCraigAndChangAreExact) {
  for_random_frames(35, [](Chance& chance, const test::Folder& folder, const Frame& frame) {
    const int count = 1 + chance.below(8);
    const Superelement se =
        reduced(folder, frame.text,
                {"modes.set=\"craig_chang\"", fmt::format("modes.count={}", count), "mesh.elements=3"});
    const VectorXd omega = elastic(se.K_se, se.M_se);
    ASSERT_GE(omega.size(), count);
    ASSERT_LT(se.n(), frame.full.n());
    for (int k = 0; k < count;
         ++k)  // the eigensolver's residual of 1e-8, squared in the eigenvalue, and round-off
      EXPECT_NEAR(omega(k), frame.omega(k), 1e-7 * frame.omega(k));
    // Attachment modes: the static stiffness between the interfaces.
    EXPECT_LE((dynamic_stiffness(se, 0.0) - dynamic_stiffness(frame.full, 0.0)).norm(),
              1e-8 * frame.full.K_se.topLeftCorner(se.n_b, se.n_b).norm());
  });
}

TEST(BeamRequests, ResponseModesAreExactAtTheirFrequency) {
  for_random_frames(35, [](Chance& chance, const test::Folder& folder, const Frame& frame) {
    const int count = 3;
    const Superelement few =
        reduced(folder, frame.text, {fmt::format("modes.count={}", count), "mesh.elements=3"});
    const double omega = chance.between(0.1, 0.6) * std::sqrt(few.omega2(few.n_q - 1));
    const Superelement se = reduced(folder, frame.text,
                                    {fmt::format("modes.count={}", count), "mesh.elements=3",
                                     fmt::format("modes.response_at=[{:.17g}]", omega / kTwoPi)});
    const MatrixXd right = dynamic_stiffness(frame.full, omega);
    const VectorXd size = right.diagonal().cwiseAbs().cwiseSqrt();
    const auto error = [&](const Superelement& of) {
      return ((dynamic_stiffness(of, omega) - right).array() / (size * size.transpose()).array())
          .abs()
          .maxCoeff();
    };
    // Near an eigenfrequency of the held part the stiffness has lost as many digits as its diagonal entries tell.
    EXPECT_LT(error(se), 1e-6);
    if (se.n() < frame.full.n()) EXPECT_LT(error(se), 0.01 * error(few) + 1e-9);
  });
}

TEST(BeamRequests, StruckModesAreGone) {
  for_random_frames(35, [](Chance& chance, const test::Folder& folder, const Frame& frame) {
    const int number = 7 + chance.below(4);
    const Superelement se =
        reduced(folder, frame.text,
                {"modes.count=1000", "mesh.elements=3", fmt::format("modes.strike_modes=[{}]", number)});
    ASSERT_EQ(se.n(), frame.full.n() - 1);
    const VectorXd omega = elastic(se.K_se, se.M_se);
    for (Index k = 0; k < omega.size(); ++k) {
      const double right = frame.omega(k < number - 7 ? k : k + 1);
      EXPECT_NEAR(omega(k), right, 1e-6 * right);
    }
  });
}

TEST(BeamRequests, EffectiveMassIsKept) {
  for_random_frames(35, [](Chance& chance, const test::Folder& folder, const Frame& frame) {
    const double fraction = chance.between(0.3, 0.95);
    const Superelement se = reduced(
        folder, frame.text, {fmt::format("modes.effective_mass={:.6f}", fraction), "mesh.elements=1"});
    // The full matrices: every node an interface, members of one element.
    std::string all = frame.text.substr(0, frame.text.find("[interface."));
    std::size_t n_nodes = 0;
    while (all.find(fmt::format("[node.n{}]", n_nodes)) != std::string::npos) ++n_nodes;
    for (std::size_t k = 0; k < n_nodes; ++k) all += fmt::format("[interface.n{}]\n", k);
    const Superelement full = reduced(folder, all, {"mesh.elements=1"});
    ASSERT_EQ(full.n_q, 0);
    const Index n_b = se.n_b, n_i = full.n() - n_b;
    if (n_i == 0) return;
    MatrixXd R = superelement::rigid_motions(full);
    const Vector3d centre = full.inertia.S_x / full.inertia.mass;
    for (int a = 0; a < 3; ++a)
      R.col(3 + a) = (R.col(3 + a) - R.leftCols(3) * Vector3d::Unit(a).cross(centre)).eval();
    const MatrixXd K_ii = full.K_se.bottomRightCorner(n_i, n_i), M_ii = full.M_se.bottomRightCorner(n_i, n_i);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> held(K_ii, M_ii);
    const MatrixXd p = held.eigenvectors().leftCols(se.n_q).transpose() * full.M_se.bottomRows(n_i) * R;
    const MatrixXd R_i = R.bottomRows(n_i);
    for (int d = 0; d < 6; ++d)
      EXPECT_GE(p.col(d).squaredNorm(), (fraction - 1e-6) * R_i.col(d).dot(M_ii * R_i.col(d)));
  });
}

TEST(BeamRequests, AccuracyIsKept) {
  for_random_frames(35, [](Chance& chance, const test::Folder& folder, const Frame& frame) {
    const double accuracy = std::pow(10.0, chance.between(-3.0, -1.5)),
                 up_to = 1.001 * frame.omega(chance.below(6));
    std::vector<std::string> set = {fmt::format("modes.accuracy={:.6f}", accuracy), "mesh.elements=1"};
    if (chance.flip(0.7)) set.push_back(fmt::format("modes.up_to={:.6f}", up_to / kTwoPi));
    const Superelement se = reduced(folder, frame.text, set),
                       fine = reduced(folder, frame.text, {"mesh.elements=24", "modes.count=60"});
    const VectorXd omega = elastic(se.K_se, se.M_se), right = elastic(fine.K_se, fine.M_se);
    const Index n = set.size() == 3 ? (right.array() < up_to).count() : 6;
    ASSERT_GE(omega.size(), n);
    for (Index k = 0; k < n; ++k) EXPECT_NEAR(omega(k), right(k), accuracy * right(k));
  });
}

TEST(BeamRequests, DampingTablesGiveTheModesTheirRatios) {
  for_random_frames(35, [](Chance& chance, const test::Folder& folder, const Frame& frame) {
    const double f = frame.omega(2) / kTwoPi, low = chance.between(0.001, 0.05),
                 high = chance.between(0.001, 0.05), alpha = chance.between(0.0, 5.0),
                 beta = chance.between(0.0, 1e-5);
    const Superelement se = reduced(
        folder,
        frame.text +
            fmt::format("[damping]\nfrequencies = [{:.17g}, {:.17g}]\nratios = [{:.17g}, {:.17g}]\nalpha = "
                        "{:.17g}\nbeta = {:.17g}\n",
                        f, 3.0 * f, low, high, alpha, beta),
        {});
    EXPECT_EQ(se.modal_damping, 0.0);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(se.K_se, se.M_se);
    const MatrixXd D = modes.eigenvectors().transpose() * se.D_se * modes.eigenvectors();
    for (Index k = 6; k < se.n(); ++k) {
      const double omega = std::sqrt(modes.eigenvalues()(k)),
                   t = std::clamp((omega / kTwoPi / f - 1.0) / 2.0, 0.0, 1.0),
                   right = 2.0 * ((1.0 - t) * low + t * high) * omega + alpha + beta * omega * omega;
      EXPECT_NEAR(D(k, k), right, 1e-6 * right);
    }
  });
}

TEST(BeamRequests, LinksJoinTheirNodes) {
  for_random_frames(35, [](Chance& chance, const test::Folder& folder, const Frame& frame) {
    // Both nodes are interfaces, so that the link is a rank of one between their displacements.
    const std::size_t first = frame.text.find("[interface.");
    const std::string ends = "[interface.n0]\n[interface.n1]\n", head = frame.text.substr(0, first);
    const double k = std::pow(10.0, chance.between(3.0, 7.0)), c = std::pow(10.0, chance.between(0.0, 3.0));
    const std::vector<std::string> all = {"mesh.elements=3", "modes.count=1000", "modes.damping=0.0"};
    const Superelement bare = reduced(folder, head + ends, all);
    const Superelement se = reduced(
        folder,
        head + ends +
            fmt::format("[link.l]\nnodes = [\"n0\", \"n1\"]\nstiffness = {:.17g}\ndamping = {:.17g}\n", k, c),
        all);
    Superelement right_one;
    right_one.n_q = bare.n();
    VectorXd q = VectorXd::Zero(bare.n());
    const Vector3d e = (bare.interfaces[1].p_BoN_B - bare.interfaces[0].p_BoN_B).normalized();
    q.segment<3>(bare.interfaces[0].first_dof) = -e;
    q.segment<3>(bare.interfaces[1].first_dof) = e;
    right_one.K_se = bare.K_se + k * q * q.transpose();
    right_one.M_se = bare.M_se;
    right_one.D_se = c * q * q.transpose();
    ASSERT_EQ(se.n(), bare.n());
    const VectorXd with = elastic(se.K_se, se.M_se), right = elastic(right_one.K_se, right_one.M_se);
    for (Index j = 0; j < with.size(); ++j) EXPECT_NEAR(with(j), right(j), 1e-6 * right(j));
    const Case found = make_case(chance, folder, se, "", kJoints[6]);
    // Some of the lowest: the highest of so many modes are round-off of each other.
    std::vector<std::complex<double>> values = found.found;
    expect_same(values, right_one, [&](const Superelement& of) {
      auto s = properties::right(of, of.D_se, MatrixXd(0, of.n()));
      std::erase_if(s, [&](const auto& value) {
        return std::abs(value) > 3.0 * right(5) || std::abs(value) < 1e-3 * right(0);
      });
      return s;
    });
  });
}

// Members of one element between interfaces leave nothing to reduce.
TEST(BeamRequests, ElementsBetweenInterfacesAreTheirMatrices) {
  const test::Folder folder;
  for (int seed = 1; seed <= 100; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    const double l = chance.between(0.2, 2.0), d = chance.between(5e-3, 5e-2), E = 2.1e11, nu = 0.3;
    std::string text = fmt::format(
        "[material.m]\nyoung = {:.17g}\npoisson = {}\ndensity = 7850\n[section.s]\ntype = "
        "\"circle\"\ndiameter = {:.17g}\n"
        "[node.a]\nposition = [0, 0, 0]\n[node.b]\nposition = [{:.17g}, 0, 0]\n[member.m]\nnodes = [\"a\", "
        "\"b\"]\n"
        "theory = \"euler_bernoulli\"\n[interface.a]\n[interface.b]\n[mesh]\nelements = 1\n",
        E, nu, d, l);
    const char* const sets[] = {"craig_bampton", "craig_chang", "guyan"};
    text += fmt::format("[modes]\nset = \"{}\"\n", chance.one_of(sets));
    const Superelement se = reduced(folder, text, {});
    ASSERT_EQ(se.n_q, 0);
    ASSERT_EQ(se.n(), 12);
    const double A = std::numbers::pi * d * d / 4.0, I = std::numbers::pi * std::pow(d, 4) / 64.0;
    EXPECT_NEAR(se.K_se(0, 0), E * A / l, 1e-12 * E * A / l);
    EXPECT_NEAR(se.K_se(1, 1), 12.0 * E * I / (l * l * l), 1e-10 * se.K_se(1, 1));
    EXPECT_NEAR(se.K_se(1, 5), 6.0 * E * I / (l * l), 1e-10 * se.K_se(1, 5));
    EXPECT_NEAR(se.K_se(5, 5), 4.0 * E * I / l, 1e-10 * se.K_se(5, 5));
    EXPECT_NEAR(se.K_se(3, 3), E / (2.0 * (1.0 + nu)) * 2.0 * I / l, 1e-10 * se.K_se(3, 3));
    // Those of the constraint modes by their names.
    const superelement::ModeAnalysis constraint = superelement::constraint_modes(se);
    ASSERT_EQ(constraint.modes.size(), 12U);
    for (const superelement::Mode& mode : constraint.modes) {
      const std::string direction = mode.dof.substr(2);
      const double right = direction == "u_x"       ? E * A / l
                           : direction[0] == 'u'    ? 12.0 * E * I / (l * l * l)
                           : direction == "theta_x" ? E / (1.0 + nu) * I / l
                                                    : 4.0 * E * I / l;
      EXPECT_NEAR(mode.stiffness, right, 1e-10 * right) << mode.dof;
      EXPECT_NEAR(mode.u_se.dot(se.K_se * mode.u_se), right, 1e-10 * right);
      EXPECT_STREQ(superelement::kind_of(mode), "constraint");
    }
  }
}

}  // namespace
}  // namespace flexura::properties
