// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"

/// The linear system about a state, in independent coordinates:
///
///     x' = A x + B u,   y = C x + D u,   x = (z, z', c)
///
/// z are n_z = n_v - rank G coordinates out of the mechanism's own, chosen so that they determine the others
/// best (independent.hpp); all names are given.  About an equilibrium
///
///     A = [      0            1     ]
///         [ -M_z^-1 K_z  -M_z^-1 D_z ]
///
/// exactly, with K_z = N^T K N, M_z and D_z alike, of the derivatives of Equations::tangents().  Else the columns of A come from central differences of the constrained motion itself: z and z' are
/// moved, the other coordinates follow their constraints on position and velocity level, and the accelerations
/// are those of index 1.  Errors are then those of the differences, about 1e-9 of A's scale.  About a motion (v != 0) the
/// system is that of the perturbed motion in coordinates that move along; its coefficients are constant where
/// the motion is steady.
namespace flexura::mbs {

struct LinearSystem {
  Eigen::MatrixXd A, B, C, D;
  std::vector<std::string> states, inputs, outputs;
  Eigen::VectorXd x_0, u_0, y_0;  ///< values at the linearisation state
  std::vector<int> independent;   ///< velocity coordinates that make up z
  Eigen::MatrixXd N;              ///< n_v x n_z: dq = N z at the state
  Eigen::MatrixXd V;              ///< n_v x n_z: dv = V z + N z'; 0 at rest
  /// What A may lack, in parts of its norm in balanced coordinates: round-off, or that of differences.
  double relative_error = 1e-9;
};

/// The same system in coordinates that refer to turning axes, with W of Mechanism::turning_axes: z, z' are
/// then the components of dq, dv there, in axes that coincide with the mechanism's own at the state.
LinearSystem in_turning_axes(LinearSystem system, const Eigen::MatrixXd& W);

struct LineariseOptions {
  /// Generalised forces on these velocity coordinates are the inputs u.
  std::vector<int> inputs;
  /// Then the mechanism's own inputs with these indices (Equations::n_inputs).
  std::vector<int> signals;
  /// Outputs y of a state with its accelerations, and their names.
  std::vector<std::string> output_names;
  std::function<Eigen::VectorXd(const State&, const Eigen::VectorXd& v_dot)> outputs;
};

/// `s` must be consistent (assembled).  Throws std::runtime_error.
LinearSystem linearise(const Equations& eq, const State& s, const LineariseOptions& options = {});

struct NaturalMode {
  std::complex<double> eigenvalue;  ///< [1/s]
  double frequency_hz = 0.0;        ///< |imag| / 2 pi
  double damping = 0.0;             ///< -real / |eigenvalue|; negative: unstable
  double noise = 0.0;      ///< what the eigenvalue may lack by the round-off of A and of solving [1/s]
  Eigen::VectorXcd shape;  ///< of the velocity coordinates q (n_v), largest entry 1
};

/// Eigenvalues of A by rising frequency, of each conjugate pair the one with positive imaginary part.  Parts that are
/// no more than noise are 0.
std::vector<NaturalMode> natural_modes(const LinearSystem& system);

/// C (i omega - A)^-1 B + D at each of these frequencies [Hz].
std::vector<Eigen::MatrixXcd> frequency_response(const LinearSystem& system,
                                                 const Eigen::VectorXd& frequencies_hz);

}  // namespace flexura::mbs
