// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/write_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <stdexcept>
#include <vector>

#include "mbs/files/output.hpp"
#include "mesh/model/geometry.hpp"

namespace flexura::reduce {
namespace {

using mesh::CellBlock;
using mesh::CellType;

struct Names {
  const char* abaqus;
  int vtk, gmsh;
  std::vector<int> gmsh_order;    ///< place in gmsh's order of each of our nodes; empty: the same
  std::vector<int> abaqus_order;  ///< our node at each place of Abaqus' order; empty: the same
};

// Cell types of the VTK file format and of gmsh's reference manual ("Node ordering"); Mesh has VTK's order.
const Names& names_of(CellType type) {
  static const std::map<CellType, Names> kNames = {
      {CellType::tri3, {"S3", 5, 2, {}, {}}},
      {CellType::quad4, {"S4", 9, 3, {}, {}}},
      {CellType::tet4, {"C3D4", 10, 4, {}, {}}},
      {CellType::hex8, {"C3D8", 12, 5, {}, {}}},
      {CellType::wedge6, {"C3D6", 13, 6, {}, {}}},
      {CellType::pyramid5, {"C3D5", 14, 7, {}, {}}},
      {CellType::tet10, {"C3D10", 24, 11, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}, {}}},
      {CellType::hex20, {"C3D20", 25, 17, {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15}, {}}},
      {CellType::wedge15, {"C3D15", 26, 18, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11}, {}}},
      {CellType::pyramid13, {"C3D13", 27, 19, {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12}, {}}},
      {CellType::hex27,
       {"C3D27", 29, 12,
        {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26},
        {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 26, 24, 25, 22, 21, 23, 20}}}};
  return kNames.at(type);
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
  const bool good = labels.size() == static_cast<std::size_t>(mesh.n_nodes()) && !sorted.empty() && sorted.front() > 0 &&
                    std::ranges::adjacent_find(sorted) == sorted.end();
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

std::string abaqus(const mesh::Mesh& mesh) {
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  const std::vector<std::int64_t> labels = labels_of(mesh);
  fmt::format_to(to, "*HEADING\nmesh of a part, lengths in m\n*NODE\n");
  for (mesh::Index k = 0; k < mesh.n_nodes(); ++k)
    fmt::format_to(to, "{}, {:.17g}, {:.17g}, {:.17g}\n", labels[k], mesh.points(k, 0), mesh.points(k, 1), mesh.points(k, 2));
  std::int64_t element = 0;
  int number = 0;
  for (const CellBlock* block : blocks_of(mesh)) {
    if (block->type == CellType::pyramid13)
      throw std::invalid_argument("Abaqus knows no pyramids of 13 nodes; write .vtu or .msh");
    const Names& names = names_of(block->type);
    fmt::format_to(to, "*ELEMENT, TYPE={}, ELSET=CELLS_{}\n", names.abaqus, ++number);
    for (Eigen::Index cell = 0; cell < block->nodes.rows(); ++cell) {
      fmt::format_to(to, "{}", ++element);
      for (Eigen::Index a = 0; a < block->nodes.cols(); ++a) {
        const auto ours = names.abaqus_order.empty() ? a : names.abaqus_order[static_cast<std::size_t>(a)];
        // Sixteen entries on a line at most; a comma at its end goes on.
        fmt::format_to(to, "{}{}", a % 15 == 14 ? ",\n" : ", ", labels[block->nodes(cell, ours)]);
      }
      fmt::format_to(to, "\n");
    }
  }
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
    fmt::format_to(to, "{} {:.17g} {:.17g} {:.17g}\n", k + 1, mesh.points(k, 0), mesh.points(k, 1), mesh.points(k, 2));
  const auto blocks = blocks_of(mesh);
  Eigen::Index n = 0, element = 0;
  for (const CellBlock* block : blocks) n += block->nodes.rows();
  fmt::format_to(to, "$EndNodes\n$Elements\n{}\n", n);
  for (const CellBlock* block : blocks) {
    const Names& names = names_of(block->type);
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
  fmt::format_to(to,
                 "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
                 "byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n"
                 "<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n",
                 mesh.n_nodes(), n);
  for (mesh::Index k = 0; k < mesh.n_nodes(); ++k)
    fmt::format_to(to, "{:.17g} {:.17g} {:.17g}\n", mesh.points(k, 0), mesh.points(k, 1), mesh.points(k, 2));
  fmt::format_to(to, "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n");
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
  each([&](const CellBlock& block, Eigen::Index) { fmt::format_to(to, "{}\n", offset += block.nodes.cols()); });
  fmt::format_to(to, "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n");
  each([&](const CellBlock& block, Eigen::Index) { fmt::format_to(to, "{}\n", names_of(block.type).vtk); });
  fmt::format_to(to, "</DataArray>\n</Cells>\n<CellData>\n<DataArray type=\"Int64\" Name=\"material\" format=\"ascii\">\n");
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

void write_mesh(const std::filesystem::path& path, const mesh::Mesh& mesh) {
  const std::string end = ending_of(path);
  if (!is_mesh_ending(path))
    throw std::invalid_argument(
        fmt::format("{}: must end in .inp (Abaqus), .vtu (ParaView) or .msh (gmsh), not in \"{}\"", path.string(), end));
  mesh::Mesh plain = mesh;  // without the points around shells and beams
  plain.boundary.clear();
  plain.boundary_face.clear();
  mesh::drop_unused_nodes(plain);
  if (blocks_of(plain).empty()) throw std::invalid_argument(path.string() + ": the part has no cells to write (it is made of beams alone); leave --mesh out");
  files::write_whole(path, end == ".inp" ? abaqus(plain) : end == ".vtu" ? vtu(plain) : gmsh(plain));
}

}  // namespace flexura::reduce
