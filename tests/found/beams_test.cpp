// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Beams of absolute nodal coordinates and of segments.
namespace flexura::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

double last_of(const std::string& file, const std::string& quantity) {
  const results::Run run = results::read(file).runs.at(0);
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name == quantity)
      return run.values(run.time.size() - 1, static_cast<Eigen::Index>(i));
  throw std::logic_error("no quantity " + quantity);
}

// A cantilever of 1 m with E I = 10 N m^2 and a load of 0.1 N at its tip. A marker there with an arm of 0.9 m back towards the
// root goes along with the tip: w = P l^3 / 3 E I - 0.9 m P l^2 / 2 E I; in segments it stood on the piece that was nearest
// to it, whatever it was said to be on.
TEST(Beams, WhatIsSaidToBeOnTheTipGoesAlongWithTheTip) {
  const Folder folder;
  for (const std::string fidelity : {"beam", "rod", "ancf", "segments"}) {
    const std::string file = folder
                                 .write("cantilever.toml", R"(
gravity = [0, 0, 0]
[solver]
method = "quasi_statics"
end_time = 1
output_step = 1
[ground]
[body.b]
fidelity = ")" + fidelity + R"("
beam = {to = [1, 0, 0], elements = 6, EA = 1e6, GA_y = 1e6, GA_z = 1e6, GI_t = 10, EI_y = 10, EI_z = 10, mass_per_length = 1, rho_I_y = 1e-4, rho_I_z = 1e-4}
[body.b.marker.arm]
on = "tip"
position = [0.1, 0, 0]
[joint.j]
type = "fixed"
from = "ground"
to = "b.root"
[force.f]
type = "force"
marker = "b.tip"
z = 0.1
[measure.tip]
type = "position"
from = "ground"
to = "b.tip"
direction = [0, 0, 1]
[measure.arm]
type = "position"
from = "ground"
to = "b.arm"
direction = [0, 0, 1]
)")
                                 .string();
    const std::string rows = (folder / "rows.h5");
    const Outcome outcome = run("flexura", {"simulate", file, "-o", rows, "--no-estimate"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    // Shear adds P l / G A = 1e-7, bending is linear to (w / l)^2 = 1e-5 of itself; n elements of absolute nodal coordinates
    // are 1 / 4 n^2 too stiff, 0.7 % of either part.
    const double error = fidelity == "ancf" ? 4e-5 : 5e-7;
    EXPECT_NEAR(last_of(rows, "tip"), 0.1 / 30.0, error) << fidelity;
    EXPECT_NEAR(last_of(rows, "arm"), 0.1 / 30.0 - 0.9 * 0.1 / 20.0, error) << fidelity;
  }
}

// A free beam of 2 kg/m and 1 m thrown at 3 m/s while it turns at 2 rad/s about z: without gravity its centre goes on as it
// began, whatever the beam is made of. Its root goes the way of a rigid body's but for the stretch by the turning,
// rho A w^2 l^3 / E A = 8e-6 m.
TEST(Beams, AFreeOneIsThrown) {
  const Folder folder;
  for (const std::string fidelity : {"rigid", "ancf", "segments"}) {
    const std::string file = folder
                                 .write("thrown.toml", R"(
gravity = [0, 0, 0]
[solver]
end_time = 0.1
output_step = 0.1
[ground]
[body.b]
fidelity = ")" + fidelity + R"("
velocity = [3, -1, 0]
angular_velocity = [0, 0, 2]
beam = {to = [1, 0, 0], elements = 4, EA = 1e6, GA_y = 1e6, GA_z = 1e6, GI_t = 1e3, EI_y = 1e3, EI_z = 1e3, mass_per_length = 2, rho_I_y = 1e-3, rho_I_z = 1e-3}
[measure.x]
type = "position"
from = "ground"
to = "b.root"
direction = [1, 0, 0]
[measure.y]
type = "position"
from = "ground"
to = "b.root"
direction = [0, 1, 0]
)")
                                 .string();
    const std::string rows = (folder / "rows.h5");
    const Outcome outcome = run("flexura", {"simulate", file, "-o", rows, "--no-estimate"});
    ASSERT_EQ(outcome.exit_code, 0) << fidelity << outcome.err;
    // The origin of the body moves with (3, -1), its centre at 0.5 m with (3, -1) + 2 x 0.5 = (3, 0).
    EXPECT_NEAR(last_of(rows, "x"), 3 * 0.1 + 0.5 - 0.5 * std::cos(0.2), 5e-5) << fidelity;
    EXPECT_NEAR(last_of(rows, "y"), -0.5 * std::sin(0.2), 5e-5) << fidelity;
  }
}

// A beam in segments held at its tip by a slider that its place fits only roughly: the pieces start as made, and the slider's
// place follows. Started from where each was said to be, they held a deformation that no motion of the joints could close.
TEST(Beams, HeldAtItsTipStartsAsMade) {
  const Folder folder;
  const std::string file = folder
                               .write("slider.toml", R"(
gravity = [0, 0, 0]
[solver]
end_time = 0.01
output_step = 0.01
[ground.marker.rail]
position = [1, 0, 0]
axis = [1, 0, 0]
[body.b]
fidelity = "segments"
position = [0.01, 0.02, 0.03]
rotation = ["2 deg", "-1 deg", "3 deg"]
beam = {to = [1, 0, 0], elements = 3, EA = 1e6, GA_y = 1e6, GA_z = 1e6, GI_t = 1e3, EI_y = 1e3, EI_z = 1e3, mass_per_length = 2, rho_I_y = 1e-3, rho_I_z = 1e-3}
[body.b.marker.end]
on = "tip"
axis = [1, 0, 0]
[joint.slide]
type = "prismatic"
from = "ground.rail"
to = "b.end"
[measure.root]
type = "distance"
from = "b.root"
to = "b.end"
)")
                               .string();
  const std::string rows = (folder / "rows.h5");
  const Outcome outcome = run("flexura", {"simulate", file, "-o", rows, "--no-estimate"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(last_of(rows, "root"), 1.0, 1e-12);
}

// What elements of a beam err by no run judges: a study says "at least" of its estimate, and holds it against no error (it
// stood there as 1.4e-5 % of a true 1.35 %).
TEST(Beams, AStudySaysWhatItsRunsCouldNotJudge) {
  const Folder folder;
  folder.write("cantilever.toml", R"(
gravity = [0, 0, -9.81]
[solver]
end_time = 0.1
output_step = 0.01
[ground]
[body.b]
fidelity = "segments"
beam = {to = [1, 0, 0], elements = 2, EA = 1e6, GA_y = 1e6, GA_z = 1e6, GI_t = 10, EI_y = 10, EI_z = 10, mass_per_length = 0.5, rho_I_y = 1e-4, rho_I_z = 1e-4, damping_time = 1e-3}
[joint.j]
type = "fixed"
from = "ground"
to = "b.root"
[measure.tip]
type = "position"
from = "ground"
to = "b.tip"
direction = [0, 0, 1]
)");
  const std::string study = folder
                                .write("study.toml", R"(
mechanism = "cantilever.toml"
repeats = 1
[axis.elements.choice.two]
set = ["body.b.beam.elements=2"]
[axis.elements.choice.four]
set = ["body.b.beam.elements=4"]
[quantity.tip]
of = "tip"
)")
                                .string();
  const Outcome outcome = run("flexura", {"study", study});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr(">= "));
  EXPECT_THAT(outcome.out, Not(HasSubstr("over the true one")));
}

// A wire of 6 mm, tightened to 5 kN over 10 m, starts as its weight w hangs in it: half of that at each end, and a tension that
// the sag's stretch, w^2 L^2 / 24 T^2, adds to. Its bending alone would let it sag by 4 m, where "the mass matrix is not
// positive definite" was all that was said.
TEST(Beams, ATightWireStartsQuasiStatically) {
  const Folder folder;
  folder.write("wire.toml", R"(
stiffening = true
[material.s]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"
[section.r]
type = "circle"
diameter = "6 mm"
[node.a]
position = [0, 0, 0]
[node.b]
position = ["10 m", 0, 0]
[member.w]
nodes = ["a", "b"]
elements = 40
theory = "euler_bernoulli"
[interface.a]
[interface.b]
[load.pre]
member = "w"
preload = "5 kN"
[modes]
count = 20
)");
  ASSERT_EQ(run("flexura-reduce", {folder / "wire.toml"}).exit_code, 0);
  const std::string file = folder
                               .write("tight.toml", R"(
gravity = [0, 0, -9.81]
[ground.marker.b]
position = ["10 m", 0, 0]
[body.w]
superelement = "wire.se.h5"
fidelity = "modal-stiffened"
damping = 0
frame = "joints"
[joint.a]
type = "fixed"
from = "ground"
to = "w.a"
[joint.b]
type = "fixed"
from = "ground.b"
to = "w.b"
[force.pre]
type = "distributed_load"
body = "w"
load = "pre"
[solver]
initial_deformation = "quasi_static"
end_time = 0.01
output_step = 0.01
[output]
quantities = ["a.force_?"]
)")
                               .string();
  const std::string rows = (folder / "rows.h5");
  const Outcome outcome = run("flexura", {"simulate", file, "-o", rows, "--no-estimate"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const double A = 3.14159265 / 4 * 36e-6, w = 7850 * A * 9.81, T = 5000,
               stretched = 210e9 * A * w * w * 100 / (24 * T * T);
  EXPECT_NEAR(std::abs(last_of(rows, "a.force_z")), 5 * w, 1e-3 * w);
  // The clamped ends take sqrt(EI / T) = 52 mm of it each, 5 % of the stretch; 20 modes another 4 %.
  EXPECT_NEAR(std::abs(last_of(rows, "a.force_x")), T + stretched, 0.12 * stretched);
}

// A rope without bending stiffness below a jib carries 3 t: it starts stretched by (m + m_rope / 2) g L / EA (NaN before).
TEST(Beams, ARopeStartsStretchedByItsLoad) {
  const Folder folder;
  const std::string file = folder
                               .write("rope.toml", R"(
[ground]
[body.jib]
mass = 1000
inertia = [10, 1000, 1000]
[body.jib.marker.trolley]
position = [30, 0, 0]
[body.rope]
fidelity = "cable"
position = [30, 0, 0]
[body.rope.beam]
to = [0, 0, -20]
elements = 8
EA = 2e7
mass_per_length = 5
[body.load]
mass = 3000
inertia = [1000, 1000, 1000]
position = [30, 0, -20]
[joint.slew]
type = "revolute"
from = "ground"
to = "jib"
drive = "0"
[joint.hang]
type = "spherical"
from = "jib.trolley"
to = "rope.root"
[joint.hook]
type = "spherical"
from = "rope.tip"
to = "load"
[measure.z]
type = "position"
from = "jib.trolley"
to = "load"
direction = [0, 0, 1]
[solver]
initial_deformation = "quasi_static"
end_time = 0.1
output_step = 0.1
)")
                               .string();
  const std::string rows = (folder / "rows.h5");
  const Outcome outcome = run("flexura", {"simulate", file, "-o", rows, "--no-estimate"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(last_of(rows, "z"), -20.0 - (3000.0 + 50.0) * 9.81 * 20.0 / 2e7, 1e-6);
}

}  // namespace
}  // namespace flexura::test
