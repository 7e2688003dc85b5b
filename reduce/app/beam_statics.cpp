// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/beam_statics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <ostream>

#include "beam/model/section_stress.hpp"
#include "reduce/linalg/session.hpp"

namespace flexura::reduce {
namespace {

nlohmann::json list(const beam::Vector6d& v) {
  return std::vector<double>(v.data(), v.data() + 6);
}

// What is round-off beside the greatest force (and moment) of the row is printed as zero.
beam::Vector6d without_round_off(beam::Vector6d v) {
  for (const int first : {0, 3}) {
    const double least = 1e-10 * v.segment<3>(first).cwiseAbs().maxCoeff();
    for (int k = first; k < first + 3; ++k)
      if (std::abs(v(k)) < least) v(k) = 0.0;
  }
  return v;
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
  const Structure structure(mesh, part.solids);
  const Eigen::MatrixXd U = static_displacements(structure, interfaces, part.cases);
  std::string names;
  for (const BeamInterface& interface : interfaces) names += (names.empty() ? "" : ", ") + interface.name;
  nlohmann::json cases = nlohmann::json::array();
  for (std::size_t k = 0; k < part.cases.size(); ++k) {
    const LoadCase& load = part.cases[k];
    const Eigen::VectorXd u = U.col(static_cast<Eigen::Index>(k)).head(mesh.n_dofs());
    nlohmann::json node_rows = nlohmann::json::array(), member_rows = nlohmann::json::array();
    out << fmt::format("case {}, held: {}\n{:<24} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12}\n", load.name,
                       names, "node", "u_x [m]", "u_y", "u_z", "theta_x [rad]", "theta_y", "theta_z");
    for (std::size_t n = 0; n < part.model.nodes.size(); ++n) {
      const beam::Vector6d d = without_round_off(u.segment<6>(6 * static_cast<Eigen::Index>(n)));
      out << fmt::format("{:<24} {:>12.5g} {:>12.5g} {:>12.5g} {:>12.5g} {:>12.5g} {:>12.5g}\n",
                         part.model.nodes[n].name, d(0), d(1), d(2), d(3), d(4), d(5));
      node_rows.push_back({{"node", part.model.nodes[n].name}, {"displacement", list(d)}});
    }
    out << fmt::format("{:<24} {:>9} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12}  {}\n", "member",
                       "x [m]", "N [N]", "V_y", "V_z", "T [N m]", "M_y", "M_z", "stress [Pa]", "at");
    for (std::size_t m = 0; m < part.model.members.size(); ++m) {
      nlohmann::json rows = nlohmann::json::array();
      for (const beam::MemberResult& r :
           beam::member_results(mesh, static_cast<int>(m), u, places, load.members)) {
        const std::vector<beam::PointStress> stresses =
            beam::section_stresses(mesh, static_cast<int>(m), r.x, r.resultants);
        const auto greatest =
            std::max_element(stresses.begin(), stresses.end(),
                             [](const auto& a, const auto& b) { return a.von_mises() < b.von_mises(); });
        out << fmt::format("{:<24} {:>9.4g}", part.model.members[m].name, r.x);
        const beam::Vector6d printed = without_round_off(r.resultants);
        for (int i = 0; i < 6; ++i) out << fmt::format(" {:>12.5g}", printed(i));
        if (greatest != stresses.end())
          out << fmt::format(" {:>12.5g}  {}", greatest->von_mises(), greatest->name);
        out << '\n';
        rows.push_back({{"x", r.x},
                        {"resultants", list(r.resultants)},
                        {"displacement", list(r.displacement)},
                        {"stresses", stresses_json(stresses)}});
      }
      member_rows.push_back({{"member", part.model.members[m].name}, {"places", rows}});
    }
    cases.push_back({{"case", load.name}, {"nodes", node_rows}, {"members", member_rows}});
  }
  if (report.empty()) return;
  const std::filesystem::path beside = report.string() + ".part";
  std::ofstream file(beside);
  file << nlohmann::json{{"part", part.name},
                         {"resultants", {"N", "V_y", "V_z", "T", "M_y", "M_z"}},
                         {"cases", cases}}
              .dump(1)
       << '\n';
  file.close();
  if (!file) throw std::runtime_error(report.string() + " cannot be written");
  std::filesystem::rename(beside, report);
}

}  // namespace flexura::reduce
