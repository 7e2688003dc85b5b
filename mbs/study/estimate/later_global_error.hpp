// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "mbs/study/estimate/global_error.hpp"

namespace flexura::study {

/// The integrator's share of a run (global_error.hpp), told when and only if it is asked for: until then its steps are
/// remembered as far as they fit.
class LaterGlobalError {
 public:
  /// Null where there is no GlobalError.  `run` outlives it.
  static std::unique_ptr<LaterGlobalError> make(const mbs::PreparedMechanism& run,
                                                double most_memory = kMostMemory);

  /// Adds itself to the callbacks, which call it before whatever they call already.
  void watch(mbs::RunCallbacks& callbacks);

  IntegratorEstimate estimate();

 private:
  static constexpr double kMostMemory = 64e6;  // [B]

  using Happening = std::function<void(GlobalError&)>;
  LaterGlobalError(std::unique_ptr<GlobalError> tells, double most_memory);
  void happens(Happening what, double bytes);
  void tell();

  std::unique_ptr<GlobalError> tells_;
  double most_memory_, memory_ = 0.0;
  std::vector<Happening> waiting_;
};

}  // namespace flexura::study
