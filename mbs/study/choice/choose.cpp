// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/choose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/study/choice/beam_screening.hpp"
#include "mbs/study/choice/body_choice.hpp"
#include "mbs/study/choice/screening.hpp"
#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {
namespace {

using Eigen::VectorXd;
using terminal::number;

// At 0.8 three of the trade's 18 cases missed their accuracy, at 0.5 none.
constexpr double kShareOfModes = 0.5;
// A run goes on from where its error had used up this part of the budget (of the squares' integral).
constexpr double kLastGood = 0.25;
constexpr int kMostRestarts = 6;
// At 1 % deflections of 10 um are still above the absolute part of the error allowed, 0.1 um.
constexpr double kAbsoluteFactor = 0.01;
// A slope of a tenth turns an axis by 0.1^2 / 2: half a per cent of the length, which no mode knows.
constexpr double kLargestOfLinear = 0.1;
constexpr double kUsualAccuracy = 0.01;  // of bodies with fidelity = "auto" in a run without accuracy

double accuracy_of(const mbs::PreparedMechanism& run) {
  return run.file.solver.quantity("accuracy");
}

// A superelement whose fidelity is to be chosen.
bool is_open(const mbs::PreparedMechanism& run, const mbs::BodyDescription& body) {
  if (body.superelement.empty() || body.name.find('.') != std::string::npos)
    return false;  // a subsystem's own file says
  const auto given = run.file.fidelity.find(body.name);
  return given == run.file.fidelity.end() ? accuracy_of(run) > 0.0 : given->second == "auto";
}

// A beam without superelement whose fidelity is to be chosen; it stands there as ANCF.
bool is_open_beam(const mbs::PreparedMechanism& run, const mbs::BodyDescription& body) {
  const auto given = run.file.fidelity.find(body.name);
  return body.superelement.empty() && body.flexible && given != run.file.fidelity.end() &&
         given->second == "auto";
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class Chooser {
 public:
  Chooser(const mbs::PreparedMechanism& given, const std::filesystem::path& file,
          const std::vector<std::string>& overrides, const mbs::RunCallbacks& callbacks)
      : accuracy_(accuracy_of(given) > 0.0 ? accuracy_of(given) : kUsualAccuracy),
        as_given_(given),
        file_(file),
        given_(overrides),
        callbacks_(callbacks) {
    for (const mbs::BodyDescription& body : given.mechanism->description().bodies)
      if (is_open(given, body))
        choices_[body.name] = {};
      else if (is_open_beam(given, body))
        beams_.push_back({body.name, true, ""});
    if (accuracy_of(given) > 0.0) {
      tolerance_ = std::clamp(1e-3 * accuracy_, 1e-9, 1e-4);
      given_.push_back(fmt::format("solver.tolerance={:.3g}", *tolerance_));
      given_.push_back(fmt::format("solver.absolute_factor={}", kAbsoluteFactor));
    }
  }

  ChosenRun run() {
    const auto start = std::chrono::steady_clock::now();
    ChosenRun out{prepared(overrides()), overrides(), {}, {}, {}, false, {}, {}, 0, 0.0};
    // A name that nothing has is refused before the run.
    if (choices_.empty()) mbs::select_quantities(*out.prepared.mechanism, out.prepared.file.outputs);
    screen(out);
    if (!choices_.empty() && out.result.complete && out.has_estimate) choose();
    if (std::ranges::any_of(choices_, [](const auto& entry) { return !entry.second.rigid; }) ||
        std::ranges::any_of(beams_, [](const BeamChoice& beam) { return !beam.rigid; })) {
      const double screening = seconds_since(start);
      out = simulate(out.prepared);
      out.screening_wall += screening;
    } else {
      out.screening_wall = std::max(0.0, seconds_since(start) - out.result.wall_time);
    }
    for (const auto& [body, choice] : choices_) out.reasons.push_back(choice.text(body));
    for (const BeamChoice& beam : beams_) out.reasons.push_back(beam.text());
    out.reasons.insert(out.reasons.end(), restarts_.begin(), restarts_.end());
    out.restarts = static_cast<int>(restarts_.size());
    out.set = keys_of(out.overrides);
    if (tolerance_)
      out.reasons.push_back(
          fmt::format("tolerance {:.1e}: a thousandth of the wanted {}", *tolerance_, percent(accuracy_)));
    return out;
  }

 private:
  mbs::PreparedMechanism prepared(const std::vector<std::string>& words) const {
    return mbs::prepare(file_, words, {}, as_given_.cache);
  }

  std::vector<std::string> overrides() const {
    std::vector<std::string> out = given_;
    for (const auto& [body, choice] : choices_) {
      const auto words = choice.overrides(body);
      out.insert(out.end(), words.begin(), words.end());
    }
    const auto beams = overrides_of_beams();
    out.insert(out.end(), beams.begin(), beams.end());
    return out;
  }
  std::vector<std::string> overrides_of_beams() const {
    std::vector<std::string> out;
    for (const BeamChoice& beam : beams_)
      out.push_back(fmt::format("body.{}.fidelity={}", beam.body, beam.rigid ? "rigid" : "ancf"));
    return out;
  }

  // The run with the bodies rigid that are to be chosen; `out` must outlive the screening.
  void screen(ChosenRun& out) {
    for (const mbs::OutputInfo& info : out.prepared.mechanism->quantities()) of_rigid_.insert(info.name);
    // Where nothing is to be chosen but the tolerance, the shadows are those of any run.
    const auto shadows = choices_.empty() ? Shadows::make(out.prepared, file_, out.overrides) : nullptr;
    if (!choices_.empty()) {
      full_ = FullModel::make(out.prepared, file_, out.overrides);
      screening_.emplace(out.prepared, *full_, file_, out.overrides);
    }
    std::vector<std::string> names;
    for (const BeamChoice& beam : beams_) names.push_back(beam.body);
    BeamScreening beams(*as_given_.mechanism, *out.prepared.mechanism, names);
    mbs::RunCallbacks mine = callbacks_;
    mine.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount& energy) {
      out.rows.push_back({s, v_dot, energy});
      beams.take(s, v_dot);
      if (screening_) screening_->take(s, v_dot);
      if (shadows) shadows->take(s, v_dot);
    };
    out.result =
        mbs::run(*out.prepared.mechanism, out.prepared.state, out.prepared.v_dot, out.prepared.options, mine);
    if (shadows) {
      out.has_estimate = true;
      out.estimate = shadows->estimate();
    } else if (screening_ && screening_->has_shadows()) {
      out.has_estimate = true;
      out.estimate = sizes_ = screening_->estimate();
      span_ = screening_->span();
    }
    choose_beams(beams.beams());
  }

  void choose_beams(const std::vector<ScreenedBeam>& screened) {
    const double share = kShareOfModes * accuracy_;
    for (std::size_t i = 0; i < beams_.size(); ++i) {
      const ScreenedBeam& s = screened[i];
      beams_[i].rigid = s.deflection <= share;
      beams_[i].reason = fmt::format(
          "rigid, its joints would load it with up to {} N, enough to bend it (EI {} N m^2, {} m long) by {} "
          "of its length{}",
          number(s.force, 2), number(s.bending_stiffness, 2), number(s.length, 2), percent(s.deflection),
          s.deflection > kLargestOfLinear ? ": far beyond what modes describe" : "");
    }
  }

  void choose() {
    const double share = kShareOfModes * accuracy_ / static_cast<double>(choices_.size());
    std::vector<std::string> not_rigid;
    for (const SourceEstimate& source : sizes_.by_body) {
      const auto found = choices_.find(source.body);
      if (found == choices_.end()) continue;
      found->second.available = source.available;
      if (source.error > share || has_output_of_its_own(source.body))
        not_rigid.push_back(source.body);
      else
        found->second.reason =
            fmt::format("its deformation changes outputs by {} at most", percent(source.error));
    }
    for (const Screened& s : screening_->bodies(not_rigid))
      if (std::ranges::find(not_rigid, s.body) != not_rigid.end()) choose_body(s, share);
  }

  // The choice without the wish for one.
  std::vector<std::string> keys_of(std::vector<std::string> overrides) const {
    const auto wishes = std::erase_if(
        overrides, [](const std::string& word) { return word.starts_with("solver.accuracy="); });
    if (accuracy_of(as_given_) > 0.0 && wishes == 0) overrides.push_back("solver.accuracy=");
    // The last word on a key counts.
    const auto key = [](const std::string& word) { return word.substr(0, word.find('=')); };
    for (std::size_t i = overrides.size(); i-- > 0;)
      if (std::any_of(overrides.begin() + static_cast<std::ptrdiff_t>(i) + 1, overrides.end(),
                      [&](const std::string& later) { return key(later) == key(overrides[i]); }))
        overrides.erase(overrides.begin() + static_cast<std::ptrdiff_t>(i));
    return overrides;
  }

  // Stress, say, that a rigid body has none of.
  bool has_output_of_its_own(const std::string& body) const {
    return std::ranges::any_of(sizes_.outputs, [&](const OutputEstimate& output) {
      return output.name.starts_with(body + '.') && !of_rigid_.contains(output.name);
    });
  }

  void choose_body(const Screened& s, double share) {
    BodyChoice& choice = choices_.at(s.body);
    choice.rigid = false;
    choice.candidate = screening_->cheapest(s.body, share);
    // A stiffness that is off by a part is a deflection that is off by this part.
    choice.stiffened = s.stiffness_change * std::min(1.0, s.rigid_error) > share;
    choice.explain(s, share);
  }

  // A row in the full model from which a better choice may go on.
  struct Good {
    mbs::State state;
    VectorXd v_dot;
    mbs::EnergyAccount energy;
    VectorXd squares;  // of the errors until there
    std::size_t rows = 0;
    bool is_there = false;
  };

  // One run with the present choices, and on with more where its shadows say so.
  ChosenRun simulate(const mbs::PreparedMechanism& screened) {
    screening_.reset();
    const std::vector<std::string> stiffened = stiffened_bodies();
    const bool bent = std::ranges::any_of(beams_, [](const BeamChoice& beam) { return !beam.rigid; });
    if (!stiffened.empty() || (full_ && bent)) {
      std::vector<std::string> words = given_;
      const auto beams = overrides_of_beams();
      words.insert(words.end(), beams.begin(), beams.end());
      full_ = FullModel::make(screened, file_, words, stiffened);
    }
    ChosenRun out{prepared(overrides()), overrides(), {}, {}, {}, false, {}, {}, 0, 0.0};
    const double start_time = out.prepared.options.start_time;
    mbs::State state = out.prepared.state;
    VectorXd v_dot = out.prepared.v_dot;
    Good start;
    mbs::StepCounts steps_before;
    double wall_before = 0.0;
    for (int attempt = 0;; ++attempt) {
      Good good;
      const std::string worst = run_until_over(out, state, v_dot, start, good, attempt < kMostRestarts);
      add(out.result.counts, steps_before);
      if (worst.empty()) break;
      BodyChoice& choice = choices_.at(worst);
      const std::string was = choice.what(worst);
      choice.refine();
      const double t_stopped = out.result.state.t;
      if (good.is_there) start = std::move(good);
      go_on(out, start, state, v_dot);
      restarts_.push_back(fmt::format("{} had used up the accuracy at t = {} s; gone on from t = {} s as {}",
                                      was, number(t_stopped, 3), number(state.t, 3), choice.what(worst)));
      steps_before = out.result.counts;
      wall_before += out.result.wall_time;
    }
    out.prepared.options.start_time = start_time;
    if (!out.rows.empty()) out.result.energy = out.rows.back().energy;
    out.result.wall_time += wall_before;
    return out;
  }

  // A run that uses up its accuracy is stopped where something can be refined: the body to refine.  Empty where
  // the run ended otherwise.
  std::string run_until_over(ChosenRun& out, const mbs::State& state, const VectorXd& v_dot,
                             const Good& start, Good& good, bool may_stop) {
    const auto shadows = full_ ? Shadows::make(out.prepared, *full_) : nullptr;
    VectorXd spent;
    if (shadows) spent = VectorXd::Zero(static_cast<Eigen::Index>(shadows->outputs().size()));
    if (start.is_there) spent = start.squares;
    std::string to_refine;
    mbs::RunCallbacks mine = callbacks_;
    mine.row = [&](const mbs::State& s, const VectorXd& a, const mbs::EnergyAccount& energy) {
      // The row from which the run goes on is there already.
      if (!start.is_there || s.t > state.t) out.rows.push_back({s, a, continued(energy, start.energy)});
      if (!shadows || !shadows->take(s, a)) return;
      const VectorXd squares = spent + shadows->squares();
      const double error = worst_output(squares, span_, sizes_.outputs).first;
      if (error > accuracy_ && may_stop) {
        to_refine = worst_choice(shadows->estimate());
        may_stop = !to_refine.empty();
      }
      if (error * error > kLastGood * accuracy_ * accuracy_ || (start.is_there && s.t <= state.t)) return;
      good.state = shadows->corrected(good.v_dot);
      good.energy = out.rows.back().energy;
      good.squares = squares;
      good.rows = out.rows.size();
      good.is_there = true;
    };
    mine.stop_wanted = [&] {
      return !to_refine.empty() || (callbacks_.stop_wanted && callbacks_.stop_wanted());
    };
    out.result = mbs::run(*out.prepared.mechanism, state, v_dot, out.prepared.options, mine);
    out.has_estimate = shadows != nullptr;
    out.estimate = shadows ? shadows->estimate() : TruncationEstimate();
    if (shadows) {
      out.result.wall_time -= out.estimate.wall;
    }
    return to_refine;
  }

  // The chosen body that loses most among those to which something can be added.
  std::string worst_choice(const TruncationEstimate& estimate) const {
    for (const SourceEstimate& source : estimate.by_body)
      if (const auto found = choices_.find(source.body);
          found != choices_.end() && found->second.can_be_refined())
        return source.body;
    return "";
  }

  // The mechanism as it is chosen now, in the state of `start`, with the rows until there.
  void go_on(ChosenRun& out, const Good& start, mbs::State& state, VectorXd& v_dot) {
    out.overrides = overrides();
    mbs::PreparedMechanism refined = prepared(out.overrides);
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

  std::vector<std::string> stiffened_bodies() const {
    std::vector<std::string> out;
    for (const auto& [body, choice] : choices_)
      if (choice.stiffened) out.push_back(body);
    return out;
  }

  // The energy book of a run that was restarted: as if it had not been.
  static mbs::EnergyAccount continued(mbs::EnergyAccount now, const mbs::EnergyAccount& before) {
    now.start -= before.work_in - before.dissipated + before.error();
    now.work_in += before.work_in;
    now.dissipated += before.dissipated;
    now.gross_work += before.gross_work;
    now.peak = std::max(now.peak, before.peak);
    return now;
  }

  static void add(mbs::StepCounts& counts, const mbs::StepCounts& more) {
    counts.steps += more.steps;
    counts.evaluations += more.evaluations;
    counts.jacobians += more.jacobians;
    counts.error_failures += more.error_failures;
    counts.newton_failures += more.newton_failures;
    counts.restarts += more.restarts;
    counts.singular_crossings += more.singular_crossings;
  }

  // The first rows of a run, told by another mechanism.
  void move_rows(ChosenRun& out, const mbs::Mechanism& to, std::size_t rows) const {
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

  double accuracy_;
  const mbs::PreparedMechanism& as_given_;
  std::filesystem::path file_;
  std::vector<std::string> given_;
  const mbs::RunCallbacks& callbacks_;
  std::optional<double> tolerance_;
  std::map<std::string, BodyChoice> choices_;
  std::vector<BeamChoice> beams_;
  std::unique_ptr<FullModel> full_;
  std::optional<Screening> screening_;
  std::set<std::string> of_rigid_;  // names of quantities with the open bodies rigid
  TruncationEstimate sizes_;        // what the screening says about the outputs' sizes
  double span_ = 0.0;
  std::vector<std::string> restarts_;
};

}  // namespace

bool is_to_be_chosen(const mbs::PreparedMechanism& run) {
  return accuracy_of(run) > 0.0 ||
         std::ranges::any_of(run.mechanism->description().bodies,
                             [&](const auto& body) { return is_open(run, body) || is_open_beam(run, body); });
}

ChosenRun run_within(const mbs::PreparedMechanism& given, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides, const mbs::RunCallbacks& callbacks) {
  return Chooser(given, file, overrides, callbacks).run();
}

}  // namespace flexura::study
