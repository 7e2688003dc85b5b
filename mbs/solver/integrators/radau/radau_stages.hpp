// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>

#include "mbs/solver/integrators/newton_matrix.hpp"
#include "mbs/solver/integrators/radau/radau_tableau.hpp"

namespace flexura::mbs {

/// Newton's method for the stages of Radau IIA (radau.hpp) with derivatives of each stage's own,
///
///     (1/h) sum_j B_ij F_y',i dZ_j + F_y,i dZ_i = -R_i,
///
/// where one matrix for all stages does not contract: the mass matrix in the axes of a ball joint whose one inertia is
/// 1e10 times the other changes by 1e10 (omega h)^2 from stage to stage.  B is replaced by the triangular L^-1 of A = L U
/// with ones on U's diagonal (P. J. van der Houwen, J. J. B. de Swart, SIAM J. Sci. Comput. 18 (1997) 41-55), so that the
/// stages are solved for one after the other, each with a real matrix; what this leaves falls to 0 within three passes
/// where the step is short beside what moves, and for the stiff and the algebraic parts.
class RadauStages {
 public:
  RadauStages(const Equations& eq, const RadauTableau& tableau, const State& start);

  void set_start(const State& s);
  /// Takes the derivatives of stage i at (t, y, y') and factorises for a step h; false when these are not finite.
  bool linearise(int i, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& yp, double h);
  /// From the residuals R_i the corrections dZ_i in their place.
  void solve(std::array<Eigen::VectorXd, 3>& R);

  long linearised() const { return linearised_; }
  long evaluations() const;  ///< of the equations, by the derivatives

 private:
  struct Stage {
    Stage(const Equations& eq, const State& start) : form(eq, start), matrix(form) {}
    StabilisedIndex2 form;
    NewtonMatrix<double> matrix;
  };
  std::array<std::unique_ptr<Stage>, 3> stages_;
  Eigen::Matrix3d L_inverse_;
  double h_ = 0.0;
  Eigen::VectorXd rate_, product_, rhs_;
  long linearised_ = 0;
};

}  // namespace flexura::mbs
