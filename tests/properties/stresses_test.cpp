// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every solid and sheet and whatever modes are kept: under loads inside the body its stress in a mechanism is that of the
// finite elements' statics.  The judge keeps every mode, so that the shapes hold all displacements of the mesh.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mbs/solver/start/prepare.hpp"
#include "mbs/superelement/file.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/properties/parts.hpp"

namespace flexura::properties {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using mbs::chance::Chance;

std::string list(const Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

std::string scene_text(Chance& chance, const superelement::Superelement& se, const std::string& keys) {
  const superelement::Interface& held = se.interfaces.front();
  const bool spins = chance.flip(0.4);
  std::string text = fmt::format(
      "gravity = {}\n[ground.marker.o]\nposition = {}\n[body.b]\nsuperelement = \"part.se.h5\"\nstress = "
      "true\n{}[body.b.marker.o]\non = \"{}\"\n",
      list(chance.vector(0.02)), list(held.p_BoN_B), keys, held.name);
  for (int k = 0; k < 3; ++k)
    text += fmt::format("[body.b.stress_point.p{}]\nposition = {}\n", k, list(chance.vector(0.3)));
  text += fmt::format("[joint.j]\ntype = \"{}\"\nfrom = \"ground.o\"\nto = \"b.o\"\n",
                      spins ? "revolute" : "fixed");
  // Gravity turns with the rest where the axis, z, is not along it: the first instant is looked at.
  if (spins) text += fmt::format("drive = \"{:.17g} * t\"\n", chance.between(0.03, 1.0));
  text += fmt::format(
      "[force.own]\ntype = \"distributed_load\"\nbody = \"b\"\nload = \"own\"\nfactor = "
      "{:.17g}\n[solver]\nend_time = "
      "1\ninitial_deformation = \"quasi_static\"\n",
      chance.between(-1.0, 1.0));
  return text;
}

// The stresses at the points, and the greatest.
VectorXd stresses(const test::Folder& folder, const std::string& scene) {
  const mbs::PreparedMechanism p = mbs::prepare(folder.write("m.toml", scene));
  const std::vector<mbs::OutputInfo> infos = p.mechanism->quantities();
  std::vector<int> which;
  for (std::size_t i = 0; i < infos.size(); ++i)
    if (infos[i].name == "b.von_mises" || infos[i].name.find(".stress_") != std::string::npos)
      which.push_back(static_cast<int>(i));
  VectorXd out(static_cast<Eigen::Index>(which.size()));
  const auto scratch = p.mechanism->make_scratch();
  p.mechanism->evaluate(which, p.state, p.v_dot, *scratch, out);
  return out;
}

class Stresses : public testing::TestWithParam<Kind> {};

TEST_P(Stresses, UnderLoadsInsideTheBodyAreThoseOfTheWholeMesh) {
  int judged = 0;
  for (int seed = 1; judged < 30 && seed <= 150 && !HasFailure(); ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const test::Folder folder;
    const RandomPart part = random_part(chance, GetParam(), folder, {.all_directions = true});
    if (!part.refused.empty()) continue;
    const Vector3d field = chance.vector(0.03);
    const std::string text =
        part.text +
        fmt::format(
            "[load.own]\ntype = \"field\"\nx = \"{:.9g} * y\"\ny = \"{:.9g} * x\"\nz = \"{:.9g}\"\n"
            "[recovery]\nstress = true\nprecision = \"double\"\n",
            field.x(), field.y(), field.z());
    const auto file = folder.write("own.toml", text);
    const int few = 1 + chance.below(4);
    // Of those that the superelement has, the mechanism takes any number.
    const std::string keys = chance.flip(0.5) ? fmt::format("modes = {}\n", 1 + chance.below(4)) : "";
    superelement::Superelement se;
    const auto with = [&](int modes) {
      se = reduce::reduce(reduce::read_part(file, {fmt::format("modes.count={}", modes)})).superelement;
      superelement::write(folder / "part.se.h5", se);
    };
    with(few);
    Chance same = chance;
    const std::string scene = scene_text(chance, se, keys);
    SCOPED_TRACE(text + scene);
    const VectorXd found = stresses(folder, scene);
    with(2000);
    const VectorXd right = stresses(folder, scene_text(same, se, ""));
    ++judged;
    // Loads are a thousandth of the usual, so that the inertia of the deformation itself, which is of second order, is
    // below this; what inertia adds is kept in single precision.
    EXPECT_LT((found - right).cwiseAbs().maxCoeff(), 1e-4 * right.cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(judged, 30);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Stresses, testing::Values(Kind::solids, Kind::shells),
                         [](const auto& info) { return name_of(info.param); });

}  // namespace
}  // namespace flexura::properties
