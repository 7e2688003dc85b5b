// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/app/run/quantity_list.hpp"
#include "mbs/app/run/state_table.hpp"
#include "mbs/base/terminal/terminal.hpp"

namespace flexura::app {

namespace {

nlohmann::json to_json(const NamedRun& run) {
  using nlohmann::json;
  const mbs::PreparedMechanism& p = run.prepared;
  const mbs::Mechanism& m = *p.mechanism;
  const mbs::MechanismDescription& d = m.description();
  const mbs::Sizes n = m.sizes();
  const int n_dyn = n.n_dyn - n.n_held;
  json joints = json::array(), states = json::array(), redundant = json::array();
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    joints.push_back({{"name", d.joints[j].name},
                      {"type", d.joints[j].joint->type()},
                      {"is_connection", d.joints[j].is_connection},
                      {"is_constraint", !m.in_tree(static_cast<int>(j))}});
  }
  for (int i = 0; i < n.n_v; ++i)
    states.push_back({{"name", m.name_of_velocity(i)}, {"velocity", p.state.v(i)}});
  json others = json::array();
  for (int i = 0; i < n.n_dyn; ++i)
    others.push_back({{"name", m.name_of_dynamic(i)}, {"kind", m.is_held(i) ? "held" : "dynamic"}});
  for (int i = 0; i < n.n_lambda; ++i)
    others.push_back({{"name", m.name_of_constraint(i)}, {"kind", "constraint force"}});
  for (int i = 0; i < n.n_alg; ++i)
    others.push_back({{"name", m.name_of_algebraic(i)}, {"kind", "algebraic"}});
  for (int i = 0; i < n.n_root; ++i) others.push_back({{"name", m.name_of_root(i)}, {"kind", "root"}});
  for (const mbs::RedundantRow& row : p.redundant)
    redundant.push_back({{"name", row.name}, {"follows_from", row.follows_from}});
  json out = run_json(run);
  out.update({{"n_jnt", n.n_v - n.n_flx},
              {"n_flx", n.n_flx},
              {"n_dyn", n_dyn},
              {"n_held", n.n_held},
              {"n_alg", n.n_alg},
              {"n_lambda", n.n_lambda},
              {"n_dof", n.n_v + n_dyn - n.n_lambda},
              {"n_eq", 2 * n.n_v + n_dyn + n.n_alg + n.n_lambda},
              {"switches", n.n_root},
              {"joints", joints},
              {"states", states},
              {"other_states", others},
              {"redundant_constraints", redundant},
              {"quantities", quantity_json(p)}});
  return out;
}

}  // namespace

int check_mechanism(const MechanismArguments& arguments, bool json, const terminal::Verbosity& verbosity) {
  const std::vector<NamedRun> runs = prepare_runs(arguments);
  if (json) {
    nlohmann::json list = nlohmann::json::array();
    for (const NamedRun& run : runs) list.push_back(to_json(run));
    print_json("mechanism", runs, list);
  }
  if (verbosity.quiet || json) return 0;
  const bool colour = terminal::takes_colour(stdout);
  for (const NamedRun& run : runs) {
    const mbs::PreparedMechanism& p = run.prepared;
    const mbs::Mechanism& m = *p.mechanism;
    const mbs::MechanismDescription& d = m.description();
    const mbs::Sizes n = m.sizes();
    fmt::print("{}\n\n", heading(run));
    terminal::Table counts({{"count", terminal::Align::left}, {"value"}});
    const int n_jnt = n.n_v - n.n_flx, n_dyn = n.n_dyn - n.n_held;
    counts.add_row({"joint coordinates n_jnt", fmt::format("{}", n_jnt)});
    counts.add_row({"modal coordinates n_flx", fmt::format("{}", n.n_flx)});
    counts.add_row({"dynamic states n_dyn", fmt::format("{}", n_dyn)});
    if (n.n_held > 0) counts.add_row({"held values", fmt::format("{}", n.n_held)});
    counts.add_row({"algebraic states n_alg", fmt::format("{}", n.n_alg)});
    counts.add_row({"independent constraints n_lambda", fmt::format("{}", n.n_lambda)});
    counts.add_row({"redundant constraints", fmt::format("{}", p.redundant.size())});
    counts.add_row({"switches", fmt::format("{}", n.n_root)});
    counts.add_row({"redundant orientation parameters", fmt::format("{}", n.n_p - n.n_v)});
    counts.add_row(
        {"n_DOF = n_jnt + n_flx + n_dyn - n_lambda", fmt::format("{}", n.n_v + n_dyn - n.n_lambda)});
    counts.add_row({"n_Eq = 2 (n_jnt + n_flx) + n_dyn + n_alg + n_lambda",
                    fmt::format("{}", 2 * n.n_v + n_dyn + n.n_alg + n.n_lambda)});
    fmt::print("{}\n", counts.text(terminal::width(stdout), colour));
    terminal::Table joints({{"joint", terminal::Align::left},
                            {"type", terminal::Align::left},
                            {"is a", terminal::Align::left},
                            {"because", terminal::Align::left}});
    for (std::size_t j = 0; j < d.joints.size(); ++j) {
      const bool tree = m.in_tree(static_cast<int>(j));
      joints.add_row({d.joints[j].name, std::string(d.joints[j].joint->type()),
                      tree ? "tree joint" : "constraint",
                      tree && d.joints[j].is_connection
                          ? "the connection with the fewest freedoms to a body no joint leads to"
                      : tree               ? "it leads to its body"
                      : d.joints[j].splits ? "many flexible bodies in a chain cost less so"
                      : d.joints[j].cut    ? "the file cuts it"
                                           : "it closes a loop"});
    }
    fmt::print("{}\n", joints.text(terminal::width(stdout), colour));
    if (!p.redundant.empty()) {
      fmt::print("Redundant constraints, left out (reactions of the rows named with them are not unique):\n");
      for (const mbs::RedundantRow& row : p.redundant)
        fmt::print("  {} follows from {}\n", row.name,
                   row.follows_from.empty() ? "nothing: it restrains no motion"
                                            : fmt::format("{}", fmt::join(row.follows_from, ", ")));
      fmt::print("\n");
    }
    // Where coordinates and speeds are not as many (quaternions) the speeds stand alone.
    const bool are_pairs = n.n_p == n.n_v;
    terminal::Table states({{are_pairs ? "coordinate" : "speed", terminal::Align::left},
                            {are_pairs ? "value" : "coordinate"},
                            {are_pairs ? "rate" : "value"}});
    const StateText text(p);
    for (int i = 0; i < n.n_v; ++i)
      states.add_row({are_pairs ? text.position_name(i) : text.velocity_name(i),
                      are_pairs ? text.position(i, 7) : std::string("see assemble"), text.velocity(i, 7)});
    fmt::print("{}\n", states.text(terminal::width(stdout), colour));
    if (n.n_dyn + n.n_lambda + n.n_alg + n.n_root > 0) {
      terminal::Table others({{"state", terminal::Align::left}, {"kind", terminal::Align::left}, {"value"}});
      for (int i = 0; i < n.n_dyn; ++i)
        others.add_row({text.other_name(m.name_of_dynamic(i)), m.is_held(i) ? "held" : "dynamic",
                        terminal::number(p.state.c(i), 7)});
      for (int i = 0; i < n.n_lambda; ++i)
        others.add_row({text.multiplier_name(i), "constraint force", text.multiplier(i, 7)});
      for (int i = 0; i < n.n_alg; ++i)
        others.add_row(
            {text.other_name(m.name_of_algebraic(i)), "algebraic", terminal::number(p.state.a(i), 7)});
      for (int i = 0; i < n.n_root; ++i)
        others.add_row(
            {m.name_of_root(i), "root",
             i < static_cast<int>(p.state.root.size()) ? fmt::format("{}", p.state.root[i]) : "-"});
      fmt::print("{}\n", others.text(terminal::width(stdout), colour));
    }
    fmt::print("Quantities (* stored when the file does not say which{}):\n{}\n",
               p.redundant.empty() ? "" : ", ? not unique: without the redundant constraints left out",
               quantity_list(p, terminal::width(stdout)));
    for (const std::string& note : p.notes) terminal::say(stdout, "note: " + note);
  }
  return 0;
}

}  // namespace flexura::app
