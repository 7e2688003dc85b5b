// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/app/buckling.hpp"
#include "mbs/app/commands.hpp"
#include "mbs/app/mode_pictures.hpp"
#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/linear/asked_damping.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/linear/mode_noise.hpp"
#include "mbs/solver/linear/whirl.hpp"
#include "mbs/study/estimate/full_model.hpp"

/// eigen: natural modes of a mechanism, as a table and as pictures.
namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using terminal::Align;
using terminal::number;

struct Arguments : MechanismArguments {
  bool equilibrium = false, buckling = false, frozen = false, fixed_axes = false, json = false;
  int count = 30;
  std::string pictures;
  double amplitude = std::nan("");
};

void check(const Arguments& a) {
  if (a.count < 1) throw std::invalid_argument(fmt::format("--count is {}, it must be at least 1", a.count));
  if (a.buckling && !a.pictures.empty())
    throw std::invalid_argument("--pictures shows natural modes: it does not go with --buckling");
  if (a.buckling && a.frozen)
    throw std::invalid_argument("--buckling is about the static equilibrium: --frozen does not go with it");
  if (a.fixed_axes && (a.buckling || a.equilibrium || a.frozen))
    throw std::invalid_argument(
        "--fixed-axes is about a steady motion: it does not go with --equilibrium, --buckling or --frozen");
  if (a.frozen && a.equilibrium)
    throw std::invalid_argument("--frozen takes the state as it stands: it does not go with --equilibrium");
  if (!std::isnan(a.amplitude) && a.pictures.empty())
    throw std::invalid_argument("--amplitude is that of the pictures: give --pictures, or leave it out");
  if (a.amplitude <= 0.0 || a.amplitude > 1e40)
    throw std::invalid_argument(
        fmt::format("--amplitude is {:g}, it must be above 0 and at most 1e40", a.amplitude));
}

nlohmann::json json_of(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json();
}

// A vibration whose real part is less than what round-off may make of it, where that is no small ratio: not known, rather than none.
bool loses_damping(const mbs::NaturalMode& mode) {
  constexpr double kSmallRatio = 1e-3;  // as lost_in_round_off() tells it
  return mode.eigenvalue.imag() != 0.0 && mode.eigenvalue.real() == 0.0 &&
         mode.noise > kSmallRatio * std::abs(mode.eigenvalue);
}

// With the shapes, complex, in the coordinates that are named once.
nlohmann::json to_json(const NamedRun& run, const std::vector<mbs::NaturalMode>& modes,
                       const mbs::AskedDamping& asked, int count) {
  using nlohmann::json;
  const mbs::Mechanism& m = *run.prepared.mechanism;
  json out = run_json(run);
  json &coordinates = out["coordinates"] = json::array(), &list = out["modes"] = json::array();
  for (int i = 0; i < m.sizes().n_v; ++i) coordinates.push_back(m.name_of_velocity(i));
  for (const mbs::NaturalMode& mode : modes) {
    if (static_cast<int>(list.size()) == count) break;
    const Eigen::VectorXd real = mode.shape.real(), imag = mode.shape.imag();
    list.push_back({{"number", list.size() + 1},
                    {"real_1_s", loses_damping(mode) ? json() : json(mode.eigenvalue.real())},
                    {"imag_1_s", mode.eigenvalue.imag()},
                    {"frequency_hz", mode.frequency_hz},
                    {"damping", loses_damping(mode) ? json() : json(mode.damping)},
                    {"asked_damping", json_of(asked.of(mode))},
                    {"moves_most", moves_most(m, mode.shape.cwiseAbs())},
                    {"shape",
                     {{"real", std::vector(real.begin(), real.end())},
                      {"imag", std::vector(imag.begin(), imag.end())}}}});
  }
  return out;
}

// "+19.8", "-12.1, +3.9", "5.2 along the axis".
std::string text_of(const std::vector<mbs::Whirl>& whirls) {
  std::string out;
  for (const mbs::Whirl& one : whirls) {
    if (!out.empty()) out += ", ";
    const bool is_along = one.kind == mbs::Whirl::Kind::along;
    out += is_along ? number(one.hz, 6) + " along" : (one.hz > 0.0 ? "+" : "") + number(one.hz, 6);
  }
  return out.empty() ? "unknown" : out;
}

nlohmann::json to_json(const std::vector<mbs::Whirl>& whirls) {
  nlohmann::json out = nlohmann::json::array();
  for (const mbs::Whirl& one : whirls)
    out.push_back({{"hz", one.hz},
                   {"kind", one.kind == mbs::Whirl::Kind::along ? "along" : "circular"},
                   {"share", one.share}});
  return out;
}

// With a note.
mbs::Stability judge_stability(PreparedMechanism& p, const mbs::SteadyLinearisation& about) {
  using Verdict = mbs::SteadyLinearisation::Verdict;
  const mbs::Mechanism& m = *p.mechanism;
  mbs::Stability out;
  if (about.verdict == Verdict::unsteady) return out;
  if (about.verdict == Verdict::equilibrium) {
    out = mbs::stability_at_rest(m, p.state);
  } else {
    double rate = 0.0;
    for (int i = 0; i < m.sizes().n_v; ++i)
      rate = std::max(rate, std::abs(p.state.v(i)) / m.velocity_scale(i));
    out = mbs::stability_of(m, about.system, rate);
  }
  std::string said =
      mbs::sentence(m, out, about.verdict == Verdict::equilibrium ? "the equilibrium" : "the steady motion");
  if (!said.empty()) p.notes.push_back(std::move(said));
  return out;
}

// A mechanism at rest beside an equilibrium, as one that is drawn without the sag of its springs, is meant to stand in
// it.  Where anything is driven or moves, or falls far, only its user knows.
std::optional<mbs::Stability> move_to_equilibrium_near(PreparedMechanism& p) {
  constexpr double kNear = 0.35;  // rad or typical sizes: 20 degrees
  const mbs::Mechanism& m = *p.mechanism;
  if (!p.state.v.isZero(0.0) || lasts(p) || !m.functions_of_time().empty()) return {};
  const mbs::State before = p.state;
  const Eigen::VectorXd v_dot = p.v_dot;
  const std::vector<std::string> notes = p.notes;
  try {
    const mbs::Stability stability = move_to_equilibrium(p);
    double way = 0.0;
    for (int i = 0; i < m.sizes().n_p; ++i)
      way = std::max(way, std::abs(p.state.p(i) - before.p(i)) / m.position_scale(i));
    if (way < kNear) {
      p.notes.insert(
          p.notes.begin() + static_cast<long>(notes.size()),
          "the initial state is no equilibrium: these are the modes about the one beside it, as with "
          "--equilibrium (--frozen takes the initial state)");
      return stability;
    }
  } catch (const std::runtime_error&) {  // none found: the initial state is refused for what it is
  }
  p.state = before;
  p.v_dot = v_dot;
  p.notes = notes;
  return {};
}

// A body that turns is stiffened by what holds it; terms for it that its superelement has and its fidelity leaves out are told of where
// it turns by a hundredth of the lowest mode: 1e-4 of that mode.
void note_unused_stiffening(PreparedMechanism& p, const std::vector<mbs::NaturalMode>& modes) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const mbs::NaturalMode& mode : modes)
    if (const double rate = std::abs(mode.eigenvalue); rate > 0.0) lowest = std::min(lowest, rate);
  std::vector<mbs::MarkerState> motions(p.mechanism->description().bodies.size());
  p.mechanism->body_motions(p.state, p.v_dot, *p.mechanism->make_scratch(), motions);
  for (std::size_t b = 0; b < motions.size(); ++b) {
    const mbs::BodyDescription& body = p.mechanism->description().bodies[b];
    if (!body.flexible || !body.flexible->acts_back() || body.flexible->has_geometric_stiffness() ||
        !body.is_reduced() || !(motions[b].V.angular.norm() > 0.01 * lowest) ||
        !study::has_stiffening_terms(body))
      continue;
    p.notes.push_back(
        fmt::format("body \"{}\" turns at {} rad/s, and the geometric stiffening that its superelement has "
                    "is not used: give it "
                    "fidelity = \"modal-stiffened\"",
                    body.name, number(motions[b].V.angular.norm(), 4)));
  }
}

int print_modes(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  files::Claims claims;
  claims.add(arguments.pictures);
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (!arguments.pictures.empty()) only_run(runs, arguments, "--pictures");
  nlohmann::json list = nlohmann::json::array();
  for (NamedRun& run : runs) {
    PreparedMechanism& p = run.prepared;
    std::optional<mbs::Stability> at_equilibrium;
    if (arguments.equilibrium)
      at_equilibrium = move_to_equilibrium(p);
    else if (!arguments.frozen && !arguments.fixed_axes && arguments.from_state.empty())
      at_equilibrium = move_to_equilibrium_near(p);
    give_warnings(run);
    const mbs::SteadyLinearisation about = linearise_about(p, {}, arguments.frozen);
    const auto modes = mbs::natural_modes(about.system);
    const mbs::Stability stability = at_equilibrium ? *at_equilibrium : judge_stability(p, about);
    if (modes.empty())
      p.notes.push_back("nothing of the mechanism moves or deforms: it has no natural modes");
    if (std::string lost = mbs::lost_in_round_off(modes); !lost.empty()) p.notes.push_back(std::move(lost));
    note_unused_stiffening(p, modes);
    note_discretisation(p);
    const mbs::AskedDamping asked(*p.mechanism, p.state);
    std::vector<terminal::Column> columns = {
        {"no"}, {"real [1/s]"}, {"imag [1/s]"}, {"f [Hz]"}, {"damping %"}};
    if (asked.any()) columns.push_back({"asked %"});
    columns.push_back({"moves most", Align::left});
    std::vector<std::vector<mbs::Whirl>> whirls;
    if (arguments.fixed_axes) {
      const mbs::FixedAxes axes(*p.mechanism, p.state, about);
      for (const mbs::NaturalMode& mode : modes) whirls.push_back(axes.of(mode));
      columns.push_back({"fixed axes [Hz]", Align::left});
    }
    terminal::Table table(columns);
    int index = 0;
    // Decompositions leave some 1e-13 of the largest eigenvalue in every other: no damping of that size is said.
    double round_off = 0.0;
    for (const mbs::NaturalMode& mode : modes)
      round_off = std::max(round_off, 1e-12 * std::abs(mode.eigenvalue));
    for (const mbs::NaturalMode& mode : modes) {
      if (++index > arguments.count) break;
      const bool is_undamped = std::abs(mode.eigenvalue.real()) < round_off, is_lost = loses_damping(mode);
      std::vector<std::string> row = {
          fmt::format("{}", index), is_lost ? "?" : number(is_undamped ? 0.0 : mode.eigenvalue.real(), 6),
          number(mode.eigenvalue.imag(), 6), number(mode.frequency_hz, 6),
          is_lost ? "?"
                  : number(is_undamped && mode.eigenvalue.imag() != 0.0 ? 0.0 : 100.0 * mode.damping, 4)};
      if (asked.any()) {
        const std::optional<double> ratio = asked.of(mode);
        row.push_back(ratio ? number(100.0 * *ratio, 4) : "");
      }
      row.push_back(moves_most(*p.mechanism, mode.shape.cwiseAbs()));
      if (arguments.fixed_axes) row.push_back(text_of(whirls[static_cast<std::size_t>(index - 1)]));
      table.add_row(std::move(row));
    }
    const bool talks = !verbosity.quiet && !arguments.json;
    if (arguments.json) {
      list.push_back(to_json(run, modes, asked, arguments.count));
      list.back()["about"] = about_what(p, about.verdict);
      list.back()["axes"] = about.axes;
      list.back()["stability"] = mbs::name_of(stability.verdict);
      for (std::size_t k = 0; k < list.back()["modes"].size() && arguments.fixed_axes; ++k)
        list.back()["modes"][k]["fixed_axes"] = to_json(whirls[k]);
    }
    if (talks) {
      fmt::print("{}\n\n", heading(run));
      if (!modes.empty())
        fmt::print("{}\n", table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
      for (const std::string& note : p.notes) terminal::say(stdout, "note: " + note);
    }
    if (arguments.pictures.empty()) continue;
    write_mode_pictures(arguments.pictures, run, arguments.file, modes, arguments.count, arguments.amplitude);
    if (talks)
      fmt::print("pictures {}: flexura view {} shows the modes moving\n", arguments.pictures,
                 arguments.pictures);
  }
  if (arguments.json) print_json("natural modes", runs, list);
  return 0;
}

}  // namespace

terminal::Command eigen_command() {
  return {
      "eigen", "natural frequencies and damping of a mechanism",
      [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
        auto a = std::make_shared<Arguments>();
        declare_mechanism(options, *a);
        options
            .flag("--equilibrium", a->equilibrium,
                  "about the static equilibrium, also where the initial state moves or stands far from it")
            .flag("--buckling", a->buckling,
                  "instead: factors of weight and given forces at which the equilibrium loses its stiffness")
            .flag("--frozen", a->frozen, kFrozenHelp)
            .flag("--fixed-axes", a->fixed_axes,
                  "of a rotor, also the whirl speeds in axes that stand still: positive with the rotation")
            .option("-n,--count", a->count, "N", "print at most so many, the slowest (30)")
            .option("--pictures", a->pictures, "FILE",
                    "results file with the modes as runs, for flexura view")
            .flag("--json", a->json, "print JSON, with the mode shapes (SI units)")
            .option("--amplitude", a->amplitude, "SIZE",
                    "largest motion in the pictures, rad or m (otherwise a "
                    "tenth of the mechanism's size)")
            .example("flexura eigen engine.toml --equilibrium", "eigenvalues, frequencies, damping")
            .example("flexura eigen engine.toml --json", "the same and the shapes, for scripts");
        return [a, &verbosity] {
          check(*a);
          return a->buckling ? print_buckling(*a, a->count, a->json, verbosity) : print_modes(*a, verbosity);
        };
      }};
}

}  // namespace flexura::app
