// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/app/commands.hpp"
#include "mbs/app/recorder.hpp"
#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/buckling.hpp"
#include "mbs/solver/linearise.hpp"
#include "mbs/solver/statics.hpp"
#include "mbs/terminal/terminal.hpp"

/// eigen: natural modes of a mechanism, as a table and as pictures.
namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using terminal::Align;
using terminal::number;

struct Arguments : MechanismArguments {
  bool equilibrium = false, buckling = false;
  int count = 30;
  std::string pictures;
  double amplitude = 0.1;
};

// One run for each mode: the mechanism in 24 phases of it.
void write_pictures(const NamedRun& run, const std::vector<mbs::NaturalMode>& modes,
                    const Arguments& arguments) {
  constexpr int kPhases = 24;
  const PreparedMechanism& p = run.prepared;
  const mbs::Mechanism& m = *p.mechanism;
  results::Writer writer(arguments.pictures,
                         model_header(std::span(&run, 1), arguments.file, arguments.pictures));
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m.sizes().n_v);
  for (std::size_t k = 0; k < modes.size() && static_cast<int>(k) < arguments.count; ++k) {
    const mbs::NaturalMode& mode = modes[k];
    Eigen::Index largest = 0;
    if (mode.shape.size() > 0) mode.shape.cwiseAbs().maxCoeff(&largest);
    const double size = arguments.amplitude * m.velocity_scale(static_cast<int>(largest));
    Recorder recorder(p, writer, {"energy.potential"}, false);
    recorder.begin(fmt::format("mode {}, {} Hz", k + 1, number(mode.frequency_hz, 4)));
    for (int i = 0; i <= kPhases; ++i) {
      const double phase = static_cast<double>(i) / kPhases;
      mbs::State s = p.state;
      s.t = mode.frequency_hz > 0.0 ? phase / mode.frequency_hz : phase;
      const Eigen::VectorXd d = size * (mode.shape * std::polar(1.0, 2.0 * M_PI * phase)).real();
      m.retract(p.state.p, d, s.p);
      s.v = rest;
      recorder.append(s, rest, EnergyRow{});
    }
    writer.end_run(true, "", "{}");
  }
  writer.close();
}

/// The mechanism without weight and given forces; springs, bushings and friction stay.
mbs::LinearSystem without_loads(const PreparedMechanism& p) {
  mbs::MechanismDescription d = p.mechanism->description();
  d.gravity.setZero();
  std::erase_if(d.forces, [](const auto& force) {
    return force->type() == "force" || force->type() == "torque" || force->type() == "joint_force";
  });
  mbs::Mechanism unloaded(std::move(d));
  mbs::State s = unloaded.initial_state();
  s.t = p.state.t;
  s.p = p.state.p;
  s.v.setZero();
  unloaded.drop_redundant(s.t, s.p);
  s.lambda = Eigen::VectorXd::Zero(unloaded.sizes().n_lambda);
  mbs::solve_statics(unloaded, s);
  Eigen::VectorXd v_dot;
  mbs::AccelerationSolver(unloaded).solve(s, v_dot);
  return mbs::linearise(unloaded, s);
}

int print_buckling(const Arguments& arguments, const terminal::Talk& talk) {
  std::vector<NamedRun> runs = prepare_runs(arguments);
  for (NamedRun& run : runs) {
    PreparedMechanism& p = run.prepared;
    const mbs::LinearSystem unloaded = without_loads(p);
    settle(p);
    const auto modes = mbs::buckling_modes(unloaded, mbs::linearise(*p.mechanism, p.state));
    if (talk.quiet) continue;
    fmt::print("{}\n\n", heading(run));
    terminal::Table table({{"no"}, {"load factor"}, {"moves most", Align::left}});
    int index = 0;
    for (const mbs::BucklingMode& mode : modes) {
      if (++index > arguments.count) break;
      Eigen::Index largest = 0;
      mode.shape.cwiseAbs().maxCoeff(&largest);
      table.add_row({fmt::format("{}", index), number(mode.factor, 6),
                     p.mechanism->name_of_velocity(static_cast<int>(largest))});
    }
    fmt::print("{}\n", table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
    for (const auto& body : p.mechanism->description().bodies)
      if (body.flexible && !body.flexible->data().second)
        p.notes.push_back(
            fmt::format("body \"{}\" has no geometric stiffening; with fidelity = \"modal-stiffened\" "
                        "its own buckling is seen",
                        body.name));
    for (const std::string& note : p.notes) fmt::print("note: {}\n", note);
  }
  return 0;
}

int print_modes(const Arguments& arguments, const terminal::Talk& talk) {
  terminal::require_folder_of(arguments.pictures);
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (!arguments.pictures.empty()) only_run(runs, arguments, "--pictures");
  for (NamedRun& run : runs) {
    PreparedMechanism& p = run.prepared;
    if (arguments.equilibrium) settle(p);
    const auto modes = mbs::natural_modes(mbs::linearise(*p.mechanism, p.state));
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
    if (!talk.quiet) {
      fmt::print("{}\n\n{}\n", heading(run),
                 table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
      for (const std::string& note : p.notes) fmt::print("note: {}\n", note);
    }
    if (arguments.pictures.empty()) continue;
    write_pictures(run, modes, arguments);
    if (!talk.quiet)
      fmt::print("pictures {}: flexura view {} shows the modes moving\n", arguments.pictures,
                 arguments.pictures);
  }
  return 0;
}

}  // namespace

terminal::Command eigen_command() {
  return {
      "eigen", "natural frequencies and damping of a mechanism",
      [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
        auto a = std::make_shared<Arguments>();
        declare_mechanism(options, *a);
        options.flag("--equilibrium", a->equilibrium, "about the static equilibrium, not the initial state")
            .flag("--buckling", a->buckling,
                  "instead: factors of weight and given forces at which the equilibrium loses its stiffness")
            .option("--count", a->count, "N", "print at most so many (30)")
            .option("--pictures", a->pictures, "FILE",
                    "results file with the modes as runs, for flexura view")
            .option("--amplitude", a->amplitude, "SIZE", "largest motion in the pictures, rad or m (0.1)")
            .example("flexura eigen engine.toml --equilibrium", "eigenvalues, frequencies, damping");
        return [a, &talk] { return a->buckling ? print_buckling(*a, talk) : print_modes(*a, talk); };
      }};
}

}  // namespace flexura::app
