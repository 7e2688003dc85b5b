// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "mbs/base/math/differences.hpp"
#include "mbs/base/math/rotation.hpp"
#include "mbs/controls/control.hpp"
#include "mbs/measures/measure.hpp"

/// Controls and measures whose derivatives are taken by central differences, for elements of users' own.  Inline: libraries of users
/// are not linked with the program.
namespace flexura::mbs {

/// Step of central differences by a signal or state; what is smaller than 1e-3 of its unit is stepped as if it were that.
inline double difference_step(double x) {
  return kCentralStep * std::max(std::abs(x), 1e-3);
}

/// A control that gives rates() and output(), or residual(), alone.  They must be smooth between switches.
class DifferencedControl : public Control {
 public:
  using Control::Control;
  void differentiate_rates(const double* signals, const double* c, Derivatives& d) const final {
    const auto n = static_cast<std::size_t>(n_states());
    if (n == 0) return;
    // One sweep for all states: column by column of what is seen.
    const Seen seen(*this, signals, c);
    std::vector<std::vector<double>> slopes(seen.size(), std::vector<double>(n));
    for (std::size_t k = 0; k < seen.size(); ++k) {
      std::vector<double> up(n), down(n);
      const double h = seen.step(k);
      const Seen above(seen, k, h), below(seen, k, -h);
      rates(above.signals(), above.c(), up.data());
      rates(below.signals(), below.c(), down.data());
      for (std::size_t i = 0; i < n; ++i) slopes[k][i] = (up[i] - down[i]) / (2.0 * h);
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (is_held(static_cast<int>(i))) continue;
      d.rate(static_cast<int>(i));
      for (std::size_t k = 0; k < seen.size(); ++k) seen.tell(k, slopes[k][i], d);
    }
  }
  void differentiate(const double* signals, const double* c, Derivatives& d) const final {
    const Seen seen(*this, signals, c);
    d.rows();
    for (std::size_t k = 0; k < seen.size(); ++k) {
      const double h = seen.step(k);
      const Seen above(seen, k, h), below(seen, k, -h);
      seen.tell(k, (value(above) - value(below)) / (2.0 * h), d);
    }
  }

 private:
  // The signals and states that it sees, one of them moved.
  class Seen {
   public:
    Seen(const Control& of, const double* signals, const double* c) : reads_(of.reads()) {
      std::sort(reads_.begin(), reads_.end());
      reads_.erase(std::unique(reads_.begin(), reads_.end()), reads_.end());
      const int last = reads_.empty() ? 0 : reads_.back();
      signals_.assign(signals, signals + last + 1);
      if (c != nullptr) c_.assign(c, c + of.n_states());
    }
    Seen(const Seen& from, std::size_t k, double h) : Seen(from) { at(k) += h; }
    std::size_t size() const { return reads_.size() + c_.size(); }
    const double* signals() const { return signals_.data(); }
    const double* c() const { return c_.data(); }
    double step(std::size_t k) const { return difference_step(Seen(*this).at(k)); }
    void tell(std::size_t k, double slope, Derivatives& d) const {
      if (slope == 0.0) return;
      if (k < reads_.size())
        d.by_signal(reads_[k], Eigen::Matrix<double, 1, 1>(slope));
      else
        d.by_state(static_cast<int>(k - reads_.size()), slope);
    }

   private:
    double& at(std::size_t k) {
      return k < reads_.size() ? signals_[static_cast<std::size_t>(reads_[k])] : c_[k - reads_.size()];
    }
    std::vector<int> reads_;
    std::vector<double> signals_, c_;
  };
  double value(const Seen& seen) const {
    return is_algebraic() ? residual(seen.signals()) : output(seen.signals(), seen.c());
  }
};

/// A measure that gives its value alone: a function of the positions and speeds of markers() relative to the first of them (for
/// what is absolute let the first be "ground") and of signals, not of accelerations, joint or modal coordinates.
class DifferencedMeasure : public Measure {
 public:
  using Measure::Measure;
  virtual std::vector<int> markers() const = 0;
  void differentiate(const Kinematics& kin, const double* signals, Derivatives& d) const final {
    d.rows();
    differentiate_by_signals(kin, signals, d);
    const std::vector<int> seen = markers();
    Kinematics moved = kin;
    for (std::size_t k = 1; k < seen.size(); ++k) {
      const int M = seen[k];
      const Relative at = kin.relative_motion(seen[0], M);
      const double length = at.X_FM.p.norm(), speed = at.V.norm();
      Eigen::Matrix<double, 1, 12> slopes;
      for (int i = 0; i < 12; ++i) {
        // By what is seen itself, or by 1 of its unit where that is 0.
        const double size = i < 3   ? 1.0
                            : i < 6 ? length
                                    : speed,
                     h = kCentralStep * (size > 0.0 ? size : 1.0);
        const auto value_at = [&](double step) {
          Relative rel = at;
          if (i < 3)
            rel.X_FM.R = rotation_exp(step * Vector3d::Unit(i)) * at.X_FM.R;
          else if (i < 6)
            rel.X_FM.p(i - 3) += step;
          else
            rel.V(i - 6) += step;
          moved.markers[static_cast<std::size_t>(M)] =
              seen_from(kin.markers[static_cast<std::size_t>(seen[0])], rel);
          return value(moved, signals);
        };
        slopes(i) = (value_at(h) - value_at(-h)) / (2.0 * h);
      }
      moved.markers[static_cast<std::size_t>(M)] = kin.markers[static_cast<std::size_t>(M)];
      if (!slopes.isZero(0.0)) d.by_relative(seen[0], M, slopes);
    }
  }

 private:
  void differentiate_by_signals(const Kinematics& kin, const double* signals, Derivatives& d) const {
    const std::vector<int> read = reads();
    if (read.empty()) return;
    std::vector<double> moved(signals, signals + *std::max_element(read.begin(), read.end()) + 1);
    for (const int k : read) {
      double& x = moved[static_cast<std::size_t>(k)];
      const double x_0 = x, h = difference_step(x_0);
      x = x_0 + h;
      const double above = value(kin, moved.data());
      x = x_0 - h;
      const double below = value(kin, moved.data());
      x = x_0;
      if (above != below) d.by_signal(k, Eigen::Matrix<double, 1, 1>((above - below) / (2.0 * h)));
    }
  }
  static MarkerState seen_from(const MarkerState& F, const Relative& rel) {
    MarkerState M;
    const Matrix3d& R = F.X_WP.R;
    const Vector3d r = R * rel.X_FM.p;
    M.X_WP = {R * rel.X_FM.R, F.X_WP.p + r};
    M.V.angular = F.V.angular + R * rel.V.head<3>();
    M.V.linear = F.V.linear + F.V.angular.cross(r) + R * rel.V.tail<3>();
    return M;
  }
};

}  // namespace flexura::mbs
