// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/force_field.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "mbs/formulas/expression.hpp"

namespace flexura::reduce {

namespace {

// At points (n x 3), which a message calls by `where`.
Eigen::VectorXd evaluate_at(const std::string& what, const std::string& text, const Eigen::MatrixX3d& points,
                            const char* where) {
  mbs::SignalNames names;
  const int x = names.add("x"), y = names.add("y"), z = names.add("z");
  const mbs::Expression formula(what, text, names, {});
  if (formula.reads_time())
    throw std::invalid_argument(fmt::format(
        "the formula \"{}\" reads the time t, which a load case does not have; it may use x, y, z", text));
  Eigen::VectorXd values(points.rows());
  std::vector<double> signals(static_cast<std::size_t>(names.size()), 0.0);
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    signals[x] = points(k, 0), signals[y] = points(k, 1), signals[z] = points(k, 2);
    try {
      values(k) = formula.evaluate(signals.data());
    } catch (const std::runtime_error&) {
      throw std::invalid_argument(
          fmt::format("the formula \"{}\" has no finite value at {} ({:.6g}, {:.6g}, {:.6g}) m; "
                      "check it where a divisor is zero",
                      text, where, points(k, 0), points(k, 1), points(k, 2)));
    }
  }
  return values;
}

}  // namespace

Eigen::MatrixX3d evaluate_field(const std::array<std::string, 3>& formulas, const mesh::Mesh& mesh) {
  Eigen::MatrixX3d values(mesh.n_nodes(), 3);
  for (int a = 0; a < 3; ++a)
    values.col(a) =
        evaluate_at(std::string("the component ") + "xyz"[a], formulas[a], mesh.points, "the node");
  return values;
}

Eigen::VectorXd evaluate_at_cells(const std::string& formula, const mesh::Mesh& mesh) {
  Eigen::MatrixX3d middles(mesh.n_solid_cells(), 3);
  Eigen::Index cell = 0;
  for (const mesh::CellBlock& block : mesh.solids)
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row, ++cell) {
      middles.row(cell).setZero();
      for (const mesh::Index node : block.nodes.row(row))
        middles.row(cell) += mesh.points.row(node) / static_cast<double>(block.nodes.cols());
    }
  return evaluate_at("the strain", formula, middles, "the element in");
}

}  // namespace flexura::reduce
