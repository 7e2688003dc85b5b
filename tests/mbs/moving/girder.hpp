// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <string>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

/// A girder of 10 m on two supports, in the file's words and as a series of its modes.
namespace flexura::mbs::moving {

inline constexpr double kL = 10.0, kEI = 2.1e7, kMass = 100.0;  ///< [m, N m^2, kg/m]

/// phi_n = sin(n pi x / L) of Euler and Bernoulli's beam on two supports.
struct Series {
  static double k(int n) { return n * std::numbers::pi / kL; }
  static double omega(int n) { return k(n) * k(n) * std::sqrt(kEI / kMass); }
  static double phi(int n, double x) { return std::sin(k(n) * x); }
  static double phi_1(int n, double x) { return k(n) * std::cos(k(n) * x); }
  static double phi_2(int n, double x) { return -k(n) * k(n) * std::sin(k(n) * x); }
};

/// Bodies of its own: "girder" with the markers root, p1 ... p7, tip at equal distances, hinged at its root and guided at
/// its tip; the mechanism's measure z is where p4, its middle, stands.
class GirderTest : public cases::TextCase {
 protected:
  /// By a superelement of 16 beam elements, or by a fidelity of beams with 8.  The superelement's modes are taken as the
  /// supports hold it, up to the eighth of bending at least.
  std::string girder(const std::string& fidelity,
                     const std::string& modes = "frame = \"joints\"\nmax_frequency = 500\n") const {
    std::string body;
    if (fidelity.starts_with("modal")) {
      beams::StraightBeam beam;
      beam.length = kL;
      beam.elements = 16;
      beam.between = 7;
      beam.EA = 1e10;
      beam.EI_y = beam.EI_z = kEI;
      beam.GI_t = 1e7;
      beam.mass_per_length = kMass;
      beam.rho_I_y = beam.rho_I_z = 1e-3;
      superelement::write(folder_ / "girder.se.h5", beams::beam_superelement(beam));
      body = fmt::format("[body.girder]\nsuperelement = \"girder.se.h5\"\nfidelity = \"{}\"\n{}", fidelity,
                         modes);
    } else {
      body = fmt::format(
          "[body.girder]\nfidelity = \"{}\"\n[body.girder.beam]\nto = [{}, 0, 0]\nelements = {}\nEA = "
          "1e10\nGA_y = "
          "1e10\nGA_z = 1e10\nGI_t = 1e7\nEI_y = {}\nEI_z = {}\nmass_per_length = {}\nrho_I_y = "
          "1e-3\nrho_I_z = 1e-3\n",
          fidelity, kL, 8, kEI, kEI, kMass);
      for (int i = 1; i < 8; ++i) body += fmt::format("point.p{}.at = {}\n", i, kL * i / 8);
    }
    return body + fmt::format(R"toml(
[body.girder.marker.hinge]
on = "root"
axis = [0, 1, 0]
[ground.marker.hinge]
axis = [0, 1, 0]
[ground.marker.line]
axis = [1, 0, 0]
[joint.hinge]
type = "revolute"
from = "ground.hinge"
to = "girder.hinge"
[constraint.guide]
type = "point_on_line"
from = "ground.line"
to = "girder.tip"
[measure.z]
type = "position"
from = "ground"
to = "girder.p4"
direction = [0, 0, 1]
)toml");
  }
};

inline const std::string path =
    "path = [\"girder.root\", \"girder.p1\", \"girder.p2\", \"girder.p3\", \"girder.p4\", \"girder.p5\", "
    "\"girder.p6\", \"girder.p7\", \"girder.tip\"]\n";

inline std::string solve(double end, int rows, double tolerance, const std::string& more = {}) {
  return fmt::format("[solver]\nend_time = {:.12g}\noutput_step = {:.12g}\ntolerance = {}\n{}", end,
                     end / rows, tolerance, more);
}

/// y' = f(t, y) by Kutta's classical method.
template <class F>
void kutta(const F& f, double& t, Eigen::VectorXd& y, double h) {
  const Eigen::VectorXd a = f(t, y), b = f(t + 0.5 * h, y + 0.5 * h * a), c = f(t + 0.5 * h, y + 0.5 * h * b),
                        d = f(t + h, y + h * c);
  y += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
  t += h;
}

}  // namespace flexura::mbs::moving
