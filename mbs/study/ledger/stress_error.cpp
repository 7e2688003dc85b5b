// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "mbs/mechanism/describe.hpp"
#include "mbs/study/estimate/percent.hpp"
#include "mbs/study/ledger/estimated_error.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::study {
namespace {

// Of the stored quantities of a body: its greatest stress, or components and the like at these of its stress points.
struct StoredStress {
  bool greatest = false;
  std::vector<mbs::StressField::Point> points;
  bool any() const { return greatest || !points.empty(); }
};

bool is_stored_of(const std::vector<std::string>& stored, const std::string& opening) {
  return std::ranges::any_of(stored, [&](const std::string& name) { return name.starts_with(opening); });
}

StoredStress stored_stress(const mbs::BodyDescription& body, const std::vector<std::string>& stored) {
  StoredStress out;
  out.greatest = is_stored_of(stored, body.name + ".von_mises");
  for (const mbs::StressField::Point& point : body.stress->points())
    if (is_stored_of(stored, fmt::format("{}.{}.", body.name, point.name))) out.points.push_back(point);
  return out;
}

ErrorSource stress_of(const mbs::BodyDescription& body, const StoredStress& stored) {
  ErrorSource out{"stress", body.name, {}, 0.0, "its reduction judged no stress"};
  const superelement::Superelement se =
      superelement::read(body.superelement, {.matrices = false, .inertia = false, .mesh_error = true});
  if (!se.mesh_error) return out;
  const superelement::MeshError& known = *se.mesh_error;
  double worst = -1.0;
  bool is_judged = stored.points.empty() && !known.interfaces.empty();
  if (stored.greatest)
    for (const superelement::MeshError::Interface& interface : known.interfaces) {
      if (interface.stress.singular) {
        out.note =
            "no finite stress exists at a sharp re-entrant edge or the edge of a rigid interface, a finer "
            "mesh only makes it "
            "greater; round the edge, or store a stress_point away from it";
        return out;
      }
      is_judged = is_judged && interface.stress.peak >= 0.0 && interface.stress.peak < 1.0;
      if (interface.stress.peak <= worst) continue;
      worst = interface.stress.peak;
      out.note = "of the greatest, under loads on " + interface.name;
    }
  if (is_judged) {
    out.error = worst;
    return out;
  }
  // What elements are off is no figure of the nodes' stress, which is better where the field is smooth.
  double most = -1.0;
  for (const mbs::StressField::Point& point : stored.points) {
    const int vertex = body.stress->vertex(point.place);
    if (vertex >= known.at_vertices.size() || known.at_vertices(vertex) <= most) continue;
    most = known.at_vertices(vertex);
    out.note =
        fmt::format("in elements it is off by {} of the part's rms stress at {}; compare with a finer mesh",
                    percent(most), point.name);
  }
  return out;
}

// Section forces and stresses that lack what bears on the body between its interfaces.
void add_own_loads(const mbs::BodyDescription& body, const std::vector<std::string>& stored,
                   const StoredStress& stress, std::vector<ErrorSource>& sources) {
  const std::string remedy =
      "they lack what weight, inertia and load cases bear on the body inside; reduce the part again";
  if (body.sections &&
      std::ranges::any_of(body.sections->points(), [&](const mbs::SectionPoints::Point& point) {
        return is_stored_of(stored, fmt::format("{}.{}.", body.name, point.wanted.name));
      })) {
    const auto add = [&](const std::string& note) {
      sources.push_back({"section_forces", body.name, {}, 0.0, note});
    };
    if (!body.sections->is_whole())
      add(remedy);
    else if (!body.sections->knows_stiffening())
      add("they lack what tension along its members bears on a cut, which beam parts know and decks do not; "
          "of a beam "
          "part: reduce it again");
    if (!body.flexible->acts_back())
      add("a one-way body's vibration is in its cuts and not in its joints' forces; compare with fidelity = "
          "\"modal\"");
  }
  if (stress.any() && !body.stress->has_inertia())
    sources.push_back(
        {"stress_of_own_loads",
         body.name,
         {},
         0.0,
         "its reduction does not know what weight, inertia and load cases strain between the interfaces; "
         "more modes (flexura reduce -n) leave less of it out"});
}

}  // namespace

void add_stresses(const mbs::PreparedMechanism& prepared, std::vector<ErrorSource>& sources) {
  const mbs::Mechanism& mechanism = *prepared.mechanism;
  const auto& bodies = mechanism.description().bodies;
  if (std::ranges::none_of(bodies,
                           [](const mbs::BodyDescription& body) { return body.stress || body.sections; }))
    return;
  const auto infos = mechanism.quantities();
  std::vector<std::string> stored;
  for (const int i : mbs::select_quantities(mechanism, prepared.file.outputs))
    stored.push_back(infos[static_cast<std::size_t>(i)].name);
  for (const mbs::BodyDescription& body : bodies) {
    if (!body.flexible || !(body.stress || body.sections)) continue;
    const StoredStress of = body.stress ? stored_stress(body, stored) : StoredStress{};
    if (of.any()) sources.push_back(stress_of(body, of));
    add_own_loads(body, stored, of, sources);
  }
}

}  // namespace flexura::study
