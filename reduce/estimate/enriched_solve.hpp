// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/estimate/enriched_mesh.hpp"
#include "reduce/estimate/enriched_residual.hpp"

/// a(e, w) = r(w) on some of a mesh's cells, for all functions w of theirs, gained and own.
///
/// A few steps of conjugate gradients (M. R. Hestenes, E. Stiefel 1952), preconditioned by the cells' own inverses with
/// shared functions weighted by their stiffness, come from below to within a few per cent: r is rough, so that no coarse
/// problem is needed.  What further steps would gain is added as the last ones fall off.  A gained function that is shared
/// with cells that are not chosen has the chosen ones' share of its load, and is free there; the nodes there are held: they bear no
/// load, and free ones would let a piece bend where the part cannot.
namespace flexura::reduce {

class EnrichedSolve {
 public:
  /// Cells that lie together come one after the other in `chosen`.
  EnrichedSolve(const Part& part, const EnrichedMesh& mesh, const std::vector<std::size_t>& chosen);

  /// a(e, e) of each chosen cell (n_chosen x 16) for loads r of the gained functions (3 n_functions x 16).
  StatePanel energies(const StatePanel& r);

 private:
  using Numbers = Eigen::Array<double, 1, kStatesTogether>;
  struct Cell {
    std::size_t first_function;  ///< in numbers_ and places_
    std::size_t first_entry;     ///< in K_ and B_
    int n, n_gained;             ///< functions
  };
  /// Cells one after the other, which one thread takes.
  struct Range {
    std::size_t first_cell, last_cell;
    int first_function, last_function;  ///< that appear here first
    std::vector<int> shared;            ///< others, which appear in earlier ranges
  };

  void number(const EnrichedMesh& mesh, const Part& part, const std::vector<std::size_t>& chosen);
  void find_ranges();
  void compute_cells(const Part& part, const EnrichedMesh& mesh, const std::vector<std::size_t>& chosen);
  void weigh_shared_functions();
  void multiply(const std::vector<float>& matrices, const StatePanel& X, StatePanel& Y);
  Numbers dots(const StatePanel& a, const StatePanel& b) const;
  template <class Work>
  void over_ranges(const Work& work) const;

  std::vector<Cell> cells_;
  std::vector<int> numbers_;  ///< of the cells' functions; -1: left out
  std::vector<float> sign_;   ///< of the cells' functions, 0: left out
  std::vector<int> places_;   ///< in their range: as numbers_, or -2 - k for its shared function k
  std::vector<int> from_;     ///< of the gained functions: their number in the mesh, -1 for own ones
  std::vector<float> share_;  ///< of the functions: how many of the cells that have one are chosen
  int n_functions_ = 0;
  std::vector<float> K_, B_;  ///< of the cells: stiffness, weighted inverse (3 n x 3 n)
  std::vector<Range> ranges_;
  std::vector<StatePanel> shared_;  ///< of the ranges: what they add to their shared functions
};

}  // namespace flexura::reduce
