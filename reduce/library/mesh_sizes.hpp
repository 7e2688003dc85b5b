// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/estimate/sharp_edges.hpp"

/// Sizes of the next mesh from the errors of the cells of one.
///
/// A cell of size h that is made smaller by the factor f leaves  e f^a  of its error e and costs  f^-d  cells.  Away from
/// edges a = 2p, d = 3 (p the degree).  Along an edge where stresses are unbounded like r^(lambda - 1) the energy left is that
/// of a tube, a = 2 lambda, and as sizes may grow away from the edge, only its length is to be divided: d = 1 (I. Babuska,
/// R. B. Kellogg, J. Pitkaranta, Numer. Math. 33 (1979) 447; T. Apel, Anisotropic Finite Elements, 1999).  The fewest cells for
/// a given sum of errors:  minimise sum f^-d with sum e f^a given, so that  a e f^(a+d) / d  is the same for all cells.  Of several
/// motions each has a sum of its own; with Lagrange's multipliers mu_k, 0 where a motion's sum is smaller than it may be,
/// e is sum_k mu_k e_k.
namespace flexura::reduce {

/// Factor f of each cell (order of the blocks of solids) so that the greatest sum of the errors becomes `aim`; 1/16 to
/// `coarsest`.  `share`: the errors today, n_cells x n_motions; `sharp`: of the nodes.
Eigen::VectorXd cell_factors(const mesh::Mesh& mesh, const Eigen::MatrixXd& share,
                             const std::vector<char>& sharp, double aim, double coarsest = 1.5);

/// About how many times as many cells the factors ask for.
double cells_for(const mesh::Mesh& mesh, const Eigen::VectorXd& factor, const std::vector<char>& sharp);

/// x, y, z, size (mesh::CadOptions::sizes): sizes at the nodes, growing from node to node by no more than half of the way,
/// and between the nodes where they differ much.
std::vector<double> size_points(const mesh::Mesh& mesh, const Eigen::VectorXd& factor,
                                const std::vector<char>& sharp);

}  // namespace flexura::reduce
