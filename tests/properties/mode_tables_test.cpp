// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For every superelement: mode tables and exports are the eigenvalues of its K_se and M_se.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/modes.hpp"
#include "reduce/file/flexdata_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/properties/parts.hpp"

namespace flexura::properties {
namespace {

using Eigen::MatrixXd;
using mbs::chance::Chance;
using superelement::ModeAnalysis;
using superelement::Superelement;

using Real = long double;
using MatrixXl = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

// omega^2 of (K, M), ascending, in extended precision, so that the judge's own round-off is 1e-3 of a double's: of
// M x = mu (K + s M) x, as rotations of single nodes make M all but singular.
std::vector<double> eigenvalues(const MatrixXd& K, const MatrixXd& M) {
  if (K.rows() == 0) return {};
  const Real mean = static_cast<Real>(K.trace()) / static_cast<Real>(M.trace()),
             shift = mean > 0.0L ? mean : 1.0L;
  MatrixXl M_l = M.cast<Real>(), A_l = K.cast<Real>() + shift * M_l;
  const Eigen::Matrix<Real, Eigen::Dynamic, 1> s = A_l.diagonal().cwiseSqrt().cwiseInverse();
  A_l = (s.asDiagonal() * (0.5L * (A_l + A_l.transpose())) * s.asDiagonal()).eval();
  M_l = (s.asDiagonal() * (0.5L * (M_l + M_l.transpose())) * s.asDiagonal()).eval();
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXl> solver(M_l, A_l, Eigen::EigenvaluesOnly);
  std::vector<double> out;
  for (Eigen::Index k = K.rows() - 1; k >= 0; --k)
    // What is all but massless (1e4 times the mean frequency) is known to few digits in doubles, or to none.
    if (const Real mu = solver.eigenvalues()(k); mu > 1e-8L * solver.eigenvalues()(K.rows() - 1))
      out.push_back(static_cast<double>(1.0L / mu - shift));
  return out;
}

// The dofs that stay where these interfaces are held in the directions that they keep.
std::vector<int> not_held(const Superelement& se, const std::vector<std::string>& held) {
  std::vector<int> dofs;
  for (int k = 0; k < se.n(); ++k) {
    const bool is_held = std::ranges::any_of(se.interfaces, [&](const superelement::Interface& i) {
      return k >= i.first_dof && k < i.first_dof + static_cast<int>(i.directions.size()) &&
             std::ranges::find(held, i.name) != held.end();
    });
    if (!is_held) dofs.push_back(k);
  }
  return dofs;
}

// What the table says against the judge.
void expect_same(const ModeAnalysis& table, const std::vector<double>& right, double relative,
                 const std::string& what) {
  // At the very end round-off decides of what is massless.
  ASSERT_GE(table.modes.size(), right.size()) << what;
  const int still = table.n_rigid + table.n_mechanisms;
  for (int k = 0; k < static_cast<int>(right.size()); ++k) {
    const double omega2 = table.modes[static_cast<std::size_t>(k)].omega2,
                 is = right[static_cast<std::size_t>(k)];
    if (k < still) {
      const double first =
          still < static_cast<int>(right.size()) ? right[static_cast<std::size_t>(still)] : 1.0;
      EXPECT_EQ(omega2, 0.0) << what;
      EXPECT_LT(std::abs(is), 1e-4 * first) << what << ": motion " << k + 1 << " strains the body";
    } else {
      // Round-off of the dense solution, times the ratio of the frequencies; and of K's rigid motions, of second order.
      const double tolerance = relative + 1e-14 * std::sqrt(right.back() / is);
      EXPECT_NEAR(omega2, is, tolerance * is) << what << ": mode " << k + 1 << " of " << right.size();
    }
  }
}

class ModeTables : public testing::TestWithParam<Kind> {
 protected:
  static constexpr int kCases = 50;  // of each kind
};

TEST_P(ModeTables, AreTheEigenvaluesOfTheFile) {
  const test::Folder folder;
  std::map<std::string, int> refused;
  int judged = 0;
  for (int seed = 1; judged < kCases && seed < 4 * kCases; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1000 * static_cast<std::uint64_t>(GetParam()));
    const RandomPart part = random_part(chance, GetParam(), folder);
    if (!part.refused.empty()) {
      ++refused[part.refused.substr(0, 60)];
      continue;
    }
    ++judged;
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, part.text));
    superelement::write(folder / "part.se.h5", part.superelement);
    const Superelement se = superelement::read(folder / "part.se.h5", {.stiffening = true});
    // Few modes move some interface dofs hardly by themselves (kSameMotion): what the file's last digit is of K_se is up to 1e-6 of
    // the frequencies then.
    const double relative = GetParam() == Kind::flexdata ? 1e-6 : 1e-7;
    expect_same(natural_modes(se, {}), eigenvalues(se.K_se, se.M_se), relative, "free");
    std::vector<std::string> held;
    for (const auto& interface : se.interfaces)
      if (interface.following.empty() && chance.flip(0.6)) held.push_back(interface.name);
    const std::vector<int> dofs = not_held(se, held);
    expect_same(natural_modes(se, held), eigenvalues(se.K_se(dofs, dofs), se.M_se(dofs, dofs)), relative,
                "held");
    if (HasFailure()) break;
  }
  EXPECT_EQ(judged, kCases) << [&] {
    std::string text;
    for (const auto& [why, n] : refused) text += fmt::format("{} times {}\n", n, why);
    return text;
  }();
}

// What is exported comes back with the frequencies of the modes that were written.
TEST_P(ModeTables, AreThoseOfFlexDataThatIsReadBack) {
  const test::Folder folder;
  int judged = 0;
  for (int seed = 1; judged < kCases && seed < 4 * kCases; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1000 * static_cast<std::uint64_t>(GetParam()));
    const RandomPart part = random_part(chance, GetParam(), folder);
    if (!part.refused.empty()) continue;
    const int n = 1 + chance.below(10);
    const ModeAnalysis modes = natural_modes(part.superelement, {}, n);
    const int still = modes.n_rigid + modes.n_mechanisms;
    if (modes.n_rigid != 6 || modes.n_mechanisms > 0 || static_cast<int>(modes.modes.size()) == still)
      continue;
    ++judged;
    SCOPED_TRACE(fmt::format("seed {}, {} modes\n{}", seed, n, part.text));
    superelement::write_flexdata(folder / "out.xml", superelement::make_flexdata(part.superelement, modes));
    const Superelement back = reduce::reduce(reduce::read_flexdata_part(folder / "out.xml", {})).superelement;
    const ModeAnalysis again = natural_modes(back, {});
    ASSERT_EQ(again.modes.size(), modes.modes.size());
    for (std::size_t k = static_cast<std::size_t>(still); k < modes.modes.size(); ++k)
      EXPECT_NEAR(again.modes[k].frequency_hz, modes.modes[k].frequency_hz,
                  1e-5 * modes.modes[k].frequency_hz);
    if (HasFailure()) break;
  }
  EXPECT_EQ(judged, kCases);
}

INSTANTIATE_TEST_SUITE_P(Of, ModeTables, testing::ValuesIn(kKinds),
                         [](const auto& info) { return std::string(name_of(info.param)); });

}  // namespace
}  // namespace flexura::properties
