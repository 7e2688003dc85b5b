// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/assembly/input/part.hpp"

/// How good the greatest stress of a shape is.
///
/// Along re-entrant edges and around rigid interfaces the stress of an elastic body is unbounded (estimate/sharp_edges.hpp): where
/// the greatest nodal stress lies at such a node or at a node of a cell that touches one, no mesh gives it.  Judged is then the
/// greatest of the other local maxima, which stand for themselves: values beside the edge rise and fall with it.
///
/// At a maximum the nodal value, a mean over the cells, is compared with the stress recovered from a patch around it
/// (stress_recovery.hpp; O. C. Zienkiewicz, J. Z. Zhu 1992) and with the cells' own values, which differ by as much as the mesh
/// leaves open:
///
///     error = max( |s* - s|_vM , root mean square over the cells of |s_cell - s|_vM / 2 ) / |s|_vM .
namespace flexura::reduce {

struct PeakStress {
  mesh::Index node =
      -1;  ///< that was judged; -1: none, the greatest value is unbounded and nowhere else is a maximum
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< [m]
  double von_mises = 0.0;                        ///< there [Pa per unit of the shape]
  double error = -1.0;                           ///< relative to it; -1: not known
  bool singular = false;                         ///< the greatest of all lies where stress is unbounded:
  Eigen::Vector3d singular_at = Eigen::Vector3d::Zero();  ///< there [m]
};

/// Of the states U = T Y (3 n_nodes x k); `stress` (6 n_s x n): stress modes at `nodes` (recovery/stress.hpp), Y: n x k.
/// Nothing but "not known" for parts without solid cells.
std::vector<PeakStress> peak_stresses(const Part& part, const Eigen::MatrixXd& U,
                                      const Eigen::MatrixXd& stress, const std::vector<mesh::Index>& nodes,
                                      const Eigen::MatrixXd& Y);

}  // namespace flexura::reduce
