// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// FlexData's ModeLoad: load cases go out and come back, and deform the body as they did.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/modes.hpp"
#include "reduce/file/flexdata_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/properties/parts.hpp"

namespace flexura::properties {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using mbs::chance::Chance;
using superelement::FlexData;
using superelement::Superelement;

// How all modes of the free body answer to the load, phi_j^T p, with the signs that the interfaces' motion fixes; and the resultants.
struct Answer {
  VectorXd compliance;  // displacements of the interfaces' dofs by the elastic modes
  Eigen::Matrix<double, 6, 1> resultant;
};

Answer answer_of(const Superelement& se, const VectorXd& p) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(se.K_se, se.M_se);
  const MatrixXd Y = modes.eigenvectors().rightCols(se.n() - 6);
  const VectorXd q = modes.eigenvalues().tail(se.n() - 6).cwiseInverse().asDiagonal() * (Y.transpose() * p);
  VectorXd u(6 * static_cast<Index>(se.interfaces.size()));
  for (std::size_t k = 0; k < se.interfaces.size(); ++k)
    u.segment<6>(6 * static_cast<Index>(k)) = superelement::interface_motion(se, se.interfaces[k]) * (Y * q);
  return {u, superelement::rigid_motions(se).transpose() * p};
}

TEST(FlexDataLoads, ComeBackAsTheyWentOut) {
  const test::Folder folder;
  int judged = 0;
  for (int seed = 1; judged < 100 && seed < 400; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    RandomPart part = random_part(chance, Kind::beams, folder, {.all_directions = true, .fewest_modes = 2});
    if (!part.refused.empty() || part.superelement.n() < 9) continue;
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, part.text));
    ++judged;
    Superelement se = std::move(part.superelement);
    const int n_loads = 1 + chance.below(3);
    for (int k = 0; k < n_loads; ++k) {
      VectorXd p(se.n());
      for (double& value : p) value = chance.between(-1.0, 1.0);
      se.load_cases.push_back({.name = fmt::format("case {}", k), .p_se = 100.0 * p});
    }
    const superelement::ModeAnalysis modes = superelement::natural_modes(se, {});  // all
    superelement::write_flexdata(folder / "part.xml", superelement::make_flexdata(se, modes));
    const Superelement back =
        reduce::reduce(reduce::read_flexdata_part(folder / "part.xml", {})).superelement;
    ASSERT_EQ(back.load_cases.size(), se.load_cases.size());
    for (std::size_t k = 0; k < se.load_cases.size(); ++k) {
      EXPECT_EQ(back.load_cases[k].name, se.load_cases[k].name);
      const Answer right = answer_of(se, se.load_cases[k].p_se),
                   found = answer_of(back, back.load_cases[k].p_se);
      // 17 digits, and round-off of two changes of the basis.
      EXPECT_LT((found.compliance - right.compliance).norm(), 1e-6 * right.compliance.norm());
      EXPECT_LT((found.resultant - right.resultant).norm(), 1e-8 * se.load_cases[k].p_se.norm() * se.n());
    }
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(judged, 100);
}

// Files of other programs: a number for each mode, or for rigid modes before them, or by the modes' numbers.
TEST(FlexDataLoads, OfOtherProgramsAreReadHoweverTheyCount) {
  const test::Folder folder;
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const int m = 1 + chance.below(4), way = chance.below(3);
    std::string modes, shapes, load;
    std::vector<int> ids;
    for (int j = 0; j < m; ++j) {
      ids.push_back(7 + j + (way == 2 ? chance.below(3) + 2 * j : 0));
      const double hz = 50.0 * (j + 1);
      modes +=
          fmt::format("{} {} {:.16e} 0.01\n", ids.back(), hz, std::pow(2.0 * 3.14159265358979323846 * hz, 2));
      for (int k = 0; k < 12; ++k) shapes += fmt::format("{} ", chance.between(-0.1, 0.1));
    }
    std::vector<double> right;
    for (int j = 0; j < m; ++j) right.push_back(chance.between(-50.0, 50.0));
    const int before = way == 0 ? 0 : 6, n = way == 2 ? ids.back() + chance.below(4) : before + m;
    std::vector<double> values(static_cast<std::size_t>(n));
    for (double& value : values) value = chance.between(-9.0, 9.0);
    for (int j = 0; j < m; ++j)
      values[static_cast<std::size_t>(way == 2 ? ids[static_cast<std::size_t>(j)] - 1 : before + j)] =
          right[static_cast<std::size_t>(j)];
    for (const double value : values) load += fmt::format("{:.17g} ", value);
    const auto path = folder.write(
        "x.xml",
        fmt::format(
            "<Reference_FlexData id=\"1\" num_sel_modes=\"{}\" "
            "num_sel_nodes=\"2\">\n<ModeData>{}</ModeData>\n"
            "<NodeData>1 0 0 0\n2 1 0 0\n{}</NodeData>\n<ModeLoad loadcase_id = \"{}\">\n{}</ModeLoad>\n"
            "</Reference_FlexData>\n",
            m, modes, shapes, 40 + seed, load));
    const FlexData data = superelement::read_flexdata(path);
    ASSERT_EQ(data.loads.size(), 1U);
    EXPECT_EQ(data.loads[0].id, 40 + seed);
    for (int j = 0; j < m; ++j) EXPECT_EQ(data.loads[0].on_modes(j), right[static_cast<std::size_t>(j)]);
    EXPECT_EQ(data.loads[0].has_rigid, way != 0);
  }
}

}  // namespace
}  // namespace flexura::properties
