// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <filesystem>

#include "mbs/app/commands.hpp"
#include "mbs/app/mechanism_runs.hpp"
#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/linearise.hpp"
#include "mbs/solver/statics.hpp"
#include "mbs/terminal/terminal.hpp"

/// eigen, linearize and statics: what a mechanism does near a state.
namespace flexura::app {
namespace {

using mbs::LinearSystem;
using mbs::PreparedMechanism;
using terminal::Align;
using terminal::number;

struct Arguments : MechanismArguments {
  bool equilibrium = false;
  int count = 30;
  std::string output;
  std::vector<std::string> inputs, outputs;
};

void settle(PreparedMechanism& p) {
  const mbs::StaticsReport report = mbs::solve_statics(*p.mechanism, p.state);
  mbs::AccelerationSolver(*p.mechanism).solve(p.state, p.v_dot);
  p.notes.push_back(fmt::format("equilibrium in {} steps, largest force left {} N", report.iterations,
                                number(report.force_residual, 2)));
}

std::string heading(const NamedRun& run) {
  return terminal::bold(
      fmt::format("{}, run {}, t = {} s", run.prepared.file.name, run.name, number(run.prepared.state.t, 6)),
      terminal::takes_colour(stdout));
}

int print_statics(const Arguments& arguments, const terminal::Talk&) {
  std::vector<NamedRun> runs = prepare_runs(arguments);
  for (NamedRun& run : runs) {
    PreparedMechanism& p = run.prepared;
    settle(p);
    const mbs::Mechanism& m = *p.mechanism;
    fmt::print("{}\n\n", heading(run));
    const auto which = mbs::select_quantities(m, p.file.outputs);
    const auto infos = m.quantities();
    Eigen::VectorXd values(static_cast<Eigen::Index>(which.size()));
    auto scratch = m.make_scratch();
    m.evaluate(which, p.state, p.v_dot, *scratch, values);
    terminal::Table table({{"quantity", Align::left}, {"value"}, {"unit", Align::left}});
    for (std::size_t i = 0; i < which.size(); ++i)
      table.add_row({infos[which[i]].name, number(values(static_cast<Eigen::Index>(i)), 9),
                     input::si_unit(infos[which[i]].dimension)});
    fmt::print("{}\n", table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
    for (const std::string& note : p.notes) fmt::print("note: {}\n", note);
  }
  return 0;
}

int print_modes(const Arguments& arguments, const terminal::Talk&) {
  std::vector<NamedRun> runs = prepare_runs(arguments);
  for (NamedRun& run : runs) {
    PreparedMechanism& p = run.prepared;
    if (arguments.equilibrium) settle(p);
    const auto modes = mbs::natural_modes(mbs::linearise(*p.mechanism, p.state));
    fmt::print("{}\n\n", heading(run));
    terminal::Table table(
        {{"no"}, {"real [1/s]"}, {"imag [1/s]"}, {"f [Hz]"}, {"damping %"}, {"moves most", Align::left}});
    int index = 0;
    for (const mbs::NaturalMode& mode : modes) {
      if (++index > arguments.count) break;
      Eigen::Index largest = 0;
      mode.shape.cwiseAbs().maxCoeff(&largest);
      table.add_row({fmt::format("{}", index), number(mode.eigenvalue.real(), 6),
                     number(mode.eigenvalue.imag(), 6), number(mode.frequency_hz, 6),
                     number(100.0 * mode.damping, 4),
                     p.mechanism->name_of_velocity(static_cast<int>(largest))});
    }
    fmt::print("{}\n", table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
    for (const std::string& note : p.notes) fmt::print("note: {}\n", note);
  }
  return 0;
}

std::string octave_matrix(const Eigen::MatrixXd& A) {
  if (A.size() == 0) return fmt::format("zeros({}, {});\n", A.rows(), A.cols());
  std::string text(1, '[');
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    for (Eigen::Index j = 0; j < A.cols(); ++j) text += fmt::format("{}{:.17g}", j == 0 ? "" : ", ", A(i, j));
    text += i + 1 < A.rows() ? ";\n  " : "];\n";
  }
  return text;
}

std::string octave_names(const std::vector<std::string>& names) {
  std::string text = "{";
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::string quoted;
    for (const char c : names[i]) quoted += c == '\'' ? std::string("''") : std::string(1, c);
    text += fmt::format("{}'{}'", i == 0 ? "" : ", ", quoted);
  }
  return text + "};\n";
}

int write_linear_system(const Arguments& arguments, const terminal::Talk& talk) {
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (runs.size() != 1)
    throw std::invalid_argument(
        fmt::format("{} has {} runs; choose one with --run", arguments.file, runs.size()));
  PreparedMechanism& p = runs.front().prepared;
  if (arguments.equilibrium) settle(p);
  const mbs::Mechanism& m = *p.mechanism;
  mbs::LineariseOptions options;
  std::vector<std::string> coordinates;
  for (int i = 0; i < m.sizes().n_v; ++i) coordinates.push_back(m.name_of_velocity(i));
  for (const std::string& wanted : arguments.inputs) {
    const auto found = std::ranges::find(coordinates, wanted);
    if (found == coordinates.end())
      throw std::invalid_argument(fmt::format("there is no coordinate \"{}\" to put a force on{}", wanted,
                                              input::suggestion(wanted, coordinates)));
    options.inputs.push_back(static_cast<int>(found - coordinates.begin()));
  }
  const auto which =
      arguments.outputs.empty() ? std::vector<int>{} : mbs::select_quantities(m, arguments.outputs);
  auto scratch = m.make_scratch();
  if (!which.empty()) {
    const auto infos = m.quantities();
    for (const int i : which) options.output_names.push_back(infos[i].name);
    options.outputs = [&](const mbs::State& s, const Eigen::VectorXd& v_dot) {
      Eigen::VectorXd y(static_cast<Eigen::Index>(which.size()));
      m.evaluate(which, s, v_dot, *scratch, y);
      return y;
    };
  }
  const LinearSystem system = mbs::linearise(m, p.state, options);
  std::string path = arguments.output;
  if (path.empty()) path = std::filesystem::path(arguments.file).stem().string() + "_linear.m";
  const std::string beside = path + ".part";
  {
    auto out = fmt::output_file(beside);
    out.print("% {}: x' = A x + B u, y = C x + D u about x_0, u_0, y_0 at t = {:.9g} s; SI units\n",
              p.file.name, p.state.t);
    out.print("states = {}", octave_names(system.states));
    out.print("inputs = {}", octave_names(system.inputs));
    out.print("outputs = {}", octave_names(system.outputs));
    out.print("A = {}B = {}C = {}D = {}", octave_matrix(system.A), octave_matrix(system.B),
              octave_matrix(system.C), octave_matrix(system.D));
    out.print("x_0 = {}u_0 = {}y_0 = {}", octave_matrix(system.x_0), octave_matrix(system.u_0),
              octave_matrix(system.y_0));
  }
  std::filesystem::rename(beside, path);
  if (!talk.quiet)
    fmt::print("{} states, {} inputs, {} outputs: {}\n", system.A.rows(), system.B.cols(), system.C.rows(),
               path);
  return 0;
}

}  // namespace

terminal::Command eigen_command() {
  return {"eigen", "natural frequencies and damping of a mechanism",
          [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
            auto a = std::make_shared<Arguments>();
            declare_mechanism(options, *a);
            options
                .flag("--equilibrium", a->equilibrium, "about the static equilibrium, not the initial state")
                .option("--count", a->count, "N", "print at most so many (30)")
                .example("flexura eigen engine.toml --equilibrium", "eigenvalues, frequencies, damping");
            return [a, &talk] { return print_modes(*a, talk); };
          }};
}

terminal::Command linearize_command() {
  return {
      "linearize", "write the linear state-space system about a state",
      [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
        auto a = std::make_shared<Arguments>();
        declare_mechanism(options, *a);
        options.flag("--equilibrium", a->equilibrium, "about the static equilibrium, not the initial state")
            .option("-o,--output", a->output, "FILE",
                    "Octave or MATLAB script (default: the file's name_linear.m)")
            .option("--input", a->inputs, "COORDINATE", "force or torque on these coordinates is an input u")
            .option("--measure", a->outputs, "QUANTITY",
                    "these quantities are outputs y; * and ? are wildcards")
            .example("flexura linearize engine.toml --input shaft.angle --measure guide.position -o engine.m",
                     "A, B, C, D with the names of all states");
        return [a, &talk] { return write_linear_system(*a, talk); };
      }};
}

terminal::Command statics_command() {
  return {"statics", "find the static equilibrium of a mechanism",
          [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
            auto a = std::make_shared<Arguments>();
            declare_mechanism(options, *a);
            options.example("flexura statics suspension.toml", "the state at rest and the forces in it");
            return [a, &talk] { return print_statics(*a, talk); };
          }};
}

}  // namespace flexura::app
