// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/study/estimate/percent.hpp"
#include "mbs/study/ledger/estimated_error.hpp"

namespace flexura::study {

namespace {

// An estimate of the modes and of the integrator is right to about a fourth of itself where it is best.
constexpr double kSure = 0.8;

std::string words_of(const std::string& kind, const std::string& names) {
  if (kind == "integrator") return "integrator";
  if (kind == "modes") return "modes left out of " + names;
  if (kind == "mesh") return "mesh and reduction of " + names;
  if (kind == "stress") return "stress of " + names + " by its mesh";
  if (kind == "section_forces") return "section forces of " + names;
  if (kind == "stress_of_own_loads") return "stress of " + names + " by its own loads";
  if (kind == "elements") return "elements of " + names;
  if (kind == "plane") return "bending across the plane of " + names;
  if (kind == "surface_contact") return "surface in contact of " + names;
  if (kind == "beam") return "bending of the rigid " + names;
  if (kind == "law") return "law of deformation of " + names;
  if (kind == "link") return "rigid link of " + names;
  if (kind == "inertia") return "deformation by centrifugal and Coriolis forces of " + names;
  if (kind == "stiffening") return "geometric stiffening of " + names;
  if (kind == "dead_point") return "speeds and forces in rows next to a dead point";
  if (kind == "switch") return "switching of " + names;
  if (kind == "vibration") return "vibration of " + names;
  return "user element " + names;
}

// A line of the table; what is unknown for one reason stands in one line.
struct Entry {
  std::string kind, names, note;
  std::optional<double> error;
  double at_least = 0.0;
};

std::vector<Entry> entries(const ErrorEstimate& estimate) {
  std::vector<Entry> out;
  for (const ErrorSource& source : estimate.sources) {
    const auto same = std::ranges::find_if(out, [&](const Entry& e) {
      return !e.error && !source.error && e.kind == source.kind && e.note == source.note &&
             e.at_least == source.at_least;
    });
    if (same != out.end())
      same->names += ", " + source.name;
    else
      out.push_back({source.kind, source.name, source.note, source.error, source.at_least});
  }
  std::ranges::stable_sort(
      out, [](const Entry& a, const Entry& b) { return a.error.value_or(-1.0) > b.error.value_or(-1.0); });
  return out;
}

// The words in lines of so many columns, all but the first indented.
std::string folded(const std::string& words, std::size_t width, std::size_t indent) {
  std::string out;
  std::size_t column = indent;
  for (std::size_t at = 0; at < words.size();) {
    const std::size_t end = std::min(words.find(' ', at), words.size());
    const auto size = static_cast<std::size_t>(terminal::display_width(words.substr(at, end - at)));
    if (column > indent && column + 1 + size > width) {
      out += '\n' + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      out += ' ';
      ++column;
    }
    out += words.substr(at, end - at);
    column += size;
    at = end + 1;
  }
  return out;
}

}  // namespace

std::string discretisation_line(const mbs::PreparedMechanism& prepared) {
  ErrorEstimate estimate;
  estimate.sources = discretisation_of(prepared);
  std::vector<std::string> known, unknown;
  for (const Entry& e : entries(estimate)) {
    const std::string words = words_of(e.kind, e.names);
    if (e.error)
      known.push_back(fmt::format("{} {} {}", words, percent(*e.error), e.note));
    else
      unknown.push_back(words + (e.note.empty() ? "" : fmt::format(" ({})", e.note)));
  }
  if (known.empty() && unknown.empty()) return {};
  return fmt::format("discretisation: {}{}{}{}", fmt::join(known, ", "),
                     !known.empty() && !unknown.empty() ? "; " : "",
                     unknown.empty() ? "" : "unknown: ", fmt::join(unknown, ", "));
}

std::string estimated_error_text(const ErrorEstimate& estimate) {
  constexpr std::size_t kWidth = 80, kIndent = 13;
  // What nothing but unknown sources make is no figure, not even "at least 0".
  std::string out =
      !estimate.is_whole && estimate.at_least == 0.0
          ? "estimated error unknown"
          : fmt::format("estimated error {}{} of the rms of {}", estimate.is_whole ? "" : "at least ",
                        percent(estimate.at_least), estimate.of);
  bool has_modes = false;
  for (const Entry& e : entries(estimate)) {
    has_modes = has_modes || e.kind == "modes";
    std::string words = words_of(e.kind, e.names);
    // What is known of it counts in the sum above.
    if (!e.error && e.at_least > 0.0) words += ", at least " + percent(e.at_least);
    out += fmt::format("\n  {:>9}  {}", e.error ? percent(*e.error) : "unknown",
                       folded(e.note.empty() ? words : words + ": " + e.note, kWidth, kIndent));
  }
  if (!has_modes) out += "\n          0  no mode left out";
  if (estimate.is_large)
    out +=
        "\n" + std::string(kIndent, ' ') +
        folded("an estimate to first order, of this size only a warning: compare with a run with more modes",
               kWidth, kIndent);
  return out;
}

std::string missed_accuracy(const ErrorEstimate& estimate, double accuracy) {
  const std::vector<Entry> all = entries(estimate);
  if (estimate.at_least > accuracy) {
    const bool is_known = !all.empty() && all.front().error;
    // As --reduce would ask: half of the accuracy for meshes.
    const std::string remedy =
        is_known && all.front().kind == "mesh"
            ? fmt::format(": reduce it anew with --accuracy \"{}\", or let flexura simulate --reduce do it",
                          percent(0.5 * accuracy, 2))
            : "";
    return fmt::format("{} was asked and is not met: the error is {}{} of the rms of {}, most of it by {}{}",
                       percent(accuracy), estimate.is_whole ? "" : "at least ", percent(estimate.at_least),
                       estimate.of,
                       is_known ? words_of(all.front().kind, all.front().names) : "what is left out", remedy);
  }
  // Meshes are what they are in every run; the rest is an estimate to first order.
  double of_run = estimate.at_least;
  for (const Entry& e : all)
    if (e.kind == "mesh" || e.kind == "stress") of_run -= e.error.value_or(e.at_least);
  if (of_run > kSure * accuracy)
    return fmt::format(
        "whether the {} asked for is met is not sure: the error is estimated at {}{} of the rms of {}, "
        "nearer to it than an "
        "estimate is right; ask for half of it",
        percent(accuracy), estimate.is_whole ? "" : "at least ", percent(estimate.at_least), estimate.of);
  std::vector<std::string> blind;
  for (const Entry& e : all)
    if (!e.error && (e.kind == "integrator" || e.kind == "modes" || e.kind == "stress" ||
                     e.kind == "section_forces" || e.kind == "switch" || e.kind == "elements"))
      blind.push_back(words_of(e.kind, e.names));
  if (blind.empty()) return {};
  const bool of_elements =
      std::ranges::any_of(all, [](const Entry& e) { return !e.error && e.kind == "elements"; });
  const bool of_stress =
      std::ranges::any_of(all, [](const Entry& e) { return !e.error && e.kind == "stress"; });
  return fmt::format(
      "whether the {} asked for is met is unknown: nothing judges {}; compare with a run with {}{}",
      percent(accuracy), fmt::join(blind, ", "),
      of_elements ? "a tenth of it and twice as many elements" : "a tenth of it",
      of_stress ? " and with a finer mesh" : "");
}

nlohmann::json estimated_error_json(const ErrorEstimate& estimate, const Judges& judges,
                                    const mbs::RunResult& result) {
  using nlohmann::json;
  const TruncationEstimate* const truncation = judges.truncation;
  const IntegratorEstimate* const check = judges.integrator;
  json out = {{"error", estimate.is_whole ? json(estimate.at_least) : json()},
              {"at_least", estimate.at_least},
              {"unknown", json::array()},
              {"integrator", check && check->is_whole ? json(check->error) : json()},
              {"energy_balance", std::abs(result.energy.relative_error())}};
  for (const ErrorSource& source : estimate.sources) {
    if (!source.error)
      out["unknown"].push_back({{"source", source.kind}, {"name", source.name}, {"remedy", source.note}});
    if (source.kind == "mesh") out["mesh"][source.name] = source.error ? json(*source.error) : json();
  }
  if (check && check->factor == 1.0)
    out["integrator_steps"] = {{"error", check->is_whole ? json(check->error) : json()},
                               {"output", check->output},
                               {"note", check->note},
                               {"wall_time", check->wall}};
  if (check && check->factor != 1.0)
    out["integrator_check"] = {{"error", check->error},
                               {"output", check->output},
                               {"factor", check->factor},
                               {"wall_time", check->wall}};
  if (const ElementsEstimate* const e = judges.elements)
    out["elements_check"] = {{"error", e->is_whole ? json(e->error) : json()},
                             {"at_least", e->error},
                             {"output", e->output},
                             {"bodies", e->bodies},
                             {"note", e->note},
                             {"wall_time", e->wall}};
  if (!truncation) return out;
  out["truncation"] = truncation->error;
  out["shadows"] = truncation->shadows;
  out["wall_time"] = truncation->wall;
  for (const SourceEstimate& source : truncation->by_body) out["by_body"][source.body] = source.error;
  for (const OutputEstimate& o : truncation->outputs)
    out["outputs"][o.name] = {{"max", o.max},           {"rms", o.rms},           {"final", o.final},
                              {"size_max", o.size_max}, {"size_rms", o.size_rms}, {"scale", o.scale}};
  return out;
}

}  // namespace flexura::study
