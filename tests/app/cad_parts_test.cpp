// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Real CAD parts, reduced as they come: interfaces as --list-faces prints them, no mesh options at all.  One of
// the larger ones takes a coarser mesh here; they come as they are in the slow tests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

struct CadPart {
  const char* name;
  const char* cad;           ///< the CAD file
  double volume, density;    ///< [m^3] of the CAD kernel (cases/cad_parts/occ_mass_properties.txt), [kg/m^3]
  Eigen::Vector3d centroid;  ///< [m], the same
  /// As --list-faces prints what the part file's interfaces name.
  std::vector<std::string> listed;
  const char* mesh_size = "";  ///< "" as it comes
};

CadPart coarser(CadPart part, const char* mesh_size) {
  part.mesh_size = mesh_size;
  return part;
}

void PrintTo(const CadPart& part, std::ostream* out) {
  *out << part.name;
}

class CadParts : public ::testing::TestWithParam<CadPart> {};

TEST_P(CadParts, ReduceWithInterfacesTakenFromTheListOfFaces) {
  const CadPart& part = GetParam();
  const std::string folder = std::string(FLEXURA_SOURCE_DIR) + "/cases/cad_parts/";
  const Outcome faces = run("flexura", {"reduce", "--list-faces", folder + part.cad});
  ASSERT_EQ(faces.exit_code, 0) << faces.err;
  for (const std::string& face : part.listed) EXPECT_THAT(faces.out, ::testing::HasSubstr(face));

  const Folder scratch;
  const std::string output = scratch / "part.se.h5";
  std::vector<std::string> words = {"reduce", folder + part.name + ".toml", "-o", output, "--modes", "4"};
  if (*part.mesh_size != 0) words.insert(words.end(), {"--mesh-size", part.mesh_size});
  const Outcome reduced = run("flexura", words);
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  const superelement::Superelement se = superelement::read(output);
  EXPECT_EQ(se.interfaces.size(), part.listed.size());
  // The tolerance: mass and centre against the CAD volume to 0.5 %, the centre in terms of the part's
  // size.
  EXPECT_NEAR(se.inertia.mass / (part.density * part.volume), 1.0, 0.005);
  EXPECT_LT((se.inertia.S_x / se.inertia.mass - part.centroid).norm(), 0.005 * std::cbrt(part.volume));
  // Held nowhere it has six motions without strain, each interface turning and moving alike, and no seventh.
  Eigen::VectorXd scale = se.K_se.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd K = scale.asDiagonal() * se.K_se * scale.asDiagonal();
  const Eigen::VectorXd lambda =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K, Eigen::EigenvaluesOnly).eigenvalues();
  // Rigid motions are strain-free to the round-off of the static solve, 1e-9 of the unit diagonal.
  EXPECT_LT(std::abs(lambda[5]), 1e-9);
  EXPECT_GT(lambda[6], 1e3 * std::abs(lambda[5]));
}

const CadPart kHip = {"hip",
                      "odri_hip_aa_support.step",
                      17413.813660e-9,
                      1010.0,
                      {-27.130885e-3, 0.000003e-3, 4.503852e-3},
                      {"radius 12.5 mm, length 4 mm, 180 deg, axis (0, 0, 1) through (0, 0, -2) mm",
                       "radius 1.5 mm, length 4 mm, 180 deg, axis (0, 0, 1) through (-42.5, 15, 21.1) mm",
                       "radius 1.5 mm, length 4 mm, 180 deg, axis (0, 0, 1) through (-42.5, -15, 21.1) mm"}};
const CadPart kFork = {
    "fork",
    "odri_lower_leg_structure_fork.step",
    4184.052643e-9,
    1010.0,
    {-6.596878e-3, 0.000001e-3, -141.168833e-3},
    {"radius 2.4 mm, length 2.2 mm, 180 deg, axis (1, 0, 0) through (-3.1, 0, -114) mm",
     "radius 2.4 mm, length 6.16048 mm, 132 deg, axis (1, 0, 0) through (-5.08, 0, -132) mm"}};
const CadPart kBase = {"base",
                       "odri_lower_leg_structure_base.step",
                       17365.864404e-9,
                       1010.0,
                       {2.817701e-3, 0.0, -67.405908e-3},
                       {"radius 1.55 mm, length 6 mm, 180 deg, axis (1, 0, 0) through (6, 8, 0) mm",
                        "radius 1.55 mm, length 6 mm, 180 deg, axis (1, 0, 0) through (6, -8, 0) mm",
                        "radius 4 mm, length 6.5 mm, 128 deg, axis (1, 0, 0) through (8.75, 0, -160) mm"}};
const CadPart kShaft = {
    "shaft",
    "odri_motor_antigravity_4004_custom_shaft.step",
    413.399134e-9,
    7850.0,
    {0.0, 0.0, -16.582935e-3},
    {"plane, normal (0, 0, 1) at (0, 0, 0) mm", "plane, normal (0, 0, -1) at (0, 0, -33.4) mm"}};
const CadPart kBracket = {"bracket",
                          "chrono_assembly.stp",
                          518383.678623e-9,
                          7850.0,
                          {0.0, 20.0e-3, 58.106066e-3},
                          {"radius 20 mm, length 36 mm, 360 deg, axis (0, 1, 0) through (0, 20, 120) mm",
                           "radius 5 mm, length 10 mm, 360 deg, axis (0, 0, 1) through (-77.212, 20, 5) mm",
                           "radius 5 mm, length 10 mm, 360 deg, axis (0, 0, 1) through (77.212, 20, 5) mm"}};

const auto kNamed = [](const auto& info) { return std::string(info.param.name); };
INSTANTIATE_TEST_SUITE_P(Quick, CadParts, ::testing::Values(coarser(kHip, "8 mm"), kShaft, kBracket), kNamed);
INSTANTIATE_TEST_SUITE_P(DISABLED_Long, CadParts, ::testing::Values(kHip, kFork, kBase), kNamed);

}  // namespace
}  // namespace flexura::test
