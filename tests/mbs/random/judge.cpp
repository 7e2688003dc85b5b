// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "mbs/base/math/rotation.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/linear/stability.hpp"
#include "mbs/solver/linear/steady_state.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/mbs/random/scene/scene_run.hpp"

namespace flexura::mbs::chance {

namespace {

constexpr double kTolerance = 1e-7;

class Judge {
 public:
  Judge(const Scene& scene, const JudgeOptions& options)
      : scene_(scene), options_(options), physics_(scene) {}

  Judgement judge() {
    std::string why;
    nature_ = physics_.nature(&why);
    out_.nature = nature_ == Nature::moves         ? "moves"
                  : nature_ == Nature::contradicts ? "contradicts"
                                                   : "unclear";
    if (!why.empty()) out_.nature += ": " + why;
    Writing how;
    how.solver = with("open", kTolerance);
    const Ran first = simulate(scene_, how, options_.file);
    out_.end = first.sentence();
    how.solver = with("radau", kTolerance);
    const Ran second = simulate(scene_, how, options_.file);
    fewest_steps_ = std::min(first.steps, second.steps);
    look_at_end(first);
    look_at_rows(first, "open method");
    compare(first, second, "the open method and radau", out_.integrators);
    look_at_rows(second, "radau");
    if (options_.other_files) {
      how.solver = with("open", kTolerance);
      how.bodies_backwards = true;
      how.suffix = "_backwards";
      const Ran backwards = simulate(scene_, how, options_.file);
      if (!scene_.order_matters) compare(first, backwards, "bodies in another order", out_.files);
      look_at_rows(backwards, "bodies in another order");
      how.bodies_backwards = false;
      how.length = 1000.0;
      how.mass = 1e-3;
      how.suffix = "_mm";
      const Ran millimetres = simulate(scene_, how, options_.file);
      compare(first, millimetres, "units of mm, t, s", out_.files);
      look_at_rows(millimetres, "units of mm, t, s");
    }
    if (options_.other_commands) other_commands();
    return std::move(out_);
  }

 private:
  using Nature = ScenePhysics::Nature;
  template <class... Args>
  void complain(fmt::format_string<Args...> format, Args&&... args) {
    out_.complaints.push_back(which_ + fmt::format(format, std::forward<Args>(args)...));
  }
  static std::string with(const std::string& method, double tolerance) {
    // "open" is the program's own choice, which may change on the way.
    return fmt::format("{}tolerance = {:.17g}\n",
                       method == "open" ? "" : fmt::format("method = \"{}\"\n", method), tolerance);
  }

  void look_at_message(const std::string& message, const std::string& where) {
    if (message.empty()) complain("{} ended without a message", where);
    if (message.find("nan") != std::string::npos || message.find("inf ") != std::string::npos)
      complain("{} speaks of numbers that are none: {}", where, message);
  }

  void look_at_end(const Ran& ran) {
    if (ran.end == Ran::End::broken) complain("broke: {}", ran.message);
    if (ran.end != Ran::End::complete) look_at_message(ran.message, "the run");
    if (nature_ == Nature::contradicts && ran.end == Ran::End::complete)
      complain("it contradicts itself and ran");
    if (nature_ == Nature::moves && ran.end == Ran::End::refused) complain("refused: {}", ran.message);
    if (nature_ == Nature::moves && ran.end == Ran::End::stopped && !may_stop(ran) && !may_chatter(ran))
      complain("stopped: {}", ran.message);
  }

  // A force that changes with the coordinate it acts on may drive it back across the level from both sides.
  bool may_chatter(const Ran& ran) const {
    return ran.message.find("switches without end") != std::string::npos &&
           std::ranges::any_of(scene_.forces, [](const SceneForce& f) { return f.type == "joint_force"; });
  }

  // Where the last row stands the rows are about to lose rank, or cannot hold a moment later, or only by deformation
  // beyond any linear range.
  bool may_stop(const Ran& ran) {
    if (ran.rows.empty()) return false;
    ScenePhysics physics(scene_);
    for (const RanRow& row : ran.rows) physics.count_turns_from(places_of(row.motion));
    const RanRow& last = ran.rows.back();
    const int rank = physics.rank(places_of(last.motion), last.t).rank;
    for (int k = 0; k <= 10; ++k) {
      const double dt = 0.1 * k * 1.1 * scene_.output_step;
      Places later = physics.later(last.motion, dt);
      if (physics.close(later, last.t + dt) > 1e-8) return true;
      if (physics.deformation(later) > 0.1) return true;
      const ScenePhysics::Rank there = physics.rank(later, last.t + dt);
      if (there.rank != rank || there.smallest < 0.02) return true;
    }
    return false;
  }

  void look_at_rows(const Ran& ran, const std::string& which) {
    which_ = which + ": ";
    look_at_rows(ran);
    which_.clear();
  }

  void look_at_rows(const Ran& ran) {
    said_acceleration_ = said_coordinate_ = false;
    said_rows_ = 0;
    if (ran.rows.empty()) {
      if (ran.end != Ran::End::refused) complain("no rows");
      return;
    }
    ScenePhysics physics(scene_);
    const double size = physics.size();
    const double fit = scene_.digits < 17 ? 3.0 * std::pow(10.0, 1 - scene_.digits) + 1e-9 : 1e-9;
    double sigma = 1.0;  // the rows' least singular value on the way
    double energy_0 = 0.0, moved_energy = 0.0, offset_0 = 0.0, lost = 0.0, stored = 0.0;
    Vector3d p_0, L_0, c_0;
    const bool floats = !scene_.is_grounded();
    for (std::size_t k = 0; k < ran.rows.size(); ++k) {
      const RanRow& row = ran.rows[k];
      const Places X = places_of(row.motion);
      physics.count_turns_from(X);
      double speed = 0.0, acceleration = 0.0;
      for (std::size_t b = 1; b < row.motion.size(); ++b) {
        const BodyMotion& m = row.motion[b];
        speed = std::max({speed, m.V.angular.norm(), m.V.linear.norm() / size});
        acceleration =
            std::max({acceleration, m.A.angular.norm(), m.A.linear.norm() / size, m.q_ddot.norm() / size});
      }
      if (!std::isfinite(speed + acceleration)) {
        complain("numbers that are none at t = {:.6g}", row.t);
        return;
      }
      worst(physics, physics.rows(X, row.t), fit, out_.rows, "open", row.t);
      worst(physics, physics.rates(row.motion, row.t), 1e-7 * (1.0 + speed) + 10.0 * fit * speed, out_.rates,
            "opening", row.t);
      look_at_coordinates(physics, row, X);
      const bool is_known = !scene_.has_beams();
      ScenePhysics::Gauss gauss;
      if (is_known)
        gauss = physics.accelerations(row.motion, row.t);
      else if (physics.n_rows() > 0)
        gauss.rank = physics.rank(X, row.t);
      if (physics.n_rows() > 0) sigma = std::min(sigma, gauss.rank.smallest);
      if (is_known && (physics.n_rows() == 0 || gauss.rank.is_clear()) &&
          !physics.stands_at_switch(row.motion, row.t)) {
        double error = 0.0;
        for (std::size_t b = 1; b < row.motion.size(); ++b) {
          const Vector6d a = physics.of_frame(gauss, static_cast<int>(b));
          error = std::max({error, (a.head<3>() - row.motion[b].A.angular).norm(),
                            (a.tail<3>() - row.motion[b].A.linear).norm() / size});
          if (scene_.bodies[b].part)
            error = std::max(
                error, (physics.of_modes(gauss, static_cast<int>(b)) - row.motion[b].q_ddot).norm() / size);
        }
        error /= 1.0 + acceleration + speed * speed;
        out_.accelerations = std::max(out_.accelerations, error);
        // Differences give gamma to 1e-7 of the speeds' size; weak rows make more of it.
        if (error > 1e-5 + 1e-7 / gauss.rank.smallest + 1e3 * fit && !has(said_acceleration_))
          complain("accelerations at t = {:.6g} are off by {:.2e} of {:.3g}", row.t, error, acceleration);
      }
      // Of beams there are no equations of the test's own: their energies are the program's.
      const double T = is_known ? physics.kinetic(row.motion) : row.kinetic,
                   U = is_known ? physics.potential(row.motion) : row.potential;
      const Vector3d p = physics.momentum(row.motion), c = physics.centre(row.motion);
      const Vector3d L = physics.angular_momentum(row.motion) - c.cross(p);
      if (k == 0) energy_0 = T + U, offset_0 = T + U - row.kinetic - row.potential, p_0 = p, L_0 = L, c_0 = c;
      moved_energy = std::max({moved_energy, T, std::abs(T + U - energy_0)});
      const double scale = 1e-9 + moved_energy;
      if (std::abs(T - row.kinetic) > 1e-9 * scale + 1e-9 * T)
        complain("kinetic energy {} is said to be {}", T, row.kinetic);
      if (std::abs(T + U - row.kinetic - row.potential - offset_0) > 1e-8 * (scale + std::abs(U)))
        complain("energy {} is said to be {}", T + U - offset_0, row.kinetic + row.potential);
      if (scene_.is_conservative()) {
        lost = std::max(lost, std::abs(T + U - energy_0));
        stored = std::max(stored, std::abs(U - energy_0));
      }
      if (floats && is_known) {
        const double of = physics.mass() * (size * speed + 1e-3);
        const double error = std::max((p - p_0 - physics.mass() * row.t * scene_.gravity).norm() / of,
                                      (L - L_0).norm() / (of * size));
        out_.momentum = std::max(out_.momentum, error);
      }
    }
    // Relative to the energy that was moved; where nothing was, there is nothing to be relative to.
    out_.balance = moved_energy > 1e-9 ? std::abs(ran.balance) : 0.0;
    // Each step may err by the tolerance, at worst all of them one way; steps that another method does not need are
    // no excuse.
    const double steps = static_cast<double>(std::min(ran.steps, 3 * fewest_steps_));
    const double vibrated = std::clamp(kTolerance * steps, 1e-5, 1e-3);
    // Of the energy that went to and fro; a structure that stands still moves the round-off of what it holds, 1e-11.
    const double part = lost / (1e-9 + 1e-6 * std::abs(energy_0) + moved_energy + stored);
    out_.energy = std::max(out_.energy, part);
    if (part > vibrated) complain("energy is lost by {:.2e}", part);
    // Where a run stops because its rows lose rank the forces grow without bound.
    // What rows that fit to e make of forces is right to e / sigma^2 (near_rank_loss() of dead_point.hpp).
    const double misfit = scene_.digits < 17 ? 3.0 * std::pow(10.0, 1 - scene_.digits) : 1e-15;
    const double amplified = std::min(misfit / (sigma * sigma), 1e-3);
    // Work within a step is that of the method's polynomial, in Radau of third order where the step's end is of fifth:
    // C h^4 where the tolerance is C h^6.  Energy that is lost (above) and the other method know nothing of it.
    const double polynomial = 5.0 * std::pow(kTolerance, 2.0 / 3.0);
    const double allowed = ran.end == Ran::End::stopped ? 1e-3 : std::max({vibrated, amplified, polynomial});
    if (!ran.warning.empty()) ++out_.warnings;
    if (ran.warning.empty() && out_.balance > allowed)
      complain("the energy balance is open by {:.2e}", out_.balance);
    if (out_.momentum > 1e-4) complain("momentum changes by {:.2e}", out_.momentum);
  }

  bool has(bool& said) {
    const bool before = said;
    said = true;
    return before;
  }

  void worst(const ScenePhysics& physics, const Eigen::VectorXd& g, double allowed, double& largest,
             const char* what, double t) {
    for (Eigen::Index i = 0; i < g.size(); ++i) {
      const int row = static_cast<int>(i);
      const double open = std::abs(g(i)) / (physics.row_is_length(row) ? physics.size() : 1.0);
      const double bound = physics.row_is_integrated(row) ? allowed + 100.0 * kTolerance : allowed;
      if (!physics.row_is_integrated(row)) largest = std::max(largest, open);
      if (!(open <= bound) && said_rows_++ < 3)
        complain("{} is {} by {:.2e} at t = {:.6g}, {:.1e} allowed", physics.row_name(row), what, open, t,
                 bound);
    }
  }

  void look_at_coordinates(const ScenePhysics& physics, const RanRow& row, const Places& X) {
    for (int j = 0; j < static_cast<int>(row.coordinates.size()); ++j)
      for (int i = 0; i < static_cast<int>(row.coordinates[j].size()); ++i) {
        const double q = physics.coordinate(j, i, X), v = physics.speed(j, i, row.motion);
        const bool turns = coordinates_of(scene_.joints[j].type)[i].is_angle();
        double d = row.coordinates[j][i] - q;
        if (turns) d = std::remainder(d, 2.0 * std::numbers::pi);
        if (std::abs(d) > 1e-6 && !has(said_coordinate_))
          complain("j{}.{} is {:.9g}, said to be {:.9g}", j, coordinates_of(scene_.joints[j].type)[i].name, q,
                   row.coordinates[j][i]);
        if (std::abs(v - row.speeds[j][i]) > 1e-6 * (1.0 + std::abs(v)) && !has(said_coordinate_))
          complain("j{}.{} is {:.9g}, said to be {:.9g}", j, coordinates_of(scene_.joints[j].type)[i].speed,
                   v, row.speeds[j][i]);
      }
  }

  void compare(const Ran& a, const Ran& b, const std::string& what, double& largest) {
    if (b.end == Ran::End::broken) complain("{}: broke: {}", what, b.message);
    if (a.end != b.end && nature_ != Nature::unclear) {
      complain("{}: one is {}, the other {}", what, a.sentence(), b.sentence());
      return;
    }
    // From a guess the mechanism may close elsewhere.
    if (scene_.start == Start::guess) return;
    const double d = difference(a, b, physics_.size());
    largest = std::max(largest, d);
    // Each step may err by the tolerance, at worst all of them one way.
    const double allowed = kTolerance * static_cast<double>(std::max({300L, a.steps, b.steps}));
    if (d > allowed) {
      const double growth = sensitivity();
      if (d > allowed * growth)
        complain("{}: the motion differs by {:.2e}, sensitivity {:.1f}", what, d, growth);
    }
  }

  // By how much a disturbance of the first row's speeds has grown at the end.
  double sensitivity() {
    if (sensitivity_ > 0.0) return sensitivity_;
    sensitivity_ = 1.0;
    const double eps = 1e-5;
    try {
      PreparedMechanism p =
          prepare(to_file(scene_, {.solver = with("radau", 1e-9), .suffix = "_fine"}, options_.file));
      RowReader reader(scene_, {}, *p.mechanism);
      const auto rows_from = [&](State s) {
        Ran ran;
        Eigen::VectorXd v_dot;
        assemble(*p.mechanism, s, v_dot);
        RunCallbacks callbacks;
        callbacks.row = [&](const State& x, const Eigen::VectorXd& a, const EnergyAccount&) {
          ran.rows.push_back(reader.read(x, a));
        };
        run(*p.mechanism, s, v_dot, p.options, callbacks);
        return ran;
      };
      const Ran base = rows_from(p.state);
      for (int k = 0; k < 2; ++k) {
        State s = p.state;
        for (Eigen::Index i = 0; i < s.v.size(); ++i) s.v(i) += eps * ((i + k) % 2 == 0 ? 1.0 : -1.0);
        sensitivity_ = std::max(sensitivity_, difference(base, rows_from(s), physics_.size()) / eps);
      }
    } catch (const std::exception&) {
    }
    return sensitivity_;
  }

  static bool is_finite(const Eigen::MatrixXd& A) { return A.allFinite(); }

  void attempt(const std::string& what, const std::function<bool()>& work) {
    try {
      if (!work()) complain("{} gives numbers that are none", what);
    } catch (const std::exception& e) {
      if (!is_documented(e)) complain("{} broke: {}", what, e.what());
      look_at_message(e.what(), what);
    }
  }

  void other_commands() {
    const std::string file = to_file(scene_, {.solver = with("open", kTolerance)}, options_.file);
    attempt("linearisation", [&] {
      const PreparedMechanism p = prepare(file);
      p.mechanism->not_unique(p.state.t, p.state.p);
      const SteadyLinearisation out = linearise_steady(*p.mechanism, p.state, 1.0, {});
      for (const NaturalMode& mode : natural_modes(out.system))
        if (!std::isfinite(mode.frequency_hz + mode.eigenvalue.real())) return false;
      return is_finite(out.system.A);
    });
    attempt("statics", [&] {
      PreparedMechanism p = prepare(file);
      find_equilibrium(*p.mechanism, p.state);
      AccelerationSolver(*p.mechanism).solve(p.state, p.v_dot);
      stability_at_rest(*p.mechanism, p.state);
      const LinearSystem system = linearise(*p.mechanism, p.state);
      natural_modes(system);
      return is_finite(system.A) && p.state.p.allFinite() && p.state.lambda.allFinite();
    });
  }

  const Scene& scene_;
  const JudgeOptions& options_;
  ScenePhysics physics_;
  Nature nature_ = Nature::unclear;
  Judgement out_;
  std::string which_;  // run is being looked at
  bool said_acceleration_ = false, said_coordinate_ = false;
  int said_rows_ = 0;
  long fewest_steps_ = 0;  // of the open method and radau
  double sensitivity_ = 0.0;
};

}  // namespace

Judgement judge(const Scene& scene, const JudgeOptions& options) {
  return Judge(scene, options).judge();
}

}  // namespace flexura::mbs::chance
