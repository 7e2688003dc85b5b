// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/force_field.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "mbs/formulas/expression.hpp"

namespace flexura::reduce {

Eigen::MatrixX3d evaluate_field(const std::array<std::string, 3>& formulas, const mesh::Mesh& mesh) {
  mbs::SignalNames names;
  const int x = names.add("x"), y = names.add("y"), z = names.add("z");
  Eigen::MatrixX3d values(mesh.n_nodes(), 3);
  std::vector<double> signals(static_cast<std::size_t>(names.size()), 0.0);
  for (int a = 0; a < 3; ++a) {
    const mbs::Expression formula(std::string("the component ") + "xyz" [a], formulas[a], names, {});
    if (formula.reads_time())
      throw std::invalid_argument(fmt::format(
          "the formula \"{}\" reads the time t, which a load case does not have; it may use x, y, z",
          formulas[a]));
    for (mesh::Index node = 0; node < mesh.n_nodes(); ++node) {
      signals[x] = mesh.points(node, 0), signals[y] = mesh.points(node, 1), signals[z] = mesh.points(node, 2);
      try {
        values(node, a) = formula.evaluate(signals.data());
      } catch (const std::runtime_error&) {
        throw std::invalid_argument(
            fmt::format("the formula \"{}\" has no finite value at the node ({:.6g}, {:.6g}, {:.6g}) m; "
                        "check it where a divisor is zero",
                        formulas[a], mesh.points(node, 0), mesh.points(node, 1), mesh.points(node, 2)));
      }
    }
  }
  return values;
}

}  // namespace flexura::reduce
