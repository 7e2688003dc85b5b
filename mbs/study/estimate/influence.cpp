// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/influence.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "mbs/formulas/motion_function.hpp"
#include "mbs/formulas/time_function.hpp"
#include "mbs/study/estimate/judged_outputs.hpp"

namespace flexura::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using Dependence = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

// Beside the largest of its kind less than this is round-off, or what no accuracy asks for.
constexpr double kNothing = 1e-9;
// Of typical sizes: how far states are drawn from the start, and a step of a difference.
constexpr double kDrawn = 0.05, kStep = 1e-4;

double drawn(Index i, int round, int kind) {
  return std::cos(1.7 * static_cast<double>(i) + 0.9 * round + 2.3 * kind + 0.3);
}

class Graph {
 public:
  Graph(FullModel& full, const std::vector<int>& outputs)
      : full_(full),
        n_(full.mechanism().sizes()),
        outputs_(outputs),
        moves_(Dependence::Constant(n_.n_v, n_.n_v, false)),
        shows_(Dependence::Constant(static_cast<Index>(outputs.size()), n_.n_v, false)) {
    std::vector<bool> modal(static_cast<std::size_t>(n_.n_v), false);
    for (const ModalBlock& block : full.blocks()) {
      std::vector<Index>& group = groups_.emplace_back();
      for (Index j = 0; j < block.m; ++j) {
        group.push_back(block.v + j);
        modal[static_cast<std::size_t>(group.back())] = true;
      }
    }
    for (Index j = 0; j < n_.n_v; ++j)
      if (!modal[static_cast<std::size_t>(j)]) groups_.push_back({j});
  }

  void look(const mbs::State& start, double t, int round) {
    const mbs::Mechanism& m = full_.mechanism();
    mbs::State s = start;
    s.t = t;
    VectorXd v_dot(n_.n_v), step(n_.n_v);
    for (Index i = 0; i < n_.n_v; ++i) {
      const double size = m.velocity_scale(static_cast<int>(i));
      step(i) = kDrawn * size * drawn(i, round, 0);
      s.v(i) = size * drawn(i, round, 1);
      v_dot(i) = size * drawn(i, round, 2);
    }
    for (Index k = 0; k < n_.n_lambda; ++k) s.lambda(k) = drawn(k, round, 3);
    m.retract(start.p, step, s.p);
    LinearisedRow row;
    full_.linearise(s, v_dot, row);
    add(s, v_dot, row);
  }

  // What acts on one of these may act on all of them.
  void join(const std::vector<Index>& coordinates) {
    for (const Index i : coordinates)
      for (const Index j : coordinates) moves_(i, j) = true;
  }

  // Coordinates that the quantity `which` sees by their positions.
  std::vector<Index> seen_by(Index output) const {
    std::vector<Index> out;
    for (Index j = 0; j < n_.n_v; ++j)
      if (shows_(output, j)) out.push_back(j);
    return out;
  }

  // Coordinates on which one of the first `count` outputs depends.
  std::vector<bool> reached(Index count) const {
    std::vector<bool> out(static_cast<std::size_t>(n_.n_v), false);
    std::vector<Index> next;
    const auto take = [&](Index j) {
      if (out[static_cast<std::size_t>(j)]) return;
      out[static_cast<std::size_t>(j)] = true;
      next.push_back(j);
    };
    for (Index j = 0; j < n_.n_v; ++j)
      if (shows_.col(j).head(count).any()) take(j);
    while (!next.empty()) {
      const Index i = next.back();
      next.pop_back();
      for (Index j = 0; j < n_.n_v; ++j)
        if (moves_(i, j)) take(j);
    }
    return out;
  }

 private:
  void take_all() {
    moves_.setConstant(true);
    shows_.setConstant(true);
  }

  void add(const mbs::State& s, const VectorXd& v_dot, const LinearisedRow& row) {
    const Index n = n_.n_v, l = n_.n_lambda;
    // Ways through states (a motor's that lags behind its command) are not told apart.
    if (!row.C_p.isZero(0.0) || !row.C_v.isZero(0.0)) {
      take_all();
      return;
    }
    // Of unit masses and unit rows.
    const VectorXd scale = row.M.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    MatrixXd S = MatrixXd::Zero(n + l, n + l);
    S.topLeftCorner(n, n) = scale.asDiagonal() * row.M * scale.asDiagonal();
    if (l > 0) {
      MatrixXd G = row.G * scale.asDiagonal();
      for (Index k = 0; k < l; ++k)
        if (const double size = G.row(k).norm(); size > 0.0) G.row(k) /= size;
      S.bottomLeftCorner(l, n) = G;
      S.topRightCorner(n, l) = G.transpose();
      S.bottomRightCorner(l, l).diagonal().setConstant(-1e-12);
    }
    const Eigen::PartialPivLU<MatrixXd> lu(S);
    Dependence to_rates = Dependence::Constant(n + l, n, false);
    for (const MatrixXd* of : {&row.K, &row.D}) {
      MatrixXd loads = MatrixXd::Zero(n + l, n);
      loads.topRows(n) = scale.asDiagonal() * *of;
      for (Index j = 0; j < n; ++j)
        if (const double size = loads.col(j).norm(); size > 0.0) loads.col(j) /= size;
      const MatrixXd X = lu.solve(loads);
      if (!X.allFinite()) {
        take_all();
        return;
      }
      to_rates = to_rates || X.array().abs() > kNothing;
    }
    moves_ = moves_ || to_rates.topRows(n);
    differences(s, v_dot, to_rates);
  }

  // What the outputs see, by differences.  Deformations of one body are moved together: who sees one is taken to see all.
  void differences(const mbs::State& s, const VectorXd& v_dot, const Dependence& to_rates) {
    const mbs::Mechanism& m = full_.mechanism();
    const Index n = n_.n_v, l = n_.n_lambda, count = shows_.rows();
    const auto n_groups = static_cast<Index>(groups_.size());
    VectorXd plus, minus;
    std::array<MatrixXd, 4> d;
    for (MatrixXd& part : d) part.setZero(count, n_groups);
    d[3].setZero(count, l);
    const auto difference = [&](MatrixXd& out, Index j, const mbs::State& up, const VectorXd& a_up,
                                const mbs::State& down, const VectorXd& a_down) {
      full_.evaluate(outputs_, up, a_up, plus);
      full_.evaluate(outputs_, down, a_down, minus);
      out.col(j) = plus - minus;
      for (Index i = 0; i < count; ++i)
        if (!(std::abs(out(i, j)) > 1e-13 * (std::abs(plus(i)) + std::abs(minus(i))))) out(i, j) = 0.0;
    };
    mbs::State up = s, down = s;
    VectorXd step(n);
    for (Index g = 0; g < n_groups; ++g) {
      step.setZero();
      for (const Index j : groups_[static_cast<std::size_t>(g)])
        step(j) = kStep * m.velocity_scale(static_cast<int>(j)) * (1.0 + 0.5 * drawn(j, 0, 4));
      m.retract(s.p, step, up.p);
      m.retract(s.p, -step, down.p);
      difference(d[0], g, up, v_dot, down, v_dot);
      up.p = down.p = s.p;
      up.v += step;
      down.v -= step;
      difference(d[1], g, up, v_dot, down, v_dot);
      up.v = down.v = s.v;
      difference(d[2], g, s, v_dot + step, s, v_dot - step);
    }
    for (Index k = 0; k < l; ++k) {
      up.lambda(k) += kStep;
      down.lambda(k) -= kStep;
      difference(d[3], k, up, v_dot, down, v_dot);
      up.lambda(k) = down.lambda(k) = s.lambda(k);
    }
    for (Index i = 0; i < count; ++i) {
      const auto is_seen = [&](int kind, Index k) {
        return std::abs(d[kind](i, k)) > kNothing * d[kind].row(i).cwiseAbs().maxCoeff();
      };
      for (Index g = 0; g < n_groups; ++g)
        for (const Index j : groups_[static_cast<std::size_t>(g)]) {
          shows_(i, j) = shows_(i, j) || is_seen(0, g) || is_seen(1, g);
          if (is_seen(2, g)) shows_.row(i) = shows_.row(i) || to_rates.row(j);
        }
      for (Index k = 0; k < l; ++k)
        if (is_seen(3, k)) shows_.row(i) = shows_.row(i) || to_rates.row(n + k);
    }
  }

  FullModel& full_;
  mbs::Sizes n_;
  const std::vector<int>& outputs_;
  Dependence moves_;                        // moves_(i, j): i depends on j
  std::vector<std::vector<Index>> groups_;  // coordinates that differences move together
  Dependence shows_;                        // shows_(i, j): output i on j
};

// Beside the outputs the places of bodies between which something may come to act; nothing where that is not known.
std::optional<std::vector<std::vector<int>>> places_of_switches(const mbs::Mechanism& m) {
  const auto infos = m.quantities();
  std::vector<std::vector<int>> out;
  for (const auto& force : m.description().forces) {
    if (force->n_switches() == 0) continue;
    const auto [from, to] = force->markers();
    if (from < 0 || to < 0) return std::nullopt;
    std::vector<int> places;
    for (const int marker : {from, to}) {
      const int body = m.description().markers[static_cast<std::size_t>(marker)].body;
      const std::string name = m.description().bodies[static_cast<std::size_t>(body)].name;
      for (std::size_t i = 0; i < infos.size(); ++i)
        if (infos[i].name.starts_with(name + ".position_")) places.push_back(static_cast<int>(i));
    }
    out.push_back(std::move(places));
  }
  return out;
}

// A measure by a formula that can be level where its bodies are at first (max(sway - 1 mm, 0), "sway > 0 ? ...", a table), which what only
// the results show is not watched for.
bool can_be_level(const mbs::Mechanism& m) {
  return std::ranges::any_of(m.description().measures, [](const auto& measure) {
    const mbs::Expression* const formula = measure->formula();
    return formula && mbs::MotionFunction::may_peak(formula->tree());
  });
}

// Where each function of time that is no drive is greatest and least: a factor step(t, ...) or "t > 1 ? ... : 0" before a deflection
// begins to act after the start.  The half is taken whose bounds go further, the earlier of equal ones; none where there are too many.
std::optional<std::vector<double>> times_at_work(const mbs::Mechanism& m, double begin, double end) {
  constexpr std::size_t kMost = 12;
  constexpr int kHalvings = 40;
  std::vector<double> out = {begin +
                             0.37 * (end - begin)};  // of factors of measures that only the results show
  for (const auto& f : m.functions_of_time()) {
    if (f->drives()) continue;
    for (const double sign : {1.0, -1.0}) {
      const auto reach = [&](double a, double b) {
        const auto value = f->over(a, b).value;
        return sign > 0.0 ? value.hi : -value.lo;
      };
      double a = begin, b = end;
      for (int i = 0; i < kHalvings; ++i) {
        const double middle = 0.5 * (a + b);
        (reach(a, middle) >= reach(middle, b) ? b : a) = middle;
      }
      // Behind the place, where a jump has been.
      const double t = b;
      if (std::ranges::none_of(out,
                               [&](double other) { return std::abs(t - other) <= 1e-6 * (end - begin); }))
        out.push_back(t);
      if (out.size() > kMost) return std::nullopt;
    }
  }
  return out;
}

}  // namespace

std::set<std::string> bodies_of_influence(FullModel& full, const mbs::State& start,
                                          const std::vector<int>& outputs, double end) {
  const mbs::Mechanism& m = full.mechanism();
  std::set<std::string> all;
  for (const ModalBlock& block : full.blocks()) all.insert(block.name);
  const auto places = places_of_switches(m);
  bool has_conditions = !m.description().controls.empty();
  for (int i = 0; i < m.sizes().n_root; ++i) has_conditions = has_conditions || m.is_condition(i);
  // So can a spring with play be, by its curve, and other formulas of the motion.
  if (has_conditions || !m.functions_of_motion().empty() || can_be_level(m) || !places || outputs.empty())
    return all;
  const auto times = times_at_work(m, start.t, end);
  if (!times) return all;

  std::vector<int> seen = outputs;
  for (const auto& some : *places) seen.insert(seen.end(), some.begin(), some.end());
  Graph graph(full, seen);
  for (const int round : {0, 1}) graph.look(start, start.t, round);
  for (const double t : *times) graph.look(start, t, 0);
  Index next = static_cast<Index>(outputs.size());
  for (std::size_t k = 0; k < places->size(); ++k) {
    std::vector<Index> touched;
    for (std::size_t i = 0; i < (*places)[k].size(); ++i, ++next)
      for (const Index j : graph.seen_by(next)) touched.push_back(j);
    // The deformations of the two bodies themselves.
    for (const auto& force : m.description().forces) {
      if (force->n_switches() == 0) continue;
      const auto [from, to] = force->markers();
      for (const ModalBlock& block : full.blocks())
        for (const int marker : {from, to})
          if (m.description().markers[static_cast<std::size_t>(marker)].body == block.body)
            for (Index j = 0; j < block.m; ++j) touched.push_back(block.v + j);
    }
    graph.join(touched);
  }
  const std::vector<bool> reached = graph.reached(static_cast<Index>(outputs.size()));
  std::set<std::string> out;
  for (const ModalBlock& block : full.blocks())
    for (Index j = 0; j < block.m; ++j)
      if (reached[static_cast<std::size_t>(block.v + j)]) out.insert(block.name);
  return out;
}

std::set<std::string> bodies_without_influence(const mbs::PreparedMechanism& run,
                                               std::set<std::string> bodies) {
  constexpr int kModesThatTell = 6;
  if (bodies.empty() || run.file.outputs.empty()) return {};
  const auto few =
      FullModel::make(run, {.stiffened = {}, .rigid = {}, .modes = kModesThatTell, .own_frames = true});
  if (!few) return {};
  std::vector<OutputEstimate> unused;
  for (const std::string& body : bodies_of_influence(
           *few, few->state_of(run), judged_outputs(run, few->mechanism(), unused), run.options.end_time))
    bodies.erase(body);
  return bodies;
}

}  // namespace flexura::study
