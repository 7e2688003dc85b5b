// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/cms/result/reduction.hpp"

namespace flexura::reduce {

/// Between which modes the normal modes end, for the certificate.
struct Cut {
  double omega2_last = 0.0, omega2_next = 0.0;  ///< of the last one kept and the first left out [rad^2/s^2]
  int n_modes = 0;                              ///< 0: of another mode set, or none
  bool counted = false;                         ///< by the eigensolver's own shifts
  std::vector<int> order;                       ///< of the factorisation
};

/// A reduction (craig_bampton.hpp) but for its certificate, a stage each.  The factor is gone on return: the certificate's takes
/// its place in memory.  `part`, of which `model` is, is `whole` with its elastic ties rigid, if it `has_elastic` ones; a rank of
/// a team that does not lead gives its share for both.  Throws what craig_bampton() throws.
Cut run_stages(const Part& whole, const Part& part, bool has_elastic, const TiedModel& model,
               const ReductionOptions& options, Reduction& reduction);

}  // namespace flexura::reduce
