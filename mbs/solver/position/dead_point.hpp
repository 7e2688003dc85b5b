// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/position/projection.hpp"

/// Positions at which independent constraint rows lose rank for an instant: dead points, change points, where
/// branches of motion cross, and the last position that a locking mechanism reaches.
///
/// With D = M_ii^-1/2, E the rows' lengths in G D, and Y, N the left and right null spaces of E G D, a motion
/// along w = D N z goes on if the constraints' second derivative allows it,
///
///     Q(w) = Y^T E gamma(w) = 0,
///
/// and it is the only one near by if dQ/dz has full rank (a transversal crossing).
namespace flexura::mbs {

/// Looks where a consistent state with its accelerations leads. Throws AssemblyError where rank is lost and
/// neither the speeds nor, from rest, the accelerations lie on a branch: which one the mechanism takes would be
/// decided by round-off. Returns a note where rank is lost and it stands still, else "".
std::string require_one_branch(const Equations& eq, const State& s, const Eigen::VectorXd& v_dot);

/// Whether rows that are independent elsewhere depend on each other where the mechanism stands.
bool loses_rank(const Equations& eq, const State& s);

/// The message of an integrator that could not go on from s: where rows nearly lose rank there it says which, else
/// it is `trouble` as it was.
std::string with_rank_loss(const Equations& eq, const State& s, const std::string& trouble);

/// One sentence where a run came so near to a position at which rows lose rank that what follows from their inverse is
/// worse than ten times `tolerance` there, else "". With sigma their least singular value, an error e of the positions
/// (in parts of the mechanism's size: what its parts do not fit by, and round-off) moves the mechanism by e / sigma
/// along the motion that the rows nearly allow, which changes sigma by as much, and so speeds, accelerations and forces
/// by e / sigma^2 of themselves.
std::string near_rank_loss(const Equations& eq, const LoopCloser::Nearness& nearness, double misfit,
                           double tolerance);

}  // namespace flexura::mbs
