// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "beam/ancf/body.hpp"

/// One ANCF body with its loads and constraints, for the drivers of this folder (statics, dynamics,
/// frequencies):
///
///     M v' + 2 (m (x) Omega~) v + (m (x) Omega~^2) q + f(q, v) + G^T lambda = F(t, q)
///     g(t, q) = 0,   G = dg/dq
///
/// Omega is the steady spin of the frame that q is written in (zero: inertial); it turns about the frame's
/// origin.
namespace flexura::beam::ancf {

/// Constraint rows supplied by the caller.
class Constraint {
 public:
  virtual ~Constraint() = default;
  virtual int rows() const = 0;
  /// g (rows()) and, unless nullptr, the entries of G = dg/dq (row, coordinate, value).
  virtual void evaluate(double t, const Eigen::VectorXd& q, VectorRef g, Triplets* G) const = 0;
  /// Entries of sum_k lambda_k d2 g_k/dq2.  Rows that are linear in q have none; without them nonlinear rows
  /// cost Newton iterations, not accuracy.
  virtual void add_hessian(double /*t*/, const Eigen::VectorXd& /*q*/, ConstVectorRef /*lambda*/,
                           Triplets& /*K*/) const {}
};

/// Adds a load to f and, unless nullptr, its derivative by q to df_dq.  In statics t is the load factor, 0
/// to 1.
using Load = std::function<void(double t, const Eigen::VectorXd& q, VectorRef f, Triplets* df_dq)>;

/// A coordinate that is given: value, rate and acceleration at t.
struct Drive {
  int coordinate = 0;
  std::function<Eigen::Vector3d(double t)> motion;
};

struct Problem {
  const AncfBody* body = nullptr;
  /// Coordinates held where the start configuration has them.
  std::vector<int> fixed;
  std::vector<Drive> drives;
  std::vector<std::shared_ptr<const Constraint>> constraints;
  std::vector<Load> loads;
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();  ///< Omega [rad/s]; a planar body has z only

  int n_lambda() const;
  /// True for coordinates that equations determine.  Throws std::invalid_argument for a coordinate outside
  /// the body or given twice.
  std::vector<char> free_coordinates() const;
};

/// t f: the dead load of a static solution, t its load factor.
Load proportional_load(Eigen::VectorXd f);
/// f at every t: steady loads in dynamics, loads that are whole from the first load step on in statics.
Load constant_load(Eigen::VectorXd f);

/// Residual and its derivatives at one configuration.
struct Evaluation {
  Eigen::VectorXd r;  ///< f(q, v) + spin terms + G^T lambda - F (n_q), without M v'
  Eigen::VectorXd g;  ///< (n_lambda)
  Triplets K, D, G;   ///< dr/dq, dr/dv, dg/dq
};

/// Work space of evaluate().
struct ProblemScratch {
  explicit ProblemScratch(const Problem& problem);
  AncfBody::Scratch element;
  BlockTridiagonal K, D, centrifugal, coriolis;
};

/// `q_before` as in AncfBody::force_and_tangents.
void evaluate(const Problem& problem, double t, const Eigen::VectorXd& q, const Eigen::VectorXd* v,
              const Eigen::VectorXd& lambda, ProblemScratch& scratch, Evaluation& out,
              const Eigen::VectorXd* q_before = nullptr);

/// Solves  [S  G^T; G  0] (dq, dlambda) = (a, b)  on the free coordinates, by a sparse LU that keeps the
/// chain's band.
class SaddleSolver {
 public:
  SaddleSolver(std::vector<char> free, int n_lambda);
  ~SaddleSolver();
  SaddleSolver(const SaddleSolver&) = delete;
  SaddleSolver& operator=(const SaddleSolver&) = delete;

  /// Returns false when the matrix is singular.
  bool factor(const Triplets& S, const Triplets& G);
  /// dq is zero where coordinates are not free.
  void solve(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::VectorXd& dq,
             Eigen::VectorXd& dlambda) const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

}  // namespace flexura::beam::ancf
