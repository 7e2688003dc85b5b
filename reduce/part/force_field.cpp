// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/force_field.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <numbers>
#include <stdexcept>

#include "mbs/base/documents/formula_text.hpp"
#include "mbs/base/documents/shown_text.hpp"

namespace flexura::reduce {

Eigen::MatrixX3d evaluate_field(const std::array<std::string, 3>& formulas, const mesh::Mesh& mesh) {
  Eigen::MatrixX3d values(mesh.n_nodes(), 3);
  double x[3];
  for (int a = 0; a < 3; ++a) {
    const auto refuse = [&](const std::string& why) {
      throw std::invalid_argument(
          fmt::format("the formula \"{}\" cannot be read ({}); it may use x, y, z and pi",
                      input::shown_text(formulas[a]), why));
    };
    if (const std::string why = input::wrong_with_formula(formulas[a]); !why.empty()) refuse(why);
    mu::Parser parser;
    parser.DefineVar("x", &x[0]);
    parser.DefineVar("y", &x[1]);
    parser.DefineVar("z", &x[2]);
    parser.DefineConst("pi", std::numbers::pi);
    try {
      parser.SetExpr(formulas[a]);
      for (mesh::Index node = 0; node < mesh.n_nodes(); ++node) {
        for (int b = 0; b < 3; ++b) x[b] = mesh.points(node, b);
        values(node, a) = parser.Eval();
      }
    } catch (const mu::Parser::exception_type& error) {
      refuse(input::shown_text(error.GetMsg(), 120));
    }
  }
  if (!values.allFinite())
    throw std::invalid_argument(
        "the formulas give a value that is not finite at a node of the part; check them where a divisor is "
        "zero");
  return values;
}

}  // namespace flexura::reduce
