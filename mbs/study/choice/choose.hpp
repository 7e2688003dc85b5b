// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/elements_check.hpp"
#include "mbs/study/estimate/integrator_check.hpp"
#include "mbs/study/estimate/shadows.hpp"

/// Fidelity and tolerance for a wanted accuracy.
///
/// A run with the bodies rigid that are to be chosen is cheap, and says what their deformation would change
/// (screening.hpp).  A body that changes nothing beyond its share of the wanted accuracy stays rigid; the
/// others get their response modes ("static") and the fewest free modes that keep the rest within their
/// share, and geometric stiffening where spin, acceleration and loads change their stiffness enough to
/// matter.  Half of the accuracy is for what is left out, half for what the first-order screening does not see and
/// for the integrator.  Of that half each body has an equal share, those of least influence first; what one does not use the
/// others have.
///
/// A beam of the mechanism file is chosen like a superelement, which it has in memory (beam_superelement.hpp), where its
/// deformation stays in the linear range; where it does not it becomes geometrically exact.  Two runs with fewer elements
/// then tell what these cost (elements_check.hpp), and it runs again with twice as many until that is within its share.
///
/// The chosen mechanism runs with its own shadows.  Where their error has used up 0.7 of the accuracy, by
/// the whole run's measure, the run stops and the body that contributes most gets more.  In its first half the run then begins
/// anew; later it goes on from the last row at which half of that was left, with the deformation that the shadows had there.
///
/// Where a part of the screening shows that every such body needs all its deformations it ends there.
///
/// The tolerance begins loose and becomes finer where the run's own estimate of its integrator asks for it
/// (tolerance_choice.hpp).  Its absolute part is a hundredth of it.
namespace flexura::study {

struct RowOfRun {
  mbs::State state;
  Eigen::VectorXd v_dot;
  mbs::EnergyAccount energy;
};

struct ChosenRun {
  mbs::PreparedMechanism prepared;
  std::vector<std::string> set;  ///< keys that give the same run without a choice
  mbs::RunResult result;
  std::vector<RowOfRun> rows;  ///< what the callback `row` would have been given
  bool has_estimate = false;
  TruncationEstimate estimate;
  std::optional<IntegratorEstimate> integrator;
  std::optional<ElementsEstimate> elements;  ///< where beams were chosen
  std::vector<std::string> reasons;          ///< one line for each body, restart and tolerance
  int restarts = 0;
  double screening_wall = 0.0;  ///< [s] of the screening and of what restarts threw away
  double screening_cpu = 0.0;   ///< [s], of the same, of all threads
};

/// True where a body has fidelity = "auto", or where the run has a wanted accuracy
/// (solver.accuracy) and a superelement has no fidelity of its own.
bool is_to_be_chosen(const mbs::PreparedMechanism& run);

/// Runs it: `given` is the mechanism as its source describes it.  With solver.accuracy the tolerance is chosen, too; without
/// it the accuracy is 1 %.  `integrator`: its share is told as well.  Throws what prepare() throws.
ChosenRun run_within(const mbs::PreparedMechanism& given, const mbs::RunCallbacks& callbacks,
                     bool integrator = true);

}  // namespace flexura::study
