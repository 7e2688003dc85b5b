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

/// One sentence where a run shows rows so near to a position at which constraints lose rank that they are worse than
/// `tolerance`, else "": by what their loops are open by (RankWatch), or worse than ten times that by what the mechanism's
/// parts do not fit by, `misfit` in parts of its size, as misfit / sigma^2.
std::string near_rank_loss(const Equations& eq, const RankWatch::Nearness& nearness, double misfit,
                           double tolerance);

}  // namespace flexura::mbs
