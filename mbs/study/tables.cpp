// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/tables.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/base/files/table_text.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {
namespace {

using files::markdown_text;
using nlohmann::json;

json json_number(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

}  // namespace

json as_json(const StudyFile& study, const Judgement& judgement, const std::string& created_by) {
  json out = {{"name", study.name},
              {"created_by", created_by},
              {"mechanism", study.mechanism.string()},
              {"answers", judgement.answers},
              {"notes", judgement.notes},
              {"uncertainty", judgement.largest_uncertainty}};
  for (std::size_t k = 0; k < study.quantities.size(); ++k) {
    const WantedQuantity& q = study.quantities[k];
    out["quantities"].push_back({{"label", q.label},
                                 {"of", q.name},
                                 {"norm", norm_names()[static_cast<std::size_t>(q.norm)]},
                                 {"uncertainty", judgement.uncertainty[k]}});
  }
  for (const Row& row : judgement.rows) {
    const Measurement& c = *row.cost;
    json line = {{"name", row.choice->name},
                 {"set", row.choice->set},
                 {"part_set", row.choice->part_set},
                 {"results", std::filesystem::absolute(c.results).string()},
                 {"complete", c.complete},
                 {"wall", c.wall},
                 {"median_wall", c.median_wall()},
                 {"median_cpu", c.median_cpu()},
                 {"peak_memory", c.peak_memory},
                 {"reduce_wall", c.reduce_wall},
                 {"solver_wall", c.solver_wall},
                 {"steps", c.steps},
                 {"evaluations", c.evaluations},
                 {"relative_energy_error", c.energy_error},
                 {"wanted", row.choice->wanted > 0.0 ? json(row.choice->wanted) : json(nullptr)},
                 {"effectivity", row.effectivity >= 0.0 ? json(row.effectivity) : json(nullptr)},
                 {"estimated_error", row.estimate >= 0.0 ? json(row.estimate) : json(nullptr)},
                 {"estimate_is_at_least", row.is_at_least},
                 {"error", json_number(row.error.against_reference)},
                 {"error_to_finest", json_number(row.error.against_finest)},
                 {"worst", study.quantities[row.worst].label},
                 {"on_front", row.on_front},
                 {"failure", c.failure}};
    for (const ErrorOf& e : row.errors)
      line["errors"].push_back({json_number(e.against_reference), json_number(e.against_finest)});
    out["choices"].push_back(std::move(line));
  }
  return out;
}

std::string as_csv(const StudyFile& study, const Judgement& judgement) {
  std::string text =
      "choice,wall [s],cpu [s],peak memory [B],steps,evaluations,reduce wall [s],error,error to finest,on "
      "front";
  for (const auto& q : study.quantities) text += "," + files::csv_quoted("error of " + q.label);
  text += "\n";
  for (const Row& row : judgement.rows) {
    const Measurement& c = *row.cost;
    text += fmt::format("{},{:.6g},{:.6g},{:.0f},{},{},{:.6g},{:.9g},{:.9g},{}",
                        files::csv_quoted(row.choice->name), c.median_wall(), c.median_cpu(), c.peak_memory,
                        c.steps, c.evaluations, c.reduce_wall, row.error.against_reference,
                        row.error.against_finest, row.on_front ? 1 : 0);
    for (const ErrorOf& e : row.errors) text += fmt::format(",{:.9g}", e.against_reference);
    text += "\n";
  }
  return text;
}

std::string as_markdown(const StudyFile& study, const Judgement& judgement, const std::string& picture) {
  std::string text = fmt::format("## {}\n\n", markdown_text(study.name));
  if (!picture.empty()) text += fmt::format("![error over time]({})\n\n", picture);
  text += fmt::format(
      "|  | choice | {} [s] | memory | steps | error | of | estimated by the run "
      "| over the error |\n|---|---|---|---|---|---|---|---|---|\n",
      study.cpu_is_cost ? "cpu" : "wall");
  for (const Row& row : judgement.rows) {
    const Measurement& c = *row.cost;
    if (!c.complete) {
      text +=
          fmt::format("|  | {} | failed: {} |\n", markdown_text(row.choice->name), markdown_text(c.failure));
      continue;
    }
    text += fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
                        row.on_front               ? "**front**"
                        : row.choice->wanted > 0.0 ? "chosen"
                                                   : "",
                        markdown_text(row.choice->name), terminal::number(row.price, 3),
                        terminal::bytes(c.peak_memory), c.steps, percent(row.error.against_reference),
                        markdown_text(study.quantities[row.worst].label),
                        row.estimate >= 0.0 ? (row.is_at_least ? ">= " : "") + percent(row.estimate) : "",
                        row.effectivity >= 0.0 ? terminal::number(row.effectivity, 2) : "");
  }
  if (!judgement.chosen.empty()) {
    text +=
        "\n| wanted | chosen: error | met | cost [s] | cheapest rung that meets it | its cost [s] | ratio "
        "|\n|---|---|---|---|---|---|---|\n";
    for (const Chosen& c : judgement.chosen)
      text += fmt::format("| {} | {} | {} | {} | {} | {} | {} |\n", percent(c.wanted),
                          percent(c.row->error.against_reference), c.met() ? "yes" : "**no**",
                          terminal::number(c.row->price, 3),
                          c.cheapest ? markdown_text(c.cheapest->choice->name) : "none",
                          c.cheapest ? terminal::number(c.cheapest->price, 3) : "",
                          c.cheapest ? terminal::number(c.cost_ratio(), 3) : "");
  }
  text += fmt::format("\nThe reference is known within {}.\n\n", percent(judgement.largest_uncertainty));
  for (const std::string& answer : judgement.answers) text += "- " + markdown_text(answer) + "\n";
  return text;
}

}  // namespace flexura::study
