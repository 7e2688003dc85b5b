// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/sequence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/independent.hpp"
#include "mbs/solver/position/quasi_static_start.hpp"
#include "mbs/solver/position/rank_watch.hpp"
#include "mbs/solver/statics/statics.hpp"

namespace flexura::mbs {

namespace {

// One state after the other, each from the one before; shorter strides where the next is not found.
class Sequence : public Integrator {
 public:
  Sequence(const Equations& eq, const SolverOptions& options, const char* what)
      : eq_(eq), options_(options), what_(what) {
    for (int k = 0; k < eq.sizes().n_root; ++k)
      if (!eq.is_condition(k))
        throw std::invalid_argument(
            fmt::format("{} does not locate switches, and \"{}\" is one: use method = \"ida\"", what,
                        eq.name_of_root(k)));
  }
  void start(const State& s, const Eigen::VectorXd&) override {
    now_ = s;
    // Each state for itself: formulas are as they are there.
    for (std::size_t k = 0; k < now_.root.size(); ++k) now_.root[k] = 0;
    solve(now_, v_dot_);
    from_ = begin_ = now_;
    v_dot_from_ = v_dot_;
  }
  StepEnd step(double t_stop) override {
    StepEnd end;
    end.t_begin = now_.t;
    const double stride = std::min(options_.output_step, t_stop - now_.t);
    const double least = options_.min_step > 0.0 ? options_.min_step : 1e-4 * options_.output_step;
    double h = stride;
    for (;;) {
      const bool has_rates = is_to_go_on_from(now_);
      State from = has_rates ? now_ : from_, next = from;
      try {
        Eigen::VectorXd v_dot_from = has_rates ? v_dot_ : v_dot_from_, v_dot = v_dot_from;
        advance(next, v_dot, now_.t + h - from.t);
        begin_ = now_;
        from_ = from;
        v_dot_from_ = v_dot_from;
        now_ = next;
        v_dot_ = v_dot;
        break;
      } catch (const std::runtime_error& e) {
        ++counts_.newton_failures;
        h *= 0.5;
        if (h < least)
          throw IntegrationError(
              fmt::format("{} cannot go on beyond t = {:.9g} s: {}", what_, now_.t, e.what()));
      }
    }
    ++counts_.steps;
    ++counts_.evaluations;
    // An output time is met to the bit.
    if (h == stride && stride == t_stop - end.t_begin) now_.t = t_stop;
    end.t_end = now_.t;
    return end;
  }
  void interpolate(double t, State& s, Eigen::VectorXd& v_dot) override {
    if (t == now_.t) {
      s = now_;
      v_dot = v_dot_;
      return;
    }
    // Forward: where a speed jumps at the end of the step it has jumped there already, and at a dead point it may be anything.
    const bool is_forward = is_motion() && begin_.t <= t && t < now_.t;
    s = is_forward ? from_ : now_;
    v_dot = is_forward ? v_dot_from_ : v_dot_;
    advance(s, v_dot, t - s.t);
    s.t = t;
  }
  StepCounts counts() const override { return counts_; }
  void remember(History& history) override {
    const Sizes n = eq_.sizes();
    mbs::remember(history, now_, n);
    history(v_dot_);
    mbs::remember(history, from_, n);
    history(v_dot_from_);
    for (const Eigen::VectorXd* x : {&v_dot_, &v_dot_from_})
      if (history.reads() && x->size() != 0) require_size(x->size(), n.n_v);
    if (history.reads()) begin_ = now_;
  }

 protected:
  virtual void move(State& s, const Eigen::VectorXd& v_dot, double h) const = 0;  // a guess h later
  virtual void solve(State& s, Eigen::VectorXd& v_dot) = 0;
  virtual void advance(State& s, Eigen::VectorXd& v_dot, double h) {
    move(s, v_dot, h);
    solve(s, v_dot);
  }
  /// Whether a state follows from the one before.
  virtual bool is_motion() const { return false; }
  /// Whether its rates lead to the next.
  virtual bool is_to_go_on_from(const State&) { return true; }

  const Equations& eq_;
  SolverOptions options_;
  const char* what_;
  State from_, begin_, now_;  // of the last step: what it was guessed from, begin and end
  Eigen::VectorXd v_dot_from_, v_dot_;
  StepCounts counts_;
};

/// Bodies that deform take the shape that balances their loads and the inertia of the driven motion, without vibration
/// (kineto-elastostatics; start_quasi_static()).
class KinematicSequence final : public Sequence {
 public:
  KinematicSequence(const Equations& eq, const SolverOptions& options)
      : Sequence(eq, options, "kinematics"), ranks_(eq) {
    if (eq.sizes().n_dyn > 0)
      throw std::invalid_argument(
          fmt::format("kinematics alone does not integrate the dynamic state \"{}\": use method = \"ida\"",
                      eq.name_of_dynamic(0)));
  }
  void start(const State& s, const Eigen::VectorXd& v_dot) override {
    std::vector<std::string> names;
    if (list_elastic()) {
      names = free_rigid_motion(s);
    } else {
      for (const int i : linearise(eq_, s).independent) names.push_back(eq_.name_of_velocity(i));
    }
    if (!names.empty()) {
      for (std::string& name : names) name = "\"" + name + "\"";
      throw std::invalid_argument(fmt::format(
          "kinematics needs every freedom driven, and {} of them {} not ({} would determine the rest): drive "
          "{}, or use method = \"ida\"",
          names.size(), names.size() == 1 ? "is" : "are", fmt::join(names, ", "),
          names.size() == 1 ? "it" : "them"));
    }
    for (int k = 0; k < eq_.sizes().n_lambda; ++k) integrates_ = integrates_ || !eq_.is_holonomic(k);
    Sequence::start(s, v_dot);
  }

 protected:
  void move(State& s, const Eigen::VectorXd& v_dot, double h) const override {
    Eigen::VectorXd d = h * s.v + 0.5 * h * h * v_dot, p(s.p.size());
    eq_.retract(s.p, d, p);
    s.p = p;
    s.v += h * v_dot;
    s.t += h;
  }
  void solve(State& s, Eigen::VectorXd& v_dot) override {
    if (!elastic_.empty()) {
      AssembleOptions shape;  // as it was, first
      shape.keep_position = shape.keep_velocity = is_elastic_;
      assemble(eq_, s, v_dot, shape);
      start_quasi_static(eq_, s, v_dot);
      return;
    }
    AssembleReport report = assemble_positions(eq_, s);
    const Eigen::VectorXd guess = s.v;
    try {
      assemble_velocities(eq_, s, {}, report);
    } catch (const AssemblyError&) {
      // On a dead point no speeds close the loops where round-off of positions asks for some.
      if (!ranks_.is_lost(ranks_.independence(s))) throw;
      s.v = guess;
    }
    AccelerationSolver(eq_).solve(s, v_dot);
  }
  bool is_motion() const override { return true; }
  // Next to a dead point they are wrong by any amount, and those from before it lead across.
  bool is_to_go_on_from(const State& s) override {
    return integrates_ || eq_.sizes().n_lambda == 0 || !ranks_.is_lost(ranks_.independence(s));
  }
  // Positions follow from the drives but for those of drives of speed, which are integrated: by the step above, of second order, in
  // halves until one step and two differ by the tolerance.
  void advance(State& s, Eigen::VectorXd& v_dot, double h) override {
    State whole = s;
    Eigen::VectorXd a = v_dot;
    Sequence::advance(whole, a, h);
    if (integrates_) {
      State halves = s;
      a = v_dot;
      for (int half = 0; half < 2; ++half) Sequence::advance(halves, a, 0.5 * h);
      double error = 0.0;
      for (int i = 0; i < eq_.sizes().n_p; ++i)
        error = std::max(error, std::abs(halves.p(i) - whole.p(i)) / (3.0 * eq_.position_scale(i)));
      if (!(error <= options_.tolerance)) {
        if (!(std::abs(h) > 1e-6 * options_.output_step))
          throw std::runtime_error(
              "positions of driven speeds are not found to the tolerance; take a larger one, or method = "
              "\"ida\"");
        for (int half = 0; half < 2; ++half) advance(s, v_dot, 0.5 * h);
        return;
      }
      whole = halves;
    }
    s = whole;
    v_dot = a;
  }

 private:
  bool list_elastic() {
    const int n_v = eq_.sizes().n_v;
    is_elastic_.assign(static_cast<std::size_t>(n_v), false);
    for (int i = 0; i < n_v; ++i) {
      int i_p = -1;
      double stiffness = 0.0, damping = 0.0;
      if (!eq_.elastic_coordinate(i, i_p, stiffness, damping)) continue;
      is_elastic_[static_cast<std::size_t>(i)] = true;
      elastic_.push_back(i);
    }
    return !elastic_.empty();
  }
  // Speeds that determine the motion that drives leave where nothing deforms.
  std::vector<std::string> free_rigid_motion(const State& s) const {
    const Sizes n = eq_.sizes();
    const auto scratch = eq_.make_scratch();
    Eigen::MatrixXd M(n.n_v, n.n_v), G(n.n_lambda, n.n_v);
    eq_.mass_matrix(s.p, *scratch, M);
    eq_.constraint_matrix(s, s.p, *scratch, G);
    std::vector<int> rigid;
    for (int i = 0; i < n.n_v; ++i)
      if (!is_elastic_[static_cast<std::size_t>(i)]) rigid.push_back(i);
    // What round-off leaves of rows that only deformation changes is no row.
    Eigen::MatrixXd G_r = G(Eigen::all, rigid);
    for (int k = 0; k < n.n_lambda; ++k)
      if (G_r.row(k).norm() < 1e-9 * G.row(k).norm()) G_r.row(k).setZero();
    std::vector<std::string> names;
    for (const int i : independent_coordinates(M(rigid, rigid), G_r).independent)
      names.push_back(eq_.name_of_velocity(rigid[static_cast<std::size_t>(i)]));
    return names;
  }

  bool integrates_ = false;
  std::vector<int> elastic_;  // velocity coordinates that deform bodies
  std::vector<bool> is_elastic_;
  RankWatch ranks_;
};

class StaticSequence final : public Sequence {
 public:
  StaticSequence(const Equations& eq, const SolverOptions& options)
      : Sequence(eq, options, "quasi_statics") {}

 protected:
  void move(State& s, const Eigen::VectorXd&, double h) const override { s.t += h; }
  void solve(State& s, Eigen::VectorXd& v_dot) override {
    solve_statics(eq_, s);
    v_dot = Eigen::VectorXd::Zero(s.v.size());
  }
};

class Rest final : public Integrator {
 public:
  void start(const State& s, const Eigen::VectorXd&) override { now_ = s; }
  StepEnd step(double t_stop) override {
    StepEnd end;
    end.t_begin = now_.t;
    end.t_end = now_.t = t_stop;
    ++counts_.steps;
    return end;
  }
  void interpolate(double t, State& s, Eigen::VectorXd& v_dot) override {
    s = now_;
    s.t = t;
    v_dot.resize(0);
  }
  StepCounts counts() const override { return counts_; }
  void remember(History& history) override { history(now_); }

 private:
  State now_;
  StepCounts counts_;
};

}  // namespace

std::unique_ptr<Integrator> make_rest() {
  return std::make_unique<Rest>();
}

std::unique_ptr<Integrator> make_kinematics(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<KinematicSequence>(eq, options);
}

std::unique_ptr<Integrator> make_quasi_statics(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<StaticSequence>(eq, options);
}

}  // namespace flexura::mbs
