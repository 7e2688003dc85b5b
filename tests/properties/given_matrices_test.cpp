// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every K, M, D of nodes with displacements and rotations that another program writes, however it writes them: the superelement
// with all modes is that model.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <numeric>

#include "reduce/file/part_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/app/command.hpp"
#include "tests/properties/six_dof_models.hpp"

namespace flexura::properties {
namespace {

// Stiffness that the dofs `kept` feel, all others free.
MatrixXd condensed(const MatrixXd& K, const std::vector<Index>& kept) {
  std::vector<Index> rest;
  for (Index i = 0; i < K.rows(); ++i)
    if (std::ranges::find(kept, i) == kept.end()) rest.push_back(i);
  if (rest.empty()) return K(kept, kept);
  return K(kept, kept) - K(kept, rest) * K(rest, rest).ldlt().solve(K(rest, kept));
}

// An interface: nodes that move as one piece.
struct Set {
  std::vector<std::size_t> nodes;
  Vector3d point;
};

std::vector<Set> random_sets(const Model& model, Chance& chance) {
  if (chance.flip(0.4)) return {{{0}, model.x[0]}, {{1}, model.x[1]}};
  if (model.n() == 2 || chance.flip(0.5)) return {{{0}, model.x[0]}};
  std::vector<Set> sets{{{0, 1}, chance.vector(1.0)}};  // two nodes: on a line
  if (model.n() > 2 && model.turns[2] != 0) sets.push_back({{2}, model.x[2]});
  return sets;
}

// Motion of the model's rows by six dofs of each interface and those of all other nodes.
MatrixXd independent(const Model& model, const std::vector<Set>& sets) {
  MatrixXd T = MatrixXd::Zero(6 * model.n(), 6 * model.n());
  Index column = 0;
  std::vector<char> taken(model.x.size(), 0);
  for (const Set& set : sets) {
    for (const std::size_t node : set.nodes) {
      auto block = T.block<6, 6>(6 * static_cast<Index>(node), column);
      block.setIdentity();
      for (int d = 0; d < 3; ++d)
        block.block<3, 1>(0, 3 + d) = Vector3d::Unit(d).cross(model.x[node] - set.point);
      taken[node] = 1;
    }
    column += 6;
  }
  for (const Index dof : model.dofs())
    if (taken[static_cast<std::size_t>(dof / 6)] == 0) T(dof, column++) = 1.0;
  return T.leftCols(column);
}

void expect_the_model(const Superelement& se, const Model& model, const std::vector<Set>& sets,
                      double tolerance) {
  const MatrixXd T = independent(model, sets);
  const auto of = [&](const MatrixXd& A) -> MatrixXd { return T.transpose() * A * T; };
  const MatrixXd K = of(model.K), M = of(model.M), D = of(model.D);
  ASSERT_EQ(se.n(), K.rows());
  ASSERT_EQ(se.n_b, 6 * static_cast<int>(sets.size()));
  expect_close(eigenvalues(se.K_se, se.M_se).tail(K.rows() - 6), eigenvalues(K, M).tail(K.rows() - 6),
               tolerance, "eigenvalue");
  if (D.norm() > 1e-9) {  // not within a rigid piece alone
    ASSERT_EQ(se.D_se.rows(), se.n());
    expect_close(eigenvalues(se.D_se, se.M_se), eigenvalues(D, M), tolerance, "damping");
  }
  EXPECT_NEAR(se.inertia.mass, model.mass, tolerance * model.mass);
  EXPECT_LT((se.inertia.S_x - model.S_x).norm(), tolerance * model.mass);
  EXPECT_LT((se.inertia.S_xx - model.S_xx).norm(), tolerance * model.mass);
  // The interfaces' displacements and rotations are those of the nodes.
  std::vector<Index> kept(6 * sets.size());
  std::iota(kept.begin(), kept.end(), 0);
  EXPECT_LT((condensed(se.K_se, kept) - condensed(K, kept)).norm(),
            tolerance * K.norm());  // of one interface both are zero
}

std::string interface_text(const Model& model, const std::vector<Set>& sets) {
  std::string text;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    std::string nodes;
    for (const std::size_t node : sets[k].nodes)
      nodes += fmt::format("{}{}", nodes.empty() ? "" : ", ", model.label[node]);
    text += fmt::format(
        "[interface.i{}]\nby = \"nodes\"\nnodes = [{}]\nreference = [{:.17g}, {:.17g}, {:.17g}]\n", k, nodes,
        sets[k].point.x(), sets[k].point.y(), sets[k].point.z());
  }
  return text;
}

struct Units {
  const char* text;
  double length, mass;
};
constexpr Units kUnits[] = {{"unit = \"m\"\n", 1.0, 1.0}, {"unit = \"mm\"\n", 1e-3, 1e3}};

TEST(GivenMatrices, WithRotationsAreTheModel) {
  const test::Folder folder;
  for (int seed = 1; seed <= 250; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const Model model = random_model(chance);
    const std::vector<Set> sets = random_sets(model, chance);
    const Units& units = chance.one_of(kUnits);
    const auto in_file = [&](const MatrixXd& A) { return in_units(A, units.length, units.mass); };
    folder.write("nodes.csv", table_of_nodes(model, units.length));
    const Format formats[] = {Format::market, Format::coordinate, Format::nodes, Format::large, Format::free};
    const Format format = chance.one_of(formats);
    const bool with_D = !model.D.isZero(0.0);
    const std::string K = written(model, in_file(model.K), format, "KAAX", chance),
                      M = written(model, in_file(model.M), format, "MAAX", chance),
                      D = written(model, in_file(model.D), format, "BAAX", chance);
    const bool nastran = format == Format::large || format == Format::free;
    std::string text = fmt::format("[geometry]\nfile = \"nodes.csv\"\n{}", units.text);
    if (chance.flip(0.7)) {
      if (nastran && chance.flip(0.5)) {  // all in one file
        folder.write("K.pch", K + M + (with_D ? D : ""));
        text += "[matrices]\nstiffness = \"K.pch\"\nmass = \"K.pch\"\n";
        if (with_D) text += "damping = \"K.pch\"\n";
      } else {
        folder.write("K.txt", K), folder.write("M.txt", M), folder.write("D.txt", D);
        text += "[matrices]\nstiffness = \"K.txt\"\nmass = \"M.txt\"\n";
        if (with_D) text += "damping = \"D.txt\"\n";
      }
      text += interface_text(model, sets) + "[modes]\ncount = 500\ndamping = 0.0\n";
    } else {  // vectors that span everything
      const MatrixXd T = independent(model, sets);
      MatrixXd Q(T.cols(), T.cols());
      for (double& q : Q.reshaped()) q = chance.between(-1.0, 1.0);
      const MatrixXd V = T * MatrixXd(Q.householderQr().householderQ());
      // The same shapes in the file's unit of length: their displacements are numbers, their rotations per length.
      MatrixXd V_file = V;
      for (Index i = 0; i < V.rows(); ++i)
        if (i % 6 > 2) V_file.row(i) *= units.length;
      const auto reduced = [&](const MatrixXd& X) { return dense(V_file.transpose() * in_file(X) * V_file); };
      folder.write("V.txt", dense(V_file));
      folder.write("K.txt", reduced(model.K)), folder.write("D.txt", reduced(model.D));
      folder.write("M.txt", M);
      text += "[mode_vectors]\nvectors = \"V.txt\"\nstiffness = \"K.txt\"\nmass = \"M.txt\"\n";
      if (with_D) text += "damping = \"D.txt\"\n";
      text += interface_text(model, sets) + "[modes]\ndamping = 0.0\n";
    }
    SCOPED_TRACE(text + K + M);
    const Superelement se = reduce::reduce(reduce::read_part(folder.write("part.toml", text))).superelement;
    // Ten digits of large fields; the others print all.  Rigid and soft motions lose the span of K's eigenvalues, 1e4.
    expect_the_model(se, model, sets, format == Format::large ? 1e-5 : 1e-7);
    if (testing::Test::HasFailure()) return;
  }
}

// What this program has of a sheet, written as six rows a node and read again, reduces to what the sheet itself does.
TEST(GivenMatrices, OfOurShellsGiveTheirSuperelement) {
  const test::Folder folder;
  for (int seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const int n = 2 + chance.below(2), across = 2 + chance.below(2);
    folder.write("part.inp", random_sheet(chance, n, across));
    const int last = 1 + 2 * ((n + 1) * across - 1), count = chance.below(10);
    const std::string rest = fmt::format(
        "[interface.a]\nby = \"nodes\"\nnodes = [1]\n[interface.b]\nby = \"nodes\"\nnodes = "
        "[{}]\n[modes]\ncount = "
        "{}\n",
        last, count);
    const reduce::PartInput own =
        reduce::read_part(folder.write("own.toml", "[geometry]\nfile = \"part.inp\"\nunit = \"m\"\n" + rest));
    const Model model = full_model(own);
    const Format formats[] = {Format::market, Format::coordinate, Format::nodes, Format::free};
    const Format format = chance.one_of(formats);
    folder.write("K.txt", written(model, model.K, format, "KAAX", chance));
    folder.write("M.txt", written(model, model.M, format, "MAAX", chance));
    folder.write("nodes.csv", table_of_nodes(model, 1.0));
    const bool table = chance.flip(0.5);
    const Superelement
        read =
            reduce::reduce(
                reduce::read_part(folder.write(
                    "read.toml",
                    fmt::format("[geometry]\nfile = \"{}\"\nunit = \"m\"\n[matrices]\nstiffness = \"K.txt\"\n"
                                "mass = \"M.txt\"\n",
                                table ? "nodes.csv" : "part.inp") +
                        rest)))
                .superelement,
        right = reduce::reduce(own).superelement;
    ASSERT_EQ(read.n_b, 12);
    ASSERT_EQ(read.n(), right.n());
    const MatrixXd K = right.K_se.topLeftCorner(12, 12), M = right.M_se.topLeftCorner(12, 12);
    // Solutions of K with a condition of some 1e8 (drilling beside stretch).
    EXPECT_LT((read.K_se.topLeftCorner(12, 12) - K).norm(), 1e-7 * K.norm());
    EXPECT_LT((read.M_se.topLeftCorner(12, 12) - M).norm(), 1e-7 * M.norm());
    expect_close(eigenvalues(read.K_se, read.M_se).tail(read.n() - 6),
                 eigenvalues(right.K_se, right.M_se).tail(read.n() - 6), 1e-7, "eigenvalue");
    EXPECT_NEAR(read.inertia.mass, right.inertia.mass, 1e-9 * right.inertia.mass);
    EXPECT_LT((read.inertia.S_xx - right.inertia.S_xx).norm(), 1e-9 * right.inertia.S_xx.norm());
    EXPECT_LT((read.inertia.S_phi.leftCols(12) - right.inertia.S_phi.leftCols(12)).norm(),
              1e-7 * right.inertia.S_phi.norm());
    EXPECT_GT(table ? 1 : read.surface.triangles.rows(), 0);
    if (testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace flexura::properties
