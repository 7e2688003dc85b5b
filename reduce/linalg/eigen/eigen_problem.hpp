// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

struct _p_PetscViewer;  // PETSc's, which only .cpp files see

namespace flexura::linalg {

/// K phi = omega^2 M phi by what the operators do to blocks of vectors (n x k).  `solve` is (K + shift M)^-1
/// on the space in which the problem lives (fixed averages may make it smaller than n); its results lie in
/// that space.
struct EigenProblem {
  using Operator = std::function<void(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y)>;
  int n = 0;           ///< length of the vectors
  int n_free = 0;      ///< dimension of the space
  double shift = 0.0;  ///< of `solve` [1/s^2]
  Operator solve, multiply_K, multiply_M;
  /// Y = |K| |X| entry by entry, for what round-off leaves of a residual.
  Operator multiply_magnitudes;
  /// The orthogonal projection into the space: takes reactions out of a residual K phi - omega^2 M phi, and
  /// round-off out of phi; may be empty.
  std::function<void(Eigen::MatrixXd&)> project;
  /// Likewise for residuals alone, where the space is no coordinate plane with reactions across it (interface
  /// modes); in place of `project` there.  May be empty.
  std::function<void(Eigen::MatrixXd&)> condense;
  /// Sums numbers over the processes that hold rows of the vectors each (n is this one's); empty: one has all.
  std::function<void(double* numbers, Eigen::Index count)> sum;
  int rank = 0;  ///< of this process among them
  /// Writes what `solve` consists of to a viewer of PETSc; may be empty.
  std::function<void(_p_PetscViewer* viewer)> view;

  /// (K - sigma M)^-1 on the space, sigma within the spectrum, and what its factor counts by Sylvester's law.
  struct Shifted {
    Operator solve;
    int n_below = 0;  ///< eigenvalues below sigma
  };
  /// Factorises; std::runtime_error where sigma is all but an eigenvalue.  Empty: there is no such way.
  std::function<Shifted(double sigma)> shifted;
  /// Operations of such a factorisation, and of a solve for one right-hand side.
  double factor_operations = 0.0, solve_operations = 0.0;

  /// A^T B over all rows.
  Eigen::MatrixXd inner(const Eigen::Ref<const Eigen::MatrixXd>& A,
                        const Eigen::Ref<const Eigen::MatrixXd>& B) const;
  void project_residual(Eigen::MatrixXd& R) const {
    if (condense)
      condense(R);
    else if (project)
      project(R);
  }
};

/// How many eigenpairs: the lowest `count`, or all with omega^2 up to `omega2_max`, whichever asks for more;
/// clusters at the end are completed.
struct EigenRequest {
  int count = 0;
  double omega2_max = 0.0;
  double tolerance = 1e-9;  ///< relative residual, see EigenPairs; met where round-off allows it
};

struct EigenPairs {
  Eigen::VectorXd omega2;     ///< ascending [rad^2/s^2]
  Eigen::MatrixXd Phi;        ///< n x k, M-orthonormal
  Eigen::VectorXd residual;   ///< ||K phi - omega^2 M phi|| / ||(K + shift M) phi||, each pair
  Eigen::VectorXd round_off;  ///< eps || |K| |phi| || / ||(K + shift M) phi||, each pair
  double omega2_next = 0.0;   ///< the first eigenvalue that was left out; infinite where there is none
  int n_solves = 0;           ///< right-hand sides solved for
  int n_blocks = 0;           ///< solves with a block of right-hand sides
  /// No eigenvalue up to the last one is missing: factors of shifts beyond it have counted them (Sylvester).
  bool counted = false;
};

/// Two eigenvalues closer than this fraction are one cluster: both are kept or none.
inline constexpr double kClusterGap = 1e-4;

/// Cuts ascending pairs to what the request asks for; a cluster at the cut is kept whole.
void trim(EigenPairs& pairs, const EigenRequest& request);

/// Every residual is below the tolerance, or is what the round-off of phi and of the solve alone makes of it
/// (a pair of a matrix as near to K as the numbers of the machine allow: N. J. Higham, Accuracy and Stability
/// of Numerical Algorithms, SIAM 2002, sections 7.1 and 10.1).  Slender parts of small cells have low modes
/// whose K phi is the small difference of large terms.
bool is_accurate(const EigenPairs& pairs, double tolerance);

/// Computes Rayleigh quotients and residuals of M-orthonormal vectors anew, from K and M themselves.
void measure_residuals(const EigenProblem& problem, EigenPairs& pairs);

/// Makes M-orthonormal to round-off what nearly is, from the lowest mode up: a trace of a low mode in a high
/// one is harmless, a trace of a high one in a low one would show in K phi a thousand times enlarged.
void orthonormalise(const EigenProblem& problem, Eigen::MatrixXd& Phi);

/// One inverse iteration, (omega^2 + shift) S phi = phi - (K + shift M)^-1 (K - omega^2 M) phi: solved for the
/// small difference, it is free of what the solve loses where averages hold a body that is much softer without
/// them.  Residuals are measured anew.
void polish(const EigenProblem& problem, EigenPairs& pairs);

/// Such steps as long as they help and are needed: one with an accurate factor, some with one that is not (block low-rank).
void polish_until_accurate(const EigenProblem& problem, double tolerance, EigenPairs& pairs);

}  // namespace flexura::linalg
