// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/start.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "mbs/solver/accuracy/mechanism_scales.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/position/dead_point.hpp"
#include "mbs/solver/position/quasi_static_start.hpp"
#include "mbs/solver/position/row_watch.hpp"
#include "mbs/solver/start/following_start.hpp"
#include "mbs/solver/start/warning_mark.hpp"
#include "mbs/solver/statics/close_loops.hpp"

namespace flexura::mbs {
namespace {

constexpr const char* kLocked =
    "the constraints leave no degree of freedom and nothing drives it: the mechanism is a structure and "
    "stands "
    "still (a loop whose axes are out of line by a little is one)";

bool is_locked(const StartedMechanism& p) {
  const Sizes n = p.mechanism->sizes();
  return n.n_v > 0 && n.n_lambda > 0 && p.assembly.constraint_rank == n.n_v && p.state.v.isZero(1e-12) &&
         p.v_dot.isZero(1e-9) &&
         std::ranges::none_of(p.mechanism->description().joints,
                              [](const JointDescription& j) { return j.is_driven(); });
}

constexpr const char* kRings =
    "but for its deformation the mechanism is a structure, and its bodies start undeformed: it rings about "
    "the "
    "shape that it rests in, and forces at the start are those of letting go, not of rest "
    "(solver.initial_deformation "
    "= \"quasi_static\" starts at rest, flexura statics finds it)";

// The constraints leave nothing to bodies that do not deform, and nothing drives or moves them; loads do.  What rows hold
// by less than parts are made to is not held: hinges of a drawing, parallel to nine digits.
bool rings(const StartedMechanism& p, const std::vector<bool>& deforms) {
  const Sizes n = p.mechanism->sizes();
  if (n.n_lambda == 0 || std::ranges::find(deforms, true) == deforms.end() || p.options.quasi_static_start ||
      !p.state.v.isZero(1e-12) || p.v_dot.isZero(1e-9) ||
      std::ranges::any_of(p.mechanism->description().joints,
                          [](const JointDescription& j) { return j.is_driven(); }))
    return false;
  std::vector<bool> rigid = deforms;
  rigid.flip();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n.n_v, n.n_v), G = Eigen::MatrixXd::Zero(n.n_lambda, n.n_v);
  const auto scratch = p.mechanism->make_scratch();
  p.mechanism->mass_matrix(p.state.p, *scratch, M);
  p.mechanism->constraint_matrix(p.state, p.state.p, *scratch, G);
  // Rows in their own size, deformations included: what is left of one that bodies at rest do not feel is round-off.
  const Eigen::VectorXd unit = M.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd rows = (G * unit.asDiagonal()).rowwise().normalized();
  const auto n_rigid = std::ranges::count(rigid, true);
  if (n_rigid == 0) return true;  // bodies clamped all round
  Eigen::MatrixXd of_rigid(n.n_lambda, n_rigid);
  for (Eigen::Index i = 0, k = 0; i < n.n_v; ++i)
    if (rigid[i]) of_rigid.col(k++) = rows.col(i);
  constexpr double kHeld = 1e-6;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> held(of_rigid);
  return held.setThreshold(kHeld).rank() == n_rigid;
}

std::vector<bool> either(std::vector<bool> a, const std::vector<bool>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] || b[i];
  return a;
}

// Strain energy far above what the loads ask for: the start is then mostly the misfit.  Ten times their
// deformation.
constexpr double kOutOfScale = 100.0;

void tell_strain(const StrainedLoops& strained, const std::vector<bool>& deforms, StartedMechanism& out) {
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

// Bearings and meshes are of shafts whose markers' z axes are parallel but for small tilts: one across was given another axis, one
// opposite was turned round.  Said here, where both stand as the file has them; they may turn later.
void require_parallel_axes(const Mechanism& m, const State& s) {
  const MechanismDescription& d = m.description();
  std::vector<Pose> poses;
  for (const auto& force : d.forces) {
    const std::string_view type = force->type();
    if (type != "bearing" && type != "rolling_bearing" && type != "journal_bearing" &&
        type != "involute_mesh")
      continue;
    if (poses.empty()) m.body_poses(s, *m.make_scratch(), poses);
    const auto axis = [&](int marker) {
      const MarkerDescription& of = d.markers[static_cast<std::size_t>(marker)];
      return Vector3d(poses[static_cast<std::size_t>(of.body)].R * of.X_BP.R.col(2));
    };
    const auto [F, M] = force->markers();
    const double cosine = axis(F).dot(axis(M));
    if (cosine < 0.5)  // 60 deg: far beyond any tilt
      throw AssemblyError(
          fmt::format("force \"{}\": the z axes of its markers stand {:.4g} deg apart at the start, and they "
                      "are those about which the "
                      "shafts turn, side by side; turn one of the markers (axis)",
                      force->name(), std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / std::numbers::pi));
  }
}

// Forces along a line whose ends coincide: without a direction they do nothing, whatever they say.
void tell_points(StartedMechanism& out) {
  const Mechanism& m = *out.mechanism;
  std::vector<std::string> names;
  for (const auto& force : m.description().forces)
    if (force->type() == "line_force" || force->type() == "spring_damper") names.push_back(force->name());
  if (names.empty()) return;
  const std::vector<OutputInfo> all = m.quantities();
  const auto place = [&](const std::string& name) {
    return static_cast<int>(std::ranges::find(all, name, &OutputInfo::name) - all.begin());
  };
  std::vector<int> which;
  for (const std::string& name : names)
    which.insert(which.end(), {place(name + ".length"), place(name + ".force")});
  Eigen::VectorXd values(static_cast<Eigen::Index>(which.size()));
  const auto scratch = m.make_scratch();
  m.evaluate(which, out.state, out.v_dot, *scratch, values);
  constexpr double kNoLength = 1e-12;  // [m] what round-off leaves of places that coincide
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(2 * k);
    if (values(i) < kNoLength && values(i + 1) != 0.0)
      out.notes.push_back(
          fmt::format("{}force \"{}\" is {:.4g} N at the start, where its ends coincide: the line between "
                      "them has no direction, and "
                      "nothing acts; move one of its markers",
                      warning_mark, names[k], values(i + 1)));
  }
}

// What formulas read and what they move would depend on which of the redundant rows are left out.
void require_unique_loads(const StartedMechanism& out) {
  const Mechanism& m = *out.mechanism;
  if (!m.algebraic_is_coupled()) return;
  std::set<std::string> read;
  for (int i = 0; i < m.sizes().n_alg; ++i) read.insert(m.name_of_algebraic(i));
  const std::vector<bool> open = m.not_unique(out.state, out.state.p);
  const std::vector<OutputInfo> infos = m.quantities();
  for (std::size_t q = 0; q < infos.size(); ++q)
    if (open[q] && read.contains(infos[q].name))
      throw AssemblyError(fmt::format(
          "formulas read \"{}\", which redundant constraints leave open: the motion would depend on "
          "which of them is left out; let one of them give way (a bushing), or take what is too much "
          "out (flexura check on a file without these formulas names it)",
          infos[q].name));
}

}  // namespace

// Vibration that nothing excites bounds the steps of a multistep method, not those of Radau IIA: on the
// scenes of cases/trade the latter is 1.2 to 700 times faster with all modes, as fast without any.  One-way
// bodies likewise: the undamped slider-crank at 100 rad/s takes it 1.1 times real time with 6 modes, 48 with
// 34 (explicit Runge-Kutta 3.3 and 61, IDA 1.6 and more than 600).  ANCF beams, too: their sections are stiff
// against all but bending; the first 0.02 s of a steel cantilever of 1 m x 10 mm x 10 mm under its weight
// take it 1.1 s (IDA 37 s, generalised-alpha 60 s).
bool has_deformation(const Mechanism& mechanism) {
  return std::ranges::any_of(mechanism.description().bodies,
                             [](const BodyDescription& body) { return body.flexible != nullptr; });
}

void assemble_start(StartedMechanism& out, const GivenState& given) {
  // A dense matrix of as many rows takes 0.8 GB.
  constexpr int kMostSpeeds = 10'000;
  if (const int n = out.mechanism->sizes().n_v; n > kMostSpeeds)
    throw std::invalid_argument(
        fmt::format("the mechanism has {} speeds, {} are taken, since their matrices are dense; fix bodies "
                    "to one another by "
                    "joints, or keep fewer modes",
                    n, kMostSpeeds));
  AssembleOptions keep;
  keep.keep_position = velocities_of(*out.mechanism, out.state, given.positions);
  keep.keep_velocity = given.velocities;
  const std::vector<bool> deforms = deformations_of(*out.mechanism, out.state);
  const std::optional<StrainedLoops> strained = close_loops(*out.mechanism, out.state, keep, out.assembly);
  require_parallel_axes(*out.mechanism, out.state);
  if (out.mechanism->sizes().n_alg > 0 && !given.whole)
    out.mechanism->start_contacts(out.state, *out.mechanism->make_scratch());
  out.redundant = out.mechanism->drop_redundant(out.state, out.state.p);
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
  // At a dead point speeds of no branch give accelerations that the kept rows do not meet, and those left out neither:
  // nothing contradicts there.
  std::string crossing = require_one_branch(*out.mechanism, out.state, out.v_dot);
  const bool at_dead_point = out.mechanism->n_left_out() > 0 && loses_rank(*out.mechanism, out.state);
  RowWatch(*out.mechanism).begin(out.state, out.v_dot, at_dead_point);
  if (is_locked(out)) out.assembly.notes.push_back(kLocked);
  if (!given.whole && rings(out, deforms)) out.assembly.notes.push_back(kRings);
  if (!crossing.empty()) out.assembly.notes.push_back(std::move(crossing));
  if (strained) tell_strain(*strained, deforms, out);
  if (out.options.quasi_static_start && !given.whole) {
    start_quasi_static(*out.mechanism, out.state, out.v_dot, keep);
    start_following(*out.mechanism, out.state, out.v_dot);
    // What a beam in segments deforms by are coordinates of joints, which start where the file or its loops say.
    if (std::ranges::any_of(out.mechanism->description().joints,
                            [](const JointDescription& j) { return j.bends; }))
      out.assembly.notes.push_back(
          "beams in segments start undeformed: initial_deformation = \"quasi_static\" sets bodies that "
          "deform, and "
          "these are rigid ones on springs; take fidelity = \"beam\" or \"ancf\", or begin with "
          "--equilibrium");
  }
  tell_points(out);
  // The second assembly finds the loops closed; what it took is in the first report.
  out.assembly.iterations += positions.iterations;
  out.assembly.position_change += positions.position_change;
  out.assembly.positions_kept = positions.positions_kept;
  out.assembly.notes.insert(out.assembly.notes.begin(), positions.notes.begin(), positions.notes.end());
  // Of the description's own positions: a run that goes on from a state has the scales of the one that was cut.
  out.options.scales = std::make_shared<Scales>(scales_of(*out.mechanism, out.mechanism->initial_state()));
  if (!out.redundant.empty()) {
    require_unique_loads(out);
    std::vector<std::string> names;
    for (const RedundantRow& row : out.redundant) names.push_back("\"" + row.name + "\"");
    out.notes.push_back(
        fmt::format("{} redundant constraint{} left out: {}; reactions that they share are not unique "
                    "(flexura check says which)",
                    names.size(), names.size() == 1 ? "" : "s", fmt::join(names, ", ")));
  }
  out.notes.insert(out.notes.end(), out.assembly.notes.begin(), out.assembly.notes.end());
}

void forget_ringing(std::vector<std::string>& notes) {
  std::erase(notes, kRings);
}

}  // namespace flexura::mbs
