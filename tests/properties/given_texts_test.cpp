// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// For all that other programs print of a model: stresses by elements, matrices by Nastran's cards.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "mbs/superelement/exchange/exchange.hpp"
#include "reduce/file/part_file.hpp"
#include "reduce/library/reduce.hpp"
#include "reduce/part/nastran_matrices.hpp"
#include "tests/app/command.hpp"
#include "tests/properties/six_dof_models.hpp"

namespace flexura::properties {
namespace {

// Stresses of elements or of their corners are those of the nodes, as means over the elements that have the node.
TEST(GivenMatrices, StressesOfElementsAreAveragedAtNodes) {
  const test::Folder folder;
  for (int seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const std::string deck = random_sheet(chance, 2, 2 + chance.below(2));
    folder.write("part.inp", deck);
    const std::string rest = "[interface.a]\nby = \"nodes\"\nnodes = [1]\n";
    const reduce::PartInput own =
        reduce::read_part(folder.write("own.toml", "[geometry]\nfile = \"part.inp\"\nunit = \"m\"\n" + rest));
    const Model model = full_model(own);
    const Index n_v = 4;
    MatrixXd V(model.K.rows(), n_v);
    for (double& v : V.reshaped()) v = chance.between(-1.0, 1.0);
    // Elements and their nodes, as the deck's text has them.
    std::map<std::int64_t, std::vector<std::int64_t>> elements;
    bool inside = false;
    for (std::size_t at = 0; at < deck.size(); at = deck.find('\n', at) + 1) {
      const std::string line = deck.substr(at, deck.find('\n', at) - at);
      if (line[0] == '*') {
        inside = line.starts_with("*ELEMENT");
        continue;
      }
      if (!inside) continue;
      std::vector<std::int64_t> numbers;
      for (std::size_t k = 0; k != std::string::npos && k < line.size(); k = line.find(',', k) + 1) {
        numbers.push_back(std::atoll(line.c_str() + k));
        if (line.find(',', k) == std::string::npos) break;
      }
      std::sort(numbers.begin() + 1, numbers.end());
      elements[numbers[0]] = {numbers.begin() + 1, numbers.end()};
    }
    const bool corners = chance.flip(0.5);
    Index rows = 0;
    for (const auto& [label, nodes] : elements) rows += corners ? 6 * static_cast<Index>(nodes.size()) : 6;
    MatrixXd given(rows, n_v), mean = MatrixXd::Zero(6 * model.n(), n_v);
    for (double& v : given.reshaped()) v = chance.between(-1e6, 1e6);
    for (Index a = 0; a < model.n(); ++a) {
      Index row = 0;
      int count = 0;
      for (const auto& [label, nodes] : elements)
        for (std::size_t k = 0; k < nodes.size(); ++k) {
          if (nodes[k] == model.label[static_cast<std::size_t>(a)]) {
            mean.middleRows<6>(6 * a) += given.middleRows<6>(row);
            ++count;
          }
          if (corners || k + 1 == nodes.size()) row += 6;
        }
      mean.middleRows<6>(6 * a) /= count;
    }
    folder.write("V.txt", dense(V)), folder.write("K.txt", dense(V.transpose() * model.K * V));
    folder.write("M.txt", written(model, model.M, Format::market, "", chance));
    folder.write("elements.txt", dense(given)), folder.write("nodes.txt", dense(mean));
    const auto stress = [&](const char* file, const char* place) {
      const std::string text = fmt::format(
          "[geometry]\nfile = \"part.inp\"\nunit = \"m\"\n[mode_vectors]\nvectors = \"V.txt\"\nstiffness = "
          "\"K.txt\"\nmass = \"M.txt\"\nstress = \"{}\"\nstress_at = \"{}\"\n[recovery]\nstress = "
          "true\nprecision = "
          "\"double\"\n",
          file, place);
      const Superelement se =
          reduce::reduce(reduce::read_part(folder.write("part.toml", text + rest))).superelement;
      return se.stress.value().S;
    };
    const auto right = stress("nodes.txt", "nodes"),
               found = stress("elements.txt", corners ? "corners" : "elements");
    ASSERT_EQ(right.rows(), 6 * model.n());
    // Sums of up to six numbers that are printed in full.
    EXPECT_LT((found - right).norm(), 1e-12 * right.norm());
    EXPECT_GT(right.norm(), 0.0);
    if (testing::Test::HasFailure()) return;
  }
}

// The digits that a DMIG file has are the digits that are read: small fields, and what `flexura export -f dmig` writes.
TEST(GivenMatrices, DmigIsReadToTheLastDigit) {
  const test::Folder folder;
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const Model model = random_model(chance);
    const auto as_printed = [](const std::string& text) { return std::strtod(text.c_str(), nullptr); };
    // Exponents stay within a small field's: two digits.
    std::map<std::array<std::int64_t, 4>, double> found;
    reduce::read_dmig(folder.write("small.pch", written(model, model.K, Format::small, "K2GG", chance) +
                                                    written(model, model.M, Format::small, "M2GG", chance)),
                      'K', [&](const reduce::DmigEntry& e) {
                        found[{e.point[0], e.component[0], e.point[1], e.component[1]}] = e.value;
                        found[{e.point[1], e.component[1], e.point[0], e.component[0]}] = e.value;
                      });
    std::size_t count = 0;
    for (Index i = 0; i < model.K.rows(); ++i)
      for (Index j = 0; j < model.K.cols(); ++j) {
        if (model.K(i, j) == 0.0) continue;
        ++count;
        const auto at = found.find({model.label[static_cast<std::size_t>(i / 6)], i % 6 + 1,
                                    model.label[static_cast<std::size_t>(j / 6)], j % 6 + 1});
        ASSERT_NE(at, found.end()) << i << " " << j;
        // Of a mirror image the other triangle's number may be printed, which rounding can set apart.
        EXPECT_NEAR(at->second, as_printed(fmt::format("{:.2E}", model.K(i, j))),
                    1.1e-2 * std::abs(model.K(i, j)));
      }
    EXPECT_EQ(found.size(), count);

    Superelement se;
    se.name = "random";
    const int n_b = 6 + 6 * chance.below(2);
    for (int k = 0; 6 * k < n_b; ++k) {
      superelement::Interface interface;
      interface.name = fmt::format("i{}", k);
      for (int d = 0; d < 6; ++d) interface.directions.push_back(static_cast<superelement::Direction>(d));
      interface.first_dof = 6 * k;
      se.interfaces.push_back(interface);
    }
    se.n_b = n_b, se.n_q = chance.below(5);
    const auto random = [&] {
      MatrixXd A(se.n(), se.n());
      for (double& a : A.reshaped())
        a = chance.either_sign(0.1, 1.0) * std::pow(10.0, chance.between(-30.0, 30.0)) *
            (chance.flip(0.8) ? 1.0 : 0.0);
      return MatrixXd(0.5 * (A + A.transpose()));
    };
    se.K_se = random(), se.M_se = random(), se.D_se = random();
    superelement::write_dmig(folder / "flex.dmig", se);
    ASSERT_TRUE(reduce::is_nastran_text(folder / "flex.dmig"));
    const std::pair<char, const MatrixXd*> all[] = {{'K', &se.K_se}, {'M', &se.M_se}, {'B', &se.D_se}};
    for (const auto& [letter, A] : all) {
      MatrixXd read = MatrixXd::Zero(se.n(), se.n());
      const auto place = [&](std::int64_t point, int component) {
        return component == 0 ? n_b + point - 1'000'001 : 6 * (point - 1) + component - 1;
      };
      reduce::read_dmig(folder / "flex.dmig", letter, [&](const reduce::DmigEntry& e) {
        const Index i = place(e.point[0], e.component[0]), j = place(e.point[1], e.component[1]);
        read(i, j) = read(j, i) = e.value;
      });
      for (Index i = 0; i < se.n(); ++i)
        for (Index j = 0; j < se.n(); ++j)
          EXPECT_EQ(read(i, j), as_printed(fmt::format("{:.9E}", (*A)(i, j))));
    }
    if (testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace flexura::properties
