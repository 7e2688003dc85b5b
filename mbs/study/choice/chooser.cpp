// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/chooser.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <numbers>
#include <optional>
#include <ranges>
#include <stdexcept>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/study/estimate/influence.hpp"
#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {
namespace {

using Eigen::VectorXd;
using terminal::number;

// At 1 % deflections of 10 um are still above the absolute part of the error allowed, 0.1 um.
constexpr double kAbsoluteFactor = 0.01;
// A beam that loses so much of its stiffness is half way to where it buckles, which no mode knows.
constexpr double kNearBuckling = 0.5;
// Stiffening that costs less than this part of a body's share is left out unseen.
constexpr double kOfShare = 0.1;
// Parts of the run after which the screening looks whether anything but all deformations would do.
constexpr std::array kLooksWhetherLost = {0.1, 0.3};
constexpr double kUsualAccuracy = 0.01;  // of bodies with fidelity = "auto" in a run without accuracy

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

Chooser::Chooser(const mbs::PreparedMechanism& given, const mbs::RunCallbacks& callbacks, bool integrator)
    : accuracy_(accuracy_of(given) > 0.0 ? accuracy_of(given) : kUsualAccuracy),
      as_given_(given),
      callbacks_(callbacks),
      tells_integrator_(integrator) {
  for (const mbs::BodyDescription& body : given.mechanism->description().bodies)
    if (is_open(given, body)) choices_[body.name].is_beam = body.of_beam != nullptr;
  if (accuracy_of(given) > 0.0) tolerance_.emplace(accuracy_, given);
}

ChosenRun Chooser::run() {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t start_cpu = std::clock();
  const auto cpu_since = [&] { return static_cast<double>(std::clock() - start_cpu) / CLOCKS_PER_SEC; };
  // A loop may close, or a drive move, by deformation alone.
  std::optional<mbs::PreparedMechanism> rigid;
  try {
    rigid.emplace(prepared());
  } catch (const input::InputError& error) {
    if (choices_.empty()) throw;
    keep_all_because(error.what());
    rigid.emplace(prepared());
  }
  const bool can_be_rigid =
      std::ranges::all_of(choices_, [](const auto& entry) { return entry.second.rigid; });
  ChosenRun out{std::move(*rigid), {}, {}, {}, false, {}, {}, {}, {}, 0, 0.0, 0.0};
  // A name that nothing has is refused before the run.
  if (choices_.empty()) mbs::select_quantities(*out.prepared.mechanism, out.prepared.file.outputs);
  bool is_screened = false;
  const auto look = [&] {
    is_screened = true;
    leave_out(out.prepared);
    screen(out);
    const bool ended = out.result.complete || out.result.stopped_as_told || lost_at_ >= 0.0;
    if (!ended && !choices_.empty() && !is_interrupted())
      keep_all_because(out.result.stopped_because);
    else if (!choices_.empty() && ended && out.has_estimate)
      out.estimate.missed > 0.0 || lost_at_ >= 0.0 ? keep_all() : choose();
    return ended ? packed() : mbs::PreparationCache::Matrices();
  };
  if (can_be_rigid) {
    const auto kept = as_given_.cache && !choices_.empty()
                          ? as_given_.cache->get("choice", key_of_choice(), look)
                          : std::make_shared<const mbs::PreparationCache::Matrices>(look());
    if (!is_screened && !recall(*kept, out.prepared)) {
      for (auto& [body, choice] : choices_) choice = {.is_beam = choice.is_beam};
      without_influence_.clear();
      look();
    }
  }
  if (!is_screened || std::ranges::any_of(choices_, [](const auto& entry) { return !entry.second.rigid; })) {
    const double screening = seconds_since(start), screening_cpu = cpu_since();
    steps_.reset();
    out = simulate(out.prepared);
    refine_beams(out);
    out.screening_wall += screening;
    out.screening_cpu += screening_cpu;
  } else {
    out.screening_wall = std::max(0.0, seconds_since(start) - out.result.wall_time);
    out.screening_cpu = std::max(0.0, cpu_since() - out.result.wall_time);
    if (steps_ && out.result.complete) out.integrator = steps_->estimate();
    steps_.reset();
    if (has_to_run_finer(out)) {
      const double screening = seconds_since(start), screening_cpu = cpu_since();
      out = simulate(out.prepared);
      out.screening_wall += screening;
      out.screening_cpu += screening_cpu;
    }
  }
  for (const auto& [body, choice] : choices_)
    if (!without_influence_.contains(body)) out.reasons.push_back(choice.text(body));
  if (!without_influence_.empty())
    out.reasons.push_back(fmt::format("{}: rigid: no output that is asked for depends on {} deformation",
                                      fmt::join(without_influence_, ", "),
                                      without_influence_.size() == 1 ? "its" : "their"));
  out.reasons.insert(out.reasons.end(), restarts_.begin(), restarts_.end());
  out.restarts = static_cast<int>(restarts_.size());
  out.set = keys();
  if (tolerance_) out.reasons.push_back(tolerance_->text());
  return out;
}

mbs::PreparedMechanism Chooser::prepared() const {
  return mbs::prepare(as_given_.source, choice(), {}, as_given_.cache);
}

// What was given, with the present tolerance.
mbs::ModelChoice Chooser::of_integrator() const {
  mbs::ModelChoice out = as_given_.choice;
  if (!tolerance_) return out;
  out.tolerance = tolerance_->value();
  out.absolute_factor = kAbsoluteFactor;
  return out;
}

mbs::ModelChoice Chooser::choice() const {
  mbs::ModelChoice out = of_integrator();
  for (const auto& [body, choice] : choices_) out.bodies[body] = choice.model();
  return out;
}

mbs::ModelChoice Chooser::choice_of_exact() const {
  mbs::ModelChoice out = of_integrator();
  for (const std::string& body : exact()) out.bodies[body] = choices_.at(body).model();
  return out;
}

// Beams that no shadow describes.
std::set<std::string> Chooser::exact() const {
  std::set<std::string> out;
  for (const auto& [body, choice] : choices_)
    if (choice.exact) out.insert(body);
  return out;
}

// Bodies on whose deformation no output depends that is asked for.
void Chooser::leave_out(const mbs::PreparedMechanism& rigid) {
  if (choices_.size() < 2) return;
  std::set<std::string> open;
  for (const auto& [body, choice] : choices_) open.insert(body);
  without_influence_ = bodies_without_influence(rigid, std::move(open));
}

// The run with the bodies rigid that are to be chosen; `out` must outlive the screening.
void Chooser::screen(ChosenRun& out) {
  for (const mbs::OutputInfo& info : out.prepared.mechanism->quantities()) of_rigid_.insert(info.name);
  // Where nothing is to be chosen but the tolerance, the shadows are those of any run.
  const auto shadows = choices_.empty() ? Shadows::make(out.prepared) : nullptr;
  if (!choices_.empty()) {
    full_ = FullModel::make(out.prepared, {.stiffened = {}, .rigid = without_influence_, .own_frames = true});
    if (full_) screening_.emplace(out.prepared, *full_);
  }
  mbs::RunCallbacks mine = callbacks_;
  const mbs::SolverOptions& o = out.prepared.options;
  std::size_t next = 0;  // of kLooksWhetherLost
  mine.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount& energy) {
    out.rows.push_back({s, v_dot, energy});
    if (screening_) screening_->take(s, v_dot);
    if (shadows) shadows->take(s, v_dot);
    if (next < kLooksWhetherLost.size() &&
        s.t >= o.start_time + kLooksWhetherLost[next] * (o.end_time - o.start_time)) {
      ++next;
      if (looks_whether_lost_ && screening_ && all_are_lost()) lost_at_ = s.t;
    }
  };
  mine.stop_wanted = [&] { return lost_at_ >= 0.0 || (callbacks_.stop_wanted && callbacks_.stop_wanted()); };
  if (screening_) screening_->ask_for_looks(mine);
  if (shadows)
    shadows->ask_for_looks(mine,
                           [&](const mbs::State& s, const VectorXd& v_dot) { shadows->look(s, v_dot); });
  // An output that rigid bodies do not have is no output of this run.
  const auto has_all = [&] {
    try {
      mbs::select_quantities(*out.prepared.mechanism, out.prepared.file.outputs);
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  };
  // Told only where this is the run that is kept.
  if ((tells_integrator_ || (tolerance_ && tolerance_->is_watched())) && has_all())
    steps_ = LaterGlobalError::make(out.prepared);
  if (steps_) steps_->watch(mine);
  out.result =
      mbs::run(*out.prepared.mechanism, out.prepared.state, out.prepared.v_dot, out.prepared.options, mine);
  if (shadows) {
    out.has_estimate = true;
    out.estimate = shadows->estimate();
  } else if (screening_ && screening_->has_shadows()) {
    out.has_estimate = true;
    out.estimate = sizes_ = screening_->estimate();
    span_ = lost_at_ < 0.0 ? screening_->span() : o.end_time - o.start_time;
  }
}

// Of the accuracy, for the deformations that each open body leaves out.
double Chooser::share_of_each() const {
  // What is followed roughly has a tenth of its share.
  return (sizes_.followed_roughly.empty() ? 1.0 : 0.1) * kShareOfModes * accuracy_ /
         static_cast<double>(choices_.size() - without_influence_.size());
}

// A part of the run may be enough to see that nothing but all deformations will do.  Sizes of outputs are not known to its end,
// so that the loss has to be several times too much; nor are spin and loads, which stiffen.
bool Chooser::all_are_lost() {
  constexpr double kSure = 2.0, kNearlyLost = 0.3;
  if (!screening_->has_shadows()) return false;
  sizes_ = screening_->estimate();
  const mbs::SolverOptions& o = as_given_.options;
  const double whole = o.end_time - o.start_time, limit = kSure * share_of_each();
  const auto& bodies = as_given_.mechanism->description().bodies;
  const double part = std::sqrt(screening_->span() / whole);
  std::vector<std::string> open;
  for (const SourceEstimate& source : sizes_.by_body) {
    if (!choices_.contains(source.body)) continue;
    open.push_back(source.body);
    if (source.error * part <= limit ||
        has_stiffening_terms(*std::ranges::find(bodies, source.body, &mbs::BodyDescription::name)))
      return false;
  }
  if (open.size() + without_influence_.size() != choices_.size()) return false;
  for (const std::string& body : open)
    if (const double loss = screening_->least_loss(body, limit, whole); loss <= limit) {
      looks_whether_lost_ = loss > kNearlyLost * limit;
      return false;
    }
  return true;
}

// A share of the budget for each body, those of least influence first: what one does not need is the others'.
void Chooser::choose() {
  auto bodies = static_cast<double>(choices_.size() - without_influence_.size());
  double left = share_of_each() * bodies;
  const auto spend = [&](double loss) {
    left = std::max(0.0, left - loss);
    bodies -= 1.0;
  };
  std::vector<std::string> not_rigid;
  for (const SourceEstimate& source : sizes_.by_body | std::views::reverse) {
    const auto found = choices_.find(source.body);
    if (found == choices_.end()) continue;
    found->second.available = source.available;
    if (make_exact_beyond_range(source.body)) {
      bodies -= 1.0;
      continue;
    }
    // Of that no candidate is judged.
    if (!source.beyond.empty() && source.error <= left / bodies) {
      keep_all_of(source.body, source.available, source.beyond);
      bodies -= 1.0;
      continue;
    }
    if (source.error > left / bodies || has_output_of_its_own(source.body)) {
      not_rigid.push_back(source.body);
      continue;
    }
    spend(source.error);
    found->second.reason =
        fmt::format("its deformation changes outputs by {} at most", percent(source.error));
  }
  const std::vector<Screened> screened = screening_->bodies(not_rigid);
  for (const std::string& body : not_rigid) {
    choose_body(*std::ranges::find(screened, body, &Screened::body), left / bodies);
    spend(choices_.at(body).candidate.loss);
  }
}

// Of what lies between two rows nothing is known, nor what it leaves behind where nothing moves.
void Chooser::keep_all() {
  const auto& bodies = as_given_.mechanism->description().bodies;
  for (const SourceEstimate& source : sizes_.by_body) {
    const auto found = choices_.find(source.body);
    if (found == choices_.end()) continue;
    BodyChoice& choice = found->second;
    choice.available = source.available;
    if (make_exact_beyond_range(source.body)) continue;
    choice.rigid = false;
    choice.candidate.all = true;
    choice.candidate.modes = source.available;
    // Nothing has told what its loads do to its stiffness.
    choice.stiffened =
        lost_at_ < 0.0 &&
        has_stiffening_terms(bodies[static_cast<std::size_t>(
            std::ranges::find(bodies, source.body, &mbs::BodyDescription::name) - bodies.begin())]);
    if (lost_at_ >= 0.0)
      choice.reason =
          fmt::format("rigid, {} is off by {} until t = {} s, and no smaller number keeps outputs within {}",
                      source.output, percent(source.error), number(lost_at_, 3), percent(share_of_each()));
    else
      choice.reason = fmt::format(
          "forces change within {:.3g} s more often than is looked at beside rows {:.3g} s apart, which "
          "would "
          "judge "
          "fewer; a shorter run has that judged",
          sizes_.missed, sizes_.rows_apart);
  }
}

// The run with the open bodies rigid cannot begin or go on.
void Chooser::keep_all_because(const std::string& why) {
  // Nor does it tell which of them have an influence.
  without_influence_.clear();
  full_.reset();
  const auto& bodies = as_given_.mechanism->description().bodies;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const auto found = choices_.find(bodies[b].name);
    if (found == choices_.end()) continue;
    const std::string reason = "the run with it rigid cannot be: " + why.substr(0, why.find(';'));
    // How far it bends nothing has told.
    if (found->second.is_beam)
      found->second.make_exact(reason);
    else
      keep_all_of(bodies[b].name, deformations_of(bodies[b]), reason);
  }
}

void Chooser::keep_all_of(const std::string& body, int available, const std::string& why) {
  BodyChoice& choice = choices_.at(body);
  choice = {.is_beam = choice.is_beam};
  choice.rigid = false;
  choice.available = available;
  choice.candidate.all = true;
  choice.candidate.modes = available;
  choice.reason = why;
}

// The choice without the wish for one, as keys of a file.
std::vector<std::string> Chooser::keys() const {
  std::vector<std::string> out = as_given_.source->words();
  const auto wishes =
      std::erase_if(out, [](const std::string& word) { return word.starts_with("solver.accuracy="); });
  const std::vector<std::string> chosen = mbs::words_of(choice());
  out.insert(out.end(), chosen.begin(), chosen.end());
  if (accuracy_of(as_given_) > 0.0 && wishes == 0) out.push_back("solver.accuracy=");
  // The last word on a key counts.
  const auto key = [](const std::string& word) { return word.substr(0, word.find('=')); };
  for (std::size_t i = out.size(); i-- > 0;)
    if (std::any_of(out.begin() + static_cast<std::ptrdiff_t>(i) + 1, out.end(),
                    [&](const std::string& later) { return key(later) == key(out[i]); }))
      out.erase(out.begin() + static_cast<std::ptrdiff_t>(i));
  return out;
}

// Stress, say, that a rigid body has none of.
bool Chooser::has_output_of_its_own(const std::string& body) const {
  return std::ranges::any_of(sizes_.outputs, [&](const OutputEstimate& output) {
    return output.name.starts_with(body + '.') && !of_rigid_.contains(output.name);
  });
}

void Chooser::choose_body(const Screened& s, double share) {
  BodyChoice& choice = choices_.at(s.body);
  choice.rigid = false;
  choice.candidate = screening_->cheapest(s.body, share);
  // A stiffness that is off by a part is a deflection that is off by this part, and a frequency that is off by half of it: what rings
  // comes out of phase by that times the angle that it turns until it has died away.
  const double change = s.stiffness_change * std::min(1.0, s.rigid_error);
  const double angle = 2.0 * std::numbers::pi * s.first_hz * std::min(span_, s.ringing_time);
  choice.stiffened = change * (choice.candidate.modes > 0 ? std::max(1.0, 0.5 * angle) : 1.0) > share;
  // A beam's own bending turns what loads it along its axis, which the rigid run does not show.
  choice.stiffening_counts = change > kOfShare * share || (choice.is_beam && s.has_stiffening_terms);
  if (choice.is_beam && s.most_negative_change < -kNearBuckling)
    choice.make_exact(
        fmt::format("its loads take {} of its stiffness away", percent(-s.most_negative_change)));
  else
    choice.explain(s, share);
}

bool Chooser::make_exact_beyond_range(const std::string& body) {
  BodyChoice& choice = choices_.at(body);
  if (!choice.is_beam || !screening_->leaves_linear_range(body)) return false;
  choice.make_exact("its loads would bend it beyond what is linear in modes");
  return true;
}

std::vector<std::string> Chooser::judged_with_stiffening() const {
  std::vector<std::string> out;
  for (const auto& [body, choice] : choices_)
    if (!choice.rigid && (choice.stiffened || choice.stiffening_counts)) out.push_back(body);
  return out;
}

}  // namespace flexura::study
