// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/list_deck.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <ostream>
#include <set>

#include "mesh/import/abaqus.hpp"
#include "mesh/import/nastran.hpp"
#include "mesh/import/unv.hpp"
#include "mesh/model/cells/cell.hpp"

namespace flexura::reduce {
namespace {

std::string count(std::size_t n, const std::string& noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

std::string number_of(const mesh::Mesh& mesh, mesh::Index node) {
  return std::to_string(mesh.node_label.empty() ? node + 1 : mesh.node_label[static_cast<std::size_t>(node)]);
}

void print_elements(const mesh::ImportedModel& model, std::ostream& out) {
  for (const auto* blocks : {&model.mesh.solids, &model.mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      out << fmt::format("  {} of type {}\n", count(static_cast<std::size_t>(block.nodes.rows()), "element"),
                         mesh::name_of(block.type));
  for (const auto& [n, noun] : {std::pair{model.bars.size(), "beam or rod"},
                                {model.springs.size(), "spring or damper"},
                                {model.masses.size(), "point mass"}})
    if (n > 0) out << fmt::format("  {}: {}\n", noun, n);
}

void print_materials(const mesh::ImportedModel& model, std::ostream& out) {
  std::set<std::string> said;  // copies along other axes have one name
  for (const mesh::ImportedMaterial& material : model.materials) {
    if (!material.plies.empty() || !said.insert(material.name).second) continue;
    out << fmt::format("  material {}: {}, {}\n", material.name,
                       material.orthotropic ? std::string("with directions")
                                            : fmt::format("E {:g}, nu {:g}", material.E, material.nu),
                       material.rho > 0.0 ? fmt::format("density {:g}", material.rho)
                                          : std::string("no density (--density gives one)"));
  }
}

// What the deck holds at the ground, as one line of node numbers: joints of the mechanism hold it there.
void print_supports(const mesh::ImportedModel& model, std::ostream& out) {
  std::set<mesh::Index> nodes;
  for (const mesh::ImportedDofs& fixed : model.fixed) nodes.insert(fixed.node);
  if (nodes.empty()) return;
  std::vector<std::string> numbers;
  for (const mesh::Index node : nodes) {
    if (numbers.size() == 12) break;
    numbers.push_back(number_of(model.mesh, node));
  }
  out << fmt::format("held at the ground (SPC): {}: {}{}\n", count(nodes.size(), "node"),
                     fmt::join(numbers, ", "), nodes.size() > numbers.size() ? ", ..." : "");
}

void print_part_file(const std::filesystem::path& deck, const mesh::ImportedModel& model, std::ostream& out) {
  const bool dense =
      std::ranges::all_of(model.materials, [](const auto& m) { return m.rho > 0.0 || !m.plies.empty(); });
  out << fmt::format(
      "\nA part file, for example:\n\n[geometry]\nfile = \"{}\"\nunit = \"m\"  # or mm, ...: decks do not "
      "say\n{}",
      deck.filename().string(), dense ? "" : "density = \"7800 kg/m^3\"\n");
  if (!model.ties.empty()) {
    out << fmt::format("\n[interface.a]\nby = \"tie\"\nelement = {}\n", model.ties.front().label);
  } else if (!model.mesh.sets.empty()) {
    // The smallest set of faces: what holds the part is rarely all of it.
    const auto best = std::ranges::min_element(model.mesh.sets, {}, [](const auto& set) {
      return std::pair{set.second.faces.empty(), set.second.nodes.size()};
    });
    out << fmt::format("\n[interface.a]\nby = \"group\"\ngroup = \"{}\"\n", best->first);
  } else if (!model.fixed.empty()) {
    out << fmt::format("\n[interface.a]\nby = \"nodes\"\nnodes = [{}]\n",
                       number_of(model.mesh, model.fixed.front().node));
  }
  out << "\n[modes]\ncount = 20\n";
}

}  // namespace

bool is_deck(PartFormat format) {
  return format == PartFormat::abaqus || format == PartFormat::nastran || format == PartFormat::unv;
}

void print_deck(const std::filesystem::path& deck, PartFormat format, std::ostream& out) {
  const mesh::ImportedModel model = format == PartFormat::abaqus
                                        ? mesh::read_abaqus(deck, mesh::DeckProgram::unknown)
                                    : format == PartFormat::nastran ? mesh::read_nastran(deck)
                                                                    : mesh::read_unv(deck);
  const mesh::Mesh& mesh = model.mesh;
  const Eigen::RowVector3d low = mesh.points.colwise().minCoeff(), high = mesh.points.colwise().maxCoeff();
  out << fmt::format("{}: {}, from ({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}), numbers as in the deck\n",
                     deck.filename().string(), count(static_cast<std::size_t>(mesh.n_nodes()), "node"),
                     low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
  print_elements(model, out);
  print_materials(model, out);
  if (!mesh.sets.empty()) out << "sets (by = \"group\"):\n";
  for (const auto& [name, set] : mesh.sets) {
    Eigen::Index faces = 0;
    for (const mesh::CellBlock& block : set.faces) faces += block.nodes.rows();
    out << fmt::format(
        "  \"{}\": {}{}\n", name, count(set.nodes.size(), "node"),
        faces > 0 ? fmt::format(", {} of the surface", count(static_cast<std::size_t>(faces), "face")) : "");
  }
  if (!model.ties.empty()) out << "ties (by = \"tie\"; without any [interface] each becomes one):\n";
  for (const mesh::ImportedTie& tie : model.ties)
    out << fmt::format("  {}: {}, node {}, {}\n", tie.label,
                       tie.kind == mesh::ImportedTie::Kind::rigid ? "rigid (RBE2)" : "average (RBE3)",
                       number_of(mesh, tie.reference), count(tie.nodes.size(), "node"));
  print_supports(model, out);
  for (const std::string& warning : model.warnings) out << "warning: " << warning << '\n';
  print_part_file(deck, model, out);
}

}  // namespace flexura::reduce
