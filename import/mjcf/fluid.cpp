// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "import/mjcf/sections.hpp"

namespace flexura::import::mjcf {
namespace {

using std::numbers::pi;

Line text_line(const std::string& key, const std::string& value) {
  return {key, toml(value)};
}

std::string letter(int k) {
  return std::string(1, "xyz"[k]);
}

// A frame whose z axis is the k-th of another one.
Matrix3d turned_to(int k) {
  Matrix3d R;
  R.col(2) = Vector3d::Unit(k);
  R.col(0) = Vector3d::Unit((k + 1) % 3);
  R.col(1) = Vector3d::Unit((k + 2) % 3);
  return R;
}

/// MuJoCo's inertia box model (its documentation, "Computation", Passive forces: fluid): with the box of edges 2 r that has the body's mass and
/// inertia, and speeds v, w of its centre in its axes,
///
///     force  = -3 pi d eta v - rho/2 b_j b_k |v_i| v_i,      d = (b_x + b_y + b_z) / 3, b = 2 r
///     torque = -pi d^3 eta w - rho/64 b_i (b_j^4 + b_k^4) |w_i| w_i
class FluidWriter {
 public:
  FluidWriter(const Option& option, tree::Writer& writer) : option_(option), writer_(writer) {
    still_ = writer_.marker(-1, "fluid", {});
  }

  void add(int link, const tree::Inertial& inertial, const Matrix3d& R) {
    const Vector3d I = (R.transpose() * inertial.inertia * R).diagonal();
    for (int k = 0; k < 3; ++k)
      b_[k] = std::sqrt(std::max(1e-15, I.sum() - 2.0 * I[k]) / inertial.mass * 6.0);
    name_ = writer_.body(link) + "_fluid";
    const Pose X{R, inertial.center};
    marker_ = writer_.marker(link, name_, X);
    if (option_.viscosity > 0.0) add_viscous();
    if (option_.density > 0.0) add_pressure(link, X);
  }

 private:
  // The same in all directions.
  void add_viscous() {
    const double d = b_.mean();
    const auto three = [](double x) { return toml(Vector3d(Vector3d::Constant(x))); };
    writer_.add("force", name_ + "_viscous", {},
                {text_line("type", "bushing"),
                 text_line("from", still_),
                 text_line("to", marker_),
                 {"damping", three(3.0 * pi * d * option_.viscosity)},
                 {"rotational_damping", three(pi * d * d * d * option_.viscosity)}});
    if (option_.wind.isZero(0.0)) return;
    std::vector<Line> lines = {text_line("type", "force"), text_line("marker", marker_)};
    for (int k = 0; k < 3; ++k)
      lines.emplace_back(letter(k), toml(3.0 * pi * d * option_.viscosity * option_.wind[k]));
    writer_.add("force", name_ + "_wind", {}, lines);
  }

  void add_pressure(int link, const Pose& X) {
    std::vector<std::string> axes, speeds, turns;
    for (int k = 0; k < 3; ++k) {
      axes.push_back(writer_.marker(link, name_ + "_" + letter(k), X * Pose{turned_to(k), Vector3d::Zero()}));
      speeds.push_back(measure("velocity", "v", marker_, k));
      if (option_.wind[k] != 0.0)
        speeds.back() = fmt::format("({} - ({}))", speeds.back(), toml(option_.wind[k]));
      turns.push_back(measure("angular_velocity", "w", marker_, k));
    }
    std::vector<Line> force = {text_line("type", "force"), text_line("marker", marker_),
                               text_line("axes", marker_)};
    std::vector<Line> torque = {text_line("type", "torque"), text_line("marker", marker_),
                                text_line("axes", marker_)};
    for (int k = 0; k < 3; ++k) {
      const double p = b_[(k + 1) % 3], q = b_[(k + 2) % 3];
      std::string v, w;
      for (int i = 0; i < 3; ++i) {
        const std::string cosine = measure("axis", "axis_" + letter(k), axes[static_cast<std::size_t>(k)], i);
        v += fmt::format("{}{} * {}", i > 0 ? " + " : "", cosine, speeds[static_cast<std::size_t>(i)]);
        w += fmt::format("{}{} * {}", i > 0 ? " + " : "", cosine, turns[static_cast<std::size_t>(i)]);
      }
      const auto drag = [&](const char* what, const std::string& value, double factor) {
        const std::string m = writer_.add("measure", fmt::format("{}_{}_own_{}", name_, what, letter(k)), {},
                                          {text_line("type", "expression"), text_line("value", value)});
        return text_line(letter(k), fmt::format("-{} * abs({}) * {}", toml(factor), m, m));
      };
      force.push_back(drag("v", v, 0.5 * option_.density * p * q));
      torque.push_back(drag("w", w, option_.density / 64.0 * b_[k] * (std::pow(p, 4) + std::pow(q, 4))));
    }
    writer_.add("force", name_ + "_drag", {}, force);
    writer_.add("force", name_ + "_drag", {}, torque);
  }

  std::string measure(const char* type, const std::string& what, const std::string& to, int k) {
    return writer_.add("measure", fmt::format("{}_{}_{}", name_, what, letter(k)), {},
                       {text_line("type", type),
                        text_line("from", still_),
                        text_line("to", to),
                        {"direction", toml(Vector3d(Vector3d::Unit(k)))}});
  }

  const Option& option_;
  tree::Writer& writer_;
  Vector3d b_ = Vector3d::Zero();  ///< edges of the box
  std::string still_, name_, marker_;
};

// Where the file gives none, the principal ones.
Matrix3d axes_of(const Scene& scene, int link) {
  if (const auto known = scene.inertia_axes.find(link); known != scene.inertia_axes.end())
    return known->second;
  Matrix3d R = Eigen::SelfAdjointEigenSolver<Matrix3d>(
                   scene.tree.links[static_cast<std::size_t>(link)].inertial.inertia)
                   .eigenvectors();
  if (R.determinant() < 0.0) R.col(0) *= -1.0;
  return R;
}

}  // namespace

void add_fluid(const Scene& scene, tree::Writer& writer, Findings& findings) {
  const Option& option = scene.scopes.front().model->option;
  if (!(option.density > 0.0) && !(option.viscosity > 0.0)) return;
  FluidWriter fluid(option, writer);
  const tree::Tree& tree = scene.tree;
  for (const tree::Joint& joint : tree.joints) {
    const tree::Inertial& inertial = tree.links[static_cast<std::size_t>(joint.child)].inertial;
    const auto link = static_cast<std::size_t>(joint.child);
    if (!(inertial.mass > 1e-15) || !scene.moves[link]) continue;
    if (scene.ellipsoid_fluid.contains(joint.child))
      findings.note("forces of a fluid left out",
                    fmt::format("body \"{}\": its geoms have fluidshape \"ellipsoid\", whose forces "
                                "the mechanism file has no element for: they are left out",
                                shown(tree.links[link].name)));
    else
      fluid.add(joint.child, inertial, axes_of(scene, joint.child));
  }
}

}  // namespace flexura::import::mjcf
