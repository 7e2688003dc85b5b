// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/LU>
#include <utility>
#include <vector>

#include "mbs/study/estimate/step_operator.hpp"

/// The linear equations of a small correction to a run,
///
///     M delta'' + D delta' + K delta + Z_c gamma + G^T dlambda = f(t),      G delta = 0,
///     gamma' = C_p delta + C_v delta' + C_c gamma,
///
/// with the matrices of the row, for several loads f (columns) at once; gamma (n_c) is what the correction makes of
/// the states of controls and forces (filters, motors that lag behind their commands).  One step of generalised-alpha (Chung
/// and Hulbert 1993, rho_inf = 0.4, in the form of Arnold and Bruels 2007: the equations hold at the rows
/// themselves, an auxiliary acceleration carries the algorithm) leads from row to row, whatever the
/// frequencies: what the rows do not resolve responds statically.  That holds where loads change slowly; where
/// they begin at once or jump, modes ring until their damping has brought them to rest, and there the steps
/// are as short as the modes ask that still ring (Transients).  States take a step of the theta method, theta = 1 /
/// (1 + rho), which damps what no step resolves by as much.
namespace flexura::study {

/// At one row: M, D, K n x n, G n_lambda x n; Z_c n x n_c, C_p and C_v n_c x n, C_c n_c x n_c.
struct LinearisedRow {
  Eigen::MatrixXd M, D, K, G;
  Eigen::MatrixXd Z_c, C_p, C_v, C_c;
  /// Algebraic states follow: alpha = A_p delta + A_v delta' + A_c gamma (n_a x n, n_a x n, n_a x n_c).  They are
  /// worked into the others.
  Eigen::MatrixXd A_p, A_v, A_c;
  long number = 0;  ///< of its own where several rows share it, so that its factors serve for all; 0: none
};

/// How long modes ring after a sudden load, and how short the steps must be that follow them: an oscillation
/// of frequency omega and damping ratio zeta is followed with kStepsPerPeriod steps until it has fallen to
/// exp(-kDecay).  Few steps in all: the fast ones are at rest soon.
class Transients {
 public:
  /// More modes that may ring: squares of their frequencies [rad^2/s^2], and damping 2 zeta omega [1/s].
  void add(const Eigen::VectorXd& omega2, const Eigen::VectorXd& damping);
  /// Those of the row as its constraints hold them: a joint takes damping from a body's free modes, which have it, and gives to motions
  /// that have none.  False, and none, where there are too many coordinates for it to pay or the row is no vibration.
  bool add(const LinearisedRow& row, const Eigen::MatrixXd& G);
  /// Loads have just jumped.  Nothing is followed any more once the steps are used up.
  void begin();
  /// The longest step from here [s]; infinite where nothing rings.
  double step() const;
  void pass(double dt);

 private:
  void pass_those_at_rest();

  static constexpr double kStepsPerPeriod = 12.0, kDecay = 4.0, kLeastDampingRatio = 2e-3;
  std::vector<std::pair<double, double>> modes_;  // until when it rings [s], step [s]; the fastest first
  std::size_t fastest_ = 0;                       // of those that still ring
  double since_ = 0.0;
  long steps_left_ = 40000;
};

class LinearCorrection {
 public:
  LinearCorrection(Eigen::Index n, Eigen::Index columns);

  /// To the next row, h [s] later; h = 0 at the first one, where it only finds the accelerations.  load n x
  /// columns; G in place of row.G, which may be that of an earlier row.  Load and G go evenly from those of
  /// the last row to these; a load that has jumped is there from the last row on.
  void step(double h, const LinearisedRow& row, const Eigen::MatrixXd& G, const Eigen::MatrixXd& load,
            Transients* transients = nullptr, bool jumped = false);

  const Eigen::MatrixXd& delta() const { return delta_; }  ///< n x columns
  const Eigen::MatrixXd& rate() const { return rate_; }
  const Eigen::MatrixXd& acceleration() const { return acceleration_; }
  const Eigen::MatrixXd& dlambda() const { return dlambda_; }  ///< n_lambda x columns
  const Eigen::MatrixXd& states() const { return states_; }    ///< n_c x columns

 private:
  void factor(double h, double rho, const LinearisedRow& row);
  void factor_schur(Eigen::MatrixXd schur);
  void make_operator(double h, double rho, const LinearisedRow& row, const Eigen::MatrixXd& G,
                     const Eigen::MatrixXd& B);
  void step_once(double h, double rho, const LinearisedRow& row, const Eigen::MatrixXd& G,
                 const Eigen::MatrixXd& B, const Eigen::MatrixXd& load);
  void step_within_row(double h, double rho, const LinearisedRow& row, const Eigen::MatrixXd& G,
                       const Eigen::MatrixXd& B, const Eigen::MatrixXd& load);
  void predict(double h, double rho);
  void correct(double h, double rho);

  void predict_states(double h, double rho, const LinearisedRow& row);
  void correct_states(double h, double rho, const LinearisedRow& row);

  Eigen::MatrixXd delta_, rate_, acceleration_, auxiliary_, dlambda_;
  Eigen::MatrixXd states_, state_rates_;
  Eigen::MatrixXd last_G_, last_load_;
  Eigen::PartialPivLU<Eigen::MatrixXd> A_;  // of the step solved last
  // Where many steps are solved with it, and these of a G that stays the same: what makes one of them.
  StepOperator operator_;
  Eigen::MatrixXd operator_G_;
  int uses_ = 0;  // steps within rows that these factors have made
  Eigen::PartialPivLU<Eigen::MatrixXd> schur_;
  // Of a step; kept, since short steps of few coordinates would spend most of their time on memory.
  Eigen::MatrixXd predicted_, predicted_rate_, rhs_, next_, G_part_, B_part_, gap_;
  // Of the factors: with states, what positions and rates at the end of a step make of these there.
  Eigen::MatrixXd states_by_delta_, states_by_rate_, old_states_;
  Eigen::PartialPivLU<Eigen::MatrixXd> states_lu_;
  bool states_act_ = false;  // upon the motion
  long number_ = 0;
  double h_ = 0.0, rho_ = 0.0;
};

}  // namespace flexura::study
