// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/equations/equations.hpp"
#include "mbs/mechanism/motion/tree_motion.hpp"

/// Axes that turn: the same motion through a tree joint, its components in axes K that turn with Omega
/// relative to the joint's frame F and coincide with F's now.
///
///     V_FM = S v,     S exp(t W) = diag(R, R) S,  R = exp(t [Omega]x)     =>     S W = ad S
///
/// with ad = diag([Omega]x, [Omega]x).  W is there where the span of S is the same in all these axes: a ball
/// joint's and a free joint's, a plane's turning in itself, a hinge's turning about its pin (W = 0 then).
namespace flexura::mbs {

/// As in Mechanism, after forward() on level velocity.
Eigen::MatrixXd turning_axes(const Topology& tree, const State& s, const Vector3d& Omega_W,
                             const Motion& motion);
Eigen::MatrixXd turning_with_bodies(const Topology& tree, const State& s, const Motion& motion);

}  // namespace flexura::mbs
