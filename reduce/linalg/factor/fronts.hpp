// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "reduce/linalg/factor/subtrees.hpp"
#include "reduce/linalg/factor/supernodal_factor.hpp"

namespace flexura::linalg {

/// One run of the multifrontal method (supernodal_factor.hpp).  What a front leaves to the rows below, its
/// update, is a Trapezoid of all columns.  Updates of a subtree that one core works through lie on a stack;
/// those of the subtrees' roots and of the fronts above wait on their own and are freed as soon as the parent
/// has them.  Real: what numbers are computed and kept as, double or float.
template <class Real>
class Fronts {
 public:
  /// Of the factor only the analysis is used here.
  Fronts(const UpperCsr& A, SupernodalFactor& L, bool must_be_definite);

  /// The most bytes that are in use at once during run(): numbers of L written so far and updates.
  double peak_bytes() const;

  /// Writes the numbers of L.  The column of L at which the factorisation ended, or -1.
  int run();

 private:
  // What a thread works with.
  struct Scratch {
    std::vector<int> place;         // of a row of L in the front
    std::unique_ptr<Real[]> stack;  // of updates that wait for their parent
  };

  std::size_t n_updates(int s) const;
  std::size_t n_updates_of_children(int s) const;
  std::size_t stack_size(int root) const;
  std::size_t room() const;  // of the largest stack
  void permute();
  Scratch take_scratch(std::size_t room);
  void give_back(Scratch scratch);
  void process_subtree(int root, Scratch& scratch);
  void process(int s, bool on_all_cores, std::vector<int>& place, Real* U);
  void add_update(int child, const std::vector<int>& place, const Trapezoid& shape, Real* F, Real* U,
                  bool on_all_cores) const;

  static constexpr int kNone = std::numeric_limits<int>::max();
  const UpperCsr& A_;
  SupernodalFactor& L_;
  bool must_be_definite_;
  std::vector<int> begin_, row_;  // the lower triangle of P A P^T by columns
  std::vector<double> entry_;
  SupernodeTree tree_;
  Subtrees subtrees_;
  std::vector<const Real*> updates_;
  std::vector<std::unique_ptr<Real[]>> owned_;  // updates from subtrees and at the top
  std::mutex mutex_;
  std::vector<Scratch> spare_;
  std::atomic<int> failed_{kNone};
};

}  // namespace flexura::linalg
