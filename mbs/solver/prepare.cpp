// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/prepare.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mbs/solver/kinematic_blocks.hpp"

namespace flexura::mbs {

namespace {

// A velocity coordinate is held in the position assembly when all positions of its block were given.
std::vector<bool> held_coordinates(const Mechanism& mechanism, const State& s) {
  std::vector<bool> keep(mechanism.sizes().n_v, false);
  const std::vector<bool>& given = mechanism.given_positions();
  const KinematicBlocks kinematics(mechanism, s.p);
  for (const KinematicBlocks::Block& block : kinematics.blocks()) {
    bool all = true;
    for (const int i : block.p) all = all && given[i];
    for (const int j : block.v) keep[j] = all;
  }
  return keep;
}

}  // namespace

PreparedMechanism prepare(const std::filesystem::path& path, const std::vector<std::string>& overrides) {
  MechanismFile file = read_mechanism(path, solver_schema(), overrides);
  PreparedMechanism out{std::move(file), {}, {}, {}, {}, {}, {}, {}};
  out.options = read_solver_options(out.file.solver);
  out.notes = out.file.notes;
  out.mechanism = std::make_unique<Mechanism>(out.file.description);
  out.state = out.mechanism->initial_state();
  out.state.t = out.options.start_time;
  AssembleOptions keep;
  keep.keep_position = held_coordinates(*out.mechanism, out.state);
  keep.keep_velocity = out.mechanism->given_velocities();
  try {
    out.assembly = assemble_positions(*out.mechanism, out.state, keep);
    out.redundant = out.mechanism->drop_redundant(out.state.t, out.state.p);
    out.state.lambda = Eigen::VectorXd::Zero(out.mechanism->sizes().n_lambda);
    const AssembleReport positions = std::move(out.assembly);
    out.assembly = assemble(*out.mechanism, out.state, out.v_dot, keep);
    // The second assembly finds the loops closed; what it took is in the first report.
    out.assembly.iterations += positions.iterations;
    out.assembly.position_change += positions.position_change;
    out.assembly.positions_kept = positions.positions_kept;
    out.assembly.notes.insert(out.assembly.notes.begin(), positions.notes.begin(), positions.notes.end());
  } catch (const AssemblyError& e) {
    throw input::InputError(fmt::format("{}: {}", path.string(), e.what()));
  }
  if (!out.redundant.empty()) {
    std::vector<std::string> names;
    for (const RedundantRow& row : out.redundant) names.push_back("\"" + row.name + "\"");
    out.notes.push_back(
        fmt::format("{} redundant constraint{} left out: {}; reactions that they share are not unique "
                    "(flexura check says which)",
                    names.size(), names.size() == 1 ? "" : "s", fmt::join(names, ", ")));
  }
  for (const std::string& note : out.assembly.notes) out.notes.push_back(note);
  return out;
}

}  // namespace flexura::mbs
