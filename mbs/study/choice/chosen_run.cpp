// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/study/choice/chooser.hpp"
#include "mbs/study/estimate/global_error.hpp"
#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {
namespace {

using Eigen::VectorXd;
using terminal::number;

// A run stops where the error of its modes has used up this part of the accuracy: the integrator has a part of it, too, and an
// estimate to first order told 9.8 % where 12 % were true (a rocker with four of its modes).
constexpr double kStop = 0.7;
// It goes on from where the error had used up this part of the accuracy (of the squares' integral).
constexpr double kLastGood = 0.25 * kStop * kStop;
constexpr int kMostRestarts = 6;
// The outputs' sizes may grow behind the part of the run that a screening has seen that ended early.
constexpr double kOfUnsureSizes = 0.85;
constexpr double kEarly = 0.25;  // of the run
constexpr double kSoon = 0.5;    // of the run
// The energy book of a run that was restarted: as if it had not been.
mbs::EnergyAccount continued(mbs::EnergyAccount now, const mbs::EnergyAccount& before) {
  now.start -= before.work_in - before.dissipated + before.error();
  now.work_in += before.work_in;
  now.dissipated += before.dissipated;
  now.gross_work += before.gross_work;
  now.peak = std::max(now.peak, before.peak);
  return now;
}

void add(mbs::StepCounts& counts, const mbs::StepCounts& more) {
  counts.steps += more.steps;
  counts.evaluations += more.evaluations;
  counts.jacobians += more.jacobians;
  counts.error_failures += more.error_failures;
  counts.newton_failures += more.newton_failures;
  counts.restarts += more.restarts;
  counts.singular_crossings += more.singular_crossings;
}

}  // namespace

// The shadows' model of the choice: beams that are exact are as they are.
void Chooser::make_full(const mbs::PreparedMechanism& screened, const std::vector<std::string>& stiffened) {
  full_ = FullModel::make(screened, {.stiffened = stiffened,
                                     .rigid = without_influence_,
                                     .as_given = exact(),
                                     .besides = choice_of_exact(),
                                     .own_frames = true});
  if (full_ && !exact().empty()) take_sizes(screened);
}

// Outputs of the present full model, as large as they were in the one before.
void Chooser::take_sizes(const mbs::PreparedMechanism& run) {
  std::vector<OutputEstimate> outputs;
  judged_outputs(run, full_->mechanism(), outputs);
  for (OutputEstimate& o : outputs) {
    const auto known = std::ranges::find(sizes_.outputs, o.name, &OutputEstimate::name);
    o.counts = known != sizes_.outputs.end() && known->counts;
    if (!o.counts) continue;
    o.scale = known->scale;
    o.size_rms = known->size_rms;
  }
  sizes_.outputs = std::move(outputs);
}

// One run with the present choices, and on with more where its shadows say so.
ChosenRun Chooser::simulate(const mbs::PreparedMechanism& screened) {
  screening_.reset();
  const std::vector<std::string> stiffened = judged_with_stiffening();
  if (!stiffened.empty() || !exact().empty()) make_full(screened, stiffened);
  ChosenRun out{prepared(), {}, {}, {}, false, {}, {}, {}, {}, 0, 0.0, 0.0};
  const double start_time = out.prepared.options.start_time;
  mbs::State state = out.prepared.state;
  VectorXd v_dot = out.prepared.v_dot;
  Good start;
  mbs::StepCounts steps_before;
  double wall_before = 0.0;
  for (int attempt = 0;; ++attempt) {
    Good good;
    const std::vector<std::string> worst =
        run_until_over(out, state, v_dot, start, good, attempt < kMostRestarts);
    add(out.result.counts, steps_before);
    if (integrator_spent_ > 0.0 || has_to_run_finer(out)) {
      if (integrator_spent_ > 0.0) restarts_.push_back(given_up_by_integrator(out));
      start = {};
      go_on(out, start, state, v_dot);
      steps_before = out.result.counts;
      wall_before += out.result.wall_time;
      continue;
    }
    if (worst.empty()) break;
    std::vector<std::string> was, is;
    bool is_beyond_range = false;
    for (const std::string& body : worst) {
      BodyChoice& choice = choices_.at(body);
      refined_.insert(body);
      was.push_back(choice.what(body));
      if (beyond_range_.contains(body))
        choice.make_exact("it left the range in which its deformation is linear");
      else
        choice.refine();
      is_beyond_range = is_beyond_range || choice.exact;
      is.push_back(choice.what(body));
    }
    const double t_stopped = out.result.state.t;
    // What a run has lost that goes on is not known to its end; one that has just begun is cheap to begin anew, or that would go
    // on from its beginning.
    const bool begins_anew =
        is_beyond_range ||
        (!start.is_there && (t_stopped - start_time < kSoon * span_ ||
                             (good.is_there && good.state.t - start_time < kEarly * span_)));
    if (is_beyond_range) {
      start = {};
      make_full(screened, judged_with_stiffening());
    }
    if (good.is_there && !begins_anew) start = std::move(good);
    // The part before is judged no more.
    if (start.is_there && tolerance_) tolerance_->take_safe_one();
    go_on(out, start, state, v_dot);
    restarts_.push_back(fmt::format(
        "{} {} at t = {} s; {} as {}", fmt::join(was, "; "),
        is_beyond_range ? "left its linear range" : "had used up the accuracy", number(t_stopped, 3),
        start.is_there ? fmt::format("gone on from t = {} s", number(state.t, 3)) : "begun anew",
        fmt::join(is, "; ")));
    steps_before = out.result.counts;
    wall_before += out.result.wall_time;
  }
  out.prepared.options.start_time = start_time;
  if (!out.rows.empty()) out.result.energy = out.rows.back().energy;
  out.result.wall_time += wall_before;
  return out;
}

// Beams that are chosen run again with twice the elements as long as these cost more than their share.
void Chooser::refine_beams(ChosenRun& out) {
  constexpr int kMostDoublings = 5;
  if (accuracy_of(as_given_) <= 0.0 || !tells_integrator_) return;
  ElementsCheck::KnownRuns known;
  for (int doublings = 0; out.result.complete; ++doublings) {
    const auto check = ElementsCheck::make(out.prepared, &known);
    if (!check) return;
    for (const RowOfRun& row : out.rows) check->take(row.state, row.v_dot);
    out.elements = check->estimate(callbacks_, out.result.wall_time,
                                   out.integrator && out.integrator->is_whole ? out.integrator->error : 0.0);
    if ((out.elements->is_whole && out.elements->error <= kShareOfModes * accuracy_) ||
        doublings == kMostDoublings || (doublings > 0 && !out.elements->is_whole))
      return;
    bool has_more = false;
    for (auto& [body, choice] : choices_) {
      const auto spot = std::ranges::find(out.prepared.file.blind_spots, body, &mbs::BlindSpot::name);
      if (!choice.exact || spot == out.prepared.file.blind_spots.end() || spot->key.empty()) continue;
      choice.elements = 2 * spot->elements;
      has_more = true;
    }
    if (!has_more) return;
    const std::optional<ElementsEstimate> before = std::move(out.elements);
    const double wall = out.result.wall_time;
    out = simulate(out.prepared);
    out.result.wall_time += wall;
    restarts_.push_back(fmt::format("elements of {}: {}; run again with twice as many",
                                    fmt::join(before->bodies, ", "),
                                    before->is_whole ? percent(before->error) : "unknown"));
  }
}

// A run that uses up its accuracy is stopped where something can be refined: the bodies to refine.  Empty where
// the run ended otherwise.
std::vector<std::string> Chooser::run_until_over(ChosenRun& out, const mbs::State& state,
                                                 const VectorXd& v_dot, const Good& start, Good& good,
                                                 bool may_stop) {
  const auto shadows = full_ ? Shadows::make(out.prepared, *full_) : Shadows::make(out.prepared);
  VectorXd spent;
  if (shadows) spent = VectorXd::Zero(static_cast<Eigen::Index>(shadows->outputs().size()));
  if (start.is_there) spent = start.squares;
  std::vector<std::string> to_refine;
  beyond_range_.clear();
  std::vector<std::pair<std::string, int>> beams;  // that may have to be exact
  const auto& bodies = out.prepared.mechanism->description().bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (const auto found = choices_.find(bodies[b].name);
        found != choices_.end() && found->second.is_beam && !found->second.exact && !found->second.rigid)
      beams.emplace_back(bodies[b].name, static_cast<int>(b));
  mbs::LinearRange range(*out.prepared.mechanism,
                         out.prepared.options.end_time - out.prepared.options.start_time);
  mbs::RunCallbacks mine = callbacks_;
  mine.row = [&](const mbs::State& s, const VectorXd& a, const mbs::EnergyAccount& energy) {
    // The row from which the run goes on is there already.
    if (!start.is_there || s.t > state.t) out.rows.push_back({s, a, continued(energy, start.energy)});
    if (!beams.empty() && may_stop) {
      range.observe(s);
      for (const auto& [name, b] : beams)
        if (range.is_left(b)) beyond_range_.insert(name);
      if (!beyond_range_.empty()) {
        to_refine.assign(beyond_range_.begin(), beyond_range_.end());
        may_stop = false;
      }
    }
    if (!shadows || !shadows->take(s, a)) return;
    const VectorXd squares = spent + shadows->squares();
    const double error = worst_output(squares, span_, sizes_.outputs).first;
    if (error > kStop * accuracy_ && may_stop) {
      to_refine = worst_choices(shadows->estimate());
      may_stop = !to_refine.empty();
    }
    if (error * error > kLastGood * accuracy_ * accuracy_ || (start.is_there && s.t <= state.t)) return;
    good.state = shadows->corrected(good.v_dot);
    good.energy = out.rows.back().energy;
    good.squares = squares;
    good.rows = out.rows.size();
    good.is_there = true;
  };
  if (shadows)
    shadows->ask_for_looks(mine, [&](const mbs::State& s, const VectorXd& a) { shadows->look(s, a); });
  const bool is_watched = tolerance_ && tolerance_->is_watched() && !start.is_there;
  const auto steps = tells_integrator_ || is_watched ? GlobalError::make(out.prepared) : nullptr;
  integrator_spent_ = 0.0;
  mine.stop_wanted = [&] {
    if (const double spent = is_watched && steps ? steps->spent(sizes_.outputs) : 0.0;
        tolerance_ && tolerance_->is_too_much(lost_at_ < 0.0 ? spent : kOfUnsureSizes * spent))
      integrator_spent_ = spent;
    return integrator_spent_ > 0.0 || !to_refine.empty() ||
           (callbacks_.stop_wanted && callbacks_.stop_wanted());
  };
  if (steps) steps->watch(mine);
  out.result = mbs::run(*out.prepared.mechanism, state, v_dot, out.prepared.options, mine);
  out.integrator.reset();
  if (steps && out.result.complete) {
    out.integrator = steps->estimate();
    out.result.wall_time -= steps->wall();
    if (start.is_there) {
      std::string& note = out.integrator->note;
      if (note.empty()) note = fmt::format("about {} since", percent(out.integrator->error));
      note = fmt::format("{}; of the part until t = {} s it is not known", note, number(state.t, 3));
      out.integrator->is_whole = false;
      out.integrator->error = 0.0;
    }
  }
  out.has_estimate = shadows != nullptr;
  out.estimate = shadows ? shadows->estimate() : TruncationEstimate();
  if (shadows) {
    out.result.wall_time -= out.estimate.wall;
  }
  if (start.is_there)
    add_part_before(out, shadows ? VectorXd(start.squares + shadows->squares()) : start.squares);
  return to_refine;
}

// The sentence of a run that its integrator has made too wrong; a finer tolerance for the next.
std::string Chooser::given_up_by_integrator(const ChosenRun& out) {
  const double before = tolerance_->value(), t = out.result.state.t;
  tolerance_->give_up(integrator_spent_, span_ > 0.0 ? (t - out.prepared.options.start_time) / span_ : 1.0);
  return fmt::format("tolerance {:.1e} had used up the accuracy at t = {} s; begun anew with {:.1e}", before,
                     number(t, 3), tolerance_->value());
}

// A run that came to its end is asked what its integrator cost.
bool Chooser::has_to_run_finer(const ChosenRun& out) {
  if (!tolerance_ || !(out.result.complete || out.result.stopped_as_told)) return false;
  const mbs::Sizes n = out.prepared.mechanism->sizes();
  if (n.n_v + n.n_dyn == 0) return false;  // nothing to integrate
  const double before = tolerance_->value();
  if (!tolerance_->has_to_be_finer(out.integrator ? &*out.integrator : nullptr,
                                   out.result.energy.relative_error(),
                                   out.has_estimate ? out.estimate.error : 0.0))
    return false;
  restarts_.push_back(
      fmt::format("tolerance {:.1e} {}; begun anew with {:.1e}", before,
                  out.integrator && out.integrator->is_whole
                      ? fmt::format("cost {} in {}", percent(out.integrator->error), out.integrator->output)
                      : "cost what its steps do not tell",
                  tolerance_->value()));
  return true;
}

// What the modes cost that were left out until the run went on with more: of the whole run, with what is left out since.
void Chooser::add_part_before(ChosenRun& out, const VectorXd& squares) const {
  TruncationEstimate& estimate = out.estimate;
  if (!out.has_estimate) estimate.outputs = sizes_.outputs;
  const auto [error, worst] = worst_output(squares, span_, sizes_.outputs);
  estimate.error = error;
  estimate.worst = worst;
  for (std::size_t i = 0; i < estimate.outputs.size(); ++i) {
    OutputEstimate& o = estimate.outputs[i];
    o.rms = std::sqrt(squares(static_cast<Eigen::Index>(i)) / span_);
    // Of single rows before that nothing is kept.
    o.max = out.has_estimate ? std::max(o.max, o.rms) : o.rms;
    if (!out.has_estimate) o.final = 0.0;
  }
  for (const std::string& body : refined_) {
    auto source = std::ranges::find(estimate.by_body, body, &SourceEstimate::body);
    if (source == estimate.by_body.end()) {
      estimate.by_body.push_back(
          {body, choices_.at(body).available, choices_.at(body).available, 0.0, "", ""});
      source = std::prev(estimate.by_body.end());
    }
    // Which body it was is not kept: each may have been.
    source->error = std::max(source->error, error);
    if (worst >= 0) source->output = sizes_.outputs[static_cast<std::size_t>(worst)].name;
  }
  out.has_estimate = true;
}

// The chosen body that loses most among those to which something can be added, and those that lose nearly as much.
std::vector<std::string> Chooser::worst_choices(const TruncationEstimate& estimate) const {
  constexpr double kNearly = 0.5;
  std::vector<std::string> out;
  double most = 0.0;
  for (const SourceEstimate& source : estimate.by_body) {
    const auto found = choices_.find(source.body);
    if (found == choices_.end() || !found->second.can_be_refined()) continue;
    most = std::max(most, source.error);
    if (source.error >= kNearly * most) out.push_back(source.body);
  }
  return out;
}

// The mechanism as it is chosen now, in the state of `start`, with the rows until there.
void Chooser::go_on(ChosenRun& out, const Good& start, mbs::State& state, VectorXd& v_dot) {
  mbs::PreparedMechanism refined = prepared();
  state = refined.state;
  v_dot = refined.v_dot;
  if (start.is_there) {
    move_rows(out, *refined.mechanism, start.rows);
    Embedding(*refined.mechanism, *full_).project(start.state, start.v_dot, state, v_dot);
    mbs::assemble(*refined.mechanism, state, v_dot);
    refined.options.start_time = state.t;
  } else {
    out.rows.clear();
  }
  out.prepared = std::move(refined);
}

// The first rows of a run, told by another mechanism.
void Chooser::move_rows(ChosenRun& out, const mbs::Mechanism& to, std::size_t rows) const {
  out.rows.resize(rows);
  Embedding from_old(*out.prepared.mechanism, *full_), to_new(to, *full_);
  mbs::State full;
  VectorXd full_v_dot;
  for (RowOfRun& row : out.rows) {
    from_old.embed(row.state, row.v_dot, full, full_v_dot);
    mbs::State moved = to.initial_state();
    moved.lambda = VectorXd::Zero(to.sizes().n_lambda);
    to_new.project(full, full_v_dot, moved, row.v_dot);
    row.state = std::move(moved);
  }
}

}  // namespace flexura::study
