// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/norms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

#include "mbs/base/documents/document.hpp"

namespace flexura::study {
namespace {

using Eigen::VectorXd;

// Weights of the trapezoidal rule, divided by the span.
VectorXd trapezoidal_weights(const VectorXd& t) {
  const Eigen::Index n = t.size();
  VectorXd w = VectorXd::Zero(n);
  if (n < 2) return VectorXd::Ones(n);
  for (Eigen::Index i = 0; i + 1 < n; ++i) {
    const double h = 0.5 * (t(i + 1) - t(i));
    w(i) += h;
    w(i + 1) += h;
  }
  return w / w.sum();
}

double rms(const VectorXd& t, const VectorXd& y) {
  return std::sqrt(trapezoidal_weights(t).dot(y.cwiseAbs2()));
}

// Rows that are above zero after one that was not; a signal that begins above zero has not risen.
double rises(const VectorXd& y) {
  Eigen::Index n = 0;
  for (Eigen::Index i = 1; i < y.size(); ++i) n += y(i) > 0.0 && !(y(i - 1) > 0.0);
  return static_cast<double>(n);
}

void require_same_times(const VectorXd& a, const VectorXd& b) {
  const double span = b.size() > 1 ? b(b.size() - 1) - b(0) : 1.0;
  if (a.size() != b.size() || (a - b).cwiseAbs().maxCoeff() > 1e-9 * span)
    throw std::invalid_argument(
        fmt::format("the runs store {} and {} rows at different times; all choices of a study need the same "
                    "solver.start_time, end_time and output_step",
                    a.size(), b.size()));
}

}  // namespace

const std::vector<std::string>& norm_names() {
  static const std::vector<std::string> names = {"max", "rms", "final", "mean", "peak", "frequency", "count"};
  return names;
}

Norm norm_of(const std::string& name) {
  const auto found = std::ranges::find(norm_names(), name);
  if (found == norm_names().end())
    throw std::invalid_argument(
        fmt::format("there is no norm \"{}\"{}", name, input::suggestion(name, norm_names())));
  return static_cast<Norm>(found - norm_names().begin());
}

Signal window(const Signal& signal, double from, double to) {
  const Eigen::Index n = signal.time.size();
  if (n == 0) return signal;
  const double slack = 1e-9 * (signal.time(n - 1) - signal.time(0));
  const double *begin = signal.time.data(), *end = begin + n;
  const auto first = std::lower_bound(begin, end, from - slack) - begin;
  const auto last = std::upper_bound(begin, end, to + slack) - begin;
  if (last <= first) return {};
  return {signal.time.segment(first, last - first), signal.value.segment(first, last - first)};
}

double size_of(const Signal& reference, Norm norm) {
  if (reference.value.size() == 0) return 0.0;
  switch (norm) {
    case Norm::rms:
      return rms(reference.time, reference.value);
    case Norm::frequency:
      return dominant_frequency(reference);
    case Norm::count:
      return rises(reference.value);
    default:
      return reference.value.cwiseAbs().maxCoeff();
  }
}

double value_of(const Signal& signal, Norm norm) {
  const VectorXd& y = signal.value;
  if (y.size() == 0)
    throw std::invalid_argument("a signal without rows has no value; give a span of time that has rows");
  if (norm == Norm::final) return y(y.size() - 1);
  if (norm == Norm::mean) return trapezoidal_weights(signal.time).dot(y);
  return size_of(signal, norm);
}

double difference(const Signal& signal, const Signal& reference, Norm norm) {
  if (norm == Norm::count) return std::abs(rises(signal.value) - rises(reference.value));
  if (norm != Norm::final) require_same_times(signal.time, reference.time);
  const VectorXd &y = signal.value, &y_ref = reference.value;
  if (y.size() == 0 || y_ref.size() == 0)
    throw std::invalid_argument(
        "a signal without rows cannot be compared; give a span of time that has rows");
  switch (norm) {
    case Norm::max:
      return (y - y_ref).cwiseAbs().maxCoeff();
    case Norm::rms:
      return rms(reference.time, y - y_ref);
    case Norm::final:
      return std::abs(y(y.size() - 1) - y_ref(y_ref.size() - 1));
    case Norm::mean:
      return std::abs(trapezoidal_weights(reference.time).dot(y - y_ref));
    case Norm::peak:
      return std::abs(y.cwiseAbs().maxCoeff() - y_ref.cwiseAbs().maxCoeff());
    case Norm::frequency:
      return std::abs(dominant_frequency(signal) - dominant_frequency(reference));
    case Norm::count:
      break;  // told above
  }
  return 0.0;
}

double dominant_frequency(const Signal& signal) {
  const Eigen::Index n = signal.time.size();
  if (n < 8) throw std::invalid_argument(fmt::format("a frequency needs at least 8 rows, there are {}", n));
  const double start = signal.time(0), span = signal.time(n - 1) - start;
  const VectorXd w = trapezoidal_weights(signal.time);
  VectorXd y = signal.value;
  VectorXd hann(n);
  for (Eigen::Index i = 0; i < n; ++i)
    hann(i) = 1.0 - std::cos(2.0 * std::numbers::pi * (signal.time(i) - start) / span);
  // The mean in the window's own weight leaves nothing of a constant.
  const VectorXd weight = w.cwiseProduct(hann);
  y.array() -= weight.dot(y) / weight.sum();
  if (y.cwiseAbs().maxCoeff() <= 1e-14 * signal.value.cwiseAbs().maxCoeff()) return 0.0;
  const VectorXd weighted = weight.cwiseProduct(y);
  const auto strength = [&](double f) {
    std::complex<double> sum = 0.0;
    for (Eigen::Index i = 0; i < n; ++i)
      sum += std::polar(weighted(i), -2.0 * std::numbers::pi * f * (signal.time(i) - start));
    return std::norm(sum);
  };
  // The main lobe of the window is 4 / span wide: half a line of 1 / span between samples cannot miss it.
  const double step = 0.5 / span, highest = 0.5 * static_cast<double>(n - 1) / span;
  double best = step * 2.0, most = -1.0;
  for (double f = 2.0 * step; f <= highest; f += step) {
    const double s = strength(f);
    if (s > most) {
      most = s;
      best = f;
    }
  }
  // Golden section: one maximum within a lobe.
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double a = best - step, b = best + step;
  double c = b - golden * (b - a), d = a + golden * (b - a), s_c = strength(c), s_d = strength(d);
  for (int k = 0; k < 40; ++k) {
    if (s_c > s_d) {
      b = d;
      d = c;
      s_d = s_c;
      c = b - golden * (b - a);
      s_c = strength(c);
    } else {
      a = c;
      c = d;
      s_c = s_d;
      d = a + golden * (b - a);
      s_d = strength(d);
    }
  }
  return 0.5 * (a + b);
}

}  // namespace flexura::study
