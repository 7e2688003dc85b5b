// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mesh/import/imported.hpp"

/// What all readers share: labels become indices, cells are gathered by type, unused cards are counted.
namespace flexura::mesh {

/// "deck.inp, line 12": where a message points.
struct Where {
  const std::string* file = nullptr;
  int line = 0;
  std::string text() const { return *file + ", line " + std::to_string(line); }
};

/// Refuses a folder, a device, a pipe: what may never end (std::invalid_argument).  A missing file is for the
/// reader to tell.
void require_file(const std::filesystem::path& path);

/// A line of a deck as it is read: control characters, of which tabs and carriage returns are none here, are made plain
/// (mbs/base/files/plain_text.hpp).  Refuses what no text has (std::invalid_argument).
std::string plain_line(std::string line, const Where& where);

/// What short lines of a deck stand for beside themselves (generated sets, sets of sets, THRU, a part's instances after the first):
/// counted before it is made, and bounded, as a deck of a kilobyte can ask for more than any memory holds.
class Implied {
 public:
  /// `n` more nodes, elements or labels.  Throws std::invalid_argument with the place beyond 2e7 in all.
  void add(std::size_t n, const Where& where);

 private:
  std::size_t total_ = 0;
};

/// Numbers of a deck that a structure cannot have, with the place of the card: std::invalid_argument "deck.inp, line 12:
/// CBAR 7 has the area -1; it must be above 0".
void require_positive(double value, const std::string& of, const char* what, const Where& where);
void require_not_negative(double value, const std::string& of, const char* what, const Where& where);
/// Throws std::invalid_argument with this text unless `good`.
void require(bool good, const std::string& what);

/// Area above 0; second moments, torsion constant and shear factors at least 0; I_yy I_zz >= I_yz^2.  Mass may be taken away.
void require_section(const ImportedBar& bar, const std::string& of, const Where& where);

/// A mass of at least 0, with moments of inertia where it is 0, and these of a body.
void require_mass(const ImportedMass& mass, const std::string& of, const Where& where);

/// Cards that were read over: name, count, first line.
class Unused {
 public:
  void add(const std::string& card, const Where& where);
  /// "3 cards PLOAD4 are not used (first in deck.bdf, line 7)", in order of appearance.
  std::vector<std::string> messages(const std::string& noun) const;
  /// "3 times PBEAM's taper: end A is used all along (first in deck.bdf, line 7)".
  std::vector<std::string> remarks() const;

 private:
  struct Entry {
    std::string card, first;
    int count = 0;
  };
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t> place_;
};

/// What stops a deck, gathered so that all of it is told at once.
class Faults {
 public:
  template <class Work>
  void guard(const Work& work) {
    try {
      work();
    } catch (const std::invalid_argument& error) {
      add(error.what());
    }
  }
  /// "deck.bdf, line 12: ..."; those that differ in numbers alone are of one kind.
  void add(const std::string& text);
  bool any() const { return !kinds_.empty(); }
  /// Throws std::invalid_argument where there are some: the one as it stands, or the first of each kind with its count.
  void raise() const;

 private:
  std::vector<std::pair<std::string, int>> kinds_;
  std::map<std::string, std::size_t> place_;
};

/// Visits, by reference, every number of a node in bars, springs, masses, ties and equations.
template <class Visit>
void each_attached_node(ImportedModel& model, const Visit& visit) {
  for (ImportedBar& bar : model.bars)
    for (Index& node : bar.nodes) visit(node);
  for (ImportedSpring& spring : model.springs)
    for (Index& node : spring.nodes) visit(node);
  for (ImportedMass& mass : model.masses) visit(mass.node);
  for (ImportedTie& tie : model.ties) {
    visit(tie.reference);
    for (Index& node : tie.nodes) visit(node);
  }
  for (ImportedEquation& equation : model.equations)
    for (ImportedEquation::Term& term : equation.terms) visit(term.node);
}

class ModelBuilder {
 public:
  /// Labels are unique in a scope (an instance of a part); most formats have scope 0 only.
  Index add_node(int scope, std::int64_t label, const Eigen::Vector3d& x, const Where& where);
  Index node(int scope, std::int64_t label,
             const Where& where) const;  ///< throws for a label that was not given
  bool has_node(int scope, std::int64_t label) const { return numbers_.contains({scope, label}); }

  struct Cell {
    CellType type;
    std::int64_t label;
    std::vector<Index> nodes;  ///< in the order of Mesh; of quadratic shells mid-side nodes may lack (-1)
    Index material;            ///< -1 = none stated
    CellVariant variant = CellVariant::standard;
    double thickness = 0, offset = 0;  ///< shells (tri3, quad4; tri6, quad8 become these at the end)
    Where where;
  };
  /// Returns the cell's number, as `cells` counts.
  std::size_t add_cell(int scope, CellType type, std::int64_t label, std::vector<Index> nodes,
                       const Where& where);
  std::vector<Cell>& cells() { return cells_; }
  const std::vector<Cell>& cells() const { return cells_; }
  const Eigen::Vector3d& place(Index node) const { return points_[static_cast<std::size_t>(node)]; }

  void move(Index node, const Eigen::Vector3d& x) { points_[static_cast<std::size_t>(node)] = x; }

  /// Nodes that become others, in labels, cells and sets.
  void join(const std::map<Index, Index>& same);

  void add_to_set(const std::string& name, const std::vector<Index>& nodes);

  /// Fills model.mesh (blocks in order of first appearance of their type), its boundary and sets; drops nodes
  /// on which no cell, bar, spring, mass or tie stands, and gives those of the model (which were numbers of add_node until
  /// here) their numbers in the mesh; what is fixed or kept at a dropped node goes with it.  Throws when some cells have a
  /// material and others none, or cells are turned inside out.
  void finish(ImportedModel& model);

  /// What becomes of quadratic shells, for messages.
  static const char* split_shells();

 private:
  /// Solids whose numbering alone turns them inside out get the mirrored one; quadratic ones whose edges bulge so far that a
  /// point is turned inside out get straight edges.  Both are said.  Throws with all others.
  void mend_solids(ImportedModel& model);
  /// Quadratic shells as linear ones between the same nodes.
  void split_quadratic_shells();
  struct KeyHash {
    std::size_t operator()(const std::pair<int, std::int64_t>& key) const {
      return std::hash<std::uint64_t>()(static_cast<std::uint64_t>(key.second) * 1000003u +
                                        static_cast<std::uint64_t>(key.first));
    }
  };
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::int64_t> labels_;
  std::unordered_map<std::pair<int, std::int64_t>, Index, KeyHash> numbers_;
  std::unordered_map<std::pair<int, std::int64_t>, Index, KeyHash> cell_numbers_;
  std::vector<Cell> cells_;
  std::map<std::string, std::vector<Index>> sets_;
};

}  // namespace flexura::mesh
