// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/element.hpp"

#include <map>
#include <stdexcept>
#include <string>
#include <utility>

#include "mesh/model/cells/record.hpp"

namespace flexura::reduce {
namespace {

using mesh::CellType;

mesh::Quadrature centre_of(CellType type) {
  const Eigen::Matrix<double, 1, 3> centre = mesh::reference_nodes(type).colwise().mean();
  return {centre, Eigen::VectorXd::Ones(1)};
}

// Mass is integrated with the rule that the mesh's own volume, centre and inertia are measured with, so that
// both agree to round-off on curved cells too (tetrahedra: degree 5; degree 4 is exact for a straight tet10).
// Stiffness of tet10 has 4 points like Abaqus' C3D10 and CalculiX: exact for straight edges, where strains
// are linear; for curved ones the usual reduced integration.
Element make(CellType type, Lumping lumping, Enhancement enhancement = Enhancement::none) {
  return {type,
          mesh::nodes_per_cell(type),
          tabulate(type, mesh::stiffness_quadrature(type)),
          tabulate(type, mesh::volume_quadrature(type)),
          tabulate(type, centre_of(type)),
          lumping,
          enhancement};
}

using Registry = std::map<std::pair<CellType, Formulation>, Element>;

Registry make_registry() {
  Registry registry;
  const auto add = [&registry](Formulation formulation, Element element) {
    registry.emplace(std::pair{element.type, formulation}, std::move(element));
  };
  for (const mesh::CellRecord& record : mesh::cell_records())
    if (record.is_solid())
      add(Formulation::standard, make(record.type, record.is_linear() ? Lumping::row_sum : Lumping::scaled));
  add(Formulation::enhanced, make(CellType::hex8, Lumping::row_sum, Enhancement::bubbles));
  // Eight points leave six modes of a single element without energy beside its rigid motions.  Those of neighbours do not fit
  // to one another where two elements lie across and along (Zienkiewicz, Taylor, vol. 1, 12.5); a single row of elements keeps one
  // for each, even with one end held (tied_solver.cpp says so).  The mass stays whole.
  Element reduced = make(CellType::hex20, Lumping::scaled);
  reduced.stiffness = tabulate(CellType::hex20, mesh::stiffness_quadrature(CellType::hex8));
  reduced.strains = Strains::at_points;
  add(Formulation::reduced, std::move(reduced));
  Element uniform = make(CellType::hex8, Lumping::row_sum);
  uniform.strains = Strains::uniform;
  add(Formulation::reduced, std::move(uniform));
  Element mean = make(CellType::hex8, Lumping::row_sum);
  mean.strains = Strains::mean_volume;
  add(Formulation::mean_volume, std::move(mean));
  return registry;
}

}  // namespace

Formulation formulation_of(const mesh::CellBlock& block, Formulation of_part) {
  switch (block.variant) {
    case mesh::CellVariant::reduced:
      return Formulation::reduced;
    case mesh::CellVariant::bubbles:
      return Formulation::enhanced;
    case mesh::CellVariant::mean_volume:
      if (of_part == Formulation::standard) return Formulation::mean_volume;
      break;
    case mesh::CellVariant::standard:
      break;
  }
  return of_part;
}

TabulatedRule tabulate(CellType type, const mesh::Quadrature& rule) {
  TabulatedRule table;
  for (Eigen::Index q = 0; q < rule.weights.size(); ++q) {
    const Eigen::Vector3d xi = rule.points.row(q);
    const mesh::ShapeValues values = mesh::evaluate_shape(type, xi);
    table.points.push_back({rule.weights(q), xi, values.N, values.dN});
  }
  return table;
}

const Element& solid_element(CellType type, Formulation formulation) {
  static const Registry registry = make_registry();  // built on first use, constant from then on
  auto found = registry.find({type, formulation});
  if (found == registry.end()) found = registry.find({type, Formulation::standard});
  if (found == registry.end())
    throw std::invalid_argument(std::string("cells of type ") + mesh::name_of(type) +
                                " are not solid elements");
  return found->second;
}

}  // namespace flexura::reduce
