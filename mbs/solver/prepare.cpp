// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/prepare.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/close_loops.hpp"
#include "mbs/solver/dead_point.hpp"
#include "mbs/solver/mechanism_scales.hpp"
#include "mbs/solver/not_assembled.hpp"
#include "mbs/solver/row_watch.hpp"
#include "mbs/solver/saddle.hpp"
#include "mbs/solver/settle.hpp"

namespace flexura::mbs {

namespace {

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

constexpr const char* kRings =
    "but for its deformation the mechanism is a structure, and its bodies start undeformed: it rings about the "
    "shape that it rests in, and forces at the start are those of letting go, not of rest (solver.initial_deformation "
    "= \"quasi_static\" starts at rest, flexura statics finds it)";

// The constraints leave nothing to bodies that do not deform, and nothing drives or moves them; loads do.
bool rings(const PreparedMechanism& p, const std::vector<bool>& deforms) {
  const Sizes n = p.mechanism->sizes();
  if (n.n_lambda == 0 || std::ranges::find(deforms, true) == deforms.end() || p.options.settled_start ||
      !p.state.v.isZero(1e-12) || p.v_dot.isZero(1e-9) ||
      std::ranges::any_of(p.file.description.joints, [](const JointDescription& j) { return j.is_driven(); }))
    return false;
  std::vector<bool> rigid = deforms;
  rigid.flip();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n.n_v, n.n_v), G = Eigen::MatrixXd::Zero(n.n_lambda, n.n_v);
  const auto scratch = p.mechanism->make_scratch();
  p.mechanism->mass_matrix(p.state.p, *scratch, M);
  p.mechanism->constraint_matrix(p.state.t, p.state.p, *scratch, G);
  SaddleSolver saddle;
  saddle.factor(*p.mechanism, M, G, rigid);
  return saddle.rank() == std::ranges::count(rigid, true);
}

std::vector<bool> either(std::vector<bool> a, const std::vector<bool>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] || b[i];
  return a;
}

// Strain energy far above what the loads ask for: the start is then mostly the misfit.  Ten times their
// deformation.
constexpr double kOutOfScale = 100.0;

void tell_strain(const StrainedLoops& strained, const std::vector<bool>& deforms, PreparedMechanism& out) {
  std::string sentence = sentence_of(strained, *out.mechanism, out.state);
  if (strained.are_parts_as_made) {
    out.notes.push_back(std::move(sentence));
    return;
  }
  const double asked = energy_of_loads(*out.mechanism, strained, deforms, out.state);
  if (!(strained.energy > kOutOfScale * asked)) {
    out.notes.push_back(std::move(sentence));
    return;
  }
  double largest = 0.0;
  int which = 0;
  for (Eigen::Index i = 0; i < out.state.lambda.size(); ++i)
    if (std::abs(out.state.lambda(i)) > largest) {
      largest = std::abs(out.state.lambda(i));
      which = static_cast<int>(i);
    }
  const std::string loads = asked > 1e-9 * strained.energy ? fmt::format("{:.3g} J", asked) : "none of it";
  out.notes.push_back(fmt::format(
      "{}{}; the loads at the start ask for {}. The run begins with the forces of this misfit, {:.4g} {} "
      "in \"{}\": mend the markers, lengths or initial positions unless it is meant",
      warning_mark, sentence, loads, largest, force_unit_of(*out.mechanism, which),
      out.mechanism->name_of_constraint(which)));
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
    const std::vector<bool> deforms = deformations_of(*out.mechanism, out.file, out.state);
    const std::optional<StrainedLoops> strained =
        close_loops(*out.mechanism, out.file, out.state, keep, out.assembly);
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
    if (state_file.empty() && rings(out, deforms)) out.assembly.notes.push_back(kRings);
    if (std::string note = require_one_branch(*out.mechanism, out.state, out.v_dot); !note.empty())
      out.assembly.notes.push_back(std::move(note));
    if (strained) tell_strain(*strained, deforms, out);
    if (out.options.settled_start && state_file.empty()) settle(*out.mechanism, out.state, out.v_dot, keep);
    // The second assembly finds the loops closed; what it took is in the first report.
    out.assembly.iterations += positions.iterations;
    out.assembly.position_change += positions.position_change;
    out.assembly.positions_kept = positions.positions_kept;
    out.assembly.notes.insert(out.assembly.notes.begin(), positions.notes.begin(), positions.notes.end());
  } catch (const OpenLoops& e) {
    std::vector<Opening> openings = openings_of(*out.mechanism, e.g);
    out.state.p = e.p;
    const std::string what = fmt::format("{}: {}", path.string(), e.what());
    throw NotAssembled(what, std::make_shared<const PreparedMechanism>(std::move(out)), std::move(openings));
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
