// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/beams/numbering.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace flexura::reduce {

using Eigen::MatrixXd;

Numbering::Numbering(const Structure& structure, const std::vector<BeamInterface>& interfaces) {
  const beam::BeamMesh& mesh = structure.mesh();
  if (interfaces.empty())
    throw std::invalid_argument("the beam part has no interface; name at least one node as an interface");
  code.assign(structure.n_dofs(), kUnused);
  const int n_nodes = mesh.n_dofs() / 6;
  for (const BeamInterface& interface : interfaces) {
    if (interface.node < 0 || interface.node >= static_cast<int>(mesh.model().nodes.size()) ||
        !structure.used()[6 * interface.node])
      throw std::invalid_argument(
          fmt::format("interface \"{}\": there is no node number {} with a member or solid", interface.name,
                      interface.node));
    if (interface.directions.empty() ||
        !std::is_sorted(interface.directions.begin(), interface.directions.end()) ||
        interface.directions.front() < 0 || interface.directions.back() > 5)
      throw std::invalid_argument(
          fmt::format("interface \"{}\": its directions must be some of 0 to 5, ascending", interface.name));
    for (const int direction : interface.directions) {
      int& code_here = code[6 * interface.node + direction];
      if (code_here != kUnused)
        throw std::invalid_argument(
            fmt::format("interface \"{}\": node \"{}\" is an interface already in this direction ({})",
                        interface.name, mesh.model().nodes[interface.node].name, direction));
      code_here = -(++n_b);
    }
  }
  group_begin.push_back(0);
  for (int node = 0; node < n_nodes; ++node) {
    if (!structure.used()[6 * node]) continue;
    for (int k = 0; k < 6; ++k)
      if (code[6 * node + k] == kUnused) {
        code[6 * node + k] = n_i++;
        dof_of.push_back(6 * node + k);
      }
    if (group_begin.back() < n_i) group_begin.push_back(n_i);
  }
  for (int mode = mesh.n_dofs(); mode < structure.n_dofs(); ++mode) {
    code[mode] = n_i++;
    dof_of.push_back(mode);
    group_begin.push_back(n_i);
  }
}

SplitMatrix::SplitMatrix(const beam::SparseMatrix& A, const Numbering& numbering) {
  ib = MatrixXd::Zero(numbering.n_i, numbering.n_b);
  std::vector<int> begin = {0}, columns;
  std::vector<std::pair<int, int>> row;
  for (int i = 0; i < numbering.n_i; ++i) {
    std::vector<int> entries;
    for (beam::SparseMatrix::InnerIterator it(A, numbering.dof_of[i]); it; ++it) {
      const int j = numbering.code[it.row()];
      if (j > i) entries.push_back(j);
    }
    std::sort(entries.begin(), entries.end());
    columns.push_back(i);
    columns.insert(columns.end(), entries.begin(), entries.end());
    begin.push_back(static_cast<int>(columns.size()));
  }
  ii = std::make_unique<linalg::SymmetricMatrix>(std::move(begin), std::move(columns));
  const auto add = [&](int i, int j, double value) {
    const std::array<int, 2> dofs = {i, j};
    MatrixXd block = MatrixXd::Zero(2, 2);
    block(0, 1) = block(1, 0) = value;
    ii->add(dofs, block);
  };
  for (int column = 0; column < A.outerSize(); ++column)
    for (beam::SparseMatrix::InnerIterator it(A, column); it; ++it) {
      const int r = numbering.code[it.row()], c = numbering.code[column];
      if (r == Numbering::kUnused || c == Numbering::kUnused) continue;
      if (r >= 0 && c >= 0) {
        if (r == c)
          ii->add_to_diagonal(r, it.value());
        else if (r < c)
          add(r, c, it.value());
      } else if (r >= 0) {
        ib(r, -c - 1) = it.value();
      }
    }
  ii->finish();
}

linalg::CholeskyFactor factorise(const Structure& structure, const Numbering& numbering,
                                 const SplitMatrix& K) {
  try {
    return linalg::CholeskyFactor(*K.ii, numbering.group_begin);
  } catch (const linalg::SingularMatrix& error) {
    throw std::invalid_argument(fmt::format(
        "the interfaces do not hold the beam part: it can move without strain, noticed at {}; let the "
        "interfaces keep more directions",
        structure.describe(numbering.dof_of[error.dof])));
  }
}

MatrixXd solve_refined(const linalg::CholeskyFactor& factor, const linalg::SymmetricMatrix& K,
                       const MatrixXd& B) {
  MatrixXd X = factor.solve(B), KX;
  K.multiply(X, KX);
  X += factor.solve(B - KX);
  return X;
}

}  // namespace flexura::reduce
