// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/study_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "mbs/base/documents/units.hpp"
#include "mbs/base/files/new_folder.hpp"
#include "mbs/study/estimate/percent.hpp"
#include "mbs/study/goals.hpp"

namespace flexura::study {
namespace {

namespace in = input;

struct Axis {
  std::string name;
  std::vector<Choice> choices;
};

in::Key set_key(const std::string& doc) {
  return in::texts("set", doc +
                              "; \"key.path=value\" of the mechanism file, or \"part.NAME.key.path=value\" "
                              "of the part file of [part.NAME]");
}

in::TableSchema choice_schema(const std::string& name, const std::string& doc) {
  in::TableSchema schema;
  schema.name = name;
  schema.doc = doc;
  schema.keys = {set_key("what this choice changes")};
  return schema;
}

in::TableSchema axis_schema() {
  in::TableSchema axis;
  axis.name = "axis";
  axis.doc =
      "One thing to choose: either a key and its values, or choices by name. Both run from coarse to fine; "
      "the last one is "
      "the finest.";
  axis.keys = {
      in::text("key", "key that takes the values, like \"body.rod.modes\" or \"part.rod.mesh.size\""),
      in::texts("values", "its values, as after --set, from coarse to fine"),
      in::table_map("choice",
                    choice_schema("choice", "A choice that takes several keys, or deserves a name."),
                    "choices by name, from coarse to fine")};
  return axis;
}

in::TableSchema part_schema() {
  in::TableSchema part;
  part.name = "part";
  part.doc =
      "A part file that the study reduces itself: once for each set of its keys, into the cache. With it, "
      "mesh and modes can be choices.";
  part.keys = {
      in::text("file", "part file, relative to the study file").required(),
      in::texts("bodies", "bodies of the mechanism that take its superelement; default: the one of its name"),
      in::texts("set", "\"key.path=value\" of the part file for all choices")};
  return part;
}

in::TableSchema reference_schema() {
  in::TableSchema check, reference;
  check.name = "check";
  check.doc =
      "The reference with one thing coarser. Their difference is its uncertainty in this direction (an upper "
      "bound where refinement at least halves the error); with ratio and order it is divided by ratio^order "
      "- 1 (Richardson).";
  check.keys = {
      set_key("what is coarser").required(),
      in::quantity("ratio", in::dim::none, "how much coarser, as of mesh sizes or steps").above(1.0),
      in::quantity("order", in::dim::none, "order with which the error falls").above(0.0)};
  reference.name = "reference";
  reference.doc =
      "The converged run that errors are measured against: the finest choice with these changes on top. "
      "Without this table: solver.tolerance=1e-10, checked by 1e-9.";
  reference.keys = {set_key("what the reference changes"),
                    in::table_map("check", check, "coarser neighbours; uncertainties add up")};
  return reference;
}

in::TableSchema quantity_schema() {
  in::TableSchema quantity;
  quantity.name = "quantity";
  quantity.doc = "What has to be right. The error of a choice is the largest of its quantities' errors.";
  quantity.keys = {
      in::text("of", "name of the quantity in the results; default: the name of this table"),
      in::choice("norm", norm_names(),
                 "max and rms of the difference over time; final value; mean; peak (largest absolute value); "
                 "frequency of the strongest line; how often |y| rises above the level; each divided by the "
                 "reference's own (final and mean: by its largest absolute value)")
          .or_default("max"),
      in::quantity("level", in::dim::none, "of norm count: the SI value that |y| has to rise above")
          .or_default("0")
          .at_least(0.0),
      in::quantity("from", in::dim::time, "compare from this time"),
      in::quantity("to", in::dim::time, "compare to this time"),
      in::quantity("scale", in::dim::none, "SI value to divide by instead, where the quantity is about zero")
          .above(0.0)};
  return quantity;
}

in::TableSchema want_schema() {
  in::TableSchema want;
  want.name = "want";
  want.doc = "What the study answers in words.";
  want.keys = {
      in::quantities("accuracy", in::dim::none, "names the cheapest choice for each: [\"10 %\", \"1 %\"]"),
      in::flag(
          "chosen",
          "also lets flexura simulate choose for each accuracy (solver.accuracy, and fidelity \"auto\" of "
          "the parts' bodies) and compares the cost with the cheapest choice that meets it")
          .or_default("false"),
      in::quantities("time", in::dim::time, "names the most accurate choice within each: [\"1 s\"]")};
  for (in::Key& key : goal_keys()) want.keys.push_back(std::move(key));
  return want;
}

// Sorts overrides to the mechanism and to the parts.
void take_overrides(const in::Section& section, const std::string& key, const std::vector<std::string>& texts,
                    const std::vector<Part>& parts, Choice& choice) {
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      section.refuse(key, fmt::format("\"{}\" is no \"key.path=value\"", text), "write key and value");
    if (!text.starts_with("part.")) {
      choice.set.push_back(text);
      continue;
    }
    const std::size_t dot = text.find('.', 5);
    const std::string name = text.substr(5, std::min(dot, equals) - 5);
    std::vector<std::string> known;
    for (const Part& part : parts) known.push_back(part.name);
    if (dot == std::string::npos || dot > equals || std::ranges::find(known, name) == known.end())
      section.refuse(key, fmt::format("\"{}\": there is no [part.{}]", text, name),
                     in::suggestion(name, known));
    choice.part_set[name].push_back(text.substr(dot + 1));
  }
}

Axis read_axis(const std::string& name, const in::Section& section, const std::vector<Part>& parts) {
  Axis axis{name, {}};
  const auto named = section.table_map("choice");
  if (section.has("key") == !named.empty())
    section.refuse("key", "an axis has either a key with values or choices by name",
                   fmt::format("write key and values, or [axis.{}.choice.NAME]", name));
  if (section.has("key")) {
    const std::string key = section.text("key");
    for (const std::string& value : section.texts("values")) {
      Choice choice;
      choice.name = key.substr(key.rfind('.') + 1) + " " + value;
      take_overrides(section, "values", {key + "=" + value}, parts, choice);
      axis.choices.push_back(std::move(choice));
    }
  }
  for (const auto& [word, table] : named) {
    Choice choice;
    choice.name = word;
    take_overrides(table, "set", table.texts("set"), parts, choice);
    axis.choices.push_back(std::move(choice));
  }
  if (axis.choices.empty()) section.refuse("values", "an axis without choices", "give at least one value");
  return axis;
}

void append(Choice& choice, const Choice& other) {
  choice.set.insert(choice.set.end(), other.set.begin(), other.set.end());
  for (const auto& [part, texts] : other.part_set) {
    auto& mine = choice.part_set[part];
    mine.insert(mine.end(), texts.begin(), texts.end());
  }
}

Choice combine(const std::vector<Axis>& axes, const std::vector<std::size_t>& at) {
  Choice choice;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Choice& one = axes[i].choices[at[i]];
    choice.name += (i == 0 ? "" : ", ") + one.name;
    append(choice, one);
  }
  return choice;
}

// The first axis changes slowest; the last combination is the finest.
std::vector<Choice> all_combinations(const std::vector<Axis>& axes) {
  std::vector<Choice> choices;
  std::vector<std::size_t> at(axes.size(), 0);
  while (true) {
    choices.push_back(combine(axes, at));
    std::size_t i = axes.size();
    while (i > 0 && ++at[i - 1] == axes[i - 1].choices.size()) at[--i] = 0;
    if (i == 0) return choices;
  }
}

// Each axis by itself, the others at their finest.
std::vector<Choice> one_at_a_time(const std::vector<Axis>& axes) {
  std::vector<std::size_t> finest;
  for (const Axis& axis : axes) finest.push_back(axis.choices.size() - 1);
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t k = 0; k < finest[i]; ++k) {
      std::vector<std::size_t> at = finest;
      at[i] = k;
      choices.push_back(combine(axes, at));
    }
  choices.push_back(combine(axes, finest));
  return choices;
}

// Before any is made: twelve axes of nine values are 2.8e11 combinations.
void require_few(const in::Section& root, const std::vector<Axis>& axes, std::size_t named,
                 bool one_at_a_time) {
  constexpr double most = 10'000.0, most_keys = 200'000.0;
  double combinations = axes.empty() ? 0.0 : 1.0;
  for (const Axis& axis : axes) {
    const auto n = static_cast<double>(axis.choices.size());
    combinations = one_at_a_time ? combinations + n - 1.0 : combinations * n;
  }
  const double keys = combinations * static_cast<double>(axes.size());
  combinations += static_cast<double>(named);
  if (combinations > most || keys > most_keys)
    root.refuse("axis",
                fmt::format("{:.3g} choices of {} axes; at most {:g} are taken, with {:g} keys in all",
                            combinations, axes.size(), most, most_keys),
                "take fewer values, or ladder = \"one_at_a_time\"");
}

Choice changed(const Choice& base, const std::string& name, const in::Section& section,
               const std::vector<Part>& parts) {
  Choice choice = base;
  choice.name = name;
  Choice changes;
  take_overrides(section, "set", section.texts("set"), parts, changes);
  append(choice, changes);
  return choice;
}

void read_reference(const in::Section& root, StudyFile& study) {
  const Choice& finest = study.choices.back();
  if (!root.has("reference")) {
    study.reference = finest;
    study.reference.name = "reference";
    study.reference.set.push_back("solver.tolerance=1e-10");
    Choice coarser = study.reference;
    coarser.name = "reference, tolerance 1e-9";
    coarser.set.back() = "solver.tolerance=1e-9";
    study.checks.push_back({std::move(coarser), 1.0});
    return;
  }
  const in::Section section = root.table("reference");
  study.reference = changed(finest, "reference", section, study.parts);
  for (const auto& [name, check] : section.table_map("check")) {
    if (check.has("ratio") != check.has("order"))
      check.refuse("ratio", "ratio and order belong together", "give both, or neither");
    double share = 1.0;
    if (check.has("ratio")) share = 1.0 / (std::pow(check.quantity("ratio"), check.quantity("order")) - 1.0);
    study.checks.push_back({changed(study.reference, "reference, " + name, check, study.parts), share});
  }
  if (study.checks.empty())
    section.refuse("check", "nothing says how far the reference is converged",
                   "add [reference.check.NAME] with a coarser tolerance, mesh or number of modes");
}

std::vector<Part> read_parts(const in::Section& root) {
  std::vector<Part> parts;
  for (const auto& [name, section] : root.table_map("part")) {
    Part part{name, section.file("file"), section.texts("bodies"), section.texts("set")};
    std::error_code none;
    if (!std::filesystem::is_regular_file(part.file, none))
      section.refuse("file", "there is no such file", "give the part file's path relative to the study file");
    if (part.bodies.empty()) part.bodies.push_back(name);
    parts.push_back(std::move(part));
  }
  return parts;
}

void read_choices(const in::Section& root, StudyFile& study) {
  std::vector<Axis> axes;
  for (const auto& [name, section] : root.table_map("axis"))
    axes.push_back(read_axis(name, section, study.parts));
  for (const auto& [name, section] : root.table_map("choice")) {
    Choice choice;
    choice.name = name;
    take_overrides(section, "set", section.texts("set"), study.parts, choice);
    study.choices.push_back(std::move(choice));
  }
  require_few(root, axes, study.choices.size(), root.text("ladder") == "one_at_a_time");
  if (!axes.empty()) {
    std::vector<Choice> combined =
        root.text("ladder") == "one_at_a_time" ? one_at_a_time(axes) : all_combinations(axes);
    study.choices.insert(study.choices.end(), combined.begin(), combined.end());
  }
  if (study.choices.empty())
    root.refuse("axis", "a study without choices", "add [axis.NAME] with key and values, or [choice.NAME]");
  std::set<std::string> names;
  for (const Choice& choice : study.choices)
    if (!names.insert(choice.name).second)
      root.refuse("choice", fmt::format("two choices are called \"{}\"", choice.name),
                  "name one of them otherwise");
}

void read_quantities(const in::Section& root, StudyFile& study) {
  for (const auto& [name, section] : root.table_map("quantity")) {
    WantedQuantity q;
    q.name = section.has("of") ? section.text("of") : name;
    q.label = name;
    q.norm = norm_of(section.text("norm"));
    if (section.has("from")) q.from = section.quantity("from");
    if (section.has("to")) {
      q.to = section.quantity("to");
      if (q.to <= q.from) section.refuse("to", "must be after from", "give a later time");
    }
    q.level = section.quantity("level");
    if (section.has("scale")) q.scale = section.quantity("scale");
    study.quantities.push_back(std::move(q));
  }
  if (study.quantities.empty())
    root.refuse("quantity", "nothing says what has to be accurate",
                "add [quantity.NAME] with the name of a stored quantity");
}

// In front of the ladder, the finest of which stays the last.
void add_chosen(StudyFile& study) {
  std::vector<Choice> chosen;
  for (const double accuracy : study.accuracies) {
    Choice choice;
    choice.name = "chosen for " + percent(accuracy);
    choice.wanted = accuracy;
    choice.set.push_back(fmt::format("solver.accuracy={:.17g}", accuracy));
    for (const Part& part : study.parts)
      for (const std::string& body : part.bodies)
        choice.set.push_back(fmt::format("body.{}.fidelity=auto", body));
    chosen.push_back(std::move(choice));
  }
  study.choices.insert(study.choices.begin(), chosen.begin(), chosen.end());
}

}  // namespace

in::TableSchema study_schema() {
  in::TableSchema schema;
  schema.name = "study file";
  schema.doc =
      "What `flexura study` takes: a mechanism, a ladder of choices from coarse to fine, and the quantities "
      "that have to be right. Every choice is run and measured; errors are taken against the finest choice "
      "and against a converged reference with its own uncertainty.";
  schema.keys = {
      in::text("name", "title of tables and pictures; without it the file's name"),
      in::text("mechanism", "mechanism file, relative to the study file").required(),
      in::text("run", "which of its runs; may be left out where it has one"),
      in::texts("set", "\"key.path=value\" of the mechanism file for all choices"),
      in::choice(
          "ladder", {"product", "one_at_a_time"},
          "all combinations of the axes' choices, or each axis by itself with the others at their finest")
          .or_default("product"),
      in::choice("cost", {"wall", "cpu"},
                 "time that the front and the answers count: wall time, or on a busy machine the processor's")
          .or_default("wall"),
      in::integer("repeats", "runs of each choice; the median time counts")
          .or_default("3")
          .at_least(1)
          .at_most(1000),
      in::flag("estimates",
               "runs are timed with the estimates of their errors, as a user's run is; else without")
          .or_default("false"),
      in::quantity("time_limit", in::dim::time,
                   "a run that takes longer is ended and counts as failed; where cost is \"cpu\" it is "
                   "processor time, and ten times as much by the clock")
          .or_default("600 s")
          .above(0.0),
      in::text("cache",
               "folder of finished runs and reductions, relative to the study file; in its folder or the "
               "working folder unless --set names it")
          .or_default("study.cache"),
      in::table_map("part", part_schema(), "parts that the study reduces"),
      in::table_map("axis", axis_schema(), "things to choose; the choices of all are combined"),
      in::table_map(
          "choice",
          choice_schema("choice", "A choice of its own, beside the combinations; tried before them."),
          "choices by name, from coarse to fine"),
      in::table("reference", reference_schema(), "the converged run"),
      in::table_map("quantity", quantity_schema(), "what has to be right"),
      in::table("want", want_schema(), "what the study answers in words")};
  return schema;
}

StudyFile read_study(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const in::Section root = in::read_document(file, study_schema(), overrides);
  StudyFile study;
  study.file = file;
  study.name = root.title();
  study.mechanism = root.file("mechanism");
  std::error_code none;
  if (!std::filesystem::is_regular_file(study.mechanism, none))
    root.refuse("mechanism", "there is no such file",
                "give the mechanism file's path relative to the study file");
  study.cache = root.file("cache");
  // A file says where it is read, the command line where it is written.
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (!root.is_from_command_line("cache") && files::leads_out_of(folder, study.cache) &&
      files::leads_out_of(".", study.cache))
    root.refuse("cache", "lies neither in the study file's folder nor in the working folder",
                "give it on the command line: --set cache=FOLDER");
  if (root.has("run")) study.run = root.text("run");
  study.set = root.texts("set");
  study.cpu_is_cost = root.text("cost") == "cpu";
  study.repeats = root.integer("repeats");
  study.times_estimates = root.flag("estimates");
  study.time_limit = root.quantity("time_limit");
  study.parts = read_parts(root);
  read_choices(root, study);
  read_reference(root, study);
  read_quantities(root, study);
  if (root.has("want")) {
    const in::Section want = root.table("want");
    study.accuracies = want.quantities("accuracy");
    study.times = want.quantities("time");
    for (const double accuracy : study.accuracies)
      if (!(accuracy > 0.0 && accuracy <= 1.0))
        want.refuse("accuracy", "must be above 0 and at most 100 %", "give fractions or per cent");
    if (want.flag("chosen")) add_chosen(study);
    read_goals(root, want, study);
  }
  return study;
}

}  // namespace flexura::study
