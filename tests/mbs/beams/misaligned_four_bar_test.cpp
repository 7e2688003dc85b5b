// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "tests/mbs/cases/text_case.hpp"

/// The four-bar with a misaligned hinge (O. A. Bauchau, P. Betsch, A. Cardona, J. Gerstmayr, B. Jonker, P. Masarati, V. Sonneville,
/// Multibody Syst. Dyn. 37 (2016) 29, who print curves and no digits): the bars' data are theirs.  The hinge at C leans by 5 degrees, so
/// that rigid bars could not move; a drive at A turns at 0.6 rad/s from one moment to the next.  Where all bars are in line, at
/// pi/2 / 0.6 = 2.618 s, the hinge takes its greatest force, and the loop turns back.
///
/// Undamped, the bars answer the sudden start by waves of micrometres at tens of kilohertz, which an error control that
/// compares them with what has moved so far follows with steps of a microsecond.  Steps of a length of their own with numerical
/// damping go over them, as the authors' do, and so do steps of any size after a start in equilibrium.
/// The authors' 12 s take 3,000 such steps; here they end at 2.7 s.
namespace flexura::mbs::beams {
namespace {

std::string bar(const std::string& name, const std::string& from, const std::string& to, int elements,
                bool is_thin) {
  return fmt::format(
      "[body.{0}]\nfidelity = \"beam\"\n[body.{0}.beam]\nfrom = {1}\nto = {2}\ny_axis = [-1, 1, 0]\nelements "
      "= {3}\n{4}",
      name, from, to, elements,
      is_thin ? "EA = 13.25e6\nGA_y = 4.22e6\nGA_z = 4.22e6\nGI_t = 45.84\nEI_y = 70.66\nEI_z = 70.66\n"
                "mass_per_length = 0.4992\nrho_I_y = 2.662e-6\nrho_I_z = 2.662e-6\n"
              : "EA = 52.99e6\nGA_y = 16.88e6\nGA_z = 16.88e6\nGI_t = 733.5\nEI_y = 1131\nEI_z = 1131\n"
                "mass_per_length = 1.997\nrho_I_y = 42.6e-6\nrho_I_z = 42.6e-6\n");
}

class MisalignedFourBar : public cases::TextCase {
 protected:
  /// Out of the plane at C [m], force through C [N], angle of the hinge at D [rad].
  cases::Series moves(const std::string& solver, int elements = 4) const {
    const PreparedMechanism p =
        prepared("gravity = [0, 0, 0]\n" + bar("ab", "[0, 0, 0]", "[0, 0.12, 0]", elements, false) +
                 bar("bc", "[0, 0.12, 0]", "[0.24, 0.12, 0]", elements, false) +
                 bar("cd", "[0.24, 0.12, 0]", "[0.24, 0, 0]", elements, true) + R"toml(
[ground.marker.d]
position = [0.24, 0, 0]
[body.bc.marker.c]
on = "tip"
axis = [0.08715574274765817, 0, 0.9961946980917455]
[body.cd.marker.c]
on = "root"
axis = [0.08715574274765817, 0, 0.9961946980917455]
[joint.a]
type = "revolute"
from = "ground"
to = "ab.root"
drive = "-0.6*t"
[joint.b]
type = "revolute"
from = "ab.tip"
to = "bc.root"
[joint.c]
type = "revolute"
from = "bc.c"
to = "cd.c"
[joint.d]
type = "revolute"
from = "ground.d"
to = "cd.tip"
[measure.across]
type = "position"
from = "ground"
to = "bc.tip"
direction = [0, 0, 1]
[solver]
)toml" + solver);
    return cases::simulate(p, {"across", "c.force", "d.angle"});
  }
};

const std::string kSudden =
    "method = \"generalised_alpha\"\nrho_inf = 0\nfixed_step = 4e-3\noutput_step = 0.02\n";

// At 0.6 rad/s inertia does nothing until the bars are in line: equilibria at each time are another way to the same motion.
TEST_F(MisalignedFourBar, FinishesFromItsSuddenStart) {
  const auto sudden = moves(kSudden + "end_time = 2.5"),
             still = moves("method = \"quasi_statics\"\noutput_step = 0.05\nend_time = 2.5"),
             finer = moves("method = \"quasi_statics\"\noutput_step = 0.1\nend_time = 1", 8);
  for (const double t : {1.0, 2.0, 2.5}) {
    SCOPED_TRACE(t);
    const Eigen::VectorXd &now = sudden.at(t), &held = still.at(t);
    EXPECT_NEAR(now(0), held(0), 2e-5 * std::abs(held(0)));  // measured: 1e-5 at 2.5 s
    EXPECT_NEAR(now(1), held(1), 5e-4 * held(1));            // what rings, and decays by the method
    EXPECT_NEAR(now(2), held(2), 2e-6);
  }
  // What four elements leave: eight differ from them by less.
  const Eigen::VectorXd &held = still.at(1.0), &fine = finer.at(1.0);
  EXPECT_NEAR(held(0), fine(0), 1e-4 * std::abs(fine(0)));
  EXPECT_NEAR(held(1), fine(1), 1e-3 * fine(1));
}

// Through the line: order 2 at a fixed step beside order 5 at a tolerance, which starts in equilibrium.
TEST_F(MisalignedFourBar, TurnsBackWhereItsBarsAreInLine) {
  const auto
      fixed = moves(kSudden + "end_time = 2.68"),
      controlled = moves(
          "initial_deformation = \"quasi_static\"\ntolerance = 1e-3\noutput_step = 0.02\nend_time = 2.68");
  for (const double t : {2.58, 2.6, 2.62, 2.64, 2.66}) {
    SCOPED_TRACE(t);
    const Eigen::VectorXd &ours = fixed.at(t), &other = controlled.at(t);
    EXPECT_NEAR(ours(0), other(0), 2e-3 * std::abs(other(0)));
    EXPECT_NEAR(ours(1), other(1),
                0.02 * 5500.0);  // of its peak: measured 60 N, of second order in the fixed step
    EXPECT_NEAR(ours(2), other(2), 2e-3);
  }
  EXPECT_GT(controlled.at(2.62)(1), 5300.0);
  EXPECT_LT(controlled.at(2.58)(2), controlled.at(2.66)(2));  // a parallelogram's hinge would turn on
}

}  // namespace
}  // namespace flexura::mbs::beams
