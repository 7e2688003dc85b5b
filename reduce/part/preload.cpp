// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/preload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "mbs/base/documents/document.hpp"
#include "reduce/part/force_field.hpp"

namespace flexura::reduce {

CellStrains preload_strain(const LoadInput& wanted, const Part& part) {
  const mesh::Mesh& mesh = part.mesh;
  if (mesh.n_solid_cells() == 0 || part.matrices)
    throw std::invalid_argument(
        "a preload strains solid elements, and the part has none; take it away, or write preload in the load "
        "of a beam part");
  int material = -1;
  if (!wanted.material.empty()) {
    std::vector<std::string> names;
    for (const Material& one : part.materials) names.push_back(one.name);
    const auto at = std::ranges::find(names, wanted.material);
    if (at == names.end())
      throw std::invalid_argument(fmt::format("there is no material \"{}\"{}", wanted.material,
                                              input::suggestion(wanted.material, names)));
    material = static_cast<int>(at - names.begin());
  }
  const Eigen::Vector3d& a = wanted.vector;
  Eigen::Matrix<double, 1, 6> unit;
  unit << 1.0, 1.0, 1.0, 0.0, 0.0, 0.0;
  if (!a.isZero(0.0))
    unit << a.x() * a.x(), a.y() * a.y(), a.z() * a.z(), 2.0 * a.x() * a.y(), 2.0 * a.y() * a.z(),
        2.0 * a.z() * a.x();
  CellStrains strain = evaluate_at_cells(wanted.strain, mesh) * unit;
  Eigen::Index cell = 0;
  for (const mesh::CellBlock& block : mesh.solids)
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row, ++cell)
      if (material >= 0 && (block.material.empty() ? 0 : block.material[row]) != material)
        strain.row(cell).setZero();
  const double largest = strain.leftCols<3>().cwiseAbs().maxCoeff();
  if (largest == 0.0)
    throw std::invalid_argument(fmt::format(
        "the strain \"{}\" is zero in the middle of every element{}: nothing is preloaded; correct where it "
        "is not zero, in m, or refine the mesh there",
        wanted.strain, material >= 0 ? " of the material" : ""));
  if (largest > 0.1)
    throw std::invalid_argument(
        fmt::format("the strain reaches {:.3g}, and must stay below 0.1, up to which elasticity is linear "
                    "here (steel bears some 0.001); give a length over a length, without per cent",
                    largest));
  return strain;
}

}  // namespace flexura::reduce
