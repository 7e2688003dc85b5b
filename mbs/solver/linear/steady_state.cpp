// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/steady_state.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <optional>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/linear/beside_switches.hpp"
#include "mbs/solver/linear/steady_axes.hpp"
#include "mbs/solver/linear/system_difference.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Verdict = SteadyLinearisation::Verdict;

// Typical sizes (m, rad, modal amplitudes of a metre) within which a state counts as in equilibrium without a
// word, and with one: statics ends at 1e-10, a run's end at its tolerance, 1e-6.
constexpr double kExact = 1e-8, kNear = 1e-5;
/// What brings a state with accelerations away from where it is.
struct Drift {
  double offset = 0.0;         ///< to where its forces are in balance, in typical sizes
  Eigen::Index offset_of = 0;  ///< index among (z, c)
  double left = 0.0;  ///< accelerations and rates that no displacement balances, in typical sizes per s^2
  Eigen::Index left_of = 0;  ///< index among (w, c)
};

class Judge {
 public:
  Judge(const Mechanism& m, const State& s, double horizon, const LineariseOptions& options)
      : m_(m),
        n_(m.sizes()),
        horizon_(horizon),
        options_(options),
        s_(s),
        scratch_(m.make_scratch()),
        accelerations_(m) {
    accelerations_.solve(s_, v_dot_);
    c_rate_ = accelerations_.c_rate();
    options_.all_positions = true;  // what nothing reads here may be read later
    own_ = linearise(m, s_, options_);
    size_.resize(n_.n_v);
    for (int i = 0; i < n_.n_v; ++i) size_(i) = m.velocity_scale(i);
    M_.setZero(n_.n_v, n_.n_v);
    m.mass_matrix(s_.p, *scratch_, M_);
  }

  SteadyLinearisation judge();

 private:
  struct Sample {
    State s;
    VectorXd v_dot, c_rate;
    LinearSystem system;  ///< in own axes
  };

  /// Of the motion, in typical sizes [1/s].
  double speed() const { return n_.n_v == 0 ? 0.0 : s_.v.cwiseQuotient(size_).lpNorm<Eigen::Infinity>(); }
  bool rests() const { return speed() < 1e-9; }
  std::string name_of(const LinearSystem& system, Eigen::Index k) const;       ///< of (z, c)
  std::string name_of_rate(const LinearSystem& system, Eigen::Index k) const;  ///< of (w, c)
  Drift drift(const LinearSystem& system, const VectorXd& v_dot, const VectorXd& c_rate) const;
  SteadyLinearisation judge_rest();
  SteadyLinearisation judge_motion(bool accelerated);
  std::vector<double> times() const;
  const Sample& sample(const State& s);
  double opening(const State& s);
  std::string change_along(const TurningAxes& axes, double tau, double& change);
  void describe_unsteady(const Drift& d, SteadyLinearisation& out) const;

  const Mechanism& m_;
  const Sizes n_;
  const double horizon_;
  LineariseOptions options_;
  State s_;
  std::unique_ptr<Equations::Scratch> scratch_;
  AccelerationSolver accelerations_;
  VectorXd v_dot_, c_rate_, size_;
  LinearSystem own_;
  MatrixXd M_;
  std::vector<Sample> samples_;
};

std::string Judge::name_of(const LinearSystem& system, Eigen::Index k) const {
  const auto n_z = static_cast<Eigen::Index>(system.positions.size());
  return k < n_z ? m_.name_of_velocity(system.positions[k]) : m_.name_of_dynamic(system.dynamic[k - n_z]);
}

std::string Judge::name_of_rate(const LinearSystem& system, Eigen::Index k) const {
  const auto n_w = static_cast<Eigen::Index>(system.independent.size());
  return k < n_w ? m_.name_of_velocity(system.independent[k]) : m_.name_of_dynamic(system.dynamic[k - n_w]);
}

// The displacement (z, c) after which v' and c' would vanish, and what it cannot take away, in the norm of the
// masses: a body that falls accelerates all it carries, and no spring in it gives way for that.
Drift Judge::drift(const LinearSystem& system, const VectorXd& v_dot, const VectorXd& c_rate) const {
  const auto n_z = static_cast<Eigen::Index>(system.positions.size()),
             n_w = static_cast<Eigen::Index>(system.independent.size()),
             n_c = static_cast<Eigen::Index>(system.dynamic.size());
  Drift out;
  if (n_w + n_c == 0) return out;
  MatrixXd B(n_w + n_c, n_z + n_c);
  B << system.A.bottomLeftCorner(n_w + n_c, n_z), system.A.bottomRightCorner(n_w + n_c, n_c);
  // States that only motion changes, as of a friction that sticks, follow the displacements: dc = T dz.
  const MatrixXd rates_of_z = system.A.topRightCorner(n_z, n_w + n_c).leftCols(n_w);
  for (Eigen::Index k = 0; k < n_c; ++k) {
    const Eigen::VectorXd by_speeds = system.A.block(n_z + n_w + k, n_z, 1, n_w).transpose();
    if (c_rate(system.dynamic[static_cast<std::size_t>(k)]) != 0.0 || by_speeds.isZero(0.0) ||
        !B.row(n_w + k).isZero(0.0))
      continue;
    const VectorXd T = rates_of_z.transpose().completeOrthogonalDecomposition().solve(by_speeds);
    B.leftCols(n_z) += B.col(n_z + k) * T.transpose();
    B.col(n_z + k).setZero();
  }
  VectorXd e(n_w + n_c), size_of_rates(n_w + n_c), size(n_z + n_c), size_of_c(n_c);
  for (Eigen::Index k = 0; k < n_c; ++k)
    size_of_c(k) = std::max(1.0, std::abs(s_.c(system.dynamic[static_cast<std::size_t>(k)])));
  e << v_dot(system.independent), c_rate(system.dynamic);
  size_of_rates << size_(system.independent), size_of_c;
  size << size_(system.positions), size_of_c;
  // y = U x with U^T U = N^T M N, of rates and of displacements.
  const auto norm = [&](const MatrixXd& N, const VectorXd& sizes) {
    MatrixXd U = sizes.cwiseInverse().asDiagonal();
    if (N.cols() > 0) U.topLeftCorner(N.cols(), N.cols()) = (N.transpose() * M_ * N).llt().matrixU();
    return U;
  };
  const MatrixXd U = norm(system.N, size_of_rates),
                 U_inverse = norm(system.Q.leftCols(n_z), size).partialPivLu().inverse(),
                 weighted = U * B * U_inverse;
  // Differences with steps of 1e-5 leave 1e-11 of the accelerations, and 1e-14 of the stiffest: what does not
  // stand well above that is no stiffness.
  const double rate = speed(), largest = weighted.size() > 0 ? weighted.cwiseAbs().maxCoeff() : 0.0,
               noise = 1e-7 * (1.0 + e.cwiseQuotient(size_of_rates).lpNorm<Eigen::Infinity>() + rate * rate);
  VectorXd d = VectorXd::Zero(size.size()), left = e;
  if (largest > noise) {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(weighted.rows(), weighted.cols());
    decomposition.setThreshold(std::max(1e-12, noise / largest));
    decomposition.compute(weighted);
    const VectorXd open = -(U * e), y = decomposition.solve(open);
    d = U_inverse * y;
    left = U.partialPivLu().solve(weighted * y + U * e);
  }
  if (d.size() > 0) out.offset = d.cwiseQuotient(size).cwiseAbs().maxCoeff(&out.offset_of);
  out.left = left.cwiseQuotient(size_of_rates).cwiseAbs().maxCoeff(&out.left_of);
  return out;
}

std::vector<double> Judge::times() const {
  // Most of a radian, or of a typical size, and more than two: no multiples of each other.
  double rate = speed();
  if (n_.n_v > 0) rate = std::max(rate, std::sqrt(v_dot_.cwiseQuotient(size_).lpNorm<Eigen::Infinity>()));
  if (n_.n_dyn > 0) rate = std::max(rate, c_rate_.lpNorm<Eigen::Infinity>() / 10.0);
  return {0.7 / rate, 2.3 / rate};
}

double Judge::opening(const State& s) {
  if (n_.n_lambda == 0) return 0.0;
  VectorXd g(n_.n_lambda), g_dot(n_.n_lambda);
  m_.constraints(s, s.p, s.v, *scratch_, g, g_dot);
  const double rate = std::max(1.0, speed());
  return std::max(g.lpNorm<Eigen::Infinity>(), g_dot.lpNorm<Eigen::Infinity>() / rate);
}

const Judge::Sample& Judge::sample(const State& s) {
  for (const Sample& one : samples_)
    if (one.s.t == s.t && (one.s.p - s.p).lpNorm<Eigen::Infinity>() < 1e-9 &&
        (one.s.v - s.v).cwiseQuotient(size_).lpNorm<Eigen::Infinity>() <
            1e-9 * (1.0 + s.v.cwiseQuotient(size_).lpNorm<Eigen::Infinity>()) &&
        (one.s.c - s.c).isZero(1e-9))
      return one;
  Sample made;
  made.s = s;
  accelerations_.solve(made.s, made.v_dot);
  made.c_rate = accelerations_.c_rate();
  made.system = linearise(m_, made.s, options_);
  samples_.push_back(std::move(made));
  return samples_.back();
}

// Empty where tau later everything is the same in these axes; else why it is not.
std::string Judge::change_along(const TurningAxes& axes, double tau, double& change) {
  State later = along(m_, {s_, v_dot_, c_rate_}, axes, tau);
  if (!later.p.allFinite() || !later.v.allFinite()) {
    // Of a body that hardly turns the precession is a quotient of small numbers.
    change = 1.0;
    return "the motion is not one of turning axes";
  }
  // Given functions of time are held where that is no contradiction: a load that swings is no part of the
  // coefficients.  Drives go on.
  const double at_0 = opening(s_), bound = 1e-7 + 10.0 * at_0;
  if (!(opening(later) <= bound)) {
    later.t = s_.t + tau;
    if (!(opening(later) <= bound)) {
      change = 1.0;
      return fmt::format(
          "going on with the present velocities opens the constraints by {:.3g} after {:.3g} s",
          opening(later), tau);
    }
  }
  const Sample there = sample(later);  // a copy: the next one may move it
  const MatrixXd B = turned(axes.W, tau);
  const LinearSystem now = in_turning_axes(own_, axes.W), then = in_turning_axes(there.system, axes.W);
  const VectorXd expected = axes.accelerated ? v_dot_ : VectorXd(axes.W * there.s.v);
  const VectorXd c_expected = axes.accelerated ? c_rate_ : VectorXd(VectorXd::Zero(n_.n_dyn));
  const Drift d = drift(then, there.v_dot - expected, there.c_rate - c_expected);
  if (d.offset > kNear || d.left > kNear) {
    change = 1.0;
    return fmt::format("\"{}\" does not go on as it moves now",
                       d.offset > kNear ? name_of(then, d.offset_of) : name_of_rate(then, d.left_of));
  }
  int where = 0;
  const TypicalSizes sizes{
      size_, VectorXd(s_.c(now.dynamic).cwiseAbs().cwiseMax(1.0)),
      1.0 + speed() * speed() + (n_.n_v > 0 ? v_dot_.cwiseQuotient(size_).lpNorm<Eigen::Infinity>() : 0.0)};
  const LaterSystem there_now{then, B};
  // A millionth of the way on tells round-off from what changes.
  constexpr double kAtOnce = 1e-6, kAbove = 10.0;
  const auto beside = [&](double part) {
    return LaterSystem{
        in_turning_axes(sample(along(m_, {s_, v_dot_, c_rate_}, axes, part * tau)).system, axes.W),
        turned(axes.W, part * tau)};
  };
  change = largest_difference(now, there_now, sizes, where);
  // What light parts leave of heavy ones cancels in other ways in axes that have turned on: there, too, a moment later.
  const auto noise = [&] {
    int unused = 0;
    const LaterSystem soon_after{beside(1.0 + kAtOnce).system, turned(axes.W, kAtOnce * tau)};
    return std::max(largest_difference(now, beside(kAtOnce), sizes, unused),
                    largest_difference(then, soon_after, sizes, unused));
  };
  if (change > kSameCoefficient && change <= kAbove * noise()) change = 0.0;
  if (change <= kSameCoefficient) {
    std::string coupled;
    change = std::max(change, largest_coupling_difference(now, beside(kAtOnce), there_now,
                                                          beside(1.0 + kAtOnce), sizes, coupled));
    if (change <= kSameCoefficient) return {};
    return fmt::format("what \"{}\" has to do with the motion changes along it, by {:.2g} % after {:.3g} s",
                       coupled, 100.0 * std::min(change, 1.0), tau);
  }
  return fmt::format(
      "the coefficients change along the motion, by {:.2g} % of their size after {:.3g} s, most those of "
      "\"{}\"",
      100.0 * std::min(change, 1.0), tau, name_of(now, where));
}

void Judge::describe_unsteady(const Drift& d, SteadyLinearisation& out) const {
  const bool by_offset = d.offset > kNear;
  const Eigen::Index k = by_offset ? d.offset_of : d.left_of,
                     n = static_cast<Eigen::Index>(by_offset ? own_.positions.size()
                                                             : own_.independent.size());
  const double rate = k >= n      ? c_rate_(own_.dynamic[k - n])
                      : by_offset ? v_dot_(own_.positions[k])
                                  : v_dot_(own_.independent[k]);
  // Where the state itself is at rest in what lies farthest from the equilibrium.
  double largest = 0.0;
  for (const int i : own_.independent) largest = std::max(largest, std::abs(v_dot_(i)));
  const std::string name = by_offset ? name_of(own_, k) : name_of_rate(own_, k);
  if (by_offset && std::abs(rate) <= 1e-9 * largest)
    out.why =
        fmt::format("the equilibrium beside it lies {:.2g} (m, rad) away, most in \"{}\"", d.offset, name);
  else
    out.why = fmt::format("\"{}\" changes by {:.3g} per second (SI units)", name, rate);
}

SteadyLinearisation Judge::judge_rest() {
  SteadyLinearisation out;
  out.system = own_;
  const Drift d = drift(own_, v_dot_, c_rate_);
  if (d.offset > kNear || d.left > kNear) {
    describe_unsteady(d, out);
    return out;
  }
  out.verdict = Verdict::equilibrium;
  if (d.offset > kExact)
    out.notes.push_back(fmt::format("the equilibrium lies {:.2g} (m, rad) away, most in \"{}\"", d.offset,
                                    name_of(own_, d.offset_of)));
  // Coefficients that are functions of time; loads and drives that are count with their present values.
  Tangents now(m_), then(m_);
  const VectorXd rest = VectorXd::Zero(n_.n_v);
  now.evaluate(s_, rest);
  VectorXd z(n_.n_v), c(n_.n_dyn), b(n_.n_alg), z_then(n_.n_v), c_then(n_.n_dyn), b_then(n_.n_alg);
  m_.momentum(s_, rest, *scratch_, z, c, b);
  const std::size_t n_notes = out.notes.size();
  for (const double part : {1e-3, 1e-2}) {
    State later = s_;
    later.t += part * horizon_;
    m_.momentum(later, rest, *scratch_, z_then, c_then, b_then);
    const double before = opening(s_);
    if (out.notes.size() == n_notes &&
        (z_then != z || c_then != c || b_then != b || opening(later) > before + 1e-12))
      out.notes.push_back(
          fmt::format("what is given as a function of time counts with its value at t = {:.6g} s", s_.t));
    then.evaluate(later, rest);
    const auto differs = [](const MatrixXd& x, const MatrixXd& y) {
      return (x - y).cwiseAbs().maxCoeff() > kSameCoefficient * x.cwiseAbs().maxCoeff();
    };
    if (n_.n_v > 0 && (differs(now.z_p, then.z_p) || differs(now.z_v, then.z_v) ||
                       (n_.n_dyn > 0 && differs(now.z_c, then.z_c)))) {
      out.verdict = Verdict::unsteady;
      out.why = fmt::format("the coefficients change with time, within {:.3g} s", later.t - s_.t);
      break;
    }
  }
  return out;
}

SteadyLinearisation Judge::judge_motion(bool accelerated) {
  SteadyLinearisation out;
  out.system = own_;
  std::vector<TurningAxes> all = candidate_axes(m_, s_, v_dot_, accelerations_, *scratch_);
  if (accelerated) all = {{MatrixXd::Zero(n_.n_v, n_.n_v), "", true}};
  double least = 2.0;
  for (const TurningAxes& axes : all) {
    if (!axes.accelerated) {
      const Drift d = drift(in_turning_axes(own_, axes.W), v_dot_ - axes.W * s_.v, c_rate_);
      if (d.offset > kNear || d.left > kNear) {
        if (least > 1.0 && out.why.empty()) describe_unsteady(d, out);
        continue;
      }
    }
    std::string why;
    double change = 0.0;
    for (const double tau : times()) {
      double one = 0.0;
      try {
        why = change_along(axes, tau, one);
      } catch (const std::runtime_error& failure) {
        why = failure.what();
        one = 1.0;
      }
      change = std::max(change, one);
      if (!why.empty()) break;
    }
    if (why.empty()) {
      out.verdict = Verdict::steady_motion;
      out.why.clear();
      out.tau = times().back();
      out.later = along(m_, {s_, v_dot_, c_rate_}, axes, out.tau);
      out.moved = turned(axes.W, out.tau);
      if (!axes.name.empty()) {
        out.axes = axes.name;
        out.W = axes.W;
        out.system = in_turning_axes(own_, axes.W);
      }
      return out;
    }
    if (change < least) {
      least = change;
      out.why = why;
    }
  }
  return out;
}

SteadyLinearisation Judge::judge() {
  if (!rests()) return judge_motion(false);
  SteadyLinearisation at_rest = judge_rest();
  if (at_rest.verdict == Verdict::equilibrium) return at_rest;
  // Free fall, and whatever else gathers speed where nothing depends on where it is and how fast.
  const Drift d = drift(own_, v_dot_, c_rate_);
  if (d.offset > kNear || d.left <= kNear) return at_rest;
  SteadyLinearisation falls = judge_motion(true);
  if (falls.verdict == Verdict::unsteady) return at_rest;
  falls.notes.push_back(
      fmt::format("\"{}\" gathers speed, {:.3g} per second, without a force that it would meet",
                  name_of_rate(own_, d.left_of), d.left));
  return falls;
}

}  // namespace

SteadyLinearisation linearise_steady(const Mechanism& mechanism, const State& s, double horizon,
                                     const LineariseOptions& options) {
  SteadyLinearisation out = Judge(mechanism, s, horizon, options).judge();
  out.system = without_unread(std::move(out.system));
  if (out.verdict != Verdict::unsteady)
    for (std::string& note : notes_on_switches(mechanism, s)) out.notes.push_back(std::move(note));
  return out;
}

}  // namespace flexura::mbs
