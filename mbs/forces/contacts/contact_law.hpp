// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

/// The compliant law of everything that touches and lets go: contacts, bump stops, teeth.
///
/// With the penetration delta > 0 and its rate u, and n the exponent (1: linear, 3/2: Hertz),
///
///     damping d       N = k delta^n + d u,               never pulling: it lets go where N falls to 0
///     restitution e   N = k delta^n (1 + chi u / u_0),   u_0 the rate at touch-down
///
/// where chi makes the rate at lift-off exactly -e u_0 if nothing but N acts during the impact (K. H. Hunt,
/// F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445, gives the law; the condition is exact here).  From
/// m u' = -N, u du / (1 + chi u / u_0) is a multiple of delta^n d delta, whose integral vanishes over the
/// impact:
///
///     chi (1 + e) = ln((1 + chi) / (1 - chi e)),       0 <= chi < 1 / e
///
/// Touch and release are switches: the integrator stops at them.
namespace flexura::mbs {

class ContactLaw {
 public:
  /// Throws std::invalid_argument unless k > 0, n >= 1, d >= 0, 0 < e <= 1; e = 1 means no damping.
  ContactLaw(double stiffness, double exponent, double damping, double restitution, double slowest);

  static constexpr int n_switches = 2;  ///< touching, pushing
  /// What stops pushing has come down to no force; what touches may set in with a damping force.
  static bool jumps_at(int which) { return which != 1; }
  /// With restitution u_0, which stays constant between touch-downs.
  int n_states() const { return chi_ > 0.0 ? 1 : 0; }

  /// Is there a force?  Both switches on.
  static bool active(const int* root) { return root[0] == 1 && root[1] == 1; }
  /// Switching functions at a gap (< 0: penetration) and its rate: positive while the positions are right.
  void switching(double gap, double gap_rate, const int* root, const double* c, double* values) const;
  /// Positions of the switches away from their zeros.
  void start(double gap, double gap_rate, int* root, double* c) const;
  /// Takes a switch whose function fell below 0 into its other position.
  void change(int which, double gap_rate, int* root, double* c) const;
  /// N >= 0.
  double force(double gap, double gap_rate, const int* root, const double* c) const;
  /// Its derivatives.
  struct Slopes {
    double by_gap = 0.0, by_rate = 0.0, by_state = 0.0;
  };
  Slopes slopes(double gap, double gap_rate, const int* root, const double* c) const;
  /// Energy stored [J] and power lost [W].
  double energy(double gap, const int* root) const;
  /// Its part that has this energy.
  double elastic_force(double gap, const int* root) const { return active(root) ? elastic(gap) : 0.0; }
  double lost_power(double gap, double gap_rate, const int* root, const double* c) const;
  double chi() const { return chi_; }
  double stiffness() const { return k_; }

 private:
  double elastic(double gap) const { return gap < 0.0 ? k_ * std::pow(-gap, n_) : 0.0; }
  /// Positive where the law pushes; goes on through the gap's zero without a step.
  double push(double gap, double gap_rate, const double* c) const;

  double k_, n_, d_, chi_, slowest_;
};

}  // namespace flexura::mbs
