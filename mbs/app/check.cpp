// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/app/commands.hpp"
#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/known_errors.hpp"
#include "mbs/superelement/modes.hpp"

namespace flexura::app {
namespace {

using superelement::Superelement;
using terminal::Align;
using terminal::number;

// Of numbers that were computed from ones as large as `scale`, what is below a 1e-14th of it is round-off.
std::string vector_text(const Eigen::Vector3d& v, double scale) {
  const auto text = [scale](double x) { return number(std::abs(x) < 1e-14 * scale ? 0.0 : x, 6); };
  return fmt::format("({}, {}, {})", text(v[0]), text(v[1]), text(v[2]));
}

/// The largest distance from Bo of what the body's numbers were computed from [m].
double reach(const Superelement& se) {
  double largest = se.surface.vertices.size() > 0 ? se.surface.vertices.cwiseAbs().maxCoeff() : 0.0;
  for (const auto& interface : se.interfaces)
    largest = std::max(largest, interface.p_BoN_B.cwiseAbs().maxCoeff());
  return largest;
}

std::string directions_text(const superelement::Interface& interface) {
  if (interface.directions.size() == 6) return "all six";
  static const char* const names[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
  std::string text;
  for (const auto direction : interface.directions) {
    text += (text.empty() ? "" : " ") + std::string(names[static_cast<int>(direction)]);
  }
  for (const auto direction : interface.following)
    text += (text.empty() ? "(" : " (") + std::string(names[static_cast<int>(direction)]) + " follows)";
  return text;
}

nlohmann::json list(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

// By source; null where it is not known.
nlohmann::json error_json(const Superelement& se, const superelement::ModeAnalysis& modes) {
  if (static_cast<int>(modes.modes.size()) == modes.n_rigid + modes.n_mechanisms) return nullptr;
  const auto known = [](double error) { return error >= 0.0 ? nlohmann::json(error) : nlohmann::json(); };
  const auto error = superelement::frequency_error(se, modes.modes.back().frequency_hz);
  return {{"mesh", known(error.mesh)}, {"left_out", known(error.left_out)}};
}

nlohmann::json to_json(const Superelement& se, const superelement::ModeAnalysis& modes) {
  nlohmann::json interfaces = nlohmann::json::array();
  for (const auto& interface : se.interfaces) {
    interfaces.push_back({{"name", interface.name},
                          {"tie", interface.tie},
                          {"position_m", list(interface.p_BoN_B)},
                          {"dofs", interface.directions.size()}});
  }
  std::vector<double> frequencies;
  for (int k = 0; k < se.n_q; ++k) frequencies.push_back(std::sqrt(se.omega2[k]) / (2.0 * std::numbers::pi));
  const auto& J = modes.inertia;
  return {{"kind", "superelement"},
          {"name", se.name},
          {"created_by", se.created_by},
          {"n_b", se.n_b},
          {"n_q", se.n_q},
          {"mass_kg", modes.mass},
          {"mass_centre_m", list(modes.mass_centre)},
          {"inertia_kg_m2",
           {{"xx", J(0, 0)},
            {"yy", J(1, 1)},
            {"zz", J(2, 2)},
            {"xy", J(0, 1)},
            {"yz", J(1, 2)},
            {"zx", J(2, 0)}}},
          {"first_free_frequency_error", error_json(se, modes)},
          {"rigid_modes", modes.n_rigid},
          {"mechanisms", modes.n_mechanisms},
          {"fixed_interface_frequencies_hz", frequencies},
          {"modal_damping", se.modal_damping},
          {"stiffening", se.stiffening.has_value()},
          {"stress_modes", se.stress.has_value()},
          {"section_forces", se.sections ? se.sections->member.size() : 0},
          {"load_cases", se.load_cases.size()},
          {"inertia_integrals", superelement::has_inertia_integrals(se)},
          {"vertices", se.surface.vertices.rows()},
          {"triangles", se.surface.triangles.rows()},
          {"interfaces", interfaces},
          {"valid", true}};
}

// What the reduction says of its errors: as flexura modes tells it.
void add_errors(const Superelement& se, const superelement::ModeAnalysis& modes, terminal::Table& facts) {
  const auto words = [](double error) {
    return superelement::percent_words(error) + (error >= 0.0 ? " %" : "");
  };
  if (static_cast<int>(modes.modes.size()) > modes.n_rigid + modes.n_mechanisms) {
    const auto error = superelement::frequency_error(se, modes.modes.back().frequency_hz);
    facts.add_row({"its error by the mesh", words(error.mesh)});
    facts.add_row({"by modes left out", words(error.left_out)});
  }
  if (!se.mesh_error) return;
  for (const auto& interface : se.mesh_error->interfaces)
    facts.add_row(
        {"compliance at " + interface.name, "error by the mesh: " + words(interface.compliance_error)});
}

int check_superelement(const std::string& file, bool json, const terminal::Verbosity& verbosity) {
  // Everything is read, so every checksum and every relation is checked.
  const Superelement se = superelement::read(file, {.matrices = true,
                                                    .inertia = true,
                                                    .stiffening = true,
                                                    .surface = true,
                                                    .shapes = true,
                                                    .stress = true,
                                                    .sections = true,
                                                    .mesh_error = true});
  const auto modes = superelement::natural_modes(se, {}, 1);
  if (json) fmt::print("{}\n", to_json(se, modes).dump(1));
  if (verbosity.quiet || json) return 0;
  const bool colour = terminal::takes_colour(stdout);
  const double size = reach(se);
  fmt::print("{}: superelement, made by {}\n\n", terminal::bold(se.name, colour), se.created_by);
  terminal::Table interfaces({{"interface", Align::left},
                              {"tie", Align::left},
                              {"position [m]", Align::left},
                              {"directions", Align::left}});
  for (const auto& interface : se.interfaces) {
    interfaces.add_row(
        {interface.name, interface.tie, vector_text(interface.p_BoN_B, size), directions_text(interface)});
  }
  fmt::print("{}\n", interfaces.text(terminal::width(stdout), colour));

  terminal::Table facts({{"quantity", Align::left}, {"value", Align::left}});
  const auto& J = modes.inertia;
  facts.add_row({"dofs", fmt::format("{} interface + {} modes", se.n_b, se.n_q)});
  facts.add_row({"mass", number(modes.mass, 8) + " kg"});
  facts.add_row({"mass centre", vector_text(modes.mass_centre, size) + " m"});
  facts.add_row({"inertia xx, yy, zz", vector_text(J.diagonal(), J.norm()) + " kg m^2"});
  facts.add_row({"inertia xy, yz, zx", vector_text({J(0, 1), J(1, 2), J(2, 0)}, J.norm()) + " kg m^2"});
  facts.add_row({"rigid modes", fmt::format("{}", modes.n_rigid)});
  if (modes.n_mechanisms > 0)
    facts.add_row(
        {"mechanisms", fmt::format("{}: motions within the body that nothing resists", modes.n_mechanisms)});
  if (static_cast<int>(modes.modes.size()) > modes.n_rigid + modes.n_mechanisms) {
    facts.add_row({"first free frequency", number(modes.modes.back().frequency_hz, 6) + " Hz"});
  }
  add_errors(se, modes, facts);
  if (!superelement::has_inertia_integrals(se))
    facts.add_row({"inertia integrals", "none: centrifugal and Coriolis forces do not deform it"});
  if (se.n_q > 0) {
    facts.add_row({"fixed-interface modes",
                   fmt::format("{} to {} Hz", number(std::sqrt(se.omega2.minCoeff()) / 6.283185307179586, 6),
                               number(std::sqrt(se.omega2.maxCoeff()) / 6.283185307179586, 6))});
  }
  facts.add_row({"damping", fmt::format("{:.3g} % modal{}", 100.0 * se.modal_damping,
                                        se.D_se.size() > 0 ? " and D_se" : "")});
  facts.add_row({"geometric stiffening", se.stiffening ? "yes" : "no"});
  facts.add_row(
      {"stress modes", se.stress ? fmt::format("at {} vertices", se.stress->vertices.size()) : "no"});
  if (se.sections)
    facts.add_row({"section forces", fmt::format("of {} members at {} places", se.sections->members.size(),
                                                 se.sections->member.size())});
  facts.add_row({"load cases", fmt::format("{}", se.load_cases.size())});
  facts.add_row({"surface", fmt::format("{} vertices, {} triangles", se.surface.vertices.rows(),
                                        se.surface.triangles.rows())});
  fmt::print("{}\nAll checksums and relations hold.\n", facts.text(terminal::width(stdout), colour));
  return 0;
}

}  // namespace

terminal::Command check_command() {
  return {"check", "validate a superelement or a mechanism and say what it holds",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            struct Arguments : MechanismArguments {
              bool json = false;
            };
            auto a = std::make_shared<Arguments>();
            options.argument("FILE", a->file, "superelement file (.h5) or mechanism file (.toml)");
            declare_choices(options, *a);
            options.flag("--json", a->json, "print JSON")
                .example("flexura check conrod.se.h5",
                         "checksums, symmetry, rigid motions, mass; interfaces and figures")
                .example("flexura check engine.toml --run flexible --set body.rod.fidelity=auto",
                         "one run, with a key of the file replaced")
                .example("flexura check engine.toml --json",
                         "counts, joints and states of each run, for scripts");
            return [a, &verbosity] {
              if (a->file.ends_with(".toml")) return check_mechanism(*a, a->json, verbosity);
              if (!a->set.empty() || !a->runs.empty() || !a->state.empty() || !a->from_state.empty() ||
                  !a->cache.empty())
                throw std::invalid_argument(
                    fmt::format("{}: --set, --run, --state, --from-state and --cache are for mechanism files "
                                "(.toml); leave them out",
                                a->file));
              return check_superelement(a->file, a->json, verbosity);
            };
          }};
}

}  // namespace flexura::app
