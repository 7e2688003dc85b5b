// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/prepare.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/dead_point.hpp"
#include "mbs/solver/kinematic_blocks.hpp"
#include "mbs/solver/mechanism_scales.hpp"
#include "mbs/solver/row_watch.hpp"
#include "mbs/solver/settle.hpp"

namespace flexura::mbs {

namespace {

// The velocity coordinates whose block of positions is wholly marked.
std::vector<bool> velocities_of(const Mechanism& mechanism, const State& s, const std::vector<bool>& marked) {
  std::vector<bool> mask(mechanism.sizes().n_v, false);
  const KinematicBlocks kinematics(mechanism, s.p);
  for (const KinematicBlocks::Block& block : kinematics.blocks()) {
    bool all = true;
    for (const int i : block.p) all = all && marked[i];
    for (const int j : block.v) mask[j] = all;
  }
  return mask;
}

// The velocity coordinates by which bodies deform: modal ones and those between the segments of beams.
std::vector<bool> deformations_of(const Mechanism& mechanism, const std::vector<int>& segment_joints,
                                  const State& s) {
  std::vector<bool> deforms(mechanism.sizes().n_p, false);
  const std::vector<BodyDescription>& bodies = mechanism.description().bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const int first = mechanism.modal_position(static_cast<int>(b));
    if (first < 0) continue;
    for (int k = 0; k < bodies[b].flexible->m(); ++k) deforms[first + k] = true;
  }
  for (const int j : segment_joints) {
    const JointPlace& place = mechanism.joint_places()[j];
    if (!place.in_tree()) continue;
    for (int k = 0; k < place.joint->n_p(); ++k) deforms[place.i_p + k] = true;
  }
  return velocities_of(mechanism, s, deforms);
}

// Vibration that nothing excites bounds the steps of a multistep method, not those of Radau IIA: on the
// scenes of cases/trade the latter is 1.2 to 700 times faster with all modes, as fast without any.  One-way
// bodies likewise: the undamped slider-crank at 100 rad/s takes it 1.1 times real time with 6 modes, 48 with
// 34 (explicit Runge-Kutta 3.3 and 61, IDA 1.6 and more than 600).  ANCF beams, too: their sections are stiff
// against all but bending; the first 0.02 s of a steel cantilever of 1 m x 10 mm x 10 mm under its weight
// take it 1.1 s (IDA 37 s, generalised-alpha 60 s).
bool has_deformation(const Mechanism& mechanism) {
  return std::ranges::any_of(mechanism.description().bodies,
                             [](const BodyDescription& body) { return body.ked || body.flexible; });
}

constexpr const char* kLocked =
    "the constraints leave no degree of freedom and nothing drives it: the mechanism is a structure and stands "
    "still (a loop whose axes are out of line by a little is one)";

bool is_locked(const PreparedMechanism& p) {
  const Sizes n = p.mechanism->sizes();
  return n.n_v > 0 && n.n_lambda > 0 && p.assembly.constraint_rank == n.n_v && p.state.v.isZero(1e-12) &&
         p.v_dot.isZero(1e-9) &&
         std::ranges::none_of(p.file.description.joints, [](const JointDescription& j) { return j.is_driven(); });
}

std::vector<bool> either(std::vector<bool> a, const std::vector<bool>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] || b[i];
  return a;
}

// Loops are closed by moving bodies, not by bending them: first with all deformations held; what is left
// open then (parts that do not fit, redundant joints) closes with the smallest deformation from there.
AssembleReport close_loops(const Mechanism& mechanism, State& s, const AssembleOptions& keep,
                           const std::vector<bool>& deforms) {
  AssembleReport stiff;
  AssembleOptions undeformed = keep;
  undeformed.keep_position = either(keep.keep_position, deforms);
  try {
    stiff = assemble_positions(mechanism, s, undeformed);
  } catch (const AssemblyError&) {
    // The next attempt may deform the bodies from the start, and words the refusal if it fails too.
  }
  AssembleReport report = assemble_positions(mechanism, s, keep);
  report.iterations += stiff.iterations;
  report.position_change += stiff.position_change;
  return report;
}

}  // namespace

PreparedMechanism prepare(const std::filesystem::path& path, const std::vector<std::string>& overrides,
                          const std::filesystem::path& state_file, std::shared_ptr<PreparationCache> cache) {
  if (!cache) cache = std::make_shared<PreparationCache>();
  MechanismFile file = read_mechanism(path, solver_schema(), overrides, cache.get());
  PreparedMechanism out{std::move(file), {}, {}, {}, {}, {}, {}, 0.0, {}, {}, true, std::move(cache)};
  if (out.file.description.bodies.size() < 2 && out.file.description.controls.empty())
    throw input::InputError(fmt::format(
        "{}: has no body and no control: there is nothing that could move; give at least one [body.NAME]",
        path.string()));
  out.options = read_solver_options(out.file.solver);
  out.given_start_time = out.options.start_time;
  out.notes = out.file.notes;
  out.mechanism = std::make_unique<Mechanism>(out.file.description);
  if (!out.file.solver.has("method") && !out.file.solver.has("max_order") && has_deformation(*out.mechanism))
    out.options.method = "radau";
  out.options.method_is_open = !out.file.solver.has("method") && !out.file.solver.has("max_order");
  out.state = out.mechanism->initial_state();
  out.state.t = out.options.start_time;
  std::vector<bool> given_positions = out.mechanism->given_positions();
  std::vector<bool> given_velocities = out.mechanism->given_velocities();
  if (!state_file.empty()) {
    const StateChange change = read_state(state_file, *out.mechanism, out.state);
    given_positions = either(given_positions, change.position);
    given_velocities = either(given_velocities, change.velocity);
    if (!change.continuation) out.options.start_time = out.state.t;
  }
  AssembleOptions keep;
  keep.keep_position = velocities_of(*out.mechanism, out.state, given_positions);
  keep.keep_velocity = given_velocities;
  try {
    const std::vector<bool> deforms = deformations_of(*out.mechanism, out.file.segment_joints, out.state);
    out.assembly = close_loops(*out.mechanism, out.state, keep, deforms);
    if (out.mechanism->sizes().n_alg > 0 && state_file.empty())
      out.mechanism->start_contacts(out.state, *out.mechanism->make_scratch());
    out.redundant = out.mechanism->drop_redundant(out.state.t, out.state.p);
    out.state.lambda = Eigen::VectorXd::Zero(out.mechanism->sizes().n_lambda);
    const AssembleReport positions = std::move(out.assembly);
    // Bodies start without vibration where the loops allow it.
    AssembleOptions quiet = keep;
    quiet.keep_velocity = either(keep.keep_velocity, deforms);
    const State assembled = out.state;
    out.assembly = assemble(*out.mechanism, out.state, out.v_dot, quiet);
    if (!out.assembly.velocities_kept) {
      out.state = assembled;
      out.assembly = assemble(*out.mechanism, out.state, out.v_dot, keep);
    }
    if (out.mechanism->sizes().n_root > 0) {
      const auto scratch = out.mechanism->make_scratch();
      out.mechanism->start_switches(out.state, *scratch);
      AccelerationSolver(*out.mechanism).solve(out.state, out.v_dot);
    }
    RowWatch(*out.mechanism).begin(out.state, out.v_dot);
    if (is_locked(out)) out.assembly.notes.push_back(kLocked);
    if (std::string note = require_one_branch(*out.mechanism, out.state, out.v_dot); !note.empty())
      out.assembly.notes.push_back(std::move(note));
    if (out.options.settled_start && state_file.empty()) settle(*out.mechanism, out.state, out.v_dot, keep);
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
  // Of the file's own positions: a run that goes on from a state has the scales of the one that was cut.
  out.options.scales =
      std::make_shared<Scales>(scales_of(*out.mechanism, out.mechanism->initial_state()));
  if (!state_file.empty()) {
    // Now that the redundant rows are gone the multipliers have their places.
    State whole = out.state;
    StateChange change = read_state(state_file, *out.mechanism, whole);
    out.continuation_fits = change.continuation_fits;
    out.continuation = std::move(change.continuation);
  }
  return out;
}

}  // namespace flexura::mbs
