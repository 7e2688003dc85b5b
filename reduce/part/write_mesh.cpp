// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/write_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "mbs/base/files/output.hpp"
#include "mesh/model/cells/record.hpp"
#include "mesh/model/geometry.hpp"

namespace flexura::reduce {
namespace {

using mesh::CellBlock;
using mesh::CellType;

const mesh::ForeignCell& names_of(CellType type) {
  return mesh::record_of(type).foreign;
}

std::string ending_of(const std::filesystem::path& path) {
  std::string end = path.extension().string();
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return end;
}

std::vector<const CellBlock*> blocks_of(const mesh::Mesh& mesh) {
  std::vector<const CellBlock*> out;
  for (const auto* blocks : {&mesh.solids, &mesh.shells})
    for (const CellBlock& block : *blocks) out.push_back(&block);
  return out;
}

// The numbers of the file that the mesh came from, where each node has one of its own; else from 1.
std::vector<std::int64_t> labels_of(const mesh::Mesh& mesh) {
  std::vector<std::int64_t> labels = mesh.node_label;
  std::vector<std::int64_t> sorted = labels;
  std::ranges::sort(sorted);
  const bool good = labels.size() == static_cast<std::size_t>(mesh.n_nodes()) && !sorted.empty() &&
                    sorted.front() > 0 && std::ranges::adjacent_find(sorted) == sorted.end();
  if (good) return labels;
  labels.resize(static_cast<std::size_t>(mesh.n_nodes()));
  for (std::size_t k = 0; k < labels.size(); ++k) labels[k] = static_cast<std::int64_t>(k) + 1;
  return labels;
}

std::string set_name(std::string name) {
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return std::isalpha(static_cast<unsigned char>(name[0])) ? name : "S_" + name;
}

// A material in its own axes; false where it is turned against those of the mesh, for which the deck would want more.
bool abaqus_material(const Material& material, fmt::memory_buffer& out) {
  if (!material.plies.empty()) return false;
  const Eigen::Matrix<double, 6, 6> S = material.D.inverse();
  Eigen::Matrix<double, 6, 6> coupling = material.D;
  coupling.topLeftCorner<3, 3>().setZero();
  coupling.diagonal().setZero();
  if (coupling.cwiseAbs().maxCoeff() > 1e-9 * material.D.cwiseAbs().maxCoeff()) return false;
  const double E = 1.0 / S(0, 0), nu = -S(0, 1) * E;
  const auto to = std::back_inserter(out);
  fmt::format_to(to, "*MATERIAL, NAME={}\n", material.name);
  if ((isotropic(material.name, E, nu, material.density).D - material.D).cwiseAbs().maxCoeff() < 1e-9 * E) {
    fmt::format_to(to, "*ELASTIC\n{:.17g}, {:.17g}\n", E, nu);
  } else {
    fmt::format_to(to,
                   "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n{:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}, "
                   "{:.17g}, {:.17g}, {:.17g}\n{:.17g}\n",
                   E, 1.0 / S(1, 1), 1.0 / S(2, 2), nu, -S(0, 2) * E, -S(1, 2) / S(1, 1), 1.0 / S(3, 3),
                   1.0 / S(5, 5), 1.0 / S(4, 4));
  }
  fmt::format_to(to, "*DENSITY\n{:.17g}\n", material.density);
  return true;
}

std::string abaqus_name(const CellBlock& block) {
  if (block.type == CellType::hex20 && block.variant == mesh::CellVariant::reduced) return "C3D20R";
  if (block.type == CellType::hex8 && block.variant == mesh::CellVariant::reduced) return "C3D8R";
  if (block.type == CellType::hex8 && block.variant == mesh::CellVariant::bubbles) return "C3D8I";
  return names_of(block.type).abaqus;
}

std::string abaqus(const mesh::Mesh& mesh, const std::vector<Material>& materials) {
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  const std::vector<std::int64_t> labels = labels_of(mesh);
  fmt::format_to(to, "*HEADING\nmesh of a part, lengths in m\n*NODE\n");
  for (mesh::Index k = 0; k < mesh.n_nodes(); ++k)
    fmt::format_to(to, "{}, {:.17g}, {:.17g}, {:.17g}\n", labels[k], mesh.points(k, 0), mesh.points(k, 1),
                   mesh.points(k, 2));
  std::int64_t element = 0;
  int number = 0;
  fmt::memory_buffer sections;
  // Cells of one block with one material, thickness and offset.
  using Kind = std::tuple<mesh::Index, double, double>;
  const auto kind_of = [](const CellBlock& block, Eigen::Index cell) {
    const auto k = static_cast<std::size_t>(cell);
    return Kind{block.material.empty() ? 0 : block.material[k],
                block.thickness.empty() ? 0.0 : block.thickness[k],
                block.offset.empty() ? 0.0 : block.offset[k]};
  };
  const auto write_cells = [&](const CellBlock* block, const Kind& kind) {
    const mesh::ForeignCell& names = names_of(block->type);
    fmt::format_to(to, "*ELEMENT, TYPE={}, ELSET=CELLS_{}\n", abaqus_name(*block), ++number);
    const auto& [material, thickness, offset] = kind;
    if (static_cast<std::size_t>(material) < materials.size()) {
      const auto section = std::back_inserter(sections);
      const std::string& name = materials[static_cast<std::size_t>(material)].name;
      if (mesh::dimension_of(block->type) == 3)
        fmt::format_to(section, "*SOLID SECTION, ELSET=CELLS_{}, MATERIAL={}\n", number, name);
      else
        fmt::format_to(section, "*SHELL SECTION, ELSET=CELLS_{}, MATERIAL={}{}\n{:.17g}, 5\n", number, name,
                       offset != 0.0 ? fmt::format(", OFFSET={:.17g}", -offset / thickness) : "", thickness);
    }
    for (Eigen::Index cell = 0; cell < block->nodes.rows(); ++cell) {
      if (kind_of(*block, cell) != kind) continue;
      fmt::format_to(to, "{}", ++element);
      for (Eigen::Index a = 0; a < block->nodes.cols(); ++a) {
        const auto ours = names.abaqus_order.empty() ? a : names.abaqus_order[static_cast<std::size_t>(a)];
        // Sixteen entries on a line at most; a comma at its end goes on.
        fmt::format_to(to, "{}{}", a % 15 == 14 ? ",\n" : ", ", labels[block->nodes(cell, ours)]);
      }
      fmt::format_to(to, "\n");
    }
  };
  for (const CellBlock* block : blocks_of(mesh)) {
    if (names_of(block->type).abaqus.empty())
      throw std::invalid_argument(
          fmt::format("Abaqus knows no cells of type {}; write .vtu or .msh", mesh::name_of(block->type)));
    std::vector<Kind> kinds;
    for (Eigen::Index cell = 0; cell < block->nodes.rows(); ++cell)
      if (const Kind kind = kind_of(*block, cell); std::ranges::find(kinds, kind) == kinds.end())
        kinds.push_back(kind);
    for (const Kind& kind : kinds) write_cells(block, kind);
  }
  fmt::memory_buffer deck;
  bool known = !materials.empty();
  for (const Material& material : materials) known = known && abaqus_material(material, deck);
  if (known) fmt::format_to(to, "{}{}", fmt::to_string(deck), fmt::to_string(sections));
  for (const auto& [name, set] : mesh.sets) {
    fmt::format_to(to, "*NSET, NSET={}\n", set_name(name));
    for (std::size_t k = 0; k < set.nodes.size(); ++k)
      fmt::format_to(to, "{}{}", labels[set.nodes[k]], k % 8 == 7 || k + 1 == set.nodes.size() ? "\n" : ", ");
  }
  return fmt::to_string(out);
}

std::string gmsh(const mesh::Mesh& mesh) {
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  fmt::format_to(to, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", mesh.n_nodes());
  for (mesh::Index k = 0; k < mesh.n_nodes(); ++k)
    fmt::format_to(to, "{} {:.17g} {:.17g} {:.17g}\n", k + 1, mesh.points(k, 0), mesh.points(k, 1),
                   mesh.points(k, 2));
  const auto blocks = blocks_of(mesh);
  Eigen::Index n = 0, element = 0;
  for (const CellBlock* block : blocks) n += block->nodes.rows();
  fmt::format_to(to, "$EndNodes\n$Elements\n{}\n", n);
  for (const CellBlock* block : blocks) {
    const mesh::ForeignCell& names = names_of(block->type);
    std::vector<mesh::Index> nodes(static_cast<std::size_t>(block->nodes.cols()));
    for (Eigen::Index cell = 0; cell < block->nodes.rows(); ++cell) {
      for (std::size_t a = 0; a < nodes.size(); ++a)
        nodes[names.gmsh_order.empty() ? a : static_cast<std::size_t>(names.gmsh_order[a])] =
            block->nodes(cell, static_cast<Eigen::Index>(a)) + 1;
      const auto material = block->material.empty() ? 1 : block->material[static_cast<std::size_t>(cell)] + 1;
      fmt::format_to(to, "{} {} 2 {} 1 {}\n", ++element, names.gmsh, material, fmt::join(nodes, " "));
    }
  }
  fmt::format_to(to, "$EndElements\n");
  return fmt::to_string(out);
}

std::string vtu(const mesh::Mesh& mesh) {
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  const auto blocks = blocks_of(mesh);
  Eigen::Index n = 0;
  for (const CellBlock* block : blocks) n += block->nodes.rows();
  fmt::format_to(
      to,
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n"
      "<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
      mesh.n_nodes(), n);
  for (mesh::Index k = 0; k < mesh.n_nodes(); ++k)
    fmt::format_to(to, "{:.17g} {:.17g} {:.17g}\n", mesh.points(k, 0), mesh.points(k, 1), mesh.points(k, 2));
  fmt::format_to(to,
                 "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" "
                 "format=\"ascii\">\n");
  const auto each = [&](const auto& visit) {
    for (const CellBlock* block : blocks)
      for (Eigen::Index cell = 0; cell < block->nodes.rows(); ++cell) visit(*block, cell);
  };
  each([&](const CellBlock& block, Eigen::Index cell) {
    for (Eigen::Index a = 0; a < block.nodes.cols(); ++a) fmt::format_to(to, "{} ", block.nodes(cell, a));
    fmt::format_to(to, "\n");
  });
  fmt::format_to(to, "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n");
  Eigen::Index offset = 0;
  each([&](const CellBlock& block, Eigen::Index) {
    fmt::format_to(to, "{}\n", offset += block.nodes.cols());
  });
  fmt::format_to(to, "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  each([&](const CellBlock& block, Eigen::Index) { fmt::format_to(to, "{}\n", names_of(block.type).vtk); });
  fmt::format_to(
      to,
      "</DataArray>\n</Cells>\n<CellData>\n<DataArray type=\"Int64\" Name=\"material\" format=\"ascii\">\n");
  each([&](const CellBlock& block, Eigen::Index cell) {
    fmt::format_to(to, "{}\n", block.material.empty() ? 0 : block.material[static_cast<std::size_t>(cell)]);
  });
  fmt::format_to(to, "</DataArray>\n</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
  return fmt::to_string(out);
}

}  // namespace

bool is_mesh_ending(const std::filesystem::path& path) {
  const std::string end = ending_of(path);
  return end == ".inp" || end == ".vtu" || end == ".msh";
}

void write_mesh(const std::filesystem::path& path, const mesh::Mesh& mesh,
                const std::vector<Material>& materials) {
  const std::string end = ending_of(path);
  if (!is_mesh_ending(path))
    throw std::invalid_argument(fmt::format(
        "{}: must end in .inp (Abaqus), .vtu (ParaView) or .msh (gmsh), not in \"{}\"", path.string(), end));
  mesh::Mesh plain = mesh;  // without the points around shells and beams
  plain.boundary.clear();
  plain.boundary_face.clear();
  mesh::drop_unused_nodes(plain);
  if (blocks_of(plain).empty())
    throw std::invalid_argument(
        path.string() + ": the part has no cells to write (it is made of beams alone); leave --mesh out");
  files::write_whole(path, end == ".inp"   ? abaqus(plain, materials)
                           : end == ".vtu" ? vtu(plain)
                                           : gmsh(plain));
}

}  // namespace flexura::reduce
