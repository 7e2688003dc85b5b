// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/linear/linearise.hpp"

/// The damping ratio that the bodies' laws ask of a natural mode, beside the one that it has.
///
/// A law gives ratios zeta_k to eigenmodes k of its body, whose strain energies are e_k where the mechanism's mode has the total
/// energy E.  Were these all the mode's damping and the body's eigenmodes the mechanism's, its ratio would be
///
///     sum over bodies and k of zeta_k e_k / E
///
/// (energy law of composite damping; Ungar and Kerwin, JASA 34, 1962).  The mode's own ratio differs by dampers and by what the
/// joints make of the body's modes.
namespace flexura::mbs {

class AskedDamping {
 public:
  /// About the state s, which outlives it.
  AskedDamping(const Mechanism& mechanism, const State& s);

  /// True where a body's law asks for ratios above zero; else of() is of no interest.
  bool any() const { return any_; }
  /// The ratio; empty where the mode does not vibrate, and where a body takes part whose damping is a matrix (D_se): that asks for
  /// no ratio.
  std::optional<double> of(const NaturalMode& mode) const;

 private:
  struct Part {
    Eigen::VectorXi rows;    ///< m: its coordinates among the velocities
    Eigen::VectorXd omega2;  ///< m: stiffness of the modal coordinates
    Eigen::MatrixXd asked;   ///< m x m: sum of zeta_k omega_k^2 in the modal coordinates; empty: no ratios
  };
  std::vector<Part> parts_;
  Eigen::MatrixXd M_;  ///< n_v x n_v
  bool any_ = false;
};

}  // namespace flexura::mbs
