// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/known_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/formulas/time_function.hpp"

namespace flexura::mbs {

namespace {

// Of the range times the span, in one part: an impulse that no tolerance resolves.  A pulse takes some dozens of parts, so
// that what may be passed over is worth less than 1e-11 of them.
constexpr double kQuietImpulse = 1e-13;
// Parts that are not at one with themselves where they are so short, as beside a pole, are left alone.
constexpr double kShortest = 1e-12;
constexpr int kParts = 3;
// Parts looked at for one answer.  An event takes 60, a sine's period four; where more are needed a formula without
// values is asked about, or one whose jumps are as close as numbers.
constexpr int kMostParts = 1 << 18;
// Events that lie closer than so many of the smallest steps of the time are passed together.
constexpr double kTogether = 16.0;

// The resolution of the time at t; near 0, where numbers are denser, of a thousandth of the span.
double smallest_step(double t, double span) {
  return std::numeric_limits<double>::epsilon() * std::max(std::abs(t), 1e-3 * span);
}

}  // namespace

class KnownTimes::Scan {
 public:
  struct Item {
    double begin, end;
    bool is_event;
  };

  Scan(std::shared_ptr<const TimeFunction> f, double begin, double end, double fixed_step)
      : f_(std::move(f)), begin_(begin), span_(end - begin), fixed_step_(fixed_step), scanned_(begin) {
    const TimeFunction::Bounds whole = f_->over(begin, end);
    is_straight_ = whole.is_decided && whole.second.magnitude() == 0.0;
    double range = whole.value.width();
    if (!std::isfinite(range)) {
      Interval seen(std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity());
      for (int i = 0; i <= 256; ++i) {
        const double x = f_->at(begin + span_ * i / 256.0).jet.value;
        if (std::isfinite(x)) seen = {std::min(seen.lo, x), std::max(seen.hi, x)};
      }
      range = std::max(0.0, seen.width());
    }
    quiet_ = kQuietImpulse * range * span_;
    parts_.push_back({begin, end, 0.0});
  }

  bool is_straight() const { return is_straight_; }

  /// What lies behind t, as far as kParts, an event or the horizon.
  const std::deque<Item>& ahead(double t, double horizon) {
    while (!items_.empty() && items_.front().end <= t) items_.pop_front();
    for (int n = 0; !parts_.empty() && scanned_ < horizon && !is_enough(); ++n) {
      if (n == kMostParts) give_up();
      advance(t);
    }
    return items_;
  }

 private:
  struct Part {
    double begin, end, bends;  // the largest |f''| seen in the part that it is half of
  };
  bool is_enough() const { return items_.size() >= kParts || (!items_.empty() && items_.back().is_event); }
  void halve(const Part& part, double bends) {
    const double middle = 0.5 * (part.begin + part.end);
    parts_.push_back({middle, part.end, bends});
    parts_.push_back({part.begin, middle, bends});
  }
  void advance(double t);
  [[noreturn]] void give_up() const;
  void add_event(double before, double after);

  std::shared_ptr<const TimeFunction> f_;
  double begin_, span_, fixed_step_, quiet_ = 0.0, scanned_;
  bool is_straight_ = false;
  std::vector<Part> parts_;  // the earliest last
  std::deque<Item> items_;
  bool knows_branches_ = false;
  std::uint64_t branches_ = 0;  // at scanned_
};

void KnownTimes::Scan::add_event(double before, double after) {
  const Jet a = f_->at(before).jet, b = f_->at(after).jet;
  const double wide = 8.0 * (after - before);
  const auto differs = [](double x, double y, double relative, double rest) {
    return !(std::abs(y - x) <= relative * std::max(std::abs(x), std::abs(y)) + rest);
  };
  const bool value = differs(a.value, b.value, 1e-9, wide * std::max(std::abs(a.first), std::abs(b.first)));
  const bool slope = differs(a.first, b.first, 1e-9, wide * std::max(std::abs(a.second), std::abs(b.second)));
  const bool bend = differs(a.second, b.second, 1e-6, 0.0);
  if (!value && !slope && !bend) return;
  items_.push_back({before, after, true});
}

void KnownTimes::Scan::give_up() const {
  const auto has_value = [&](double t) { return std::isfinite(f_->at(t).jet.value); };
  double last = begin_, without = parts_.back().begin;
  const bool has_values = has_value(without) && has_value(parts_.back().end);
  for (int i = 0; i < 60 && !has_values && has_value(last); ++i) {
    const double middle = 0.5 * (last + without);
    (has_value(middle) ? last : without) = middle;
  }
  throw std::runtime_error(fmt::format(
      "{} cannot be followed beyond t = {:.9g} s: {}; correct the formula, or let the run end before",
      f_->where(), has_values ? scanned_ : last,
      has_values ? "it jumps or bends more often there than steps can be made"
                 : "it has no value there (asin, sqrt, log or a division beyond what they take?)"));
}

void KnownTimes::Scan::advance(double t) {
  const Part part = parts_.back();
  parts_.pop_back();
  const double h = part.end - part.begin;
  if (part.end <= t) {  // of a continued run
    scanned_ = part.end;
    knows_branches_ = false;
    return;
  }
  const TimeFunction::Bounds f = f_->over(part.begin, part.end);
  const double step = smallest_step(std::max(std::abs(part.begin), std::abs(part.end)), span_);
  if (!f.is_decided) {
    if (h > step && 0.5 * (part.begin + part.end) > part.begin) return halve(part, part.bends);
    const TimeFunction::Point a = f_->at(part.begin), b = f_->at(part.end);
    if (a.branches != b.branches) add_event(part.begin, part.end);
    knows_branches_ = true;
    branches_ = b.branches;
    scanned_ = part.end;
    return;
  }
  const double straight =
      std::min({f.value.width(), 0.25 * h * f.first.width(), 0.125 * h * h * f.second.magnitude()});
  // A fixed step that begins or ends here gives it the weight of its own length.
  const bool is_quiet = std::max(h, fixed_step_) * straight <= quiet_;
  double bends = 0.0;
  if (!is_quiet) {
    for (int i = 0; i <= 4; ++i) {
      const double x = std::abs(f_->at(part.begin + 0.25 * i * h).jet.second);
      if (x > bends) bends = x;
    }
    if (!(f.second.width() <= 1.5 * std::max(bends, part.bends)) && h > kShortest * span_)
      return halve(part, bends);
  }
  // Jumps at the seam of two parts belong to neither.
  if (knows_branches_ && branches_ != f.branches) {
    const bool old = f_->at(part.begin).branches == branches_;
    add_event(old ? part.begin : part.begin - step, old ? part.begin + step : part.begin);
  }
  knows_branches_ = true;
  branches_ = f.branches;
  scanned_ = part.end;
  if (!is_quiet && h > kShortest * span_) items_.push_back({part.begin, part.end, false});
}

KnownTimes::KnownTimes(const Equations& eq, const SolverOptions& options)
    : begin_(options.start_time),
      end_(options.end_time),
      reach_(std::max({options.output_step, options.fixed_step,
                       options.max_step > 0.0 ? options.max_step : 0.1 * (end_ - begin_)})),
      passed_(-std::numeric_limits<double>::infinity()),
      fixed_step_(options.fixed_step) {
  if (!(end_ > begin_)) return;
  for (const auto& f : eq.functions_of_time()) {
    auto scan = std::make_unique<Scan>(f, begin_, end_, fixed_step_);
    if (!scan->is_straight()) scans_.push_back(std::move(scan));
  }
}

KnownTimes::~KnownTimes() = default;

void KnownTimes::for_each(const Equations& eq, const SolverOptions& options,
                          const std::function<bool(const Stretch&)>& take) {
  KnownTimes times(eq, options);
  times.reach_ = options.end_time - options.start_time;
  double before = -std::numeric_limits<double>::infinity(), t = options.start_time;
  // A run with more of them is known to be one of short events long before its end.
  for (long i = 0; i < 100000 && t < options.end_time; ++i) {
    const Stop stop = times.next(t);
    if (!std::isfinite(stop.t)) break;
    const double begin = stop.is_event ? before : std::max(before, times.last_bound_begin_);
    if (!stop.is_due && !take({begin, stop.t, stop.is_event})) break;
    before = t = stop.is_event ? stop.after : stop.t;
    if (stop.is_event) times.pass(stop);
  }
}

double KnownTimes::shortest(const Equations& eq, const SolverOptions& options, double limit) {
  double shortest = limit;
  for_each(eq, options, [&](const Stretch& stretch) {
    shortest = std::min(shortest, stretch.end - stretch.begin);
    return true;
  });
  return shortest < limit ? shortest : 0.0;
}

KnownTimes::Looks KnownTimes::looks(const Equations& eq, const SolverOptions& options, double apart,
                                    std::size_t most) {
  constexpr int kBehind = 16;
  // Of the longest of a group: shorter ones are the ends of a curve that begins smoothly.
  constexpr double kCounts = 0.02;
  Looks out;
  const auto look = [&](double t) {
    if (t > options.start_time && t < options.end_time) out.t.push_back(t);
  };
  // What is left behind fades, nobody knows how soon.
  const auto look_behind = [&](double t) {
    for (int k = kBehind; k > 0; --k) look(t + apart * std::exp2(-0.5 * k));
  };
  // Short stretches that follow one another, up to the next event.
  std::vector<Stretch> group;
  const auto end_group = [&] {
    if (group.empty()) return;
    const double begin = group.front().begin, length = group.back().end - begin;
    double longest = 0.0;
    for (const Stretch& one : group) longest = std::max(longest, one.end - one.begin);
    const auto bounds = std::ranges::count_if(
        group, [&](const Stretch& one) { return one.end - one.begin > kCounts * longest; });
    const int n = std::max(kLooks, 4 * static_cast<int>(bounds));
    for (int k = 0; k <= n; ++k) look(begin + length * k / n);
    look_behind(begin + length);
    group.clear();
  };
  for_each(eq, options, [&](const Stretch& stretch) {
    const bool is_short = stretch.end - stretch.begin < 2.0 * apart;
    if (!is_short || (!group.empty() && stretch.begin > group.back().end + apart)) end_group();
    if (is_short) group.push_back(stretch);
    if (stretch.ends_at_event && group.empty()) {
      look(stretch.end);
      look_behind(stretch.end);
    } else if (stretch.ends_at_event) {
      end_group();
    }
    out.is_all = out.t.size() + group.size() <= most;
    return out.is_all;
  });
  end_group();
  std::ranges::sort(out.t);
  out.t.erase(std::unique(out.t.begin(), out.t.end()), out.t.end());
  out.is_all = out.is_all && out.t.size() <= most;
  if (out.t.size() > most) out.t.resize(most);
  return out;
}

KnownTimes::Stop KnownTimes::next(double t) {
  const double from = std::max(t, passed_);
  Stop stop;
  double bound = stop.t;
  for (const auto& scan : scans_) {
    int parts = 0;
    for (const Scan::Item& item : scan->ahead(from, from + reach_)) {
      if (item.is_event) {
        stop.t = std::min(stop.t, item.begin);
        break;
      }
      if (item.end - item.begin < fixed_step_) {
        // Nothing else would see that the step is too long.
        const double quarter = 0.25 * (item.end - item.begin);
        bound = std::min(bound, item.begin > from ? item.begin : std::min(item.end, from + quarter));
        break;
      }
      if (++parts < kParts) continue;
      if (item.end < bound) {
        bound = item.end;
        last_bound_begin_ = scan->ahead(from, from + reach_).front().begin;
      }
      break;
    }
  }
  if (bound < stop.t) {
    stop.t = bound;
    return stop;
  }
  if (!std::isfinite(stop.t)) return stop;
  const double close = kTogether * smallest_step(stop.t, end_ - begin_), together = stop.t + close;
  stop.is_event = true;
  stop.is_due = stop.t <= t + close;
  stop.after = stop.t;
  for (const auto& scan : scans_)
    for (const Scan::Item& item : scan->ahead(from, from + reach_))
      if (item.is_event && item.begin <= together) stop.after = std::max(stop.after, item.end);
  return stop;
}

}  // namespace flexura::mbs
