// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mbs/study/measurement.hpp"
#include "mbs/study/study_file.hpp"

/// Designs compared by the values of their quantities: which has the fewest impacts, the least peak, ...
///
/// Values are those of the finer runs where the study has them, and each is known within |value - finer value|.
/// A design is as good as the best where their values differ by less than both are known to: the answer names it.
namespace flexura::study {

struct DesignRow {
  const Choice* choice = nullptr;
  const Measurement* cost = nullptr;
  std::vector<double> values;       ///< SI, one for each quantity; NaN where the run did not complete
  std::vector<double> uncertainty;  ///< of the values; NaN: unknown
};

struct Designs {
  std::vector<DesignRow> rows;  ///< as in the study's choices
  std::vector<std::string> units;
  std::vector<std::string> answers, notes;
};

/// Throws std::invalid_argument for a quantity that the results do not have.
Designs compare_designs(const StudyFile& study, const Measurements& measured);

nlohmann::json as_json(const StudyFile& study, const Designs& designs, const std::string& created_by);
std::string as_csv(const StudyFile& study, const Designs& designs);
std::string as_markdown(const StudyFile& study, const Designs& designs);

}  // namespace flexura::study
