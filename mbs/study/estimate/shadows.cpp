// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/shadows.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <tuple>

#include "mbs/solver/integrators/known_times.hpp"
#include "mbs/study/estimate/beyond_first_order.hpp"
#include "mbs/study/estimate/deformation_error.hpp"
#include "mbs/study/estimate/influence.hpp"
#include "mbs/study/estimate/recovered_outputs.hpp"
#include "mbs/study/estimate/step_looks.hpp"

namespace flexura::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Shadows::Impl {
  Impl(const mbs::PreparedMechanism& run, FullModel& full_model, const HeldRows::Span& span,
       double most_compared)
      : full(full_model),
        embedding(*run.mechanism, full_model),
        asked(!run.file.outputs.empty()),
        starts_quasi_static(run.options.quasi_static_start),
        tolerance(tolerance_of_noise(run)),
        families(full_model.mechanism(), length_of(run)),
        every(rows_between(run)),
        compared(std::max(
            1L, static_cast<long>((run.options.end_time - run.options.start_time) / run.options.output_step /
                                  static_cast<double>(every) / most_compared))),
        step_looks(run.options.end_time - run.options.start_time),
        linearised(full_model, span) {}

  FullModel& full;
  std::unique_ptr<FullModel> own;  // where the shadows made it themselves
  Embedding embedding;
  std::vector<std::size_t> sources;  // blocks with dropped deformations
  std::unique_ptr<LinearCorrection> correction;
  std::unique_ptr<BeyondFirstOrder> beyond;
  Transients transients;
  std::unique_ptr<mbs::KnownTimes> known;  // while there are any
  bool jumped = false;
  std::vector<int> outputs;
  std::vector<OutputEstimate> sums;
  std::optional<RecoveredOutputs> recovered;
  MatrixXd source_sums, last_source;  // outputs x sources: integral of the error squared
  VectorXd square, square_size, last_square, last_size;
  VectorXd next_square, last_next, y_first;  // what the next order changes
  bool tells_next_order = false;
  bool asked = false, starts_quasi_static = false;  // asked: the user named the outputs
  double tolerance;
  Families families;
  bool joints_feel_nothing = false;
  long every = 1, compared = 1, rows = 0, even_rows = 0, taken = 0;
  long for_families = 1;  // one of so many even rows tells how large forces and motions are
  double t_compared = 0.0;
  double wall = 0.0, t = 0.0, span = 0.0;
  double missed = 0.0, rows_apart = 0.0;
  std::vector<double> look_at;
  StepLooks step_looks;

  mbs::State s, moved;
  VectorXd v_dot, r, y, y_moved;
  HeldRows linearised;

  MatrixXd next_order;                                    // n_v x sources: loads
  std::vector<std::pair<std::size_t, double>> stiffness;  // blocks, and the part by which they are too stiff
  MatrixXd stiffness_squares, last_stiffness;             // outputs x those: integral of the error squared
  MatrixXd stiffness_loads() const;
  MatrixXd loads() const;
  bool jumps_before(double t);
  void look_behind_start(double start, double end);
  void list_transients();
  bool follow(const mbs::State& at, const VectorXd& v_dot_at, bool is_row);
  void take_next_order(const MatrixXd& load);
  void compare(const mbs::State& at, const VectorXd& v_dot_at, double h);
};

// The residual, split by the body it acts on.
MatrixXd Shadows::Impl::loads() const {
  MatrixXd load = MatrixXd::Zero(r.size(), static_cast<Index>(sources.size()));
  VectorXd rest = joints_feel_nothing ? VectorXd(-r) : VectorXd::Zero(r.size());
  for (const ModalBlock& block : full.blocks()) rest.segment(block.v, block.m).setZero();
  for (std::size_t k = 0; k < sources.size(); ++k) {
    const ModalBlock& block = full.blocks()[sources[k]];
    load.col(static_cast<Index>(k)).segment(block.v, block.m) = -r.segment(block.v, block.m);
    // What the joints do not feel of one-way bodies cannot be told apart.
    if (k == 0) load.col(0) += rest;
  }
  return load;
}

// Whether a load that is known beforehand jumps or has a kink between the last row and this one.
bool Shadows::Impl::jumps_before(double now) {
  bool any = false;
  for (double at = t; known;) {
    const mbs::KnownTimes::Stop stop = known->next(at);
    if (!(stop.t < now)) break;
    any = any || stop.is_event;
    if (stop.is_event) known->pass(stop);
    const double next = stop.is_event ? stop.after : stop.t;
    if (!(next > at)) break;
    at = next;
  }
  return any;
}

MatrixXd Shadows::Impl::stiffness_loads() const {
  MatrixXd out = MatrixXd::Zero(r.size(), static_cast<Index>(stiffness.size()));
  for (std::size_t k = 0; k < stiffness.size(); ++k) {
    const ModalBlock& block = full.blocks()[stiffness[k].first];
    const mbs::ModalData& data =
        *full.mechanism().description().bodies[static_cast<std::size_t>(block.body)].flexible->modal();
    out.col(static_cast<Index>(k)).segment(block.v, block.m) =
        stiffness[k].second * data.stiffness.cwiseProduct(s.p.segment(block.p, block.m));
  }
  return out;
}

// What the first order leaves of the equations at the state that it moves the run to.  It drives the correction from the next
// row on.
void Shadows::Impl::take_next_order(const MatrixXd& load) {
  beyond->begin(s, v_dot, *linearised.row());
  for (Index k = 0; k < load.cols(); ++k) {
    const auto part = [&](const MatrixXd& columns) { return VectorXd(columns.col(k)); };
    const FullModel::Correction by{part(correction->delta()), part(correction->rate()),
                                   part(correction->dlambda()), part(correction->states())};
    full.move(s, *linearised.row(), by, moved);
    next_order.col(k) =
        -beyond->take(static_cast<std::size_t>(k), by, part(correction->acceleration()), moved, load.col(k));
  }
}

void Shadows::Impl::compare(const mbs::State& at, const VectorXd& v_dot_at, double h) {
  full.evaluate(outputs, s, v_dot, y);
  VectorXd follows = recovered->beyond(at, v_dot_at, y);
  // The shadows begin undeformed, whatever the run does.
  if (taken == 0 && starts_quasi_static) follows.setZero();
  const Index n = y.size(), n_sources = static_cast<Index>(sources.size());
  VectorXd now_square(n), now_size(n);
  MatrixXd now_source = MatrixXd::Zero(n, n_sources);
  // Each source alone, then all together (which is the same where there is one).
  for (Index k = n_sources > 1 ? 0 : n_sources; k <= n_sources; ++k) {
    const bool all = k == n_sources;
    const auto part = [&](const MatrixXd& columns) {
      return all ? VectorXd(columns.leftCols(2 * n_sources).rowwise().sum())
                 : VectorXd(columns.col(k) + columns.col(n_sources + k));
    };
    const FullModel::Correction by{part(correction->delta()), part(correction->rate()),
                                   part(correction->dlambda()), part(correction->states())};
    full.move(s, *linearised.row(), by, moved);
    full.evaluate(outputs, moved, v_dot + part(correction->acceleration()), y_moved);
    if (all && tells_next_order) {
      const auto first = [&](const MatrixXd& columns) {
        return VectorXd(columns.leftCols(n_sources).rowwise().sum());
      };
      full.move(s, *linearised.row(),
                {first(correction->delta()), first(correction->rate()), first(correction->dlambda()),
                 first(correction->states())},
                moved);
      full.evaluate(outputs, moved, v_dot + first(correction->acceleration()), y_first);
      const VectorXd now = (y_moved - y_first).cwiseAbs2();
      next_square += 0.5 * h * (now + last_next);
      last_next = now;
    }
    if (all) continue;
    const std::string& body = full.blocks()[sources[static_cast<std::size_t>(k)]].name;
    for (Index i = 0; i < n; ++i) {
      const bool is_own = recovered->owner(i) == body;
      const double error = y_moved(i) - y(i) - (is_own ? follows(i) : 0.0);
      now_source(i, k) = error * error;
    }
  }
  VectorXd y_stiff;
  MatrixXd now_stiffness(n, static_cast<Index>(stiffness.size()));
  for (Index k = 0; k < now_stiffness.cols(); ++k) {
    const auto part = [&](const MatrixXd& columns) { return VectorXd(columns.col(2 * n_sources + k)); };
    full.move(s, *linearised.row(),
              {part(correction->delta()), part(correction->rate()), part(correction->dlambda()),
               part(correction->states())},
              moved);
    full.evaluate(outputs, moved, v_dot + part(correction->acceleration()), y_stiff);
    now_stiffness.col(k) = (y_stiff - y).cwiseAbs2();
  }
  stiffness_squares += 0.5 * h * (now_stiffness + last_stiffness);
  last_stiffness = now_stiffness;
  for (Index i = 0; i < n; ++i) {
    OutputEstimate& sum = sums[static_cast<std::size_t>(i)];
    const double error = std::abs(y_moved(i) - y(i) - follows(i));
    sum.max = std::max(sum.max, error);
    sum.size_max = std::max(sum.size_max, std::abs(y_moved(i)));
    sum.final = error;
    now_square(i) = error * error;
    now_size(i) = y_moved(i) * y_moved(i);
  }
  if (n_sources == 1) now_source.col(0) = now_square;
  if (h > 0.0) {
    square += 0.5 * h * (now_square + last_square);
    square_size += 0.5 * h * (now_size + last_size);
    source_sums += 0.5 * h * (now_source + last_source);
    span += h;
  }
  last_square = now_square;
  last_size = now_size;
  last_source = now_source;
}

Shadows::Shadows(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Shadows::~Shadows() = default;

std::unique_ptr<Shadows> Shadows::make(const mbs::PreparedMechanism& run) {
  std::vector<std::string> stiffened;
  for (const mbs::BodyDescription& body : run.mechanism->description().bodies)
    if (body.is_reduced() && has_stiffening_terms(body)) stiffened.push_back(body.name);
  // What stays rigid and has no part in the outputs has none in their errors.
  std::set<std::string> rigid;
  const auto& bodies = run.mechanism->description().bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (can_deform(bodies[b]) && !run.mechanism->deforming(static_cast<int>(b))) rigid.insert(bodies[b].name);
  if (rigid.size() > 1)
    rigid = bodies_without_influence(run, std::move(rigid));
  else
    rigid.clear();
  std::unique_ptr<FullModel> full =
      FullModel::make(run, {.stiffened = stiffened, .rigid = rigid, .own_frames = true});
  if (!full) return nullptr;
  auto shadows = make(run, *full);
  if (shadows) shadows->impl_->own = std::move(full);
  return shadows;
}

std::unique_ptr<Shadows> Shadows::make(const mbs::PreparedMechanism& run, FullModel& full,
                                       const HeldRows::Span& span, double most_compared) {
  auto impl = std::make_unique<Impl>(run, full, span, most_compared);
  Impl& in = *impl;
  for (std::size_t i = 0; i < full.blocks().size(); ++i) {
    in.joints_feel_nothing = in.joints_feel_nothing || in.embedding.one_way(i);
    const bool complete = in.embedding.complete(i);
    if (!complete) in.sources.push_back(i);
    if (in.embedding.deformations(i).cols() == 0 || in.embedding.one_way(i)) continue;
    const double error = known_error(deformation_error(
        full.mechanism().description().bodies[static_cast<std::size_t>(full.blocks()[i].body)]));
    if (error > 0.0) in.stiffness.emplace_back(i, error);
  }
  // Of a run with all modes the estimate would cost more than it tells, unless its verdict counts.
  if (in.sources.empty() && run.file.solver.quantity("accuracy") == 0.0) in.stiffness.clear();
  if (in.sources.empty() && in.stiffness.empty()) return nullptr;
  in.outputs = judged_outputs(run, full.mechanism(), in.sums);
  in.recovered.emplace(*run.mechanism, in.sums);
  // What they cost grows with the third power of the coordinates.
  constexpr double kMostLooks = 4000.0, kLeastLooks = 400.0, kWork = 1.5e9;
  const auto most_looks = static_cast<std::size_t>(
      std::clamp(kWork / std::pow(full.mechanism().sizes().n_v, 3.0), kLeastLooks, kMostLooks));
  in.rows_apart = static_cast<double>(in.every) * run.options.output_step;
  constexpr double kRowsForFamilies = 100.0;
  in.for_families = std::max(1L, static_cast<long>((run.options.end_time - run.options.start_time) /
                                                   in.rows_apart / kRowsForFamilies));
  mbs::KnownTimes::Looks looks =
      mbs::KnownTimes::looks(*run.mechanism, run.options, in.rows_apart, most_looks);
  in.look_at = std::move(looks.t);
  in.look_behind_start(run.state.t, run.options.end_time);
  const Index n_out = static_cast<Index>(in.outputs.size()),
              n_sources = static_cast<Index>(in.sources.size());
  in.square = in.square_size = in.last_square = in.last_size = in.next_square = in.last_next =
      VectorXd::Zero(n_out);
  in.tells_next_order = std::isfinite(most_compared);
  in.source_sums = in.last_source = MatrixXd::Zero(n_out, n_sources);
  in.known = std::make_unique<mbs::KnownTimes>(*run.mechanism, run.options);
  in.correction = std::make_unique<LinearCorrection>(full.mechanism().sizes().n_v,
                                                     2 * n_sources + static_cast<Index>(in.stiffness.size()));
  in.stiffness_squares = in.last_stiffness = MatrixXd::Zero(n_out, static_cast<Index>(in.stiffness.size()));
  in.next_order = MatrixXd::Zero(full.mechanism().sizes().n_v, n_sources);
  in.beyond = std::make_unique<BeyondFirstOrder>(full, in.sources.size());
  std::unique_ptr<Shadows> shadows(new Shadows(std::move(impl)));
  if (!looks.is_all) shadows->take_rows_alone(run);
  return shadows;
}

// The run may set off with a jerk, loads that act at once on bodies at rest: what is left out begins to ring, faster than the rows show.
void Shadows::Impl::look_behind_start(double start, double end) {
  constexpr int kRows = 4, kLooks = 8;  // so many rows, so many looks to each
  std::vector<double> both, first;
  for (int i = 1; i < kRows * kLooks; ++i)
    if (const double at = start + rows_apart * i / kLooks; i % kLooks != 0 && at < end) first.push_back(at);
  std::ranges::merge(look_at, first, std::back_inserter(both));
  look_at = std::move(both);
}

// What may ring: the row's own vibrations, or else those of the free bodies.
void Shadows::Impl::list_transients() {
  if (transients.add(*linearised.row(), linearised.G())) return;
  for (const std::size_t i : sources) {
    const mbs::ModalData& data = *full.mechanism()
                                      .description()
                                      .bodies[static_cast<std::size_t>(full.blocks()[i].body)]
                                      .flexible->modal();
    transients.add(data.stiffness, data.damping);
  }
}

bool Shadows::Impl::follow(const mbs::State& at, const VectorXd& v_dot_at, bool is_row) {
  const auto start = std::chrono::steady_clock::now();
  const double h = taken > 0 ? at.t - t : 0.0;
  if (taken > 0 && !(h > 0.0)) return false;
  embedding.embed(at, v_dot_at, s, v_dot);
  linearised.take(s, v_dot, h);
  full.residual(s, v_dot, r);
  if (taken == 0) list_transients();
  jumped = taken > 0 && jumps_before(at.t);
  if (jumped) transients.begin();
  const MatrixXd load = loads();
  MatrixXd all(load.rows(), correction->delta().cols());
  all << load, next_order, stiffness_loads();
  correction->step(h, *linearised.row(), linearised.G(), all, &transients, jumped);
  take_next_order(load);
  if (taken % compared == 0) {
    compare(at, v_dot_at, taken > 0 ? at.t - t_compared : 0.0);
    t_compared = at.t;
  }
  // Sizes are means over rows, which lie evenly.
  if (is_row && even_rows++ % for_families == 0) families.take(s, v_dot);
  t = at.t;
  ++taken;
  wall += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return true;
}

void Shadows::ask_for_looks(mbs::RunCallbacks& callbacks,
                            std::function<void(const mbs::State&, const VectorXd&)> look) {
  callbacks.look = std::move(look);
  callbacks.look_at = impl_->look_at;
  callbacks.wants_look = [this](double begin, double end) {
    return end - begin < 0.5 * impl_->rows_apart && impl_->step_looks.wants(begin, end);
  };
}

void Shadows::take_rows_alone(const mbs::PreparedMechanism& run) {
  // A pulse is seen where two rows lie in it.
  impl_->missed = mbs::KnownTimes::shortest(*run.mechanism, run.options, 2.0 * impl_->rows_apart);
}

bool Shadows::take(const mbs::State& s, const VectorXd& v_dot) {
  if (impl_->rows++ % impl_->every != 0) return false;
  return impl_->follow(s, v_dot, true);
}

bool Shadows::look(const mbs::State& s, const VectorXd& v_dot) {
  return impl_->follow(s, v_dot, false);
}

std::size_t Shadows::rows_compared() const {
  return static_cast<std::size_t>(impl_->compared);
}
const std::vector<int>& Shadows::outputs() const {
  return impl_->outputs;
}
double Shadows::next_order_error() const {
  const Impl& in = *impl_;
  return in.tells_next_order && in.span > 0.0
             ? worst_output(in.next_square, in.span, estimate().outputs).first
             : 0.0;
}
const VectorXd& Shadows::squares() const {
  return impl_->square;
}
const mbs::State& Shadows::embedded() const {
  return impl_->s;
}
const VectorXd& Shadows::embedded_v_dot() const {
  return impl_->v_dot;
}
const VectorXd& Shadows::residual() const {
  return impl_->r;
}
bool Shadows::jumped() const {
  return impl_->jumped;
}
const HeldRows& Shadows::linearised() const {
  return impl_->linearised;
}
mbs::State Shadows::corrected(VectorXd& v_dot) const {
  v_dot = impl_->v_dot + impl_->correction->acceleration()
                             .leftCols(2 * static_cast<Index>(impl_->sources.size()))
                             .rowwise()
                             .sum();
  mbs::State out;
  const LinearCorrection& by = *impl_->correction;
  const auto sum = [&](const MatrixXd& columns) {
    return VectorXd(columns.leftCols(2 * static_cast<Index>(impl_->sources.size())).rowwise().sum());
  };
  impl_->full.move(impl_->s, *impl_->linearised.row(),
                   {sum(by.delta()), sum(by.rate()), sum(by.dlambda()), sum(by.states())}, out);
  return out;
}
const VectorXd& Shadows::corrected_outputs() const {
  return impl_->y_moved;
}

TruncationEstimate Shadows::estimate() const {
  const Impl& in = *impl_;
  TruncationEstimate out;
  out.wall = in.wall;
  out.missed = in.missed;
  out.followed_roughly = in.full.followed_roughly();
  out.rows_apart = in.missed > 0.0 ? in.rows_apart : 0.0;
  out.outputs = in.sums;
  const double span = std::max(in.span, 1e-300);
  for (std::size_t i = 0; i < out.outputs.size(); ++i) {
    OutputEstimate& o = out.outputs[i];
    o.rms = std::sqrt(in.square(static_cast<Index>(i)) / span);
    o.size_rms = std::sqrt(in.square_size(static_cast<Index>(i)) / span);
  }
  set_rests(in.full.mechanism(), in.beyond->rests(), out.outputs);
  in.families.judge(out.outputs, in.asked, in.tolerance, Families::Of::deformation);
  std::tie(out.error, out.worst) = worst_output(in.square, span, out.outputs);
  for (std::size_t k = 0; k < in.stiffness.size(); ++k) {
    const auto [error, which] =
        worst_output(in.stiffness_squares.col(static_cast<Index>(k)), span, out.outputs);
    out.by_stiffness.push_back({in.full.blocks()[in.stiffness[k].first].name, error,
                                which >= 0 ? out.outputs[static_cast<std::size_t>(which)].name : ""});
  }
  for (std::size_t k = 0; k < in.sources.size(); ++k) {
    const ModalBlock& block = in.full.blocks()[in.sources[k]];
    SourceEstimate source;
    source.body = block.name;
    source.available = static_cast<int>(block.m);
    source.kept = static_cast<int>(in.embedding.deformations(in.sources[k]).cols());
    out.shadows += source.available - source.kept;
    const auto [error, which] = worst_output(in.source_sums.col(static_cast<Index>(k)), span, out.outputs);
    source.error = error;
    if (which >= 0) source.output = out.outputs[static_cast<std::size_t>(which)].name;
    source.beyond = in.beyond->why(k);
    out.by_body.push_back(std::move(source));
  }
  std::ranges::stable_sort(out.by_body, std::ranges::greater(), &SourceEstimate::error);
  return out;
}

}  // namespace flexura::study
