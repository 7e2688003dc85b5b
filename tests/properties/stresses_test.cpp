// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every solid and sheet and whatever modes are kept: under loads inside the body its stress in a mechanism is that of the
// finite elements' statics.  The judge keeps every mode, so that the shapes hold all displacements of the mesh.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <array>
#include <map>

#include "mbs/mechanism/describe.hpp"
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

// The greatest displacement and principal strain of a surface are those of the nodes one by one, and where these are.
TEST_P(Stresses, GreatestValuesAreThoseOfTheNodesOneByOne) {
  int judged = 0;
  for (int seed = 1; judged < 20 && seed <= 100 && !HasFailure(); ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    const test::Folder folder;
    const RandomPart part =
        random_part(chance, GetParam(), folder, {.all_directions = true, .fewest_modes = 1});
    if (!part.refused.empty()) continue;
    const auto file =
        folder.write("own.toml", part.text + "[recovery]\nstress = true\nprecision = \"double\"\n");
    const superelement::Superelement se = reduce::reduce(reduce::read_part(file, {})).superelement;
    superelement::write(folder / "part.se.h5", se);
    const superelement::Interface &held = se.interfaces.front(), &pulled = se.interfaces.back();
    std::string scene = fmt::format(
        "gravity = {}\n[ground.marker.o]\nposition = {}\n[body.b]\nsuperelement = \"part.se.h5\"\nstress = "
        "true\n"
        "displacement = true\n",
        list(chance.vector(1.0)), list(held.p_BoN_B));
    const Eigen::Index n = se.surface.vertices.rows();
    const std::vector<std::int32_t>& stressed = se.stress->vertices;
    const auto at = [&](Eigen::Index v) { return Vector3d(se.surface.vertices.row(v).transpose()); };
    for (Eigen::Index v = 0; v < n; ++v)
      scene += fmt::format("[body.b.surface_point.q{}]\nposition = {}\n", v, list(at(v)));
    for (std::size_t k = 0; k < stressed.size(); ++k)
      scene += fmt::format("[body.b.stress_point.p{}]\nposition = {}\n", k, list(at(stressed[k])));
    scene += fmt::format(
        "[body.b.marker.o]\non = \"{}\"\n[body.b.marker.p]\non = \"{}\"\n[joint.j]\ntype = \"fixed\"\nfrom = "
        "\"ground.o\"\nto = \"b.o\"\n[force.f]\ntype = \"force\"\nmarker = \"b.p\"\nx = {}\ny = {}\nz = "
        "{}\n[solver]\n"
        "end_time = 1\ninitial_deformation = \"quasi_static\"\n",
        held.name, pulled.name, chance.between(-1, 1), chance.between(-1, 1), chance.between(-1, 1));
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, part.text));
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("m.toml", scene));
    const auto value = [&](const std::string& name) {
      const auto which = mbs::select_quantities(*p.mechanism, {name});
      VectorXd out(1);
      p.mechanism->evaluate(which, p.state, p.v_dot, *p.mechanism->make_scratch(), out);
      return out(0);
    };
    const auto place = [&](const std::string& of) {
      return Vector3d(value(of + "_at_x"), value(of + "_at_y"), value(of + "_at_z"));
    };
    std::map<std::array<double, 3>, double> displacements, strains;  // by place
    const auto key = [](const Vector3d& x) { return std::array<double, 3>{x(0), x(1), x(2)}; };
    double displacement = 0.0, strain = 0.0;
    for (Eigen::Index v = 0; v < n; ++v) {
      const double u = displacements[key(at(v))] = value(fmt::format("b.q{}.displacement", v));
      displacement = std::max(displacement, u);
    }
    for (std::size_t k = 0; k < stressed.size(); ++k) {
      const auto e = [&](const char* component) {
        return value(fmt::format("b.p{}.strain_{}", k, component));
      };
      Eigen::Matrix3d tensor;
      tensor << e("xx"), e("xy") / 2, e("zx") / 2, e("xy") / 2, e("yy"), e("yz") / 2, e("zx") / 2,
          e("yz") / 2, e("zz");
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(tensor, Eigen::ComputeFullU);
      const Vector3d along = svd.matrixU().col(0);
      strains[key(at(stressed[k]))] = along.dot(tensor * along);
      strain = std::max(strain, svd.singularValues()(0));
    }
    ++judged;
    // The same products in another order, at one of the places that have it.
    EXPECT_GT(displacement, 0.0);
    EXPECT_NEAR(value("b.displacement"), displacement, 1e-10 * displacement);
    EXPECT_NEAR(displacements.at(key(place("b.displacement"))), displacement, 1e-10 * displacement);
    EXPECT_NEAR(std::abs(value("b.strain")), strain, 1e-10 * strain);
    EXPECT_NEAR(value("b.strain"), strains.at(key(place("b.strain"))), 1e-10 * strain);
  }
  EXPECT_EQ(judged, 20);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Stresses, testing::Values(Kind::solids, Kind::shells),
                         [](const auto& info) { return name_of(info.param); });

}  // namespace
}  // namespace flexura::properties
