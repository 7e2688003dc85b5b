// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/subsystem_overrides.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mbs/file/bodies/read_pose.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

std::vector<std::string> take_overrides_below(const std::vector<std::string>& overrides,
                                              std::map<std::string, std::vector<std::string>>& below) {
  std::vector<std::string> placing = pose_key_names();
  placing.insert(placing.end(), {"file", "parameters", "on"});
  const std::string opening = "subsystem.";
  std::vector<std::string> own;
  for (const std::string& text : overrides) {
    const auto dot = text.find('.', opening.size());
    if (!text.starts_with(opening) || dot == std::string::npos || text.find('=') < dot) {
      own.push_back(text);
      continue;
    }
    const std::string rest = text.substr(dot + 1), key = rest.substr(0, rest.find_first_of(".=["));
    if (std::ranges::find(placing, key) != placing.end())
      own.push_back(text);
    else
      below[text.substr(opening.size(), dot - opening.size())].push_back(rest);
  }
  return own;
}

std::vector<std::string> overrides_of_placed(const input::Section& s,
                                             const std::map<std::string, double>& parameters,
                                             const std::vector<std::string>& below) {
  std::vector<std::string> overrides;
  for (const auto& [parameter, formula] : s.formulas("parameters")) {
    double value;
    try {
      const double at_start = 0.0;
      const Expression compiled(s.path() + ".parameters." + parameter, formula, SignalNames(), parameters);
      if (compiled.reads_time())
        throw std::invalid_argument(
            s.path() + ".parameters." + parameter +
            " reads the time t, and is one number for the whole run; write a formula of the "
            "parameters of this file");
      value = compiled.evaluate(&at_start);
    } catch (const std::exception& error) {
      throw input::InputError(s.document().string() + ": " + error.what());
    }
    overrides.push_back(fmt::format("parameters.{}={:.17g}", parameter, value));
  }
  overrides.insert(overrides.end(), below.begin(), below.end());
  return overrides;
}

}  // namespace flexura::mbs
