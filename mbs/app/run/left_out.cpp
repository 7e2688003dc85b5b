// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/left_out.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/study/estimate/full_model.hpp"
#include "mbs/superelement/contents.hpp"

namespace flexura::app {

LeftOut left_out(const mbs::PreparedMechanism& prepared) {
  const mbs::Mechanism& mechanism = *prepared.mechanism;
  const auto& bodies = mechanism.description().bodies;
  LeftOut out;
  const mbs::Sizes n = mechanism.sizes();
  out.states = out.states_of_all = n.n_p + n.n_v + n.n_dyn + n.n_lambda;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const mbs::BodyDescription& description = bodies[b];
    if (!description.is_reduced()) continue;
    const superelement::PartSizes bytes = description.of_beam
                                              ? superelement::PartSizes{}
                                              : superelement::contents(description.superelement).bytes;
    const mbs::FlexibleBody* const deforms = mechanism.deforming(static_cast<int>(b));
    LeftOut::Body body;
    body.name = description.name;
    body.available = study::deformations_of(description);
    body.kept = deforms ? deforms->m() : 0;
    out.states_of_all += 2 * std::max(0, body.available - body.kept);
    body.whole_bytes =
        bytes.matrices + bytes.inertia + bytes.stiffening + bytes.surface + bytes.shapes + bytes.stress;
    const auto part = [&](bool read, double size, const char* words) {
      if (read || size == 0.0) return;
      body.not_read.emplace_back(words);
      body.bytes += size;
    };
    part(deforms != nullptr, bytes.matrices, "matrices");
    part(deforms && deforms->modal() && deforms->modal()->second, bytes.stiffening, "stiffening terms");
    part(description.stress != nullptr, bytes.stress, "stress modes");
    part(description.stress || description.follows_surface, bytes.surface, "surface");
    part(deforms && description.follows_surface, bytes.shapes, "shapes of the surface");
    out.bodies.push_back(std::move(body));
  }
  out.quantities_of_all = static_cast<int>(mechanism.quantities().size());
  out.quantities = static_cast<int>(mbs::select_quantities(mechanism, prepared.file.outputs).size());
  return out;
}

namespace {

// Bodies of which the same was not read: three by their names, more by their number.
std::vector<std::string> not_read_parts(const LeftOut& out) {
  std::vector<std::pair<std::vector<std::string>, std::vector<const LeftOut::Body*>>> alike;
  for (const LeftOut::Body& body : out.bodies) {
    if (body.not_read.empty()) continue;
    auto found = std::ranges::find_if(alike, [&](const auto& one) { return one.first == body.not_read; });
    if (found == alike.end()) found = alike.insert(alike.end(), {body.not_read, {}});
    found->second.push_back(&body);
  }
  std::vector<std::string> parts;
  for (const auto& [what, bodies] : alike) {
    std::vector<std::string> names;
    double bytes = 0.0, whole = 0.0;
    for (const LeftOut::Body* body : bodies) {
      names.push_back(body->name);
      bytes += body->bytes;
      whole += body->whole_bytes;
    }
    parts.push_back(fmt::format("{} of {} ({} of {} not read)", fmt::join(what, ", "),
                                bodies.size() > 3 ? fmt::format("{} bodies", bodies.size())
                                                  : fmt::format("{}", fmt::join(names, ", ")),
                                terminal::bytes(bytes), terminal::bytes(whole)));
  }
  return parts;
}

}  // namespace

std::string left_out_line(const LeftOut& out) {
  std::vector<std::string> parts;
  for (const LeftOut::Body& body : out.bodies)
    if (body.kept < body.available)
      parts.push_back(
          fmt::format("{} of {} deformations of {}", body.available - body.kept, body.available, body.name));
  for (std::string& part : not_read_parts(out)) parts.push_back(std::move(part));
  if (out.states < out.states_of_all)
    parts.push_back(fmt::format("so {} states in place of {}", out.states, out.states_of_all));
  if (out.quantities < out.quantities_of_all)
    parts.push_back(fmt::format("{} of {} quantities not evaluated or stored",
                                out.quantities_of_all - out.quantities, out.quantities_of_all));
  return parts.empty() ? "" : fmt::format("left out: {}", fmt::join(parts, "; "));
}

nlohmann::json left_out_json(const LeftOut& out) {
  nlohmann::json json = {{"states", out.states},
                         {"states_of_all", out.states_of_all},
                         {"quantities", out.quantities},
                         {"quantities_of_all", out.quantities_of_all}};
  for (const LeftOut::Body& body : out.bodies)
    json["bodies"][body.name] = {{"deformations", body.kept},
                                 {"deformations_of_all", body.available},
                                 {"not_read", body.not_read},
                                 {"bytes_not_read", body.bytes},
                                 {"bytes_of_all", body.whole_bytes}};
  return json;
}

}  // namespace flexura::app
