// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "mbs/file/fidelities.hpp"
#include "mbs/joints/fixed.hpp"
#include "mbs/joints/prismatic.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/measures/relative_measure.hpp"
#include "mbs/study/library/run.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/superelement/box_beam.hpp"
#include "tests/mbs/test_folder.hpp"

/// Mechanisms made in C++ run as those of files do, with any model of their parts and within an accuracy: the same choice, rows
/// and errors.
namespace flexura::study {
namespace {

using mbs::MechanismBuilder;
using ::testing::Contains;
using ::testing::HasSubstr;

using PartsInPrograms = mbs::test::TestFolder;

mbs::BeamPart strip(double length) {
  mbs::BeamPart part;
  part.to_B = mbs::Vector3d(length, 0, 0);
  part.C = mbs::Vector6d(1e6, 4e5, 4e5, 0.8, 1.5, 6.0).asDiagonal();
  part.mass_per_length = 0.2;
  part.rho_I_y = part.rho_I_z = 1e-6;
  part.damping_time = 1e-4;
  part.elements = 2;
  return part;
}

// A strip on a slide that is driven, in the words of a file and in C++.
std::string shaken_file(double length, double f, const std::string& body) {
  return fmt::format(R"toml(gravity = [0, 0, -9.81]
[ground.marker.rail]
axis = [0, 0, 1]
[body.slide]
mass = 1
inertia = [1e-3, 1e-3, 1e-3]
marker.rail = {{axis = [0, 0, 1]}}
[body.strip]
{}
[joint.rail]
type = "prismatic"
from = "ground.rail"
to = "slide.rail"
drive = "1e-4*sin(2*pi*{}*t)"
[joint.clamp]
type = "fixed"
from = "slide"
to = "strip.{}"
[measure.tip]
type = "position"
from = "ground"
to = "strip.{}"
direction = [0, 0, 1]
[output]
quantities = ["tip", "rail.drive_force"]
[solver]
end_time = 0.1
tolerance = 1e-5
output_step = 0.0025
)toml",
                     body, f, length > 0.0 ? "root" : "left", length > 0.0 ? "tip" : "right");
}

std::string strip_table(double length, const std::string& model) {
  return fmt::format(R"toml({}
[body.strip.beam]
to = [{}, 0, 0]
EA = 1e6
GA_y = 4e5
GA_z = 4e5
GI_t = 0.8
EI_y = 1.5
EI_z = 6.0
mass_per_length = 0.2
rho_I_y = 1e-6
rho_I_z = 1e-6
damping_time = "0.1 ms"
elements = 2
)toml",
                     model, length);
}

template <class Part>
void build_shaken(MechanismBuilder& b, const Part& part, double f, const char* root, const char* tip) {
  b.gravity({0, 0, -9.81});
  auto slide = b.add("slide", mbs::RigidBody{.mass = 1.0, .inertia = 1e-3 * mbs::Matrix3d::Identity()});
  auto strip = b.add("strip", part);
  b.add<mbs::Prismatic>("rail", b.ground().marker(), slide.marker())
      .drive(fmt::format("1e-4*sin(2*pi*{}*t)", f));
  b.add<mbs::Fixed>("clamp", slide.marker(), strip.marker(root));
  b.add<mbs::RelativeMeasure>("tip", b.ground().marker(), strip.marker(tip),
                              mbs::RelativeQuantity::position(), mbs::Vector3d(0, 0, 1));
}

const mbs::RunSettings kSettings = {
    .end_time = 0.1, .output_step = 0.0025, .tolerance = 1e-5, .outputs = {"tip", "rail.drive_force"}};

void expect_same(const Answer& a, const Answer& b) {
  ASSERT_TRUE(a.result.complete) << a.result.stopped_because;
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (const char* const y : {"tip", "rail.drive_force"}) {
    const Eigen::VectorXd v = a.values(y), w = b.values(y);
    // Steps may differ by the round-off of what was read: within a tenth of the tolerance.
    EXPECT_LT((v - w).norm(), 1e-6 * w.norm()) << y;
  }
  EXPECT_NEAR(a.ledger.at_least, b.ledger.at_least, 0.01 * b.ledger.at_least + 1e-12);
  EXPECT_EQ(a.ledger.is_whole, b.ledger.is_whole);
}

TEST_F(PartsInPrograms, HaveEveryFidelityThatFilesHave) {
  int tried = 0;
  for (const mbs::Fidelity& fidelity : mbs::fidelities()) {
    // One-way bodies give the joints nothing to feel, and segments have springs between bodies.
    if (fidelity.name == "segments") continue;
    SCOPED_TRACE(fidelity.name);
    const auto of =
        file(shaken_file(0.6, 7.0, strip_table(0.6, fmt::format("fidelity = \"{}\"", fidelity.name))));
    MechanismBuilder b;
    build_shaken(b, mbs::Beam{strip(0.6), {.fidelity = fidelity.name}}, 7.0, "root", "tip");
    expect_same(run(b, kSettings), run(mbs::prepare(of)));
    ++tried;
  }
  EXPECT_GE(tried, 9);
}

TEST_F(PartsInPrograms, AreChosenForAnAccuracyAsInFiles) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (int k = 0; k < 6; ++k) {
    const double f = 2.0 + 20.0 * any(engine), length = 0.3 + 0.5 * any(engine),
                 accuracy = k % 2 ? 0.1 : 0.01;
    SCOPED_TRACE(fmt::format("{} Hz, {} m, {}", f, length, accuracy));
    const auto of = file(shaken_file(length, f, strip_table(length, "fidelity = \"auto\"")));
    MechanismBuilder b;
    build_shaken(b, mbs::Beam{strip(length), {.fidelity = "auto"}}, f, "root", "tip");
    mbs::RunSettings settings = kSettings;
    settings.accuracy = accuracy;
    const Answer a = run(b, settings),
                 of_file = run(mbs::prepare(of, {fmt::format("solver.accuracy={}", accuracy)}));
    EXPECT_EQ(mbs::words_of(a.choice), mbs::words_of(of_file.choice));
    EXPECT_EQ(a.reasons, of_file.reasons);
    expect_same(a, of_file);
    EXPECT_LT(a.ledger.at_least, accuracy);
    EXPECT_TRUE(a.missed.empty()) << a.missed;
  }
}

TEST_F(PartsInPrograms, ComeFromSuperelements) {
  superelement::write(folder_ / "bar.se.h5", superelement::testing::make_box_beam());
  const auto of = file(shaken_file(0.0, 30.0, "superelement = \"bar.se.h5\""));
  MechanismBuilder b;
  build_shaken(b, mbs::Part{folder_ / "bar.se.h5"}, 30.0, "left", "right");
  mbs::RunSettings settings = kSettings;
  settings.accuracy = 0.02;
  const Answer a = run(b, settings), of_file = run(mbs::prepare(of, {"solver.accuracy=0.02"}));
  EXPECT_EQ(mbs::words_of(a.choice), mbs::words_of(of_file.choice));
  expect_same(a, of_file);
  EXPECT_THAT(a.reasons, Contains(HasSubstr("strip: ")));
  // Without an accuracy it is modal.
  EXPECT_TRUE(b.build().deforming(2));
  const Answer plain = run(b, kSettings);
  EXPECT_EQ(plain.prepared.mechanism->deforming(2)->m(),
            a.prepared.mechanism->description().bodies[2].is_reduced()
                ? superelement::testing::make_box_beam().n() - 6
                : 0);
}

TEST_F(PartsInPrograms, RefuseWhatTheyAreNot) {
  MechanismBuilder b;
  build_shaken(b, mbs::Beam{strip(0.6)}, 7.0, "root", "tip");
  EXPECT_THROW(b.add("more", mbs::Part{"/nowhere/rod.se.h5"}), std::runtime_error);
  EXPECT_THROW(run(b, {.end_time = -1.0}), std::invalid_argument);
  MechanismBuilder other;
  superelement::write(folder_ / "bar.se.h5", superelement::testing::make_box_beam());
  build_shaken(other, mbs::Part{folder_ / "bar.se.h5", {.fidelity = "cable"}}, 7.0, "left", "right");
  EXPECT_THROW(run(other, kSettings), std::invalid_argument);
}

}  // namespace
}  // namespace flexura::study
