// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_types.hpp"

#include <algorithm>
#include <cctype>

#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/model/cells/cell.hpp"
#include "mesh/model/cells/record.hpp"

namespace flexura::mesh::abaqus {
namespace {

/// Variants (reduced, hybrid, incompatible, modified) share nodes and shape functions.
SolidType variant_of(CellType shape, const std::string& letters) {
  const bool reduced = letters.find('R') != std::string::npos;
  const bool hybrid = letters.find('H') != std::string::npos;
  const bool incompatible = letters.find('I') != std::string::npos;
  SolidType type{shape, CellVariant::standard, ""};
  if (reduced && (shape == CellType::hex20 || shape == CellType::hex8)) {
    type.variant = CellVariant::reduced;
  } else if (reduced) {
    type.replaced = "integrated in full: slightly stiffer";
  } else if (incompatible && shape == CellType::hex8) {
    type.variant = CellVariant::bubbles;
  } else if (shape == CellType::hex8 && (letters.empty() || letters == "H")) {
    type.variant = CellVariant::mean_volume;
  } else if (letters.find('M') != std::string::npos) {
    type.replaced = "taken as the standard element, not the modified one: slightly stiffer";
  } else if (letters.find('V') != std::string::npos) {
    type.replaced = "taken with as many nodes as the line has, integrated in full";
  }
  if (hybrid)
    type.replaced +=
        std::string(type.replaced.empty() ? "" : "; ") +
        "in displacements alone: the same but for Poisson's ratios near 0.5, where it is stiffer";
  return type;
}

}  // namespace

std::optional<SolidType> solid_type(const std::string& name) {
  const std::string type = upper(name);
  std::size_t digits = 3;
  if (type.rfind("C3D", 0) != 0 && type.rfind("DC3D", 0) != 0) return {};
  if (type[0] == 'D') return {};
  while (digits < type.size() && std::isdigit(static_cast<unsigned char>(type[digits]))) ++digits;
  const std::string plain = type.substr(0, digits);
  const auto found = std::ranges::find_if(cell_records(), [&](const CellRecord& record) {
    return record.is_solid() && record.foreign.abaqus == plain;
  });
  if (found == cell_records().end()) return {};
  return variant_of(found->type, type.substr(digits));
}

std::optional<SolidType> shell_type(const std::string& name) {
  static const std::map<std::string, CellType> kTypes = {
      {"S3", CellType::tri3},    {"S3R", CellType::tri3},    {"S3RS", CellType::tri3},
      {"STRI3", CellType::tri3}, {"S4", CellType::quad4},    {"S4R", CellType::quad4},
      {"S4RS", CellType::quad4}, {"S4RSW", CellType::quad4}, {"S4R5", CellType::quad4},
      {"S8", CellType::quad8},   {"S8R", CellType::quad8},   {"S8R5", CellType::quad8},
      {"S6", CellType::tri6},    {"STRI65", CellType::tri6}, {"US3", CellType::tri3},
      {"M3D3", CellType::tri3},  {"M3D4", CellType::quad4},  {"M3D4R", CellType::quad4},
      {"M3D6", CellType::tri6},  {"M3D8", CellType::quad8},  {"M3D8R", CellType::quad8}};
  const std::string type = upper(name);
  const auto found = kTypes.find(type);
  if (found == kTypes.end()) return {};
  if (type[0] == 'M')
    return SolidType{found->second, CellVariant::standard, "taken as shells, which resist bending as well"};
  const bool quadratic = found->second == CellType::quad8 || found->second == CellType::tri6;
  return SolidType{found->second, CellVariant::standard, quadratic ? ModelBuilder::split_shells() : ""};
}

std::vector<std::int64_t> in_mesh_order(CellType type, const std::vector<std::int64_t>& n) {
  const std::vector<int>& ours = record_of(type).foreign.abaqus_order;
  if (ours.empty()) return n;
  std::vector<std::int64_t> out(n.size());
  for (std::size_t k = 0; k < n.size(); ++k) out[static_cast<std::size_t>(ours[k])] = n[k];
  return out;
}

const std::map<std::string, std::size_t>& other_elements() {
  static const std::map<std::string, std::size_t> kTypes = {
      {"B31", 2},     {"U1", 2},      {"B31H", 2},     {"B31R", 2},     {"B33", 2},
      {"B33H", 2},    {"B32", 3},     {"B32H", 3},     {"B32R", 3},     {"T3D2", 2},
      {"T3D2H", 2},   {"T3D3", 3},    {"MASS", 1},     {"ROTARYI", 1},  {"SPRINGA", 2},
      {"SPRING1", 1}, {"SPRING2", 2}, {"DASHPOTA", 2}, {"DASHPOT1", 1}, {"DASHPOT2", 2}};
  return kTypes;
}

std::vector<int> face_corners(CellType type, int face) {
  static const std::map<int, std::vector<std::vector<int>>> kFaces = {
      {4, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}},
      {6, {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}},
      {8, {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}}};
  if (dimension_of(type) != 3) return {};
  const auto found = kFaces.find(shape_of(type).corners);
  if (found == kFaces.end() || face < 0 || face >= static_cast<int>(found->second.size())) return {};
  return found->second[static_cast<std::size_t>(face)];
}

}  // namespace flexura::mesh::abaqus
