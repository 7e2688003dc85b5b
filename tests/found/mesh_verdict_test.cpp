// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What a superelement's verdict says of its mesh: estimated, refused or called unknown, never trusted unseen; and what
// `accuracy` promises is kept.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <numbers>

#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class MeshVerdict : public Parts {
 protected:
  // What the report's estimate says of a mode.
  static double hz(const Reduced& r, std::size_t k) { return r.report["mesh_error"]["modes"].at(k)["hz"]; }
  static double error(const Reduced& r, std::size_t k) {
    const nlohmann::json& error = r.report["mesh_error"]["modes"].at(k)["frequency_error"];
    return error.is_number() ? error.get<double>() : HUGE_VAL;
  }

  void bring(const std::string& name) const {
    std::filesystem::copy(std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/found/reduce" / name,
                          folder_ / name, std::filesystem::copy_options::overwrite_existing);
  }

  /// A steel bar of 100 x 12 x 8 mm, its ends as interfaces that hold nothing but their mean motion.
  std::filesystem::path bar(const std::string& more = "", const std::string& young = "\"210 GPa\"") {
    bring("bar.brep");
    return folder_.write("bar.toml", R"([geometry]
file = "bar.brep"
unit = "mm"
[material.steel]
young = )" + young + R"(
poisson = 0.3
density = "7850 kg/m^3"
[interface.left]
by = "plane"
point = [0, 0, 0]
normal = [-1, 0, 0]
tie = "average"
[interface.right]
by = "plane"
point = ["100 mm", 0, 0]
normal = [1, 0, 0]
tie = "average"
)" + more);
  }

  /// The block of 20-node bricks, its own mesh.
  std::filesystem::path block(const std::string& more, const std::string& poisson = "0.3") {
    bring("blockC3D20.inp");
    folder_.write("block.inp",
                  replaced(read_text(folder_ / "blockC3D20.inp"), "2e+11, 0.3", "2e+11, " + poisson));
    return folder_.write("block.toml", "[geometry]\nfile = \"block.inp\"\n" + more);
  }
};

const std::string kShell = R"(*NODE
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 2, 0, 0
6, 2, 1, 0
*ELEMENT, TYPE=S4, ELSET=E
1, 1, 2, 3, 4
2, 2, 5, 6, 3
*MATERIAL, NAME=STEEL
*ELASTIC
210e9, 0.3
*DENSITY
7850
*SHELL SECTION, ELSET=E, MATERIAL=STEEL
0.01
)";
const std::string kShellHeld = "[interface.left]\nby = \"nodes\"\nnodes = [1, 4]\n[modes]\ncount = 2\n";

const std::string kHeld = "[interface.left]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\n";

/// The lowest bending frequencies [Hz] of a free beam of Timoshenko's theory, b x h, bending over h: Ritz's method with
/// Legendre polynomials for deflection and rotation, which 14 of each hold to more digits than the theory is worth.
std::vector<double> bending_hz(double L, double b, double h, double E, double nu, double rho) {
  constexpr int n = 14, n_points = 40;
  const double A = b * h, I = b * h * h * h / 12, G = E / (2 * (1 + nu)),
               kappa = 10 * (1 + nu) / (12 + 11 * nu);
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(2 * n, 2 * n), M = K;
  // Gauss's rule by the eigenvalues of its Jacobi matrix.
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n_points, n_points);
  for (int k = 1; k < n_points; ++k) J(k, k - 1) = J(k - 1, k) = k / std::sqrt(4.0 * k * k - 1.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> rule(J);
  for (int q = 0; q < n_points; ++q) {
    const double x = rule.eigenvalues()(q), weight = 2 * std::pow(rule.eigenvectors()(0, q), 2) * L / 2;
    Eigen::VectorXd P(n), dP(n);
    P(0) = 1, P(1) = x, dP(0) = 0, dP(1) = 1;
    for (int k = 2; k < n; ++k) {
      P(k) = ((2 * k - 1) * x * P(k - 1) - (k - 1) * P(k - 2)) / k;
      dP(k) = dP(k - 2) + (2 * k - 1) * P(k - 1);
    }
    dP *= 2 / L;
    Eigen::VectorXd shear(2 * n);
    shear << dP, -P;
    K += weight * kappa * G * A * shear * shear.transpose();
    K.bottomRightCorner(n, n) += weight * E * I * dP * dP.transpose();
    M.topLeftCorner(n, n) += weight * rho * A * P * P.transpose();
    M.bottomRightCorner(n, n) += weight * rho * I * P * P.transpose();
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(K, M);
  std::vector<double> out;
  for (int k = 2; k < 6; ++k) out.push_back(std::sqrt(modes.eigenvalues()(k)) / (2 * std::numbers::pi));
  return out;
}

// Bending of a free bar, from one element over its whole width on, against Timoshenko's theory, which is good to 0.3 % of
// the first modes of such a bar.
TEST_F(MeshVerdict, AccuracyChoosesMeshAndModes) {
  constexpr double kAsked = 0.03, kTheory = 0.003;
  const Reduced r = reduce(bar(), {"--mesh-size", "60 mm", "--accuracy", "3 %", "--modes", "8", "--set",
                                   "modes.compliance_accuracy=\"30 %\""});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_THAT(r.outcome.out, AllOf(HasSubstr("mesh 1: "), HasSubstr("mesh 2: ")));
  std::vector<double> truth;
  for (const auto& [b, h] : {std::pair{0.012, 0.008}, std::pair{0.008, 0.012}})
    for (const double hz : bending_hz(0.1, b, h, 2.1e11, 0.3, 7850)) truth.push_back(hz);
  std::sort(truth.begin(), truth.end());
  // Below the first torsion, 14 kHz.
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(hz(r, k) / truth[k], 1.0, kAsked + kTheory) << k;
}

// A mesh of 4 m for a bar of 0.1 m (a mistyped "4 mm"), or of linear tetrahedra: warned of with its reasons, not trusted,
// and a good file of before stays.
TEST_F(MeshVerdict, AMeshThatDoesNotResolveThePartNeverReplacesOneThatDoes) {
  const auto part = bar("[modes]\ncount = 2\n");
  const Reduced first = reduce(part, {"--mesh-size", "4", "--set", "mesh.order=1"});
  EXPECT_EQ(first.outcome.exit_code, 0) << first.outcome.err;
  EXPECT_THAT(first.outcome.err,
              AllOf(HasSubstr("does not resolve the part"), HasSubstr("larger than the part is thick"),
                    HasSubstr("of order 1"), HasSubstr("a single element through its thickness")));
  EXPECT_THAT(first.outcome.out, Not(HasSubstr("to be trusted")));
  const Reduced good = reduce(part, {"--mesh-size", "8 mm"});
  ASSERT_EQ(good.outcome.exit_code, 0) << good.outcome.err;
  EXPECT_THAT(good.outcome.err, Not(HasSubstr("thickness")));
  const std::string kept = read_text(output());
  const Outcome refused = reduce(part, {"--mesh-size", "4", "--set", "mesh.order=1"}).outcome;
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("is kept"));
  EXPECT_TRUE(read_text(output()) == kept);
}

// The same shaft by its ends (av) and by its seats (welle_seats): the estimate of the default mesh covers what a finer mesh
// changes, within the factor of two that it is worth, and no more is promised than it says.
TEST_F(MeshVerdict, AShaftWithSharpShouldersIsJudgedByItsMesh) {
  bring("stepped_shaft.step");
  bring("shaft_seats.toml");
  const Reduced coarse = reduce(folder_ / "shaft_seats.toml", {"--mesh-size", "20 mm"}),
                finer = reduce(folder_ / "shaft_seats.toml", {"--mesh-size", "9 mm"});
  ASSERT_EQ(coarse.outcome.exit_code, 0) << coarse.outcome.err;
  ASSERT_EQ(finer.outcome.exit_code, 0) << finer.outcome.err;
  for (std::size_t k = 0; k < 4; ++k) {
    const double moved = hz(coarse, k) / hz(finer, k) - 1.0;
    EXPECT_GT(moved, 0.0) << k;  // a finer mesh is softer
    EXPECT_LT(moved, 2.0 * error(coarse, k)) << k;
    EXPECT_LT(error(finer, k), error(coarse, k)) << k;
  }
  if (error(coarse, 0) > 0.01) {
    EXPECT_THAT(coarse.outcome.out, Not(HasSubstr("frequencies within 1 %")));
  }
}

// What is said of stress: bounded at ends that hold their mean motion, unbounded around one that is rigid; unknown where no
// stress modes are kept.  All of it stands in the superelement, with a picture of the error on its surface.
TEST_F(MeshVerdict, StressIsJudgedOrCalledUnboundedOrUnknown) {
  const std::string ends =
                        "tie = \"average\"\n[interface.end]\nby = \"plane\"\npoint = [4, 0, 0]\nnormal = [1, "
                        "0, 0]\ntie = \"average\"\n"
                        "[modes]\ncount = 8\n",
                    stress = "[recovery]\nstress = true\n";
  const Reduced mean = reduce(block(kHeld + ends + stress));
  ASSERT_EQ(mean.outcome.exit_code, 0) << mean.outcome.err;
  EXPECT_THAT(mean.outcome.out, AllOf(HasSubstr("stress, estimated: of the elements"),
                                      HasSubstr("; greatest stress"), Not(HasSubstr("no finite stress"))));
  const superelement::Superelement se =
      superelement::read(output(), {.surface = true, .stress = true, .mesh_error = true});
  ASSERT_TRUE(se.mesh_error);
  EXPECT_EQ(se.mesh_error->at_vertices.size(), se.surface.vertices.rows());
  ASSERT_EQ(se.mesh_error->modes.size(), mean.report["mesh_error"]["modes"].size());
  for (std::size_t k = 0; k < se.mesh_error->modes.size(); ++k) {
    const superelement::MeshError::Mode& mode = se.mesh_error->modes[k];
    EXPECT_NEAR(mode.frequency_hz, hz(mean, k), 1e-6 * hz(mean, k));
    EXPECT_NEAR(mode.error, std::min(error(mean, k), 1.0), 1e-9);
    EXPECT_FALSE(mode.stress.singular);
    // By energy: f_h / f = (1 - x)^(-1/2), stress x^(1/2).
    EXPECT_NEAR(mode.stress.mean, std::sqrt(1.0 - std::pow(1.0 + mode.error, -2.0)), 1e-6);
  }
  ASSERT_EQ(se.mesh_error->interfaces.size(), 2u);
  EXPECT_GE(se.mesh_error->interfaces[0].stress.peak, 0.0);
  const Outcome page = run("flexura", {"modes", output(), "--html", folder_ / "modes.html"});
  EXPECT_EQ(page.exit_code, 0) << page.err;
  EXPECT_THAT(read_text(folder_ / "modes.html"), HasSubstr("\"mesh_error\":true"));

  std::filesystem::remove(output());
  const Reduced rigid =
      reduce(block(replaced(kHeld + ends + stress, "tie = \"average\"\n[modes]", "[modes]")));
  ASSERT_EQ(rigid.outcome.exit_code, 0) << rigid.outcome.err;
  EXPECT_THAT(rigid.outcome.out,
              AllOf(HasSubstr("no finite stress exists"), HasSubstr("unbounded at (4000, ")));

  std::filesystem::remove(output());
  const Reduced none = reduce(block(kHeld + ends));
  EXPECT_THAT(none.outcome.out, Not(HasSubstr("greatest stress")));
  const auto unknown = superelement::read(output(), {.mesh_error = true}).mesh_error;
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->modes.front().stress.peak, -1.0);
  EXPECT_GT(unknown->modes.front().stress.mean, 0.0);
}

// A force on a point or along a line of an elastic body moves it without bound: its compliance is that of the mesh alone, and
// no accuracy is promised of it.
TEST_F(MeshVerdict, ComplianceOfAPointOrALineIsUnknown) {
  const std::string
      end = "[interface.end]\nby = \"plane\"\npoint = [4, 0, 0]\nnormal = [1, 0, 0]\n[modes]\ncount = 8\n",
      point =
          "[interface.tip]\nby = \"nodes\"\nnodes = [54]\ntie = \"node\"\ndirections = [\"x\", \"y\", "
          "\"z\"]\n",
      line =
          "[interface.tip]\nby = \"nodes\"\nnodes = [54, 36, 18]\ntie = \"average\"\ndirections = [\"x\", "
          "\"y\", \"z\"]\n";
  for (const std::string& tip : {point, line}) {
    std::filesystem::remove(output());  // a good file would be kept
    const Reduced r = reduce(block(tip + end));
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    EXPECT_THAT(r.outcome.out,
                AllOf(HasSubstr("static compliance: unknown"), Not(HasSubstr("static compliance within"))));
    for (const nlohmann::json& interface : r.report["mesh_error"]["interfaces"])
      EXPECT_TRUE(interface["compliance_error"].is_null());
    EXPECT_EQ(
        superelement::read(output(), {.mesh_error = true}).mesh_error->interfaces.at(0).compliance_error,
        -1.0);
  }
}

// What the reduction says of the mesh and of modes left out is what the runtime's commands and a run's error by source say: twice
// the error of a frequency, that of a compliance as it is, of deformation.
TEST_F(MeshVerdict, TheRuntimeSaysTheSameNumbers) {
  const Reduced r =
      reduce(block(kHeld + "tie = \"average\"\n[interface.end]\nby = \"plane\"\npoint = [4, 0, 0]\n"
                           "normal = [1, 0, 0]\ntie = \"average\"\n[modes]\ncount = 8\n"));
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  const nlohmann::json &by_mesh = r.report["mesh_error"], &left_out = r.report["estimate"];
  const auto answer = [&](const std::vector<std::string>& command) {
    const Outcome outcome = run("flexura", command);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  };
  const nlohmann::json modes = answer({"modes", output(), "--free", "--json"})["analyses"][0]["modes"];
  ASSERT_GE(modes.size(), 9u);
  for (std::size_t k = 0; k < 3; ++k) {  // of the block's pairs of modes the worse
    EXPECT_NEAR(modes[6 + k]["mesh_error"], error(r, k), 1e-8);
    EXPECT_NEAR(modes[6 + k]["left_out_error"], left_out[k]["frequency_error"].get<double>(), 1e-8);
  }
  EXPECT_FALSE(modes[0].contains("mesh_error"));  // of a rigid motion there is none
  const nlohmann::json first = answer({"check", output(), "--json"})["first_free_frequency_error"];
  EXPECT_EQ(first["mesh"], modes[6]["mesh_error"]);
  EXPECT_EQ(first["left_out"], modes[6]["left_out_error"]);

  folder_.write("run.toml", R"(name = "run"
[ground.marker.wall]
[body.block]
superelement = "part.se.h5"
[joint.held]
type = "fixed"
from = "ground.wall"
to = "block.left"
[solver]
end_time = 0.001
)");
  const nlohmann::json estimate = answer({"simulate", folder_ / "run.toml", "-o", folder_ / "run.h5",
                                          "--json"})["runs"][0]["summary"]["estimate"];
  const double compliance = by_mesh["interfaces"][0]["compliance_error"];
  EXPECT_NEAR(estimate["mesh"]["block"],
              std::max(2.0 * error(r, 0), compliance) + 2.0 * left_out[0]["frequency_error"].get<double>(),
              1e-9);
}

// Shells are not judged: unknown, in each place, never 0.
TEST_F(MeshVerdict, TheRuntimeSaysUnknownOfWhatWasNotJudged) {
  const auto part = folder_.write("shell.toml", "[geometry]\nfile = \"shell.inp\"\n" + kShellHeld);
  folder_.write("shell.inp", kShell);
  ASSERT_EQ(reduce(part).outcome.exit_code, 0);
  const Outcome modes = run("flexura", {"modes", output(), "--free"});
  EXPECT_THAT(modes.out, AllOf(HasSubstr("unknown"), HasSubstr("What the mesh costs is unknown")));
  EXPECT_THAT(run("flexura", {"check", output()}).out,
              testing::ContainsRegex("its error by the mesh +unknown"));
  const auto json = nlohmann::json::parse(run("flexura", {"modes", output(), "--free", "--json"}).out);
  EXPECT_TRUE(json["analyses"][0]["modes"][6]["mesh_error"].is_null());
}

TEST_F(MeshVerdict, AccuracyOfAGivenMeshIsReported) {
  const Reduced r = reduce(block(kHeld), {"--accuracy", "1 %"});
  // A deck's mesh stays as it is: its share is said.
  EXPECT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_THAT(r.outcome.err, HasSubstr("comes with the part and cannot be made finer"));
}

// What is asked for and cannot be judged is refused, and nothing is written.
TEST_F(MeshVerdict, AccuracyThatCannotBeJudgedIsRefused) {
  folder_.write("shell.inp", kShell);
  const auto part = folder_.write("shell.toml", "[geometry]\nfile = \"shell.inp\"\n" + kShellHeld);
  const Outcome plain = reduce(part).outcome;
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_THAT(plain.out, AllOf(HasSubstr("mesh error: unknown"), Not(HasSubstr("to be trusted"))));
  std::filesystem::remove(output());
  const Outcome refused = reduce(part, {"--accuracy", "1 %"}).outcome;
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("cannot be judged"), HasSubstr("shells or beams")));
  EXPECT_FALSE(std::filesystem::exists(output()));
}

// Young's modulus without its unit; Poisson's ratio of an incompressible material is another matter.
TEST_F(MeshVerdict, ModuliThatNoMaterialHasAreWarnedOf) {
  const Reduced r = reduce(bar("[modes]\ncount = 2\n", "210"), {"--mesh-size", "20 mm"});
  EXPECT_THAT(r.outcome.err, HasSubstr("as no material has"));
  std::filesystem::remove(output());  // a good file would be kept
  const Reduced incompressible = reduce(block(kHeld + "[modes]\ncount = 4\n", "0.4999999"));
  ASSERT_EQ(incompressible.outcome.exit_code, 0) << incompressible.outcome.err;
  EXPECT_THAT(incompressible.outcome.err,
              AllOf(HasSubstr("nearly incompressible"), HasSubstr("0.49 "), Not(HasSubstr("unit"))));
  EXPECT_THAT(incompressible.outcome.out,
              AllOf(HasSubstr("mesh error: unknown"), Not(HasSubstr("to be trusted"))));
  // The residual of its modes is round-off by the bulk modulus, no fault of theirs.
  for (const nlohmann::json& check : incompressible.report["acceptance"]["checks"]) {
    if (check["check"] == "greatest residual of a mode")
      EXPECT_TRUE(check["passed"].get<bool>()) << check.dump();
  }
  const Outcome promised =
      reduce(block(kHeld + "[modes]\ncount = 4\n", "0.4999999"), {"--accuracy", "1 %"}).outcome;
  EXPECT_EQ(promised.exit_code, 1);
  EXPECT_THAT(promised.err, HasSubstr("nearly incompressible"));
}

// Nodes on a line hold no rotation about it: refused where it is asked for, else their mean displacement.
TEST_F(MeshVerdict, NodesOnALineHoldTheirMeanDisplacement) {
  const std::string
      line = "[interface.line]\nby = \"nodes\"\nnodes = [54, 36, 18]\n",
      end = "[interface.end]\nby = \"plane\"\npoint = [4, 0, 0]\nnormal = [1, 0, 0]\n[modes]\ncount = 4\n";
  const Outcome refused = reduce(block(line + end)).outcome;
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err,
              AllOf(HasSubstr("a rotation about the axis (1, 0, 0)"), HasSubstr("tie = \"average\"")));
  for (const char* directions : {"[\"x\", \"y\", \"z\"]", "[\"x\", \"y\", \"z\", \"ry\", \"rz\"]"}) {
    std::filesystem::remove(output());  // a good file would be kept
    const Reduced r = reduce(block(line + "tie = \"average\"\ndirections = " + directions + "\n" + end),
                             {"--compare", "2"});
    ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
    EXPECT_THAT(r.outcome.out, HasSubstr("interface line: 3 nodes, average"));
    const std::vector<double> full = r.report["comparison"]["full_hz"],
                              reduced = r.report["comparison"]["reduced_hz"];
    for (std::size_t k = 0; k < full.size(); ++k) EXPECT_GE(reduced[k], full[k] * (1.0 - 1e-9)) << k;
  }
}

}  // namespace
}  // namespace flexura::test
