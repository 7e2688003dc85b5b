// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mbs/base/files/json_text.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/results/results.hpp"
#include "mbs/study/estimate/percent.hpp"
#include "mbs/study/front.hpp"

namespace flexura::study {
namespace {

using terminal::number;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

results::Run read_run(const Measurement& m) {
  return std::move(results::read(m.results).runs.front());
}

}  // namespace

std::vector<Signal> read_signals(const StudyFile& study, const results::Run& run) {
  std::vector<Signal> signals;
  for (const WantedQuantity& q : study.quantities) {
    const auto found = std::ranges::find(run.quantities, q.name, &results::Quantity::name);
    if (found == run.quantities.end())
      throw std::invalid_argument(
          fmt::format("{}: quantity.{}: the results have no \"{}\"; choose one that flexura outputs lists",
                      study.file.string(), q.label, q.name));
    Signal whole{run.time, run.values.col(found - run.quantities.begin())};
    signals.push_back(q.to > q.from || q.from > 0.0 ? window(whole, q.from, q.to > q.from ? q.to : kInfinite)
                                                    : std::move(whole));
    if (q.norm == Norm::count)
      signals.back().value = (signals.back().value.array().abs() - q.level).matrix().eval();
  }
  return signals;
}

namespace {

// A quantity that is zero or noise is judged against the largest of its unit that the reference stores.
double size_in_family(double own, const results::Run& run, const std::string& name, Norm norm) {
  constexpr double kNoise = 1e-6;
  const auto self = std::ranges::find(run.quantities, name, &results::Quantity::name);
  double family = 0.0;
  for (std::size_t k = 0; k < run.quantities.size(); ++k)
    if (run.quantities[k].unit == self->unit)
      family = std::max(family, size_of({run.time, run.values.col(static_cast<Eigen::Index>(k))}, norm));
  return own < kNoise * family ? family : own;
}

class Judge {
 public:
  Judge(const StudyFile& study, const Measurements& measured) : study_(study), measured_(measured) {}

  Judgement judge() {
    const results::Run reference = run_or_refuse(measured_.reference, study_.reference.name);
    reference_ = read_signals(study_, reference);
    for (std::size_t k = 0; k < study_.quantities.size(); ++k) {
      const WantedQuantity& q = study_.quantities[k];
      size_.push_back(q.scale > 0.0 ? q.scale : size_of(reference_[k], q.norm));
      if (q.scale <= 0.0 && q.norm != Norm::frequency && q.norm != Norm::count)
        size_.back() = size_in_family(size_.back(), reference, q.name, q.norm);
      if (!(size_.back() > 0.0))
        throw std::invalid_argument(
            fmt::format("{}: quantity.{}: \"{}\" is zero in the reference, so an error relative to it has no "
                        "meaning, and nothing else of its unit is stored; give scale",
                        study_.file.string(), q.label, q.name));
    }
    find_uncertainty();
    find_errors();
    answer();
    return std::move(out_);
  }

 private:
  results::Run run_or_refuse(const Measurement& m, const std::string& name) const {
    if (!m.complete)
      throw std::invalid_argument(fmt::format(
          "{}: the run \"{}\" {}; nothing can be measured without it; make it run by itself first",
          study_.file.string(), name, m.failure));
    return read_run(m);
  }
  std::vector<Signal> signals_or_refuse(const Measurement& m, const std::string& name) const {
    return read_signals(study_, run_or_refuse(m, name));
  }

  double relative(std::size_t k, const Signal& a, const Signal& b) const {
    return difference(a, b, study_.quantities[k].norm) / size_[k];
  }

  // The run's own estimate in the norms of the study; a mean errs no more than the rms, a frequency has none. And whether
  // it judged all in which runs of one study differ.
  double estimate_of(const results::Run& run, Row& row, bool& is_comparable) const {
    const auto summary = files::try_read_json(run.summary_json);
    if (!summary.is_object() || !summary.contains("estimate")) return -1.0;
    const auto& estimate = summary.at("estimate");
    if (estimate.contains("unknown"))
      for (const auto& source : estimate.at("unknown")) {
        row.is_at_least = true;
        is_comparable = is_comparable && source.value("source", "") == "mesh";
      }
    double largest = 0.0;
    if (estimate.contains("outputs")) {
      const auto& outputs = estimate.at("outputs");
      for (std::size_t k = 0; k < size_.size(); ++k) {
        const WantedQuantity& q = study_.quantities[k];
        const char* const norm = q.norm == Norm::rms || q.norm == Norm::mean ? "rms"
                                 : q.norm == Norm::final                     ? "final"
                                                                             : "max";
        if (q.norm == Norm::frequency || q.norm == Norm::count || !outputs.contains(q.name)) continue;
        const auto& value = outputs.at(q.name).at(norm);
        largest = std::max(largest, value.is_number() ? value.get<double>() / size_[k] : kInfinite);
      }
    }
    // Without a second run the integrator's share is unknown, and its energy balance a lower bound.
    for (const char* const key : {"integrator", "energy_balance"})
      if (estimate.contains(key) && estimate.at(key).is_number())
        return largest + estimate.at(key).get<double>();
    return largest;
  }

  void find_uncertainty() {
    out_.uncertainty.assign(size_.size(), 0.0);
    for (std::size_t c = 0; c < study_.checks.size(); ++c) {
      const auto signals = signals_or_refuse(measured_.checks[c], study_.checks[c].choice.name);
      for (std::size_t k = 0; k < size_.size(); ++k)
        out_.uncertainty[k] += study_.checks[c].share * relative(k, signals[k], reference_[k]);
    }
    out_.largest_uncertainty = *std::ranges::max_element(out_.uncertainty);
  }

  void find_errors() {
    const Measurement& finest = measured_.choices.back();
    std::vector<Signal> finest_signals;
    if (finest.complete) finest_signals = read_signals(study_, read_run(finest));
    for (std::size_t i = 0; i < study_.choices.size(); ++i) {
      Row row;
      row.choice = &study_.choices[i];
      row.cost = &measured_.choices[i];
      row.errors.assign(size_.size(), {kInfinite, kInfinite});
      bool is_comparable = true;
      if (row.cost->complete) {
        const results::Run run = read_run(*row.cost);
        const auto signals = read_signals(study_, run);
        row.estimate = estimate_of(run, row, is_comparable);
        for (std::size_t k = 0; k < size_.size(); ++k) {
          row.errors[k].against_reference = relative(k, signals[k], reference_[k]);
          if (finest.complete) row.errors[k].against_finest = relative(k, signals[k], finest_signals[k]);
        }
      }
      for (std::size_t k = 0; k < size_.size(); ++k) {
        row.error.against_finest = std::max(row.error.against_finest, row.errors[k].against_finest);
        if (row.errors[k].against_reference > row.error.against_reference) {
          row.error.against_reference = row.errors[k].against_reference;
          row.worst = k;
        }
      }
      row.price = study_.cpu_is_cost ? row.cost->median_cpu() : row.cost->median_wall();
      if (is_comparable && row.estimate > 0.0 && row.error.against_reference > 3.0 * out_.largest_uncertainty)
        row.effectivity = row.estimate / row.error.against_reference;
      out_.rows.push_back(std::move(row));
    }
    // What the program chose is no rung of the ladder.
    for (std::size_t i = 0; i < out_.rows.size(); ++i)
      if (out_.rows[i].choice->wanted == 0.0) {
        points_.push_back({out_.rows[i].price, out_.rows[i].error.against_reference});
        rungs_.push_back(i);
      }
    const std::vector<bool> front = pareto_front(points_);
    for (std::size_t k = 0; k < front.size(); ++k) out_.rows[rungs_[k]].on_front = front[k];
    for (const Row& row : out_.rows) {
      if (row.choice->wanted == 0.0) continue;
      const auto k = cheapest_within(points_, row.choice->wanted);
      out_.chosen.push_back({row.choice->wanted, &row, k ? &out_.rows[rungs_[*k]] : nullptr});
    }
  }

  const std::string& name_of(std::size_t point) const { return study_.choices[rungs_[point]].name; }

  void answer() {
    for (const double accuracy : study_.accuracies) {
      std::string text;
      if (const auto i = cheapest_within(points_, accuracy))
        text = fmt::format("cheapest within {}: {} ({} s, error {})", percent(accuracy), name_of(*i),
                           number(points_[*i].cost, 3), percent(points_[*i].error));
      else
        text = fmt::format("within {}: none of these choices", percent(accuracy));
      if (out_.largest_uncertainty > 0.3 * accuracy)
        text +=
            fmt::format("; the reference itself is only known within {}", percent(out_.largest_uncertainty));
      out_.answers.push_back(std::move(text));
    }
    for (const double time : study_.times) {
      if (const auto i = most_accurate_within(points_, time))
        out_.answers.push_back(fmt::format("most accurate within {} s: {} ({} s, error {})", number(time, 3),
                                           name_of(*i), number(points_[*i].cost, 3),
                                           percent(points_[*i].error)));
      else
        out_.answers.push_back(fmt::format("within {} s: none of these choices", number(time, 3)));
    }
    for (const Chosen& chosen : out_.chosen) {
      std::string text =
          fmt::format("chosen by the program for {}: {} s, error {}: {}", percent(chosen.wanted),
                      number(chosen.row->price, 3), percent(chosen.row->error.against_reference),
                      chosen.met() ? "met" : "not met");
      if (chosen.cheapest)
        text += fmt::format(", at {} times the cost of \"{}\"", number(chosen.cost_ratio(), 3),
                            chosen.cheapest->choice->name);
      out_.answers.push_back(std::move(text));
    }
    effectivities();
    for (const Row& row : out_.rows)
      if (!row.cost->complete)
        out_.notes.push_back(fmt::format("{}: {}", row.choice->name, row.cost->failure));
  }

  void effectivities() {
    std::vector<double> known;
    for (const Row& row : out_.rows)
      if (row.effectivity >= 0.0) known.push_back(row.effectivity);
    if (known.empty()) return;
    const auto inside = std::ranges::count_if(known, [](double e) { return e >= 0.3 && e <= 3.0; });
    const auto [least, most] = std::ranges::minmax_element(known);
    out_.answers.push_back(
        fmt::format("error as the runs estimated it over the true one: {} to {}, median {}; {} of {} between "
                    "0.3 and 3",
                    number(*least, 2), number(*most, 2), number(median(known), 2), inside, known.size()));
  }

  const StudyFile& study_;
  const Measurements& measured_;
  std::vector<std::size_t> rungs_;  // rows of points_
  std::vector<Signal> reference_;
  std::vector<double> size_;
  std::vector<TradePoint> points_;
  Judgement out_;
};

}  // namespace

Judgement judge(const StudyFile& study, const Measurements& measured) {
  return Judge(study, measured).judge();
}

}  // namespace flexura::study
