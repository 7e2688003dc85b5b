// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/recovery/stress.hpp"

#include <map>
#include <optional>

#include "reduce/elements/shell.hpp"
#include "reduce/elements/strain.hpp"

namespace flexura::reduce {

namespace {

std::vector<Eigen::Index> places_of(const Part& part, const std::vector<mesh::Index>& nodes) {
  std::vector<Eigen::Index> place(part.mesh.n_nodes(), -1);
  for (std::size_t v = 0; v < nodes.size(); ++v) place[nodes[v]] = static_cast<Eigen::Index>(v);
  return place;
}

int material_of(const mesh::CellBlock& block, Eigen::Index cell) {
  return block.material.empty() ? 0 : static_cast<int>(block.material[cell]);
}

}  // namespace

std::vector<std::pair<int, int>> nodal_materials(const Part& part, const std::vector<mesh::Index>& nodes) {
  const std::vector<Eigen::Index> place = places_of(part, nodes);
  std::vector<std::map<int, int>> cells(nodes.size());
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
      for (mesh::Index node : block.nodes.row(cell))
        if (place[node] >= 0) ++cells[place[node]][material_of(block, cell)];
  for (std::size_t b = 0; b < part.skins.size(); ++b)
    for (const ShellSkins::Corners* side : {&part.skins[b].top, &part.skins[b].bottom})
      for (Eigen::Index cell = 0; cell < side->rows(); ++cell)
        for (const mesh::Index node : side->row(cell))
          if (place[node] >= 0) ++cells[place[node]][material_of(part.mesh.shells[b], cell)];
  std::vector<std::pair<int, int>> chosen(nodes.size(), {-1, 0});
  for (const BeamStress& of : part.beam_stresses)
    if (place[of.point] >= 0) ++cells[place[of.point]][of.material];
  for (std::size_t v = 0; v < nodes.size(); ++v)
    for (const auto& [material, count] : cells[v])
      if (count > chosen[v].second) chosen[v] = {material, count};
  return chosen;
}

Eigen::MatrixXd nodal_stress_modes(const Part& part, const Eigen::MatrixXd& T,
                                   const std::vector<mesh::Index>& nodes, const Eigen::MatrixXd& rotations,
                                   const std::vector<int>& rotation_of) {
  const Eigen::Index n = T.cols();
  const std::vector<Eigen::Index> place = places_of(part, nodes);
  const std::vector<std::pair<int, int>> chosen = nodal_materials(part, nodes);
  Eigen::MatrixXd stress = Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(nodes.size()), n);
  StrainMatrix B;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const TabulatedRule at_nodes = tabulate(
        block.type,
        {mesh::reference_nodes(block.type), Eigen::VectorXd::Ones(mesh::nodes_per_cell(block.type))});
    NodePositions x(block.nodes.cols(), 3);
    const Element& element = solid_element(block.type, formulation_of(block, part.formulation));
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell) {
      const int material = material_of(block, cell);
      std::optional<StrainField> field;
      for (Eigen::Index a = 0; a < x.rows(); ++a) x.row(a) = part.mesh.points.row(block.nodes(cell, a));
      for (Eigen::Index c = 0; c < x.rows(); ++c) {
        const Eigen::Index v = place[block.nodes(cell, c)];
        if (v < 0 || chosen[v].first != material) continue;
        if (!field) field.emplace(element, x, part.materials[material].D);
        field->at(at_nodes.points[static_cast<std::size_t>(c)], B);
        Eigen::MatrixXd strain = Eigen::MatrixXd::Zero(6, n);
        for (Eigen::Index a = 0; a < x.rows(); ++a)
          strain +=
              B.middleCols<3>(3 * a) * T.middleRows<3>(3 * static_cast<Eigen::Index>(block.nodes(cell, a)));
        stress.middleRows<6>(6 * v) += part.materials[material].D * strain / chosen[v].second;
      }
    }
  }
  for (std::size_t b = 0; b < part.skins.size(); ++b) {
    const mesh::CellBlock& block = part.mesh.shells[b];
    NodePositions x(block.nodes.cols(), 3);
    Eigen::MatrixXd q(6 * x.rows(), n);
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell) {
      const int material = material_of(block, cell);
      const double t = block.thickness[cell];
      std::optional<ShellStress> of_cell;
      for (const bool top : {true, false})
        for (Eigen::Index c = 0; c < x.rows(); ++c) {
          const Eigen::Index v = place[(top ? part.skins[b].top : part.skins[b].bottom)(cell, c)];
          if (v < 0 || chosen[v].first != material) continue;
          if (!of_cell) {
            for (Eigen::Index a = 0; a < x.rows(); ++a) {
              const mesh::Index node = block.nodes(cell, a);
              x.row(a) = part.mesh.points.row(node);
              q.middleRows<3>(6 * a) = T.middleRows<3>(3 * static_cast<Eigen::Index>(node));
              q.middleRows<3>(6 * a + 3) =
                  rotations.middleRows<3>(3 * static_cast<Eigen::Index>(rotation_of.at(node)));
            }
            of_cell =
                shell_stress(x, part.materials[material], t, block.offset.empty() ? 0.0 : block.offset[cell]);
          }
          const auto corner = static_cast<std::size_t>(c);
          stress.middleRows<6>(6 * v) +=
              (top ? of_cell->top : of_cell->bottom)[corner] * q / chosen[v].second;
        }
    }
  }
  Eigen::MatrixXd q(12, n);
  for (const BeamStress& of : part.beam_stresses) {
    const Eigen::Index v = place[of.point];
    if (v < 0) continue;
    q.setZero();
    for (std::size_t end = 0; end < 2; ++end) {
      const auto row = 6 * static_cast<Eigen::Index>(end);
      q.middleRows<3>(row) = T.middleRows<3>(3 * static_cast<Eigen::Index>(of.nodes[end]));
      if (const int turns = rotation_of.at(of.nodes[end]); turns >= 0)  // not that of a rod
        q.middleRows<3>(row + 3) = rotations.middleRows<3>(3 * static_cast<Eigen::Index>(turns));
    }
    stress.middleRows<6>(6 * v) += of.of_nodes * q / chosen[v].second;
  }
  return stress;
}

Eigen::VectorXd nodal_initial_stress(const Part& part, const CellStrains& strain,
                                     const std::vector<mesh::Index>& nodes) {
  const std::vector<Eigen::Index> place = places_of(part, nodes);
  const std::vector<std::pair<int, int>> chosen = nodal_materials(part, nodes);
  Eigen::VectorXd stress = Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(nodes.size()));
  Eigen::Index of_all = 0;
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell, ++of_all) {
      const int material = material_of(block, cell);
      for (const mesh::Index node : block.nodes.row(cell))
        if (const Eigen::Index v = place[node]; v >= 0 && chosen[v].first == material)
          stress.segment<6>(6 * v) -=
              part.materials[material].D * strain.row(of_all).transpose() / chosen[v].second;
    }
  return stress;
}

}  // namespace flexura::reduce
