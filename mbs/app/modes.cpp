// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/known_errors.hpp"
#include "mbs/view/pages.hpp"

namespace flexura::app {
namespace {

using superelement::Mode;
using superelement::ModeAnalysis;
using superelement::Superelement;
using terminal::Align;

struct Arguments {
  std::string file, html;
  std::vector<std::string> clamped;
  bool free = false, fixed = false, constraint = false, json = false;
  int count = 20;
};

constexpr const char* axes[] = {"x", "y", "z"};

bool is_constraint(const ModeAnalysis& analysis) {
  return !analysis.modes.empty() && !analysis.modes.front().dof.empty();
}

std::string title(const ModeAnalysis& analysis, const Superelement& se) {
  if (is_constraint(analysis)) return "Constraint modes";
  if (analysis.held.empty()) return "Free body";
  if (analysis.held.size() == se.interfaces.size()) return "All interfaces held (fixed-interface modes)";
  return fmt::format("Held: {}", fmt::join(analysis.held, ", "));
}

// The same in few words, for the page.
std::string set_name(const ModeAnalysis& analysis, const Superelement& se) {
  return analysis.held.size() == se.interfaces.size() && !analysis.held.empty() ? "Interfaces held"
                                                                                : title(analysis, se);
}

// Effective mass in percent of the body's own, about axes through the mass centre.
std::string percent(double part, double whole) {
  if (!(whole > 0.0)) return "";
  return fmt::format("{:.2f}", 100.0 * part / whole);
}

bool is_free(const ModeAnalysis& analysis) {
  return analysis.held.empty() && !is_constraint(analysis);
}

// True of a displacement, by the name of its dof: "base.u_x".
bool is_displacement(const Mode& mode) {
  return mode.dof[mode.dof.rfind('.') + 1] == 'u';
}

std::string constraint_table(const ModeAnalysis& analysis, int width, bool colour) {
  terminal::Table table({{"no", Align::right},
                         {"interface direction", Align::left},
                         {"moved by", Align::right},
                         {"stiffness", Align::right},
                         {"strain energy [J]", Align::right}});
  int number = 0;
  for (const Mode& mode : analysis.modes) {
    const bool u = is_displacement(mode);
    table.add_row({fmt::format("{}", ++number), mode.dof, u ? "1 m" : "1 rad",
                   fmt::format("{} {}", terminal::number(mode.stiffness, 6), u ? "N/m" : "N m/rad"),
                   terminal::number(0.5 * mode.stiffness, 6)});
  }
  return table.text(width, colour);
}

// Of the free body the errors of its frequencies stand where effective masses are none.
std::string table_text(const ModeAnalysis& analysis, const Superelement& se, int width, bool colour) {
  std::vector<terminal::Column> columns = {
      {"no", Align::right}, {"kind", Align::left}, {"f [Hz]", Align::right}};
  if (!is_free(analysis)) {
    for (const char* axis : axes) columns.push_back({fmt::format("m_{} %", axis), Align::right});
    for (const char* axis : axes) columns.push_back({fmt::format("J_{} %", axis), Align::right});
  }
  columns.push_back({"damp. %", Align::right});
  if (is_free(analysis))
    for (const char* source : {"mesh %", "left out %"}) columns.push_back({source, Align::right});
  terminal::Table table(columns);
  int number = 0;
  for (const Mode& mode : analysis.modes) {
    std::vector<std::string> row = {fmt::format("{}", ++number), superelement::kind_of(mode),
                                    mode.omega2 == 0.0 ? "0" : terminal::number(mode.frequency_hz, 6)};
    for (int c = 0; c < 6 && !is_free(analysis); ++c)
      row.push_back(percent(mode.effective_mass[c], c < 3 ? analysis.mass : analysis.inertia(c - 3, c - 3)));
    row.push_back(mode.omega2 == 0.0 ? "" : fmt::format("{:.3g}", 100.0 * mode.damping));
    if (is_free(analysis)) {
      const superelement::FrequencyError error = superelement::frequency_error(se, mode.frequency_hz);
      row.push_back(mode.omega2 == 0.0 ? "" : superelement::percent_words(error.mesh));
      row.push_back(mode.omega2 == 0.0 ? "" : superelement::percent_words(error.left_out));
    }
    table.add_row(std::move(row));
  }
  return table.text(width, colour);
}

nlohmann::json known(double error) {
  return error >= 0.0 ? nlohmann::json(error) : nlohmann::json();
}

nlohmann::json to_json(const ModeAnalysis& analysis, const Superelement& se) {
  nlohmann::json modes = nlohmann::json::array();
  int number = 0;
  if (is_constraint(analysis)) {
    for (const Mode& mode : analysis.modes)
      modes.push_back({{"number", ++number},
                       {"kind", superelement::kind_of(mode)},
                       {"dof", mode.dof},
                       {"unit", is_displacement(mode) ? "m" : "rad"},
                       {"stiffness", mode.stiffness},
                       {"strain_energy", 0.5 * mode.stiffness}});
    return {{"constraint", true}, {"modes", modes}};
  }
  for (const Mode& mode : analysis.modes) {
    const auto& m = mode.effective_mass;
    modes.push_back({{"number", ++number},
                     {"kind", superelement::kind_of(mode)},
                     {"frequency_hz", mode.frequency_hz},
                     {"effective_mass_kg", {m[0], m[1], m[2]}},
                     {"effective_inertia_kg_m2", {m[3], m[4], m[5]}},
                     {"damping", mode.damping}});
    if (!is_free(analysis) || mode.omega2 == 0.0) continue;
    const superelement::FrequencyError error = superelement::frequency_error(se, mode.frequency_hz);
    modes.back()["mesh_error"] = known(error.mesh);
    modes.back()["left_out_error"] = known(error.left_out);
  }
  return {{"held", analysis.held}, {"n_rigid", analysis.n_rigid}, {"modes", modes}};
}

// What the columns mean.
std::string footnotes(const std::vector<ModeAnalysis>& analyses, const Superelement& se) {
  std::string text;
  if (std::ranges::any_of(analyses, is_free))
    text += fmt::format(
        "mesh %, left out %: by how much the mesh and the modes left out make the\n"
        "frequency too high, by their estimates.\n{}.\n",
        superelement::mesh_error_words(se));
  if (std::ranges::any_of(analyses, is_constraint))
    text +=
        "Each interface direction moved by a unit, all others at rest: the stiffness is the force or torque\n"
        "that this takes there.\n";
  if (std::ranges::any_of(analyses, [](const ModeAnalysis& a) { return !a.held.empty(); }))
    text += "m, J: effective mass and inertia about the mass centre in percent of the body's.\n";
  return text;
}

void write_page(const std::string& html, const std::string& file, const std::vector<ModeAnalysis>& analyses) {
  const Superelement se = superelement::read(file, {.matrices = true,
                                                    .inertia = true,
                                                    .surface = true,
                                                    .shapes = true,
                                                    .stress = true,
                                                    .mesh_error = true});
  std::size_t n_modes = 0;
  for (const ModeAnalysis& analysis : analyses) n_modes += analysis.modes.size();
  view::ModesPage page;
  page.columns.resize(se.n(), static_cast<Eigen::Index>(n_modes));
  for (const ModeAnalysis& analysis : analyses) {
    int number = 0;
    for (const Mode& mode : analysis.modes) {
      view::PageMode line{.set = set_name(analysis, se),
                          .number = ++number,
                          .kind = superelement::kind_of(mode),
                          .frequency_hz = mode.frequency_hz,
                          .damping = mode.damping,
                          .can_strike = is_free(analysis) && mode.omega2 > 0.0};
      for (std::size_t c = 0; c < 6; ++c) line.effective_mass[c] = mode.effective_mass[static_cast<int>(c)];
      if (!mode.dof.empty()) {
        line.kind += " " + mode.dof;
        line.detail = fmt::format("{} {}", terminal::number(mode.stiffness, 4),
                                  is_displacement(mode) ? "N/m" : "N m/rad");
        line.vibrates = false;
      }
      page.columns.col(static_cast<Eigen::Index>(page.modes.size())) = mode.u_se;
      page.modes.push_back(line);
    }
  }
  view::write_modes_page(html, se, page);
}

/// "a,b" in one word, where no interface is called so, are two of them.
std::vector<std::string> named_interfaces(const std::vector<std::string>& words, const Superelement& se) {
  const std::vector<std::string> known = superelement::interface_names(se);
  std::vector<std::string> names;
  for (const std::string& word : words) {
    if (std::ranges::find(known, word) != known.end()) {
      names.push_back(word);
      continue;
    }
    std::size_t from = 0;
    for (std::size_t comma = 0; comma != std::string::npos; from = comma + 1) {
      comma = word.find(',', from);
      names.push_back(word.substr(from, comma - from));
    }
  }
  return names;
}

int run(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  if (arguments.free + arguments.fixed + arguments.constraint + !arguments.clamped.empty() > 1) {
    throw std::invalid_argument(
        "--free, --fixed, --clamped and --constraint exclude each other; give one of them");
  }
  if (arguments.count < 1)
    throw std::invalid_argument(fmt::format("--count is {}, it must be at least 1", arguments.count));
  files::Claims claims;
  claims.add(arguments.html);
  const Superelement se =
      superelement::read(arguments.file, {.matrices = true, .inertia = true, .mesh_error = true});
  // Without a choice: the body as it hangs in the air and, with effective masses, as it sits in its
  // interfaces.
  std::vector<ModeAnalysis> analyses;
  const bool all = !arguments.free && !arguments.fixed && !arguments.constraint && arguments.clamped.empty();
  if (all || arguments.free) analyses.push_back(superelement::natural_modes(se, {}, arguments.count));
  if ((all && se.n_q > 0) || arguments.fixed) {
    analyses.push_back(superelement::natural_modes(se, superelement::interface_names(se), arguments.count));
  }
  if (!arguments.clamped.empty()) {
    analyses.push_back(
        superelement::natural_modes(se, named_interfaces(arguments.clamped, se), arguments.count));
  }

  if (arguments.constraint) analyses.push_back(superelement::constraint_modes(se));

  if (arguments.json) {
    const ModeAnalysis& first = analyses.front();
    nlohmann::json out = {
        {"name", se.name},
        {"mass_kg", first.mass},
        {"mass_centre_m", {first.mass_centre[0], first.mass_centre[1], first.mass_centre[2]}},
        {"n_b", se.n_b},
        {"n_q", se.n_q},
        {"analyses", nlohmann::json::array()}};
    for (const ModeAnalysis& analysis : analyses) out["analyses"].push_back(to_json(analysis, se));
    fmt::print("{}\n", out.dump(1));
  } else if (!verbosity.quiet) {
    const bool colour = terminal::takes_colour(stdout);
    const int width = terminal::width(stdout);
    fmt::print("{}: {} kg, {} interface dofs, {} modes\n", terminal::bold(se.name, colour),
               terminal::number(analyses.front().mass, 6), se.n_b, se.n_q);
    for (const ModeAnalysis& analysis : analyses) {
      fmt::print("\n{}\n{}", terminal::bold(title(analysis, se), colour),
                 is_constraint(analysis) ? constraint_table(analysis, width, colour)
                                         : table_text(analysis, se, width, colour));
    }
    fmt::print("\n{}", footnotes(analyses, se));
    if (all && se.n_q == 0) fmt::print("The superelement has no fixed-interface modes (static reduction).\n");
  }
  if (!arguments.html.empty()) {
    write_page(arguments.html, arguments.file, analyses);
    if (!verbosity.quiet && !arguments.json) fmt::print("wrote {}\n", arguments.html);
  }
  return 0;
}

}  // namespace

terminal::Command modes_command() {
  return {"modes", "list the natural modes of a superelement, or write a page on which they move",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto arguments = std::make_shared<Arguments>();
            options.argument("FILE", arguments->file, "superelement file")
                .flag("--free", arguments->free, "the free body: six rigid modes, then the elastic ones")
                .flag("--fixed", arguments->fixed, "all interfaces held: fixed-interface modes")
                .option("--clamped,--held", arguments->clamped, "NAME", "these interfaces held")
                .flag("--constraint", arguments->constraint,
                      "the constraint modes: a unit of each interface direction, with its stiffness and "
                      "strain energy")
                .option("-n,--count", arguments->count, "N", "at most this many elastic modes of each kind")
                .flag("--json", arguments->json, "print JSON, with effective masses in kg and kg m^2")
                .option("--html,-o,--output", arguments->html, "PAGE",
                        "write a page that shows the modes moving")
                .example("flexura modes conrod.se.h5", "free and fixed-interface modes")
                .example("flexura modes conrod.se.h5 --clamped big_end --count 5",
                         "the first five with one end held")
                .example("flexura modes conrod.se.h5 --html conrod.html", "look at them in a browser");
            return [arguments, &verbosity] { return run(*arguments, verbosity); };
          }};
}

}  // namespace flexura::app
