// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/library/builder.hpp"

namespace flexura::mbs {

/// A run of a mechanism made in C++.
struct RunSettings {
  double end_time = 10.0;    ///< [s]
  double output_step = 0.0;  ///< [s]; 0: a two-hundredth of end_time
  double accuracy = 0.0;     ///< relative rms error of the outputs that is asked for; 0: none
  double tolerance = 1e-6;   ///< of the integrator; chosen where an accuracy is asked for
  std::string method = {};   ///< "radau", "ida", ...; empty: by what deforms
  std::vector<std::string> outputs =
      {};  ///< by which the run is judged, with * and ? as wildcards; empty: the usual ones
};

/// A mechanism of a builder, made anew with other models of its parts.  Takes a copy of what the builder holds.
class PartSource final : public ModelSource {
 public:
  explicit PartSource(const MechanismBuilder& builder, RunSettings settings = {});

  MechanismFile read(const ModelChoice& choice, PreparationCache& cache) const override;
  std::string name() const override { return d_.name; }
  void add_to(input::ContentHash& hash) const override;

 private:
  MechanismDescription d_;
  std::map<int, MechanismBuilder::Open> open_;
  RunSettings settings_;
};

}  // namespace flexura::mbs
