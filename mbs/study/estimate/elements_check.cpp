// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/elements_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Beams of fewer elements are judged by finer ones: a half and a quarter of them would be no beam.
constexpr int kFewest = 4;
// The observed order: at least the first power, with a fifth for what is beside it; above four it is more often an accident.
constexpr double kLeastOrder = 0.8, kMostOrder = 4.0;
// What two runs differ by within their tolerance is the integrator's.
constexpr double kOfTolerance = 10.0, kOfIntegrator = 2.0;
// A run with finer elements may take longer; with these limits [s] and factors it does not take all day.
constexpr double kLongest = 20.0, kPatience = 5.0;

double ratio_of(const std::array<double, 3>& h, double p) {
  const auto power = [&](int i) { return std::pow(h[static_cast<std::size_t>(i)] / h[0], p); };
  return (power(2) - power(1)) / (power(1) - power(0));
}

}  // namespace

double observed_order(const std::array<double, 3>& h, double D_12, double D_23) {
  if (D_12 <= 0.0) return D_23 > 0.0 ? kMostOrder : 0.0;
  const double ratio = D_23 / D_12;
  if (ratio < ratio_of(h, kLeastOrder)) return 0.0;
  if (ratio >= ratio_of(h, kMostOrder)) return kMostOrder;
  // The ratio grows with p: a bisection to 1e-6.
  double low = kLeastOrder, high = kMostOrder;
  while (high - low > 1e-6) {
    const double middle = 0.5 * (low + high);
    (ratio_of(h, middle) < ratio ? low : high) = middle;
  }
  return low;
}

std::unique_ptr<ElementsCheck> ElementsCheck::make(const mbs::PreparedMechanism& run, KnownRuns* known) {
  std::vector<Beam> beams;
  for (const mbs::BlindSpot& spot : run.file.blind_spots)
    if (!spot.key.empty()) beams.push_back({spot.name, spot.elements});
  if (beams.empty()) return nullptr;
  std::unique_ptr<ElementsCheck> check(new ElementsCheck(run, std::move(beams), known));
  return check->which_.empty() ? nullptr : std::move(check);
}

ElementsCheck::ElementsCheck(const mbs::PreparedMechanism& run, std::vector<Beam> beams, KnownRuns* known)
    : run_(run),
      beams_(std::move(beams)),
      own_(known ? nullptr : std::make_unique<KnownRuns>()),
      known_(known ? known : own_.get()),
      which_(judged_outputs(run, *run.mechanism, outputs_)),
      families_(*run.mechanism, length_of(run)),
      rows_(*run.mechanism, which_, rows_between(run)) {}

void ElementsCheck::take(const mbs::State& s, const VectorXd& v_dot) {
  const std::size_t before = rows_.size();
  rows_.take(s, v_dot);
  if (rows_.size() > before) families_.take(s, v_dot);
}

const OutputRows& ElementsCheck::run_with(const std::vector<int>& elements,
                                          const mbs::RunCallbacks& callbacks, double& wall) {
  if (const auto found = known_->find(elements);
      found != known_->end() && found->second.outputs() == which_.size())
    return found->second;
  mbs::ModelChoice choice = run_.choice;
  for (std::size_t i = 0; i < beams_.size(); ++i) choice.bodies[beams_[i].name].elements = elements[i];
  const mbs::PreparedMechanism other = mbs::prepare(run_.source, choice, {}, run_.cache);
  const auto infos = other.mechanism->quantities();
  std::vector<int> which;
  for (const OutputEstimate& output : outputs_) {
    const auto found = std::ranges::find(infos, output.name, &mbs::OutputInfo::name);
    if (found == infos.end())
      throw std::runtime_error(output.name + " is a quantity of single elements: take it out of the outputs");
    which.push_back(static_cast<int>(found - infos.begin()));
  }
  OutputRows rows(*other.mechanism, std::move(which), rows_between(run_));
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  mbs::RunCallbacks mine;
  mine.progress = callbacks.progress;
  mine.row = [&](const mbs::State& s, const VectorXd& v_dot, const mbs::EnergyAccount&) {
    rows.take(s, v_dot);
  };
  const double limit = std::max(kLongest, kPatience * wall_of_run_);
  mine.stop_wanted = [&] { return (callbacks.stop_wanted && callbacks.stop_wanted()) || seconds() > limit; };
  const mbs::RunResult result = mbs::run(*other.mechanism, other.state, other.v_dot, other.options, mine);
  wall += seconds();
  if (!result.complete)
    throw std::runtime_error(seconds() > limit ? fmt::format("it takes longer than {:.0f} s", limit)
                                               : "it stopped: " + result.stopped_because);
  rows.forget_mechanism();
  return known_->insert_or_assign(elements, std::move(rows)).first->second;
}

void ElementsCheck::judge(bool few, const mbs::RunCallbacks& callbacks, ElementsEstimate& out) {
  std::vector<int> first, second, of_first, of_second;
  double from =
      0.0;  // of the first beam that is judged here: the lengths of elements are alike up to whole numbers
  for (const Beam& beam : beams_) {
    const int n = beam.elements;
    const bool is_meant = (n < kFewest) == few;
    first.push_back(!is_meant ? n : few ? 2 * n : (n + 1) / 2);
    second.push_back(!is_meant ? n : few ? 4 * n : (n + 3) / 4);
    if (!is_meant) continue;
    if (from == 0.0) from = n;
    of_first.push_back(first.back());
    of_second.push_back(second.back());
  }
  if (from == 0.0) return;
  std::array<double, 3> h{1.0, from / of_first[0], from / of_second[0]};
  const auto leave_unknown = [&](const std::string& why) {
    out.is_whole = false;
    out.note += fmt::format("{}{}", out.note.empty() ? "" : "; ", why);
  };
  std::array<const OutputRows*, 2> others{};
  for (const auto& [elements, rows] : {std::pair(&first, &others[0]), std::pair(&second, &others[1])}) {
    try {
      *rows = &run_with(*elements, callbacks, out.wall);
    } catch (const std::exception& error) {
      leave_unknown(
          fmt::format("a run with {} elements cannot tell: {}", fmt::join(*elements, ", "), error.what()));
      return;
    }
  }
  const double span = run_.options.end_time - run_.options.start_time;
  OutputRows::Difference near = rows_.against(*others[0], span), far = others[0]->against(*others[1], span);
  if (near.rows == 0 || far.rows == 0) {
    leave_unknown("its runs have no row in common");
    return;
  }
  const auto rms = [&](const VectorXd& squares, std::size_t i) {
    return std::sqrt(squares(static_cast<Index>(i)) / static_cast<double>(near.rows));
  };
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    outputs_[i].rms = rms(near.squares, i);
    outputs_[i].size_rms = rms(near.sizes, i);
  }
  families_.judge(outputs_, !run_.file.outputs.empty(), tolerance_of_noise(run_), Families::Of::run);
  const auto relative = [&](const OutputRows::Difference& d, std::size_t i) {
    return std::sqrt(d.squares(static_cast<Index>(i)) / static_cast<double>(d.rows)) / outputs_[i].scale;
  };
  if (few) {
    std::swap(near, far);
    h = {h[2], h[1], h[0]};
  }
  double worst = 0.0, worst_unclear = 0.0;
  std::string of, unclear;
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    if (!outputs_[i].counts || !(outputs_[i].scale > 0.0)) continue;
    const double D_12 = relative(near, i), D_23 = relative(far, i), D_run = few ? D_23 : D_12;
    double error = D_run;  // of the first order, at least
    if (std::max(D_12, D_23) >
        std::max(kOfTolerance * run_.options.tolerance, kOfIntegrator * of_integrator_)) {
      const double p = observed_order(h, D_12, D_23);
      if (p == 0.0) {
        if (D_run > worst_unclear) worst_unclear = D_run, unclear = outputs_[i].name;
        continue;
      }
      error = D_12 / (std::pow(h[1], p) - std::pow(h[0], p));  // h = 1 of the run
    }
    if (error > worst) worst = error, of = outputs_[i].name;
  }
  const std::string runs =
      fmt::format("runs with {} and {}", fmt::join(of_first, ", "), fmt::join(of_second, ", "));
  // What does not fall with the length of the elements may be anything; it matters where it is not small beside the rest.
  if (worst_unclear > 0.3 * worst) {
    leave_unknown(
        fmt::format("{} differ by {} in {}, which does not fall with their length: take more elements", runs,
                    percent(worst_unclear), unclear));
    worst = std::max(worst, worst_unclear);
    if (worst == worst_unclear) of = unclear;
  } else {
    out.note +=
        fmt::format("{}{}{}", out.note.empty() ? "" : "; ", of.empty() ? "" : "in " + of + ", ", runs);
  }
  out.error += worst;
  if (out.output.empty()) out.output = of;
}

ElementsEstimate ElementsCheck::estimate(const mbs::RunCallbacks& callbacks, double wall_of_run,
                                         double of_integrator) {
  wall_of_run_ = wall_of_run;
  of_integrator_ = of_integrator;
  ElementsEstimate out;
  for (const Beam& beam : beams_) out.bodies.push_back(beam.name);
  judge(false, callbacks, out);
  judge(true, callbacks, out);
  std::vector<int> elements;
  for (const Beam& beam : beams_) elements.push_back(beam.elements);
  OutputRows mine = rows_;
  mine.forget_mechanism();
  known_->insert_or_assign(std::move(elements), std::move(mine));
  return out;
}

}  // namespace flexura::study
