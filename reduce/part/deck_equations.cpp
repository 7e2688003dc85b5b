// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/deck_equations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "reduce/assembly/input/constraints.hpp"

namespace flexura::reduce {

void add_equations(const PartInput& input, const PartMesh& from, ModelledPart& out) {
  if (from.equations.empty()) return;
  Part& part = out.part;
  std::vector<char> follows(part.mesh.n_nodes(), 0);
  for (const InterfaceSpec& spec : part.interfaces)
    if (spec.tie == Tie::rigid || spec.tie == Tie::node)
      for (const mesh::Index node : spec.set.nodes) follows[node] = 1;
  std::vector<LinearEquation> equations;
  std::size_t to_ground = 0;
  std::string first;
  for (const mesh::ImportedEquation& equation : from.equations) {
    LinearEquation& to = equations.emplace_back();
    to.of = equation.of;
    for (const mesh::ImportedEquation::Term& term : equation.terms) {
      std::array<int, 6> order{0, 1, 2, 3, 4, 5};  // an oblique direction by its largest component
      std::ranges::stable_sort(order, std::ranges::greater(), [&](int d) { return std::abs(term.row(d)); });
      for (const int d : order)
        if (term.row(d) != 0.0) to.terms.emplace_back(NodalDof{term.node, d}, term.row(d));
    }
    const std::string motion = to.terms.empty() ? "" : resisted_motion(to, part.mesh.points);
    if (!motion.empty()) {
      if (to_ground++ == 0) first = fmt::format("{}, resists {}", to.of, motion);
    }
    if (to.terms.empty() || !motion.empty()) equations.pop_back();
  }
  if (to_ground > 0) {
    out.warnings.push_back(fmt::format(
        "{} equation{} bind{} the body to the ground (the first, {} of the whole body) and {} left "
        "out as supports are: a superelement is a free body, joints hold it at run time",
        to_ground, to_ground == 1 ? "" : "s", to_ground == 1 ? "s" : "", first,
        to_ground == 1 ? "is" : "are"));
    if (input.strict)
      throw std::invalid_argument(out.warnings.back() + "; take --strict away to have it left out");
  }
  part.dependent =
      eliminate(equations, part.mesh.points, [&](const NodalDof& dof) { return !follows[dof.node]; });
}

}  // namespace flexura::reduce
