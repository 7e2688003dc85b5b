// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/linear/linearise.hpp"

/// Where a linear system has a meaning beyond its instant: about a state at rest that stays there, or about a
/// motion along which its coefficients do not change.
///
/// The coordinates that show it are looked for: the mechanism's own, then such as refer to axes that turn
/// (Mechanism::turning_axes) with the body that each joint moves, with any one body, or with the precession
///
///     Omega = w x w' / |w|^2 + s w,    w'' = Omega x w'
///
/// of a body's angular velocity w.  In axes with v' = W v the motion goes on as
///
///     v(t + tau) = exp(tau W) v,    p' = T(p) v,
///
/// and what is asked is that rates and matrices found there anew are the same in those axes.  Eigenvalues
/// alone do not tell: of a spinning body described in fixed axes they are the same at every instant, and are
/// not those of its motion.
namespace flexura::mbs {

struct SteadyLinearisation {
  enum class Verdict {
    equilibrium,
    steady_motion,  ///< constant coefficients, in the axes that `axes` names
    unsteady        ///< `why` says so; the system is that of the instant, in the mechanism's own coordinates
  };
  Verdict verdict = Verdict::unsteady;
  LinearSystem system;
  Eigen::MatrixXd W;  ///< of the axes; empty: the mechanism's own
  std::string axes;   ///< "axes that turn with ..."; empty: the mechanism's own
  std::string why;    ///< one clause
  State later;        ///< of a steady motion: where it is tau later, and exp(tau W)
  double tau = 0.0;
  Eigen::MatrixXd moved;
  std::vector<std::string> notes;  ///< sentences for the user
};

/// `s` must be consistent (assembled); `horizon` [s] is how far ahead the user looks: what changes within a
/// hundredth of it changes.  Throws std::runtime_error.
SteadyLinearisation linearise_steady(const Mechanism& mechanism, const State& s, double horizon,
                                     const LineariseOptions& options = {});

}  // namespace flexura::mbs
