// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/statics/close_loops.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <set>

#include "mbs/solver/accuracy/mechanism_scales.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/position/closing.hpp"
#include "mbs/solver/statics/equilibrium.hpp"

namespace flexura::mbs {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The mechanism with nothing but its bodies' stiffness: U is its whole potential energy.
class Elastic {
 public:
  explicit Elastic(const Mechanism& whole) : bare_(describe(whole)) {
    std::map<std::string, int> places;
    const Sizes n = bare_.sizes();
    for (int i = 0; i < n.n_p; ++i) places[bare_.name_of_position(i)] = i;
    for (int i = 0; i < whole.sizes().n_p; ++i) {
      const auto found = places.find(whole.name_of_position(i));
      if (found == places.end()) throw std::logic_error("the bare mechanism has other coordinates");
      place_p_.push_back(found->second);
    }
    places.clear();
    for (int i = 0; i < n.n_v; ++i) places[bare_.name_of_velocity(i)] = i;
    for (int i = 0; i < whole.sizes().n_v; ++i) place_v_.push_back(places.at(whole.name_of_velocity(i)));
  }

  /// From p to where U is least; the energy.  Throws std::runtime_error.
  double relax(const State& undeformed, VectorXd& p) {
    State s = state_at(undeformed.t, undeformed.p);
    bare_.drop_redundant(s, s.p);
    s.lambda = VectorXd::Zero(bare_.sizes().n_lambda);
    find_equilibrium(bare_, s);
    for (std::size_t i = 0; i < place_p_.size(); ++i) p(static_cast<Eigen::Index>(i)) = s.p(place_p_[i]);
    return energy(undeformed.t, p);
  }

  double energy(double t, const VectorXd& p) {
    const State s = state_at(t, p);
    const EnergyReport report = bare_.energy(s, VectorXd::Zero(bare_.sizes().n_v), *bare_.make_scratch());
    return report.strain + report.potential;
  }

  /// d^2 U of the marked velocity coordinates of the whole mechanism.
  MatrixXd stiffness(double t, const VectorXd& p, const std::vector<bool>& marked) {
    const State s = state_at(t, p);
    Tangents tangents(bare_);
    tangents.evaluate(s, VectorXd::Zero(bare_.sizes().n_v));
    KinematicBlocks kinematics(bare_, s.p);
    kinematics.update(s.p, s.v);
    MatrixXd K;
    kinematics.multiply_T(tangents.z_p, K);
    std::vector<int> rows;
    for (std::size_t i = 0; i < marked.size(); ++i)
      if (marked[i]) rows.push_back(place_v_[i]);
    MatrixXd out(rows.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < rows.size(); ++j)
        out(i, j) = 0.5 * (K(rows[i], rows[j]) + K(rows[j], rows[i]));
    return out;
  }

 private:
  static MechanismDescription describe(const Mechanism& whole) {
    // Its tree, too, which may have cut joints for its size.
    MechanismDescription d = whole.description();
    d.gravity.setZero();
    // The springs between the segments of beams stand where their joints do.
    std::set<std::pair<int, int>> springs;
    for (const JointDescription& joint : d.joints)
      if (joint.bends) springs.insert({joint.marker_F, joint.marker_M});
    for (JointDescription& joint : d.joints) joint.splits = false;
    std::erase_if(d.forces, [&](const auto& force) { return !springs.contains(force->markers()); });
    d.controls.clear();
    d.measures.clear();
    for (std::size_t b = 1; b < d.bodies.size(); ++b)
      if (const auto& flexible = d.bodies[b].flexible; flexible && !flexible->acts_back())
        d.make_rigid(static_cast<int>(b));
    return d;
  }

  State state_at(double t, const VectorXd& p) const {
    State s = bare_.initial_state();
    s.t = t;
    for (std::size_t i = 0; i < place_p_.size(); ++i) s.p(place_p_[i]) = p(static_cast<Eigen::Index>(i));
    s.v.setZero();
    return s;
  }

  Mechanism bare_;
  std::vector<int> place_p_, place_v_;  // of each coordinate of the whole
};

// "\"A.angle\" from 60 to 58.67 deg": what became of initial values that the user gave.
std::string moved_values(const Mechanism& mechanism, const VectorXd& before, const VectorXd& after,
                         const std::vector<bool>& prescribed) {
  std::vector<std::string> list;
  const KinematicBlocks kinematics(mechanism, before);
  for (const KinematicBlocks::Block& block : kinematics.blocks()) {
    const bool marked = std::ranges::any_of(block.v, [&](int j) { return prescribed[j]; });
    for (const int i : block.p) {
      const double change = std::abs(after(i) - before(i));
      if (!marked || !(change > 1e-9 * (1.0 + std::abs(before(i))))) continue;
      // A coordinate's place tells its dimension.
      for (std::size_t j = 0; j < mechanism.joint_places().size(); ++j) {
        const JointPlace& place = mechanism.joint_places()[j];
        if (!place.in_tree() || i < place.i_p || i >= place.i_p + place.joint->n_p()) continue;
        const input::Dimension dimension = place.joint->coordinates()[i - place.i_p].dimension;
        const bool is_angle = dimension == input::dim::angle, is_length = dimension == input::dim::length;
        const double unit = is_angle ? M_PI / 180.0 : is_length ? 1e-3 : 1.0;
        const std::string from = fmt::format("{:.6g}", before(i) / unit),
                          to = fmt::format("{:.6g}", after(i) / unit);
        if (from == to) continue;
        list.push_back(fmt::format("\"{}\" from {} to {}{}", mechanism.name_of_position(i), from, to,
                                   is_angle    ? " deg"
                                   : is_length ? " mm"
                                               : ""));
      }
    }
  }
  return fmt::format("{}", fmt::join(list, ", "));
}

// 1 rad, or the mechanism's length: as much of a step in a watch as in a bridge.
VectorXd large_steps(const Mechanism& mechanism, const State& s) {
  const Scales scales = scales_of(mechanism, s);
  return scales.length * scales.reach_v.cwiseInverse();
}

// Whether a coordinate that is no deformation is further from where it was than a thousandth of a large step.
bool has_wandered(const Mechanism& mechanism, const VectorXd& before, const VectorXd& after,
                  const std::vector<bool>& deforms, const VectorXd& large) {
  constexpr double kFar = 1e-3;
  const KinematicBlocks kinematics(mechanism, before);
  return std::ranges::any_of(kinematics.blocks(), [&](const KinematicBlocks::Block& block) {
    double most = 0.0, step = 0.0;
    for (const int j : block.v)
      if (!deforms[j]) step = std::max(step, large(j));
    for (const int i : block.p) most = std::max(most, std::abs(after(i) - before(i)));
    return step > 0.0 && most > kFar * step;
  });
}

}  // namespace

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

std::vector<bool> deformations_of(const Mechanism& mechanism, const State& s) {
  std::vector<bool> deforms(mechanism.sizes().n_p, false);
  const std::vector<BodyDescription>& bodies = mechanism.description().bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const int first = mechanism.modal_position(static_cast<int>(b));
    if (first < 0) continue;
    for (int k = 0; k < bodies[b].flexible->m(); ++k) deforms[first + k] = true;
  }
  for (std::size_t j = 0; j < mechanism.joint_places().size(); ++j) {
    const JointPlace& place = mechanism.joint_places()[j];
    if (!mechanism.description().joints[j].bends || !place.in_tree()) continue;
    for (int k = 0; k < place.joint->n_p(); ++k) deforms[place.i_p + k] = true;
  }
  return velocities_of(mechanism, s, deforms);
}

std::optional<StrainedLoops> close_loops(const Mechanism& mechanism, State& s, const AssembleOptions& keep,
                                         AssembleReport& report) {
  const VectorXd start = s.p;
  const std::vector<bool> deforms = deformations_of(mechanism, s);
  const VectorXd large = large_steps(mechanism, s);
  ClosingOptions stiff{keep.keep_position, deforms, true, keep.max_iterations, large};
  const auto say_moved = [&] {
    if (report.positions_kept) return;
    // By less than is printed is not moved.
    const std::string values = moved_values(mechanism, start, s.p, keep.keep_position);
    std::erase_if(report.notes, [](const std::string& note) { return note.starts_with("the prescribed"); });
    if (values.empty()) return;
    report.notes.insert(
        report.notes.begin(),
        fmt::format("the initial values given do not close the loops and were moved: {}", values));
  };
  StrainedLoops out;
  const bool any_deforms = std::ranges::find(deforms, true) != deforms.end();
  Closing stiffly = close_positions(mechanism, s, stiff);
  report = stiffly.report;
  const bool failed = !stiffly.closed;
  const auto refuse = [&] {
    s.p = start;
    std::vector<std::string> open;
    for (const Opening& opening : openings_of(mechanism, stiffly.g))
      if (open.size() < 3) open.push_back(sentence_of(opening, mechanism.description()));
    const std::string why =
        !stiffly.out_of_reach.empty()
            ? why_open(stiffly)
            : fmt::format(
                  "open stays {}; check the markers, lengths and initial positions of the parts that these "
                  "join",
                  fmt::join(open, ", "));
    throw OpenLoops(fmt::format("the mechanism cannot be assembled at t = {:.6g} s: {}", s.t, why), stiffly.p,
                    stiffly.g);
  };
  if (failed) {
    if (!any_deforms) refuse();
    s.p = stiffly.p;
  } else {
    say_moved();
    if (stiffly.to_round_off || !any_deforms) return {};
    out.are_parts_as_made = true;
  }
  out.undeformed = s;
  VectorXd g(mechanism.sizes().n_lambda);
  mechanism.position_constraints(s, s.p, *mechanism.make_scratch(), g);
  out.openings = openings_of(mechanism, g);

  const auto close = [&] {
    const Closing last = close_positions(mechanism, s, {{}, {}, false, keep.max_iterations, large});
    if (!last.closed) return false;
    report.iterations += last.report.iterations;
    report.position_change += last.report.position_change;
    report.position_residual = last.report.position_residual;
    if (last.to_round_off)
      std::erase_if(report.notes, [](const std::string& n) { return n.starts_with("the loops close but"); });
    else if (failed)
      report.notes.insert(report.notes.end(), last.report.notes.begin(), last.report.notes.end());
    return true;
  };
  std::optional<Elastic> elastic;
  try {
    elastic.emplace(mechanism);
    out.stiffness = elastic->stiffness(s.t, s.p, deforms);
    elastic->relax(out.undeformed, s.p);
    // What parts as made are strained by is no reason to turn a door to where it is a little less.
    if (out.are_parts_as_made && has_wandered(mechanism, out.undeformed.p, s.p, deforms, large)) {
      s.p = out.undeformed.p;
      out.is_least = false;
    }
  } catch (const std::exception&) {
    s.p = out.undeformed.p;
    out.is_least = false;
  }
  bool closed = close();
  if (!closed && out.is_least) {
    s.p = out.undeformed.p;
    out.is_least = false;
    closed = close();
  }
  if (!closed) {
    if (failed) refuse();
    s.p = out.undeformed.p;
    return {};
  }
  if (elastic) out.energy = elastic->energy(s.t, s.p);
  if (failed) {
    report.positions_kept = moved_values(mechanism, start, s.p, keep.keep_position).empty();
    say_moved();
  }
  return out;
}

double energy_of_loads(const Mechanism& mechanism, const StrainedLoops& strained,
                       const std::vector<bool>& deforms, const State& moving) {
  if (strained.stiffness.size() == 0) return 0.0;
  const Sizes n = mechanism.sizes();
  State s = moving;
  s.p = strained.undeformed.p;
  VectorXd v_dot, r(n.n_v), c_rate(n.n_dyn), b(n.n_alg);
  AccelerationSolver(mechanism).solve(s, v_dot);
  for (int i = 0; i < n.n_v; ++i)
    if (deforms[i]) v_dot(i) = 0.0;
  mechanism.momentum(s, v_dot, *mechanism.make_scratch(), r, c_rate, b);
  VectorXd r_d(strained.stiffness.rows());
  Eigen::Index k = 0;
  for (int i = 0; i < n.n_v; ++i)
    if (deforms[i]) r_d(k++) = r(i);
  return 0.5 * std::abs(r_d.dot(strained.stiffness.ldlt().solve(r_d)));
}

std::string sentence_of(const StrainedLoops& strained, const Mechanism& mechanism, const State& s) {
  const MechanismDescription& d = mechanism.description();
  std::vector<std::string> open;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, strained.openings.size()); ++k)
    open.push_back(sentence_of(strained.openings[k], d));
  // The body whose interface moved the furthest in it.
  double furthest = 0.0;
  std::string where;
  for (std::size_t b = 0; b < d.bodies.size(); ++b) {
    const FlexibleBody* flexible = d.bodies[b].flexible.get();
    const double* modal = mechanism.modal_coordinates(static_cast<int>(b), s);
    if (!flexible || !modal || !flexible->acts_back()) continue;
    const double* before = mechanism.modal_coordinates(static_cast<int>(b), strained.undeformed);
    const auto n = static_cast<int>(flexible->nodes().size());
    for (int i = 0; i < n; ++i) {
      const Pose X_0 = flexible->node_pose(i, before), X = flexible->node_pose(i, modal);
      for (int j = 0; j < n; ++j) {
        // Of one interface as another one sees it, which does not depend on the frame.
        const Pose Y_0 = flexible->node_pose(j, before).inverse() * X_0,
                   Y = flexible->node_pose(j, modal).inverse() * X;
        const double moved = (Y.p - Y_0.p).norm();
        if (moved <= furthest) continue;
        furthest = moved;
        where =
            fmt::format(", which moves \"{}\" of body \"{}\" by {:.3g} mm against \"{}\"",
                        flexible->nodes()[i].name, d.bodies[b].name, 1e3 * moved, flexible->nodes()[j].name);
      }
    }
  }
  return fmt::format(
      "no motion of the joints closes the loops: open stays {}; the bodies are deformed to close them, with "
      "{} strain energy of {:.3g} J{}",
      fmt::join(open, ", "), strained.is_least ? "the least" : "a", strained.energy, where);
}

}  // namespace flexura::mbs
