// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/goals.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace flexura::study {

namespace in = input;

std::vector<in::Key> goal_keys() {
  return {
      in::texts("least",
                "names the choice with the least value of each of these quantities: the choices are designs "
                "then, their values are compared, not their errors, and nothing is timed"),
      in::texts("greatest", "names the choice with the greatest value of each"),
      in::texts("finer",
                "beside least and greatest: \"key.path=value\" of the mechanism file, like a smaller "
                "solver.tolerance, with which each choice is run once more; the differences are the values' "
                "uncertainty, which is unknown without")};
}

void read_goals(const in::Section& root, const in::Section& want, StudyFile& study) {
  std::vector<std::string> labels;
  for (const WantedQuantity& q : study.quantities) labels.push_back(q.label);
  for (const bool is_least : {true, false}) {
    const char* const key = is_least ? "least" : "greatest";
    for (const std::string& label : want.texts(key)) {
      const auto found = std::ranges::find(labels, label);
      if (found == labels.end())
        want.refuse(key, fmt::format("there is no quantity \"{}\"{}", label, in::suggestion(label, labels)),
                    fmt::format("write its section [quantity.{}]", label));
      study.goals.push_back({static_cast<std::size_t>(found - labels.begin()), is_least});
    }
  }
  const std::vector<std::string> finer = want.texts("finer");
  if (!study.compares_designs()) {
    if (!finer.empty())
      want.refuse("finer", "belongs to least and greatest", "for errors write [reference] with a check");
    return;
  }
  if (root.has("reference"))
    root.refuse("reference", "designs are not wrong against one another",
                "leave it out, or least and greatest; finer says "
                "how far each value is known");
  for (const char* const key : {"accuracy", "time", "chosen"})
    if (want.has(key))
      want.refuse(key, "asks for errors, least and greatest for values", "make two studies of it");
  study.checks.clear();
  if (finer.empty()) return;
  for (const std::string& text : finer)
    if (text.find('=') == std::string::npos || text.starts_with("part."))
      want.refuse("finer", fmt::format("\"{}\" is no \"key.path=value\" of the mechanism file", text),
                  "write key and value");
  for (const Choice& choice : study.choices) {
    study.finer.push_back(choice);
    study.finer.back().name += ", finer";
    study.finer.back().set.insert(study.finer.back().set.end(), finer.begin(), finer.end());
  }
}

}  // namespace flexura::study
