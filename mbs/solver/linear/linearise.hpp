// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"

/// The linear system about a state, in independent coordinates:
///
///     x' = A x + B u,   y = C x + D u + D_1 u' + D_2 u'',   x = (z, w, c) - T_0 u - T_1 u'
///
/// It is the tangent of the consistent states (perturbation.hpp).  z are positions out of the mechanism's own, n_v less the
/// rank of the rows with a position level, w are n_v - rank G speeds, both chosen so that they determine the others best
/// (independent.hpp), c the dynamic states that are no held values.  Without rows on speeds alone (rolling, drive_speed) z are
/// the integrals of w; with them there are more positions than speeds.
///
/// An input that a position follows (a drive, the offset of a coupler, the place on a path) acts by u'' too, one that a
/// speed follows by u':
///
///     (z, w, c)' = A (z, w, c) + B_0 u + B_1 u' + B_2 u''
///
/// The states are then counted from what the inputs alone make of them, T_1 = B_2, T_0 = B_1 + A B_2, so that
/// B = B_0 + A T_0; the transfer function is C (s - A)^-1 B + D + s D_1 + s^2 D_2 exactly.  D_1 and D_2 are empty where no output
/// reads a rate of the inputs.
///
/// About a motion (v != 0) the system is that of the perturbed motion in coordinates that move along; its coefficients
/// are constant where the motion is steady.
namespace flexura::mbs {

struct LinearSystem {
  Eigen::MatrixXd A, B, C, D, D_1, D_2;
  Eigen::MatrixXd T_0, T_1;  ///< empty where zero
  std::vector<std::string> states, inputs, outputs;
  Eigen::VectorXd x_0, u_0, y_0;  ///< values at the linearisation state
  std::vector<int> positions;     ///< velocity coordinates whose integrals make up z
  std::vector<int> independent;   ///< velocity coordinates that make up w
  std::vector<int> dynamic;       ///< dynamic states among x
  Eigen::MatrixXd N;              ///< n_v x w: dv = N w at fixed z
  Eigen::MatrixXd Q, V;           ///< n_v x n_x: dq = Q x, dv = V x

  /// What inputs do: B_k, and dq, dv and y by u, u', u''.
  struct ByInputs {
    std::array<Eigen::MatrixXd, 3> rates, q, v, y;
  } by_inputs;

  /// What A may lack, in parts of its norm in balanced coordinates: round-off, or that of differences.
  double relative_error = 1e-14;
};

/// The same system in coordinates that refer to turning axes, with W of Mechanism::turning_axes: z, w are
/// then the components of dq, dv there, in axes that coincide with the mechanism's own at the state.
LinearSystem in_turning_axes(LinearSystem system, const Eigen::MatrixXd& W);

/// Without the positions beyond the integrals of w that neither a rate nor an output reads.
LinearSystem without_unread(LinearSystem system);

/// A generalised force on a coordinate that is no state, that of a joint that closes a loop.
struct ForceAlong {
  std::string name;         ///< of the speed whose power it has
  Eigen::VectorXd on_rows;  ///< what a unit force puts on the velocity coordinates (n_v)
};

struct LineariseOptions {
  /// Generalised forces on these velocity coordinates are the inputs u.
  std::vector<int> inputs;
  std::vector<ForceAlong> along;  ///< then these
  /// Then the mechanism's own inputs with these indices (Equations::n_inputs).
  std::vector<int> signals;
  /// Outputs y of a state with its accelerations, and their names.
  std::vector<std::string> output_names;
  std::function<Eigen::VectorXd(const State&, const Eigen::VectorXd& v_dot)> outputs;
  bool all_positions = false;  ///< also those that without_unread() leaves out
};

/// What unit inputs `inputs`, then `along` put on the velocity coordinates (n_v rows).
Eigen::MatrixXd forces_of_inputs(const LineariseOptions& options, Eigen::Index n_v);

/// `s` must be consistent (assembled).  Throws std::runtime_error.
LinearSystem linearise(const Equations& eq, const State& s, const LineariseOptions& options = {});

/// Derivatives of outputs by everything that they read, each on its own (n_y rows): v_dot, lambda and a are held.
struct OutputTangents {
  Eigen::MatrixXd q, v, c, a, lambda, v_dot;
  std::array<Eigen::MatrixXd, 3> u;  ///< by `signals` and their rates
};
OutputTangents differentiate_outputs(const Equations& eq, const State& s, const Eigen::VectorXd& v_dot,
                                     const LineariseOptions& options);

struct NaturalMode {
  std::complex<double> eigenvalue;  ///< [1/s]
  double frequency_hz = 0.0;        ///< |imag| / 2 pi
  double damping = 0.0;             ///< -real / |eigenvalue|; negative: unstable
  double noise = 0.0;      ///< what the eigenvalue may lack by the round-off of A and of solving [1/s]
  Eigen::VectorXcd shape;  ///< of the velocity coordinates q (n_v), largest entry 1
};

/// Eigenvalues of A by rising magnitude (of a vibration its undamped frequency), of each conjugate pair the one with positive
/// imaginary part.  Parts that are no more than noise are 0.
std::vector<NaturalMode> natural_modes(const LinearSystem& system);

/// C (i omega - A)^-1 B + D + i omega D_1 - omega^2 D_2 at each of these frequencies [Hz].
std::vector<Eigen::MatrixXcd> frequency_response(const LinearSystem& system,
                                                 const Eigen::VectorXd& frequencies_hz);

/// `grid` with points more at each vibration within it: at its frequency and in steps of its half-power width about it,
/// between which a response looks like its peak.  Ascending [Hz].
Eigen::VectorXd with_resonances(const LinearSystem& system, const Eigen::VectorXd& grid);

}  // namespace flexura::mbs
