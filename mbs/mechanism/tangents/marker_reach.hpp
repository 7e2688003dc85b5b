// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <initializer_list>
#include <vector>

#include "mbs/mechanism/tangents/inertia_tangents.hpp"

/// Which coordinates move a marker, and how.
namespace flexura::mbs {

/// How a marker moves with the coordinates that it depends on: twists of a point of its body (or node), and D of (1) in
/// inertia_tangents.cpp about that point; zero for all others.
struct MarkerReach {
  using Columns6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  Columns6 twist, D;
  Columns6 rigid;         ///< twists without what the marker moves in its own body
  std::vector<int> list;  ///< from the body inwards
  std::size_t n_own = 0;  ///< those that not all markers of a load have in common come first

  void size(int n_v);
};

/// Collects coordinates of several markers, each once.
class ReachMarks {
 public:
  void size(int n_v) { mark_.assign(n_v, 0); }
  /// Those that not all of the markers have in common; nullptr counts for none.
  void collect(std::initializer_list<const MarkerReach*> reaches, std::vector<int>& out);

 private:
  std::vector<long> mark_;
  long marks_ = 0;
};

/// The reaches of markers at one state.
class MarkerReaches {
 public:
  MarkerReaches(const Topology& tree, const InertiaVariations& inertia) : tree_(tree), inertia_(inertia) {}

  /// The body nearest to all markers on the way to ground; ground where one of them is the world (-1).
  int base_of(std::initializer_list<int> markers) const;
  /// Of `point` (in W) of the marker's body; `base` as base_of() gives it.
  void reach(int marker, const Vector3d& point, int base, MarkerReach& out) const;

 private:
  const Topology& tree_;
  const InertiaVariations& inertia_;
};

}  // namespace flexura::mbs
