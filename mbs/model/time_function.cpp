// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/time_function.hpp"

#include <fmt/format.h>

#include "mbs/model/operations.hpp"

namespace flexura::mbs {
namespace {

using namespace operations;
using operations::operator+, operations::operator-, operations::operator*, operations::operator/;

// Which branches were taken, in the order in which they were met.
struct Branches {
  std::uint64_t hash = 1469598103934665603ULL;
  void note(int node, double branch) {
    for (const std::uint64_t x :
         {static_cast<std::uint64_t>(node), static_cast<std::uint64_t>(static_cast<std::int64_t>(branch))})
      hash = (hash ^ x) * 1099511628211ULL;
  }
};

// f, f', f'' within intervals.
struct IntervalJet {
  Interval value, first, second;
};

IntervalJet operator+(const IntervalJet& a, const IntervalJet& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
IntervalJet operator-(const IntervalJet& a, const IntervalJet& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
IntervalJet operator*(const IntervalJet& a, const IntervalJet& b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + Interval(2.0) * a.first * b.first + a.value * b.second};
}
IntervalJet operator/(const IntervalJet& a, const IntervalJet& b) {
  IntervalJet c;
  c.value = a.value / b.value;
  c.first = (a.first - c.value * b.first) / b.value;
  c.second = (a.second - Interval(2.0) * c.first * b.first - c.value * b.second) / b.value;
  return c;
}
IntervalJet hull(const IntervalJet& a, const IntervalJet& b) {
  return {intervals::hull(a.value, b.value), intervals::hull(a.first, b.first),
          intervals::hull(a.second, b.second)};
}
IntervalJet chain(const IntervalJet& f, const IntervalJet& x) {
  return {f.value, f.first * x.first, f.second * square(x.first) + f.first * x.second};
}
bool is_constant(const IntervalJet& x) {
  return x.first.magnitude() == 0.0 && x.second.magnitude() == 0.0;
}

// The functions of operations.cpp that are smooth.
IntervalJet smooth_unary(int code, const Interval& x) {
  const Interval one = 1.0, two = 2.0;
  switch (code) {
    case minus:
      return {-x, -1.0, 0.0};
    case sine:
      return {sin(x), cos(x), -sin(x)};
    case cosine:
      return {cos(x), -sin(x), -cos(x)};
    case tangent: {
      const Interval f = tan(x), d = one + square(f);
      return {f, d, two * f * d};
    }
    case arc_sine:
    case arc_cosine: {
      const Interval d = one / sqrt(one - square(x)), d2 = x * d * d * d;
      if (code == arc_sine) return {asin(x), d, d2};
      return {acos(x), -d, -d2};
    }
    case arc_tangent: {
      const Interval d = one / (one + square(x));
      return {atan(x), d, -two * x * square(d)};
    }
    case operations::sinh:
      return {intervals::sinh(x), intervals::cosh(x), intervals::sinh(x)};
    case operations::cosh:
      return {intervals::cosh(x), intervals::sinh(x), intervals::cosh(x)};
    case operations::tanh: {
      const Interval f = intervals::tanh(x), d = one - square(f);
      return {f, d, -two * f * d};
    }
    case operations::asinh: {
      const Interval d = one / sqrt(one + square(x));
      return {intervals::asinh(x), d, -x * d * d * d};
    }
    case operations::acosh: {
      const Interval d = one / sqrt(square(x) - one);
      return {intervals::acosh(x), d, -x * d * d * d};
    }
    case operations::atanh: {
      const Interval d = one / (one - square(x));
      return {intervals::atanh(x), d, two * x * square(d)};
    }
    case exponential:
      return {exp(x), exp(x), exp(x)};
    case logarithm:
    case logarithm_10:
    case logarithm_2: {
      const Interval scale = code == logarithm      ? 1.0
                             : code == logarithm_10 ? 1.0 / std::numbers::ln10
                                                    : 1.0 / std::numbers::ln2;
      const Interval d = one / x;
      return {scale * log(x), scale * d, -scale * square(d)};
    }
    case square_root: {
      const Interval f = sqrt(x);
      return {f, Interval(0.5) / f, -Interval(0.25) / (f * x)};
    }
    default:
      return {x, 1.0, 0.0};
  }
}

double integer_of(int code, double x) {
  return code == round_to_integer ? std::rint(x) : code == round_up ? std::ceil(x) : std::floor(x);
}

// Over an interval of time.
class Over {
 public:
  Over(const FormulaTree& tree, const Interval& time) : tree_(tree), time_(time) {}
  IntervalJet operator()(int k);
  bool is_decided = true;
  Branches branches;

 private:
  enum class Truth { no, yes, open };
  // Of x > 0 (or >= 0), with room for round-off of what x is made of.
  Truth positive(const Interval& x, double size) const {
    const double room = 2e-16 * size;
    return x.lo > room ? Truth::yes : x.hi < -room ? Truth::no : Truth::open;
  }
  Truth truth(const IntervalJet& x) const {
    return x.value.lo == 0.0 && x.value.hi == 0.0 ? Truth::no
           : x.value.contains(0.0)                ? Truth::open
                                                  : Truth::yes;
  }
  IntervalJet say(Truth truth) const {
    if (truth == Truth::open) return {{0.0, 1.0}, 0.0, 0.0};
    return {truth == Truth::yes ? 1.0 : 0.0, 0.0, 0.0};
  }
  IntervalJet compare(int k, const IntervalJet& a, const IntervalJet& b);
  IntervalJet rounded(int k, const Interval& x);
  IntervalJet extreme(int k, std::vector<IntervalJet>& x);
  IntervalJet step(int k, const std::vector<IntervalJet>& x);

  const FormulaTree& tree_;
  Interval time_;
};

IntervalJet Over::compare(int k, const IntervalJet& a, const IntervalJet& b) {
  const int code = tree_[k].code;
  const double size = a.value.magnitude() + b.value.magnitude();
  if (code == equal || code == not_equal) {
    Truth same = positive(a.value - b.value, size) == Truth::open ? Truth::open : Truth::no;
    if (same == Truth::open && is_constant(a) && is_constant(b) && a.value.width() == 0.0 &&
        b.value.width() == 0.0)
      same = a.value.lo == b.value.lo ? Truth::yes : Truth::no;
    if (same == Truth::open)
      is_decided = false;
    else
      branches.note(k, (same == Truth::yes) == (code == equal));
    if (same != Truth::open && code == not_equal) same = same == Truth::yes ? Truth::no : Truth::yes;
    return say(same);
  }
  const bool rising = code == greater || code == greater_equal;
  Truth truth = positive(rising ? a.value - b.value : b.value - a.value, size);
  // What does not change is as it is.
  if (truth == Truth::open && a.value.width() == 0.0 && b.value.width() == 0.0 && is_constant(a) &&
      is_constant(b)) {
    const double x = a.value.lo, y = b.value.lo;
    truth = (code == less            ? x < y
             : code == less_equal    ? x <= y
             : code == greater_equal ? x >= y
                                     : x > y)
                ? Truth::yes
                : Truth::no;
  }
  if (truth == Truth::open)
    is_decided = false;
  else
    branches.note(k, truth == Truth::yes);
  return say(truth);
}

IntervalJet Over::rounded(int k, const Interval& x) {
  const int code = tree_[k].code;
  const double room = 2e-16 * x.magnitude(), low = integer_of(code, x.lo - room),
               high = integer_of(code, x.hi + room);
  if (low == high || x.width() == 0.0)
    branches.note(k, integer_of(code, x.lo));
  else
    is_decided = false;
  if (x.width() == 0.0) return {integer_of(code, x.lo), 0.0, 0.0};
  return {Interval::of(low, high), 0.0, 0.0};
}

IntervalJet Over::extreme(int k, std::vector<IntervalJet>& x) {
  const bool least = tree_[k].code == minimum;
  for (std::size_t i = 0; i < x.size(); ++i) {
    bool wins = true;
    for (std::size_t j = 0; j < x.size() && wins; ++j) {
      if (i == j) continue;
      const Interval lead = least ? x[j].value - x[i].value : x[i].value - x[j].value;
      wins = positive(lead, x[i].value.magnitude() + x[j].value.magnitude()) == Truth::yes;
    }
    if (!wins) continue;
    branches.note(k, static_cast<double>(i));
    return x[i];
  }
  bool constants = true;
  for (const IntervalJet& one : x) constants = constants && is_constant(one) && one.value.width() == 0.0;
  IntervalJet all = x[0];
  for (const IntervalJet& one : x) {
    const Interval value =
        least ? Interval(std::min(all.value.lo, one.value.lo), std::min(all.value.hi, one.value.hi))
              : Interval(std::max(all.value.lo, one.value.lo), std::max(all.value.hi, one.value.hi));
    all = hull(all, one);
    all.value = value;
  }
  if (!constants) is_decided = false;
  return all;
}

IntervalJet Over::step(int k, const std::vector<IntervalJet>& x) {
  const IntervalJet &at = x[0], &x_0 = x[1], &y_0 = x[2], &x_1 = x[3], &y_1 = x[4];
  const Truth behind_0 = positive(at.value - x_0.value, at.value.magnitude() + x_0.value.magnitude()),
              behind_1 = positive(at.value - x_1.value, at.value.magnitude() + x_1.value.magnitude());
  if (behind_0 == Truth::no) return branches.note(k, -1), y_0;
  if (behind_0 == Truth::yes && behind_1 == Truth::yes) return branches.note(k, 1), y_1;
  IntervalJet u = (at - x_0) / (x_1 - x_0);
  if (!u.value.is_finite()) u.value = {0.0, 1.0};
  u.value = {std::clamp(u.value.lo, 0.0, 1.0), std::clamp(u.value.hi, 0.0, 1.0)};
  const auto rise = [](double v) { return v * v * (3.0 - 2.0 * v); };
  const Interval v = u.value;
  const IntervalJet s{
      {rise(v.lo), rise(v.hi)}, Interval(6.0) * v * (Interval(1.0) - v), Interval(6.0) - Interval(12.0) * v};
  const IntervalJet between = y_0 + (y_1 - y_0) * chain(s, u);
  if (behind_0 == Truth::yes && behind_1 == Truth::no) return branches.note(k, 0), between;
  is_decided = false;
  IntervalJet all = between;
  if (behind_0 == Truth::open) all = hull(all, y_0);
  if (behind_1 == Truth::open) all = hull(all, y_1);
  return all;
}

IntervalJet Over::operator()(int k) {
  const FormulaNode& node = tree_[k];
  // Branches that are not taken are not looked at.
  if (node.code == choice) {
    const Truth which = truth((*this)(node.args[0]));
    if (which != Truth::open) branches.note(k, which == Truth::yes);
    if (which == Truth::yes) return (*this)(node.args[1]);
    if (which == Truth::no) return (*this)(node.args[2]);
    is_decided = false;
    const IntervalJet yes = (*this)(node.args[1]);
    return hull(yes, (*this)(node.args[2]));
  }
  if (node.code == logical_and || node.code == logical_or) {
    const Truth enough = node.code == logical_or ? Truth::yes : Truth::no;
    const Truth a = truth((*this)(node.args[0]));
    if (a == enough) return say(a);
    const Truth b = truth((*this)(node.args[1]));
    if (a == Truth::open || b == Truth::open) is_decided = false;
    return say(b == enough ? b : a == Truth::open ? a : b);
  }
  std::vector<IntervalJet> x;
  x.reserve(node.args.size());
  for (const int arg : node.args) x.push_back((*this)(arg));
  switch (node.code) {
    case constant:
      return {node.value, 0.0, 0.0};
    case signal:
      return {time_, 1.0, 0.0};
    case add:
      return x[0] + x[1];
    case subtract:
      return x[0] - x[1];
    case multiply:
      return x[0] * x[1];
    case divide:
      return x[0] / x[1];
    case power: {
      if (!is_constant(x[1]) || x[1].value.width() > 0.0)
        return chain(smooth_unary(exponential, x[1].value * log(x[0].value)),
                     x[1] * chain(smooth_unary(logarithm, x[0].value), x[0]));
      const double n = x[1].value.lo;
      const auto derivative = [&](double factor, double exponent) {
        return factor == 0.0 ? Interval(0.0) : Interval(factor) * pow(x[0].value, exponent);
      };
      return chain({pow(x[0].value, n), derivative(n, n - 1.0), derivative(n * (n - 1.0), n - 2.0)}, x[0]);
    }
    case less:
    case less_equal:
    case greater:
    case greater_equal:
    case equal:
    case not_equal:
      return compare(k, x[0], x[1]);
    case absolute:
    case signum: {
      const Truth side = positive(x[0].value, x[0].value.magnitude());
      const bool still = x[0].value.width() == 0.0 && is_constant(x[0]);
      if (side == Truth::open && !still) {
        is_decided = false;
        if (node.code == signum) return {{-1.0, 1.0}, 0.0, 0.0};
        return {{0.0, x[0].value.magnitude()},
                hull(x[0], IntervalJet{} - x[0]).first,
                hull(x[0], IntervalJet{} - x[0]).second};
      }
      const double s = side == Truth::yes ? 1.0 : side == Truth::no ? -1.0 : 0.0;
      branches.note(k, s);
      return node.code == signum ? IntervalJet{s, 0.0, 0.0} : IntervalJet{s, 0.0, 0.0} * x[0];
    }
    case round_to_integer:
    case round_down:
    case round_up:
      return rounded(k, x[0].value);
    case modulo: {
      const IntervalJet n = rounded(k, (x[0] / x[1]).value);
      IntervalJet rest = x[0] - n * x[1];
      // Wherever it jumps it stays below y.
      if (n.value.width() > 0.0) {
        const Interval y = x[1].value;
        rest.value = {std::min(0.0, y.lo), std::max(0.0, y.hi)};
      }
      return rest;
    }
    case minimum:
    case maximum:
      return extreme(k, x);
    case smooth_step:
      return step(k, x);
    case table: {
      const Interval at = x[0].value;
      if (!at.is_finite()) {
        is_decided = false;
        return {Interval::everywhere(), Interval::everywhere(), Interval::everywhere()};
      }
      const double room = 2e-16 * at.magnitude();
      const double kinks = node.curve->kinks_until(at.lo - room);
      if (kinks == node.curve->kinks_until(at.hi + room) || at.width() == 0.0)
        branches.note(k, node.curve->kinks_until(at.lo));
      else
        is_decided = false;
      const Curve::Bounds f = node.curve->over(at);
      return chain({f.value, f.first, f.second}, x[0]);
    }
    case arc_tangent_2: {
      const Interval y = x[0].value, z = x[1].value;
      // It jumps across the negative half of the second axis.
      if (z.lo < 0.0 && positive(y, y.magnitude()) == Truth::open &&
          !(is_constant(x[0]) && y.width() == 0.0)) {
        is_decided = false;
        return {{-std::numbers::pi, std::numbers::pi}, Interval::everywhere(), Interval::everywhere()};
      }
      if (z.lo < 0.0) branches.note(k, y.lo > 0.0 || (y.lo == 0.0 && y.hi == 0.0) ? 1.0 : -1.0);
      const double corners[] = {std::atan2(y.lo, z.lo), std::atan2(y.lo, z.hi), std::atan2(y.hi, z.lo),
                                std::atan2(y.hi, z.hi)};
      Interval value(*std::min_element(corners, corners + 4), *std::max_element(corners, corners + 4));
      if (y.contains(0.0) && z.contains(0.0)) value = {-std::numbers::pi, std::numbers::pi};
      const Interval r2 = square(y) + square(z);
      IntervalJet f;
      f.value = value;
      f.first = (z * x[0].first - y * x[1].first) / r2;
      f.second =
          (z * x[0].second - y * x[1].second - Interval(2.0) * (z * x[1].first + y * x[0].first) * f.first) /
          r2;
      return f;
    }
    default:
      return chain(smooth_unary(node.code, x[0].value), x[0]);
  }
}

// At a moment.
class At {
 public:
  At(const FormulaTree& tree, double t) : tree_(tree), time_{t, 1.0, 0.0} {}
  Jet operator()(int k);
  Branches branches;

 private:
  Jet say(int k, bool truth) {
    branches.note(k, truth);
    return {truth ? 1.0 : 0.0, 0.0, 0.0};
  }
  const FormulaTree& tree_;
  Jet time_;
};

Jet At::operator()(int k) {
  const FormulaNode& node = tree_[k];
  if (node.code == choice) {
    const bool yes = (*this)(node.args[0]).value != 0.0;
    branches.note(k, yes);
    return (*this)(yes ? node.args[1] : node.args[2]);
  }
  if (node.code == logical_and || node.code == logical_or) {
    const bool enough = node.code == logical_or;
    const bool a = (*this)(node.args[0]).value != 0.0;
    const bool both = a == enough ? a : (*this)(node.args[1]).value != 0.0;
    return {both ? 1.0 : 0.0, 0.0, 0.0};
  }
  std::vector<Jet> x;
  x.reserve(node.args.size());
  for (const int arg : node.args) x.push_back((*this)(arg));
  switch (node.code) {
    case constant:
      return {node.value, 0.0, 0.0};
    case signal:
      return time_;
    case add:
      return x[0] + x[1];
    case subtract:
      return x[0] - x[1];
    case multiply:
      return x[0] * x[1];
    case divide:
      return x[0] / x[1];
    case power:
      return power_of(x[0], x[1]);
    case less:
      return say(k, x[0].value < x[1].value);
    case less_equal:
      return say(k, x[0].value <= x[1].value);
    case greater:
      return say(k, x[0].value > x[1].value);
    case greater_equal:
      return say(k, x[0].value >= x[1].value);
    case equal:
      return say(k, x[0].value == x[1].value);
    case not_equal:
      return say(k, x[0].value != x[1].value);
    case absolute:
    case signum:
      branches.note(k, apply_unary(signum, x[0].value));
      return apply_unary(node.code, x[0]);
    case round_to_integer:
    case round_down:
    case round_up:
      branches.note(k, integer_of(node.code, x[0].value));
      return apply_unary(node.code, x[0]);
    case modulo:
      branches.note(k, std::floor(x[0].value / x[1].value));
      return modulo_of(x[0], x[1]);
    case minimum:
    case maximum: {
      std::size_t best = 0;
      for (std::size_t i = 1; i < x.size(); ++i)
        if (node.code == minimum ? x[i].value < x[best].value : x[i].value > x[best].value) best = i;
      branches.note(k, static_cast<double>(best));
      return x[best];
    }
    case smooth_step:
      branches.note(k, x[0].value <= x[1].value ? -1 : x[0].value >= x[3].value ? 1 : 0);
      return smooth_step_of(x[0], x[1], x[2], x[3], x[4]);
    case table:
      branches.note(k, node.curve->kinks_until(x[0].value));
      return table_of(*node.curve, x[0]);
    case arc_tangent_2:
      if (x[1].value < 0.0) branches.note(k, x[0].value >= 0.0 ? 1.0 : -1.0);
      return arc_tangent_2_of(x[0], x[1]);
    default:
      return apply_unary(node.code, x[0]);
  }
}

enum class Kind { constant, of_time, other };

Kind kind_of(const FormulaTree& tree, int k, const TimeFunction::Source& source) {
  const FormulaNode& node = tree[k];
  if (node.code == signal) {
    if (node.place == 0) return Kind::of_time;
    const FormulaTree* other = source(node.place);
    return other ? kind_of(*other, other->root, source) : Kind::other;
  }
  Kind kind = Kind::constant;
  for (const int arg : node.args) {
    const Kind of_arg = kind_of(tree, arg, source);
    if (of_arg == Kind::other) return of_arg;
    if (of_arg == Kind::of_time) kind = of_arg;
  }
  return kind;
}

}  // namespace

TimeFunction::TimeFunction(std::string where, bool drives, const FormulaTree& tree, int node,
                           const Source& source)
    : where_(std::move(where)), drives_(drives) {
  tree_.root = inline_tree(tree, node, source);
}

int TimeFunction::inline_tree(const FormulaTree& tree, int k, const Source& source) {
  FormulaNode node = tree[k];
  if (node.code == signal && node.place > 0) {
    const FormulaTree* other = source(node.place);
    return inline_tree(*other, other->root, source);
  }
  node.held = 0;
  for (int& arg : node.args) arg = inline_tree(tree, arg, source);
  return tree_.add(std::move(node));
}

TimeFunction::Bounds TimeFunction::over(double begin, double end) const {
  Over over(tree_, Interval(begin, end));
  const IntervalJet f = over(tree_.root);
  return {f.value, f.first, f.second, over.is_decided, over.branches.hash};
}

TimeFunction::Point TimeFunction::at(double t) const {
  At at(tree_, t);
  const Jet jet = at(tree_.root);
  return {jet, at.branches.hash};
}

std::string TimeFunction::fingerprint() const {
  std::string text = drives_ ? "drive" : "force";
  for (const FormulaNode& node : tree_.nodes) {
    text += fmt::format(" {} {:a} {}", node.code, node.value, static_cast<const void*>(node.curve.get()));
    for (const int arg : node.args) text += fmt::format(",{}", arg);
  }
  return text;
}

std::vector<int> TimeFunction::parts(const FormulaTree& tree, const Source& source) {
  std::vector<int> found;
  const auto look = [&](const auto& self, int k) -> void {
    switch (kind_of(tree, k, source)) {
      case Kind::of_time:
        found.push_back(k);
        break;
      case Kind::other:
        for (const int arg : tree[k].args) self(self, arg);
        break;
      case Kind::constant:
        break;
    }
  };
  look(look, tree.root);
  return found;
}

}  // namespace flexura::mbs
