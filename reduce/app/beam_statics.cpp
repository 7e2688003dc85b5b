// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/beam_statics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>

#include "beam/model/section_stress.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/text_file.hpp"
#include "reduce/linalg/session/session.hpp"

namespace flexura::reduce {
namespace {

nlohmann::json list(const beam::Vector6d& v) {
  return std::vector<double>(v.data(), v.data() + 6);
}

// Six columns of numbers: three of one unit, three of another.
using Rows = std::vector<beam::Vector6d>;

// What is round-off beside the greatest number of its unit in the table is printed as zero.  The solve is
// backward stable: its error is some n eps of the largest force that the structure carries, n eps = 1e-12 for
// 10,000 dofs, and stiff elements beside soft ones lose a few digits more; five digits are printed.
Rows without_round_off(Rows rows) {
  for (const int first : {0, 3}) {
    double largest = 0.0;
    for (const beam::Vector6d& v : rows)
      largest = std::max(largest, v.segment<3>(first).cwiseAbs().maxCoeff());
    for (beam::Vector6d& v : rows)
      for (int k = first; k < first + 3; ++k)
        if (std::abs(v(k)) < 1e-8 * largest) v(k) = 0.0;
  }
  return rows;
}

std::vector<terminal::Column> columns(std::vector<terminal::Column> first,
                                      std::initializer_list<const char*> names) {
  for (const char* name : names) first.push_back({name});
  return first;
}

void add(std::vector<std::string>& cells, const beam::Vector6d& v) {
  for (int k = 0; k < 6; ++k) cells.push_back(terminal::number(v(k), 5));
}

nlohmann::json stresses_json(const std::vector<beam::PointStress>& stresses) {
  nlohmann::json rows = nlohmann::json::array();
  for (const beam::PointStress& s : stresses)
    rows.push_back({{"point", s.name},
                    {"y", s.y},
                    {"z", s.z},
                    {"sigma_xx", s.sigma_xx},
                    {"tau_xy", s.tau_xy},
                    {"tau_xz", s.tau_xz},
                    {"von_mises", s.von_mises()}});
  return rows;
}

std::vector<BeamInterface> held_interfaces(const BeamPartInput& part, const std::vector<std::string>& held) {
  if (held.empty()) return part.interfaces;
  std::vector<BeamInterface> chosen;
  std::vector<std::string> names;
  for (const BeamInterface& interface : part.interfaces) names.push_back(interface.name);
  for (const std::string& name : held) {
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end())
      throw input::InputError(
          fmt::format("--held: there is no interface \"{}\"{}", name, input::suggestion(name, names)));
    chosen.push_back(part.interfaces[at - names.begin()]);
  }
  return chosen;
}

}  // namespace

void print_statics(const BeamPartInput& part, const std::vector<std::string>& held, int places,
                   std::ostream& out, const std::filesystem::path& report) {
  if (part.cases.empty())
    throw input::InputError("the beam part has no loads; add a table [load.NAME] for each force");
  const beam::BeamMesh mesh(part.model, part.subdivision);
  const std::vector<BeamInterface> interfaces = held_interfaces(part, held);
  const linalg::Session session;
  const Structure structure(mesh, part.solids, part.links);
  const Eigen::MatrixXd U = static_displacements(structure, interfaces, part.cases);
  std::string names;
  for (const BeamInterface& interface : interfaces) names += (names.empty() ? "" : ", ") + interface.name;
  nlohmann::json cases = nlohmann::json::array();
  const int width = terminal::width(stdout);
  for (std::size_t k = 0; k < part.cases.size(); ++k) {
    const LoadCase& load = part.cases[k];
    const Eigen::VectorXd u = U.col(static_cast<Eigen::Index>(k)).head(mesh.n_dofs());
    nlohmann::json node_rows = nlohmann::json::array(), member_rows = nlohmann::json::array();
    out << fmt::format("case {}, held: {}\n\n", load.name, names);
    Rows displacements;
    for (std::size_t n = 0; n < part.model.nodes.size(); ++n) {
      displacements.push_back(u.segment<6>(6 * static_cast<Eigen::Index>(n)));
      node_rows.push_back({{"node", part.model.nodes[n].name}, {"displacement", list(displacements.back())}});
    }
    terminal::Table nodes(columns({{"node", terminal::Align::left}},
                                  {"u_x [m]", "u_y [m]", "u_z [m]", "theta_x [rad]", "theta_y", "theta_z"}));
    displacements = without_round_off(displacements);
    for (std::size_t n = 0; n < displacements.size(); ++n) {
      std::vector<std::string> cells = {part.model.nodes[n].name};
      add(cells, displacements[n]);
      nodes.add_row(std::move(cells));
    }
    out << nodes.text(width) << '\n';

    terminal::Table forces(columns({{"member", terminal::Align::left}, {"x [m]"}},
                                   {"N [N]", "V_y [N]", "V_z [N]", "T [N m]", "M_y [N m]", "M_z [N m]"}),
                           2);
    terminal::Table stress({{"member", terminal::Align::left},
                            {"x [m]"},
                            {"largest von Mises [Pa]"},
                            {"at", terminal::Align::left}});
    std::vector<std::pair<std::string, std::string>> places_of_rows;
    Rows resultants;
    for (std::size_t m = 0; m < part.model.members.size(); ++m) {
      nlohmann::json rows = nlohmann::json::array();
      for (beam::MemberResult& r : beam::member_results(mesh, static_cast<int>(m), u, places, load.members)) {
        r.resultants(beam::N) += preload_of(load, static_cast<int>(m));
        const std::vector<beam::PointStress> stresses =
            beam::section_stresses(mesh, static_cast<int>(m), r.x, r.resultants);
        const auto greatest =
            std::max_element(stresses.begin(), stresses.end(),
                             [](const auto& a, const auto& b) { return a.von_mises() < b.von_mises(); });
        places_of_rows.emplace_back(part.model.members[m].name, terminal::number(r.x, 4));
        resultants.push_back(r.resultants);
        if (greatest != stresses.end())
          stress.add_row({part.model.members[m].name, terminal::number(r.x, 4),
                          terminal::number(greatest->von_mises(), 5), greatest->name});
        rows.push_back({{"x", r.x},
                        {"resultants", list(r.resultants)},
                        {"displacement", list(r.displacement)},
                        {"stresses", stresses_json(stresses)}});
      }
      member_rows.push_back({{"member", part.model.members[m].name}, {"places", rows}});
    }
    resultants = without_round_off(resultants);
    for (std::size_t i = 0; i < resultants.size(); ++i) {
      std::vector<std::string> cells = {places_of_rows[i].first, places_of_rows[i].second};
      add(cells, resultants[i]);
      forces.add_row(std::move(cells));
    }
    out << forces.text(width) << '\n' << stress.text(width) << '\n';
    cases.push_back({{"case", load.name}, {"nodes", node_rows}, {"members", member_rows}});
  }
  if (report.empty()) return;
  const nlohmann::json json = {
      {"part", part.name}, {"resultants", {"N", "V_y", "V_z", "T", "M_y", "M_z"}}, {"cases", cases}};
  superelement::write_whole(report, json.dump(1) + "\n");
}

}  // namespace flexura::reduce
