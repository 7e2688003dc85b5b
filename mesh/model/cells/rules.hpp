// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/model/cells/cell.hpp"

/// Quadrature rules on reference cells, for the files beside.
namespace flexura::mesh {

struct Rule {
  std::vector<Eigen::Vector3d> x;
  std::vector<double> w;
  void add(double r, double s, double t, double weight) {
    x.emplace_back(r, s, t);
    w.push_back(weight);
  }
  Quadrature finish() const;
};

/// n Gauss points in each direction of a line, square or cube [-1, 1]^d; n = 1 to 5.
Rule tensor(int dimension, int n);
/// 1, 3 or 7 points (degree 1, 2, 5).
Rule triangle_symmetric(int n);
/// A collapsed square, n x n points, exact to degree 2 n - 2.
Rule triangle_collapsed(int n);
Rule triangle_times_line(const Rule& triangle, int n);
/// A collapsed cube (conical product).
Rule pyramid_rule(int n_base, int n_height);
/// The four points (a, a, a, 1 - 3 a), each of weight w.
void tetrahedron_corner_orbit(Rule& rule, double a, double w);
/// Walkington's 14 points of degree 5.
Rule tetrahedron14();

}  // namespace flexura::mesh
