// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Steps towards an equilibrium that lead downhill: Newton's, where the stiffness K is positive definite on the null space
/// of the constraints G, else those of K + sigma D, with the diagonal D of the masses; and no further along each than
/// the energy falls.  Positions have the units `unit` = D^-1/2, rows of G those of `row_unit`.
namespace flexura::mbs {

/// K on the null space of G, in these units.
Eigen::MatrixXd on_null_space(const Eigen::MatrixXd& K, const Eigen::MatrixXd& G, const Eigen::VectorXd& unit,
                              const Eigen::VectorXd& row_unit);

/// Units in which every coordinate is as stiff as the others, those that nothing holds by the masses; empty
/// where nothing is stiff.  What takes part in rows G may be softer than the rest by 1e10 only: it would be all that a row sees.
Eigen::VectorXd units_of_stiffness(const Eigen::MatrixXd& K, const Eigen::MatrixXd& G,
                                   const Eigen::VectorXd& by_mass);

/// sigma: 0 where K is positive definite already, or where there is nothing to move, and at least `floor` times the stiffest
/// direction else.
double downhill_shift(const Eigen::MatrixXd& K, const Eigen::MatrixXd& G, const Eigen::VectorXd& unit,
                      const Eigen::VectorXd& row_unit, double floor);

/// How much of a step is taken.
class Stride {
 public:
  /// Of a step of `size` typical sizes the part to try first: half a size at a time, so that a swing does not turn into a
  /// somersault, and more where the way leads straight down.
  double part(double size) const { return size > longest_ ? longest_ / size : 1.0; }
  /// Whether `part` may stand where the slope along the step is `slope` at its beginning and `ahead` at the end of the part
  /// (slopes of the energy: forces left over times the step); shortens it where that is over a hill's foot and up again.
  bool stands(double slope, double ahead, double& part);

 private:
  double longest_ = 0.5;
};

}  // namespace flexura::mbs
