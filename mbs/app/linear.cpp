// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/app/state_space.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/files/table_text.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/linear/descriptor.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/text_file.hpp"

/// linearize and statics: what a mechanism does near a state.
namespace flexura::app {
namespace {

using mbs::LinearSystem;
using mbs::PreparedMechanism;
using terminal::Align;
using terminal::number;

struct Arguments : MechanismArguments {
  bool equilibrium = false, descriptor = false, frozen = false, json = false;
  std::string output, save_state, response;
  std::vector<std::string> inputs, outputs;
};

std::string counted(std::size_t n, const std::string& what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

// Round-off of the iteration: nothing beside the largest of the same unit.
double without_round_off(double value, double largest) {
  return std::abs(value) < 1e-14 * largest ? 0.0 : value;
}

int print_statics(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  files::Claims claims;
  claims.add(arguments.save_state);
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (!arguments.save_state.empty()) only_run(runs, arguments, "--save-state");
  nlohmann::json list = nlohmann::json::array();
  for (NamedRun& run : runs) {
    PreparedMechanism& p = run.prepared;
    const mbs::Stability stability = move_to_equilibrium(p);
    give_warnings(run);
    note_discretisation(p);
    const mbs::Mechanism& m = *p.mechanism;
    const auto which = mbs::select_quantities(m, p.file.outputs);
    if (!arguments.save_state.empty()) mbs::write_state(arguments.save_state, m, p.file.name, p.state);
    if (verbosity.quiet && !arguments.json) continue;
    const auto infos = m.quantities();
    Eigen::VectorXd values(static_cast<Eigen::Index>(which.size()));
    auto scratch = m.make_scratch();
    m.evaluate(which, p.state, p.v_dot, *scratch, values);
    // Angles and their like have a natural size of one, whatever the largest of them is here.
    std::map<std::string, double> largest = {{"rad", 1.0}, {"-", 1.0}};
    for (std::size_t i = 0; i < which.size(); ++i) {
      double& most = largest[mbs::unit_of(infos[which[i]])];
      most = std::max(most, std::abs(values(static_cast<Eigen::Index>(i))));
    }
    terminal::Table table({{"quantity", Align::left}, {"value"}, {"unit", Align::left}});
    nlohmann::json quantities = nlohmann::json::array();
    for (std::size_t i = 0; i < which.size(); ++i) {
      const auto& info = infos[which[i]];
      const double value = values(static_cast<Eigen::Index>(i));
      table.add_row(
          {info.name, number(without_round_off(value, largest[mbs::unit_of(info)]), 9), mbs::unit_of(info)});
      quantities.push_back({{"name", info.name}, {"value", value}, {"unit", mbs::unit_of(info)}});
    }
    if (arguments.json) {
      list.push_back(run_json(run));
      list.back()["quantities"] = std::move(quantities);
      list.back()["stability"] = mbs::name_of(stability.verdict);
      continue;
    }
    fmt::print("{}\n\n{}\n", heading(run),
               table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
    for (const std::string& note : p.notes) terminal::say(stdout, "note: " + note);
  }
  if (arguments.json) print_json("equilibrium", runs, list);
  return 0;
}

// "0.1:100:50": frequencies [Hz] evenly over the decades.
Eigen::VectorXd frequencies_of(const std::string& text) {
  double low = 0.0, high = 0.0;
  int count = 0, used = 0;
  if (std::sscanf(text.c_str(), "%lf:%lf:%d%n", &low, &high, &count, &used) != 3 ||
      used != static_cast<int>(text.size()) || !(low >= 1e-40) || !(high > low) || !(high <= 1e40) ||
      count < 2 || count > 1000000)
    throw std::invalid_argument(
        fmt::format("--response is \"{}\", it must be FROM:TO:COUNT with 1e-40 <= FROM < TO <= 1e40 in Hz "
                    "and COUNT from 2 "
                    "to 1000000",
                    text));
  Eigen::VectorXd f(count);
  for (int i = 0; i < count; ++i) f(i) = low * std::pow(high / low, static_cast<double>(i) / (count - 1));
  return f;
}

std::filesystem::path write_response(const LinearSystem& system, const Eigen::VectorXd& f,
                                     const std::filesystem::path& path) {
  const auto H = mbs::frequency_response(system, f);
  std::string text = "frequency [Hz]";
  const auto out = std::back_inserter(text);
  for (const std::string& y : system.outputs)
    for (const std::string& u : system.inputs)
      text += "," + files::csv_field(fmt::format("|{} / {}|", y, u)) + "," +
              files::csv_field(fmt::format("phase of {} / {} [deg]", y, u));
  text += '\n';
  for (Eigen::Index k = 0; k < f.size(); ++k) {
    fmt::format_to(out, "{:.12g}", f(k));
    for (Eigen::Index i = 0; i < H[k].rows(); ++i)
      for (Eigen::Index j = 0; j < H[k].cols(); ++j)
        fmt::format_to(out, ",{:.12g},{:.9g}", std::abs(H[k](i, j)), std::arg(H[k](i, j)) * 180.0 / M_PI);
    text += '\n';
  }
  superelement::write_whole(path, text);
  return path;
}

// What B and D alone do not say of inputs that positions and speeds follow.
void note_rates_of_inputs(const LinearSystem& d, StateSpace& file, std::vector<std::string>& notes) {
  for (const auto& [name, matrix] :
       {std::pair("D_1", &d.D_1), {"D_2", &d.D_2}, {"T_0", &d.T_0}, {"T_1", &d.T_1}})
    if (matrix->size() > 0) file.matrices.emplace_back(name, *matrix);
  if (d.T_0.size() > 0)
    notes.push_back(
        "positions or speeds follow inputs: the states are counted from what the inputs make of them, x = "
        "(the quantities named) - T_0 u" +
        std::string(d.T_1.size() > 0 ? " - T_1 u'" : "") + ", and B is that of these x");
  if (d.D_1.size() == 0) return;
  std::vector<std::string> of;
  for (Eigen::Index i = 0; i < d.D_1.rows(); ++i)
    if (!d.D_1.row(i).isZero(0.0) || (d.D_2.size() > 0 && !d.D_2.row(i).isZero(0.0)))
      of.push_back("\"" + d.outputs[static_cast<std::size_t>(i)] + "\"");
  notes.push_back(fmt::format(
      "{} {} rates of inputs: y = C x + D u + D_1 u'{}; with a control of type filter between "
      "input and drive D alone is enough",
      fmt::join(of, ", "), of.size() == 1 ? "follows" : "follow", d.D_2.size() > 0 ? " + D_2 u''" : ""));
}

// Coordinates of joints that close loops, each under its own name and that of its speed.
struct Closure {
  std::string name, speed;
  mbs::CoordinateRef coordinate;
};
std::vector<Closure> closures_of(const mbs::Mechanism& m) {
  std::vector<Closure> all;
  for (std::size_t j = 0; j < m.joint_places().size(); ++j) {
    const mbs::JointPlace& place = m.joint_places()[j];
    if (place.in_tree()) continue;
    const std::string joint = m.description().joints[j].name + ".";
    const auto coordinates = place.joint->coordinates(), speeds = place.joint->speeds();
    for (int i = 0; i < place.joint->n_v(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const std::string speed = joint + speeds[k].name;
      all.push_back({speed, speed, {static_cast<int>(j), i}});
      if (place.joint->n_p() == place.joint->n_v())
        all.push_back({joint + coordinates[k].name, speed, {static_cast<int>(j), i}});
    }
  }
  return all;
}

int write_linear_system(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  std::filesystem::path path = arguments.output, table;
  if (path.empty()) path = std::filesystem::path(arguments.file).stem().string() + "_linear.m";
  files::Claims claims;
  for (const auto& file : state_space_files(path, arguments.descriptor)) claims.add(file);
  if (!arguments.response.empty()) {
    table = path;
    claims.add(table.replace_filename(path.stem().string() + "_response.csv"));
  }
  std::vector<NamedRun> runs = prepare_runs(arguments);
  NamedRun& run = only_run(runs, arguments, "linearize");
  PreparedMechanism& p = run.prepared;
  if (arguments.equilibrium) move_to_equilibrium(p);
  give_warnings(run);
  const mbs::Mechanism& m = *p.mechanism;
  mbs::LineariseOptions options;
  std::vector<std::string> coordinates;
  for (int i = 0; i < m.sizes().n_v; ++i) coordinates.push_back(m.name_of_velocity(i));
  // What is a coordinate's own has its name, too: a force along "shaft.angle" is one on "shaft.speed".
  std::vector<std::string> positions(coordinates.size());
  for (const mbs::JointPlace& place : m.joint_places())
    for (int i = 0; place.in_tree() && place.joint->n_p() == place.joint->n_v() && i < place.joint->n_v();
         ++i)
      positions[place.i_v + i] = m.name_of_position(place.i_p + i);
  const std::vector<Closure> closures = closures_of(m);
  auto scratch = m.make_scratch();
  std::vector<std::string> own;
  for (int i = 0; i < m.n_inputs(); ++i) own.push_back(m.name_of_input(i));
  for (const std::string& wanted : arguments.inputs.empty() ? own : arguments.inputs) {
    auto found = std::ranges::find(coordinates, wanted);
    if (const auto by_position = std::ranges::find(positions, wanted); by_position != positions.end())
      found = coordinates.begin() + (by_position - positions.begin());
    if (const auto signal = std::ranges::find(own, wanted); signal != own.end()) {
      options.signals.push_back(static_cast<int>(signal - own.begin()));
      continue;
    }
    if (const auto closing = std::ranges::find(closures, wanted, &Closure::name); closing != closures.end()) {
      options.along.push_back({closing->speed, m.force_along(closing->coordinate, p.state, *scratch)});
      continue;
    }
    if (found == coordinates.end()) {
      for (const Closure& one : closures) positions.push_back(one.name);
      coordinates.insert(coordinates.end(), own.begin(), own.end());
      coordinates.insert(coordinates.end(), positions.begin(), positions.end());
      throw std::invalid_argument(
          fmt::format("there is no input \"{}\" and no coordinate to put a force on{}", wanted,
                      input::suggestion(wanted, coordinates)));
    }
    options.inputs.push_back(static_cast<int>(found - coordinates.begin()));
  }
  const std::vector<std::string>& y = arguments.outputs.empty() ? p.file.y : arguments.outputs;
  const auto which = y.empty() ? std::vector<int>{} : mbs::select_quantities(m, y);
  if (!y.empty() && which.empty())
    throw std::invalid_argument(
        fmt::format("\"{}\" is a quantity of a run and has no linearisation; choose what belongs to a state, "
                    "as energy.total and power.input do",
                    y.front()));
  if (!which.empty()) {
    const auto infos = m.quantities();
    for (const int i : which) options.output_names.push_back(infos[i].name);
    options.outputs = [&](const mbs::State& s, const Eigen::VectorXd& v_dot) {
      Eigen::VectorXd values(static_cast<Eigen::Index>(which.size()));
      m.evaluate(which, s, v_dot, *scratch, values);
      return values;
    };
  }
  StateSpace file;
  file.time = p.state.t;
  std::vector<std::filesystem::path> written;
  const mbs::SteadyLinearisation about = linearise_about(p, options, arguments.frozen);
  if (arguments.descriptor) {
    if (!about.axes.empty() && !arguments.frozen)
      throw std::invalid_argument(fmt::format(
          "--descriptor writes the mechanism's own coordinates, whose coefficients change along this motion; "
          "they are constant in {}: leave --descriptor out, or take --frozen for this instant",
          about.axes));
    if (!about.axes.empty())
      p.notes.back() =
          fmt::format("frozen at t = {} s, in the mechanism's own coordinates", number(p.state.t, 6));
    const mbs::DescriptorSystem d = mbs::linearise_as_descriptor(m, p.state, options);
    file.title = fmt::format("{}: E x' = A x + B u, y = C x + D u about x_0, u_0, y_0 at t = {:.9g} s",
                             p.file.name, p.state.t);
    file.names = {{"states", d.states}, {"inputs", d.inputs}, {"outputs", d.outputs}};
    file.matrices = {{"E", d.E}, {"A", d.A},     {"B", d.B},     {"C", d.C},
                     {"D", d.D}, {"x_0", d.x_0}, {"u_0", d.u_0}, {"y_0", d.y_0}};
    if (!arguments.response.empty())
      throw std::invalid_argument(
          "--response is that of the system in independent coordinates: leave --descriptor out");
  } else {
    const LinearSystem& d = about.system;
    file.title = fmt::format("{}: x' = A x + B u, y = C x + D u about x_0, u_0, y_0 at t = {:.9g} s{}",
                             p.file.name, p.state.t, about.axes.empty() ? "" : ", in " + about.axes);
    file.names = {{"states", d.states}, {"inputs", d.inputs}, {"outputs", d.outputs}};
    file.matrices = {{"A", d.A},     {"B", d.B},     {"C", d.C},    {"D", d.D},
                     {"x_0", d.x_0}, {"u_0", d.u_0}, {"y_0", d.y_0}};
    note_rates_of_inputs(d, file, p.notes);
    if (!arguments.response.empty()) {
      if (d.inputs.empty() || d.outputs.empty())
        throw std::invalid_argument("--response needs an --input and a --measure");
      written.push_back(
          write_response(d, mbs::with_resonances(d, frequencies_of(arguments.response)), table));
    }
  }
  note_discretisation(p);
  const auto files = write_state_space(file, path);
  written.insert(written.end(), files.begin(), files.end());
  if (arguments.json) {
    nlohmann::json out = run_json(run);
    for (const auto& [what, names] : file.names) out[what] = names;
    for (const auto& one : written) out["files"].push_back(one.string());
    out["about"] = about_what(p, about.verdict);
    out["axes"] = about.axes;
    print_json("linear system", runs, nlohmann::json::array({out}));
  } else if (!verbosity.quiet) {
    for (const auto& one : written)
      fmt::print("{}, {}, {}: {}\n", counted(file.names[0].second.size(), "state"),
                 counted(file.names[1].second.size(), "input"),
                 counted(file.names[2].second.size(), "output"), one.string());
    for (const std::string& note : p.notes) terminal::say(stdout, "note: " + note);
  }
  return 0;
}

}  // namespace

terminal::Command linearize_command() {
  return {
      "linearize", "write the linear state-space system about a state",
      [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
        auto a = std::make_shared<Arguments>();
        declare_mechanism(options, *a);
        options.flag("--equilibrium", a->equilibrium, "about the static equilibrium, not the initial state")
            .flag("--frozen", a->frozen, kFrozenHelp)
            .option(
                "-o,--output", a->output, "FILE",
                ".m (Octave, MATLAB), .h5 (HDF5) or .mtx (Matrix Market); default: the file's name_linear.m")
            .flag("--descriptor", a->descriptor,
                  "E, A, B, C, D with constraints and multipliers, nothing eliminated")
            .option("--response", a->response, "FROM:TO:COUNT",
                    "also write the frequency response of outputs to inputs over these frequencies [Hz], "
                    "with points "
                    "more at the resonances between them")
            .option("--input", a->inputs, "COORDINATE",
                    "an input u: one of the file's, or force or torque on a coordinate; default: the file's")
            .option("--measure", a->outputs, "QUANTITY",
                    "these quantities are outputs y; * and ? are wildcards; default: the file's [output] y")
            .flag("--json", a->json, "print the names of states, inputs and outputs and the files as JSON")
            .example("flexura linearize engine.toml --input shaft.angle --measure guide.position -o engine.m",
                     "A, B, C, D with the names of all states");
        return [a, &verbosity] { return write_linear_system(*a, verbosity); };
      }};
}

terminal::Command statics_command() {
  return {"statics", "find the static equilibrium of a mechanism",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto a = std::make_shared<Arguments>();
            declare_mechanism(options, *a);
            options
                .option("--save-state", a->save_state, "FILE",
                        "write the equilibrium there, to start runs from it")
                .flag("--json", a->json, "print JSON (SI units)")
                .example("flexura statics suspension.toml", "the state at rest and the forces in it");
            return [a, &verbosity] { return print_statics(*a, verbosity); };
          }};
}

}  // namespace flexura::app
