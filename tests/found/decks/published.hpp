// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/found/parts.hpp"
#include "tests/reference.hpp"

namespace flexura::test {

using Six = std::array<double, 6>;

/// Decks of others with the displacements that they print.
class DeckPublished : public Parts {
 protected:
  /// An interface gN at each node N.
  /// Statics ask for no density: where the deck has none, `rest` gives it.
  Reduced reduce_at(const std::string& deck, const std::vector<int>& nodes, const std::string& rest = "") {
    std::string part = rest;
    for (const int node : nodes)
      part += fmt::format("[interface.g{}]\nby = \"nodes\"\nnodes = [{}]\n", node, node);
    return reduce_deck(deck, part + "[modes]\ncount = 1\n", {}, "DECK.DAT");
  }
  static Eigen::Index first(const superelement::Superelement& se, int node) {
    for (const auto& i : se.interfaces)
      if (i.name == fmt::format("g{}", node)) return i.first_dof;
    ADD_FAILURE() << "no interface g" << node;
    return 0;
  }
  /// Displacements under loads with the directions `held` (digits) of nodes at rest.
  static Eigen::VectorXd solve(const superelement::Superelement& se, const std::map<int, std::string>& held,
                               const std::map<int, Six>& loads) {
    std::vector<bool> fixed(static_cast<std::size_t>(se.n()));
    for (const auto& [node, digits] : held)
      for (const char c : digits) fixed[static_cast<std::size_t>(first(se, node) + c - '1')] = true;
    std::vector<int> free;
    for (int k = 0; k < se.n(); ++k)
      if (!fixed[static_cast<std::size_t>(k)]) free.push_back(k);
    Eigen::VectorXd p = Eigen::VectorXd::Zero(se.n()), u = p;
    for (const auto& [node, load] : loads)
      p.segment<6>(first(se, node)) = Eigen::Map<const Eigen::VectorXd>(load.data(), 6);
    const Eigen::MatrixXd K = se.K_se(free, free);
    u(free) = K.ldlt().solve(Eigen::VectorXd(p(free))).eval();
    return u;
  }
  /// The six of a node against those printed, each to half a unit of its seventh digit.
  static void compare(const std::string& what, const superelement::Superelement& se, const Eigen::VectorXd& u,
                      int node, const Six& printed, const char* source, double relative = 0) {
    static const char* const kNames[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
    double size[2] = {0, 0};
    for (int d = 0; d < 6; ++d)
      size[d / 3] = std::max(size[d / 3], std::abs(printed[static_cast<std::size_t>(d)]));
    for (int d = 0; d < 6; ++d) {
      const double value = printed[static_cast<std::size_t>(d)];
      const double digit = value == 0 ? 1e-9 * size[d / 3]
                                      : 0.51 * std::pow(10.0, std::floor(std::log10(std::abs(value))) - 6);
      expect_reference(fmt::format("{}, node {}, {}", what, node, kNames[d]), "", u(first(se, node) + d),
                       value, std::max(digit, relative * size[d / 3]), {source, "the last digit printed"});
    }
  }
};

}  // namespace flexura::test
