// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The motions of all nodes beside closed forms, for random meshes, members and fields.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "mbs/superelement/file.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/cms/craig_bampton.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/library/reduce.hpp"
#include "reduce/recovery/node_motions.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::properties {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using mbs::chance::Chance;
using Rotation = superelement::NodalMotions::Rotation;

constexpr mesh::CellType kSolids[] = {
    mesh::CellType::tet4,  mesh::CellType::tet10,  mesh::CellType::hex8,    mesh::CellType::hex20,
    mesh::CellType::hex27, mesh::CellType::wedge6, mesh::CellType::wedge15, mesh::CellType::pyramid5};

// A box of random cells, pushed out of square.
reduce::Part random_solid(Chance& chance, reduce::Tie tie) {
  const Vector3d size(chance.between(0.2, 1.0), chance.between(0.05, 0.3), chance.between(0.05, 0.3));
  reduce::Part part =
      reduce::testing::beam(size, {1 + chance.below(3), 1 + chance.below(2), 1 + chance.below(2)},
                            chance.one_of(kSolids), tie, tie);
  const Matrix3d shear =
      Matrix3d::Identity() + 0.3 * Matrix3d::NullaryExpr([&] { return chance.between(-1.0, 1.0); });
  reduce::testing::deform(part.mesh, [&](const Vector3d& x) { return Vector3d(shear * x); });
  for (reduce::InterfaceSpec& interface : part.interfaces) interface.point = shear * interface.point;
  return part;
}

// Every isoparametric cell has affine fields exactly, so that u = a + G x turns each node by (G - G^T) / 2.
TEST(AllNodes, TurnByHalfTheCurlOfAffineFields) {
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const reduce::Part part = random_solid(chance, reduce::Tie::rigid);
    const Matrix3d G = Matrix3d::NullaryExpr([&] { return chance.between(-1.0, 1.0); });
    const Vector3d a = chance.vector(1.0),
                   turn = 0.5 * Vector3d(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
    MatrixXd T(3 * part.mesh.n_nodes(), 1);
    for (Index node = 0; node < part.mesh.n_nodes(); ++node)
      T.middleRows<3>(3 * node) = a + G * part.mesh.points.row(node).transpose();
    const reduce::NodeMotions motions = reduce::node_motions(part, T);
    ASSERT_EQ(static_cast<Index>(motions.nodes.size()), part.mesh.n_nodes());
    for (std::size_t k = 0; k < motions.nodes.size(); ++k) {
      const auto row = 6 * static_cast<Index>(k);
      // The tip of a pyramid has no gradient of its own, and turns with nothing where it belongs to pyramids alone.
      if (motions.rotations[k] == reduce::NodeMotions::Rotation::unknown) {
        EXPECT_EQ(part.mesh.solids.front().type, mesh::CellType::pyramid5);
        continue;
      }
      // Round-off of gradients over cells 0.05 m long and fields of 1.
      EXPECT_LT((motions.T.block<3, 1>(row + 3, 0) - turn).norm(), 1e-12);
      EXPECT_EQ((motions.T.block<3, 1>(row, 0) - T.middleRows<3>(3 * static_cast<Index>(k))).norm(), 0.0);
    }
    if (testing::Test::HasFailure()) return;
  }
}

// The shapes carry rigid motions exactly, at every node, as displacement and as rotation; and M_se is made of them.
TEST(AllNodes, OfReducedSolidsFollowRigidMotions) {
  for (int seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const reduce::Part part =
        random_solid(chance, chance.flip(0.5) ? reduce::Tie::rigid : reduce::Tie::average);
    reduce::ReductionOptions options;
    options.n_modes = chance.below(4);
    options.estimate_error = false;
    options.all_nodes = true;
    const reduce::Reduction r = reduce::craig_bampton(part, options);
    ASSERT_TRUE(r.nodes);
    MatrixXd R = MatrixXd::Zero(r.n(), 6);
    for (const reduce::ReducedInterface& interface : r.interfaces)
      R.middleRows<6>(interface.first_dof) = reduce::node_motion_at(interface.point);
    const MatrixXd moved = r.nodes->T * R;
    for (std::size_t k = 0; k < r.nodes->nodes.size(); ++k) {
      if (r.nodes->rotations[k] == reduce::NodeMotions::Rotation::unknown) continue;
      // The residual of the constraint modes, 1e-9 for thin parts of steel at most.
      EXPECT_LT((moved.middleRows<6>(6 * static_cast<Index>(k)) -
                 reduce::node_motion_at(part.mesh.points.row(r.nodes->nodes[k])))
                    .norm(),
                1e-8);
    }
    if (testing::Test::HasFailure()) return;
  }
}

std::string list(const Vector3d& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

// A slender member between two nodes bends by Hermite's cubics, stretches and twists linearly (Przemieniecki 1968, 5.6): what
// its inner nodes do, with rotations, when its ends move.
TEST(AllNodes, WithinMembersAreHermitesCubics) {
  const test::Folder folder;
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const Matrix3d R = chance.rotation();
    const double l = chance.between(0.5, 2.0);
    const Vector3d a = chance.vector(1.0), b = a + l * R.col(0);
    const int elements = 2 + chance.below(5);
    const std::string text = fmt::format(
        "[material.m]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = 7850\n[section.s]\ntype = "
        "\"circle\"\ndiameter = 0.02\n[node.a]\nposition = {}\n[node.b]\nposition = "
        "{}\n[member.m]\nnodes = [\"a\", \"b\"]\ndirection = {}\nelements = {}\ntheory = "
        "\"euler_bernoulli\"\n[interface.a]\n"
        "[interface.b]\n[modes]\ncount = {}\n[recovery]\nnodes = \"all\"\nprecision = \"double\"\n",
        list(a), list(b), list(R.col(1)), elements, chance.below(3));
    const superelement::Superelement se =
        reduce::reduce(reduce::read_beam_part(folder.write("part.toml", text))).superelement;
    ASSERT_TRUE(se.nodes);
    ASSERT_EQ(static_cast<int>(se.nodes->numbers.size()), elements + 1);
    const VectorXd ends = VectorXd::NullaryExpr(12, [&] { return chance.between(-1.0, 1.0); });
    VectorXd u_se = VectorXd::Zero(se.n());
    u_se.head<12>() = ends;
    const VectorXd motion = se.nodes->T * u_se;
    const Vector3d u_1 = R.transpose() * ends.segment<3>(0), t_1 = R.transpose() * ends.segment<3>(3),
                   u_2 = R.transpose() * ends.segment<3>(6), t_2 = R.transpose() * ends.segment<3>(9);
    for (std::size_t k = 0; k < se.nodes->numbers.size(); ++k) {
      const auto row = static_cast<Index>(k);
      const double s = R.col(0).dot(se.nodes->positions.row(row).transpose() - a) / l;
      const double h_1 = 1 - 3 * s * s + 2 * s * s * s, h_2 = l * (s - 2 * s * s + s * s * s),
                   h_4 = l * (s * s * s - s * s);
      const double d_1 = (6 * s * s - 6 * s) / l, d_2 = 1 - 4 * s + 3 * s * s, d_4 = 3 * s * s - 2 * s;
      const Vector3d u((1 - s) * u_1.x() + s * u_2.x(),
                       h_1 * u_1.y() + h_2 * t_1.z() + (1 - h_1) * u_2.y() + h_4 * t_2.z(),
                       h_1 * u_1.z() - h_2 * t_1.y() + (1 - h_1) * u_2.z() - h_4 * t_2.y());
      const Vector3d theta((1 - s) * t_1.x() + s * t_2.x(),
                           -(d_1 * (u_1.z() - u_2.z()) - d_2 * t_1.y() - d_4 * t_2.y()),
                           d_1 * (u_1.y() - u_2.y()) + d_2 * t_1.z() + d_4 * t_2.z());
      // Of the static solution of up to six elements: condition 1e6.
      EXPECT_LT((R.transpose() * motion.segment<3>(6 * row) - u).norm(), 1e-8);
      EXPECT_LT((R.transpose() * motion.segment<3>(6 * row + 3) - theta).norm(), 1e-8);
    }
    if (testing::Test::HasFailure()) return;
  }
}

constexpr const char* kPlate = R"(*NODE
11, 0, 0, 0
12, 1, 0, 0
13, 2, 0, 0
21, 0, 1, 0
22, 1, 1, 0
23, 2, 1, 0
*ELEMENT, TYPE=S4, ELSET=E
1, 11, 12, 22, 21
2, 12, 13, 23, 22
*MATERIAL, NAME=M
*ELASTIC
2.1e11, 0.3
*DENSITY
7850
*SHELL SECTION, ELSET=E, MATERIAL=M
0.01
*NSET, NSET=LEFT
11, 21
*NSET, NSET=RIGHT
13, 23
)";

std::string part_of(const std::string& file, const std::string& recovery) {
  return fmt::format(
      "[geometry]\nfile = \"{}\"\nunit = \"m\"\n[interface.left]\nby = \"group\"\ngroup = "
      "\"LEFT\"\n[interface.right]\nby = \"group\"\ngroup = "
      "\"RIGHT\"\n[modes]\ncount = 3\n[recovery]\n{}\n",
      file, recovery);
}

// By file, command, Matrix Market and table: a plate of shells that moves as a whole, turned by 30 degrees.
TEST(AllNodes, OfADeckGoThroughFilesAndRuns) {
  const test::Folder folder;
  folder.write("plate.inp", kPlate);
  for (const std::string precision : {"single", "double"}) {
    const auto part = folder.write(
        "plate.toml", part_of("plate.inp", "nodes = \"all\"\nprecision = \"" + precision + "\""));
    const std::string se_file = (folder / "plate.se.h5").string();
    const test::Outcome made = test::run("flexura-reduce", {part.string(), "-q", "-o", se_file});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    superelement::Parts parts;
    parts.nodes = true;
    const superelement::Superelement se = superelement::read(se_file, parts);
    ASSERT_TRUE(se.nodes);
    EXPECT_THAT(se.nodes->numbers, testing::ElementsAre(11, 12, 13, 21, 22, 23));
    EXPECT_THAT(se.nodes->rotations, testing::Each(Rotation::own));
    const MatrixXd moved = se.nodes->T * superelement::rigid_motions(se);
    for (Index k = 0; k < 6; ++k)
      EXPECT_LT((moved.middleRows<6>(6 * k) - reduce::node_motion_at(se.nodes->positions.row(k))).norm(),
                precision == "single" ? 1e-5 : 1e-9);
    EXPECT_EQ(test::run("flexura", {"export", se_file, "--format", "matrix-market", "-q"}).exit_code, 0);
    std::istringstream written(test::read_text(folder / "plate.T.mtx"));
    std::string line;
    while (std::getline(written, line) && line.starts_with('%')) continue;
    EXPECT_EQ(line, fmt::format("36 {}", se.n()));
    for (const double value : se.nodes->T.reshaped()) {
      std::getline(written, line);
      EXPECT_EQ(std::stod(line), value);
    }
  }
  const auto scene = folder.write(
      "m.toml",
      "gravity = [0, 0, 0]\n[ground.marker.o]\n[body.b]\nsuperelement = \"plate.se.h5\"\n[body.b.marker.c]\n"
      "on = \"left\"\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground.o\"\nto = \"b.c\"\nangle = "
      "\"30 deg\"\n[solver]\nend_time = 0.1\noutput_step = 0.05\n");
  const test::Outcome ran =
      test::run("flexura", {"simulate", scene.string(), "-q", "-o", (folder / "m.h5").string()});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const test::Outcome out = test::run("flexura", {"export", (folder / "m.h5").string(), "--format", "nodes"});
  ASSERT_EQ(out.exit_code, 0) << out.err;
  std::istringstream table(test::read_text(folder / "m.run.nodes.csv"));
  std::string line;
  int rows = 0;
  // The face's node lies at (0, 0.5, 0) and stays at the origin.
  const Matrix3d turned = Eigen::AngleAxisd(M_PI / 6, Vector3d::UnitZ()).toRotationMatrix();
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::vector<std::string> fields;
    std::istringstream of(line);
    for (std::string field; std::getline(of, field, ',');) fields.push_back(field);
    ASSERT_EQ(fields.size(), 12U) << line;
    const int node = std::stoi(fields[2]);
    const Vector3d place(node % 10 - 1, node / 10 - 1, 0),
        x(std::stod(fields[3]), std::stod(fields[4]), std::stod(fields[5]));
    EXPECT_LT((x - turned * (place - Vector3d(0, 0.5, 0))).norm(), 1e-7) << line;
    ++rows;
  }
  EXPECT_EQ(rows, 3 * 6);
}

TEST(AllNodes, AreRefusedWhereNoPartKeepsThem) {
  const test::Folder folder;
  folder.write("plate.inp", kPlate);
  const auto part = folder.write("plate.toml", part_of("plate.inp", "nodes = \"surface\""));
  ASSERT_EQ(
      test::run("flexura-reduce", {part.string(), "-q", "-o", (folder / "plate.se.h5").string()}).exit_code,
      0);
  const auto scene = folder.write(
      "m.toml",
      "[ground.marker.o]\n[body.b]\nsuperelement = \"plate.se.h5\"\n[body.b.marker.c]\non = \"left\"\n"
      "[joint.j]\ntype = \"fixed\"\nfrom = \"ground.o\"\nto = \"b.c\"\n[solver]\nend_time = 0.1\n");
  ASSERT_EQ(
      test::run("flexura", {"simulate", scene.string(), "-q", "-o", (folder / "m.h5").string()}).exit_code,
      0);
  const test::Outcome out = test::run("flexura", {"export", (folder / "m.h5").string(), "--format", "nodes"});
  EXPECT_NE(out.exit_code, 0);
  EXPECT_THAT(out.err, testing::HasSubstr("reduce the part with [recovery] nodes = \"all\""));
}

}  // namespace
}  // namespace flexura::properties
