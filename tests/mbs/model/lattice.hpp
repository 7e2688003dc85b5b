// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/superelement/superelement.hpp"

/// A superelement that can be checked by hand: point masses at the nodes of a box-shaped lattice, joined by
/// bars.  Its end faces are tied rigidly to two interface nodes, the rest is reduced by Craig and Bampton.
/// All integrals are sums over the points.
namespace flexura::mbs::lattice {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Lattice {
  superelement::Superelement se;
  Matrix3Xd x;    ///< positions
  VectorXd mass;  ///< of the points
  MatrixXd T;     ///< 3 N x n: displacements for unit superelement coordinates
};

/// With n_q fixed-interface modes; bars of this E A [N].
Lattice make_lattice(int n_q, double bar_stiffness = 400.0);

/// Symmetric matrices of random numbers in place of the geometric stiffening of n shapes and two interfaces.
superelement::StiffeningTerms any_stiffening(int n, unsigned seed);

/// The superelement with pictures: all points as the vertices of its surface, and the shapes on them.
superelement::Superelement with_surface(const Lattice& lattice);

}  // namespace flexura::mbs::lattice
