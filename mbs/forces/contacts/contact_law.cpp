// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/contacts/contact_law.hpp"

#include <algorithm>
#include <stdexcept>

namespace flexura::mbs {
namespace {

/// chi (1 + e) = ln((1 + chi) / (1 - chi e)).  f = left - right starts with a slope of 0 at chi = 0, is
/// positive first and falls to minus infinity at 1 / e: bisection between the maximum and there.
double chi_of(double e) {
  if (e >= 1.0) return 0.0;
  const auto f = [e](double chi) { return chi * (1.0 + e) - std::log1p(chi) + std::log1p(-chi * e); };
  // f' = (1 + e) - 1 / (1 + chi) - e / (1 - chi e) vanishes at 0 and at chi = (1 - e) / e, the maximum.
  double low = (1.0 - e) / e, high = 1.0 / e;
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (f(middle) > 0.0 ? low : high) = middle;
  }
  return low;
}

}  // namespace

ContactLaw::ContactLaw(double stiffness, double exponent, double damping, double restitution, double slowest)
    : k_(stiffness), n_(exponent), d_(damping), chi_(0.0), slowest_(slowest) {
  if (!(k_ > 0.0)) throw std::invalid_argument("a contact needs a stiffness above 0");
  if (!(n_ >= 1.0)) throw std::invalid_argument("the exponent of a contact must be at least 1");
  if (!(d_ >= 0.0)) throw std::invalid_argument("the damping of a contact must not be negative");
  if (!(restitution > 0.0 && restitution <= 1.0))
    throw std::invalid_argument("a restitution lies between 0 (excluded) and 1");
  chi_ = chi_of(restitution);
}

double ContactLaw::push(double gap, double gap_rate, const double* c) const {
  if (chi_ > 0.0) return 1.0 - chi_ * gap_rate / c[0];
  if (d_ > 0.0) return (gap < 0.0 ? elastic(gap) : -elastic(-gap)) - d_ * gap_rate;
  return 1.0;
}

void ContactLaw::switching(double gap, double gap_rate, const int* root, const double* c,
                           double* values) const {
  values[0] = root[0] == 1 ? -gap : gap;
  // Apart from each other there is nothing to push.
  values[1] = root[0] == 0 ? 1.0 : root[1] == 1 ? push(gap, gap_rate, c) : -push(gap, gap_rate, c);
}

void ContactLaw::start(double gap, double gap_rate, int* root, double* c) const {
  root[0] = gap < 0.0 || (gap == 0.0 && gap_rate < 0.0) ? 1 : 0;
  if (chi_ > 0.0) c[0] = std::max(-gap_rate, slowest_);
  root[1] = push(gap, gap_rate, c) >= 0.0 ? 1 : 0;
}

void ContactLaw::change(int which, double gap_rate, int* root, double* c) const {
  root[which] = 1 - root[which];
  if (which == 1 || root[0] == 0) return;
  root[1] = 1;  // what comes together pushes: d u > 0, or 1 + chi
  if (chi_ > 0.0) c[0] = std::max(-gap_rate, slowest_);
}

double ContactLaw::force(double gap, double gap_rate, const int* root, const double* c) const {
  if (!active(root)) return 0.0;
  if (chi_ > 0.0) return elastic(gap) * (1.0 - chi_ * gap_rate / c[0]);
  return elastic(gap) - d_ * gap_rate;
}

ContactLaw::Slopes ContactLaw::slopes(double gap, double gap_rate, const int* root, const double* c) const {
  if (!active(root)) return {};
  const double slope = gap < 0.0 ? -k_ * n_ * std::pow(-gap, n_ - 1.0) : 0.0;
  if (chi_ == 0.0) return {slope, -d_, 0.0};
  const double f = elastic(gap);
  return {slope * (1.0 - chi_ * gap_rate / c[0]), -f * chi_ / c[0], f * chi_ * gap_rate / (c[0] * c[0])};
}

double ContactLaw::energy(double gap, const int* root) const {
  return active(root) && gap < 0.0 ? k_ * std::pow(-gap, n_ + 1.0) / (n_ + 1.0) : 0.0;
}

double ContactLaw::lost_power(double gap, double gap_rate, const int* root, const double* c) const {
  if (!active(root)) return 0.0;
  if (chi_ > 0.0) return elastic(gap) * chi_ / c[0] * gap_rate * gap_rate;
  return d_ * gap_rate * gap_rate;
}

}  // namespace flexura::mbs
