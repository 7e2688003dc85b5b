// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/cms/result/reduction.hpp"
#include "reduce/part/part_input.hpp"

/// [modes] accuracy: solve, estimate, mesh anew where the error is, until mesh and modes are within.
namespace flexura::reduce {

/// What one mesh gives, by the estimates.
struct Judgement {
  bool known = false;        ///< the mesh could be judged
  double frequencies = 0.0;  ///< greatest relative error by the mesh of those asked for
  double compliance = 0.0;   ///< likewise of the static compliance
  double modes = 0.0;        ///< of those frequencies by the modes left out, safe estimate
  std::string interface;     ///< with the greatest error of compliance
};

/// What was said of the k-th frequency [relative error], or of another that may have changed places with it since: a finer
/// mesh lets each fall by up to `raised` times what was said of it, and those whose ranges overlap may cross.  What the
/// mesh does not resolve at all is no measure of others.
double said_of_frequency(const std::vector<MeshShare::Mode>& modes, std::size_t k, double raised);

class AccuracyGoal {
 public:
  explicit AccuracyGoal(const ModesInput& modes);

  bool asked() const { return frequencies_ > 0.0; }
  /// Judges a reduction.  Where a finer mesh moved a frequency by more than the coarser mesh's estimate had said, the
  /// estimate is raised by as much.
  Judgement judge(const Reduction& reduction);
  bool mesh_reached(const Judgement& j) const;
  bool modes_reached(const Judgement& j) const;

  /// Sizes of the next mesh (mesh::CadOptions::sizes) for the last reduction judged: those of
  /// the fewest cells (P. Ladeveze, G. Coffignal, P. Marin 1986; mesh_sizes.hpp).
  /// `dofs`: of the mesh that was judged; std::runtime_error where the next one would be beyond all bounds.
  std::vector<double> next_sizes(const Part& part, int dofs);

  /// "asked 1 % ..., estimated ..."
  std::string describe(const Judgement& j) const;

 private:
  double frequencies_, compliance_, up_to_;
  MeshShare share_;  ///< of the last reduction
  std::vector<MeshShare::Mode> before_;
  double raised_ = 1.0, modes_before_ = 0.0;
  double expected_ =
      0.0;  ///< of the last sizes: the greatest error of a motion over what it may have; 0: none were given
  std::size_t n_judged_ = 0;
  int n_shapes_ = 0;
};

}  // namespace flexura::reduce
