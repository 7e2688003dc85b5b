// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/held_rows.hpp"
#include "mbs/study/estimate/judged_outputs.hpp"

/// What a run loses by the deformations it leaves out, estimated while it runs: they follow as shadows,
/// driven one-way by the loads of the run.
///
/// Beside the mechanism that runs stands the same one with every mode of every superelement
/// (full_model.hpp).  The state of the run, put into it with the dropped deformations at rest, leaves a
/// residual r in its momentum balance: the load that they would have felt (inertia of the large motion,
/// reactions at the interfaces, gravity), of a one-way body also the load that its joints would have felt,
/// and of a body without geometric stiffening whose superelement has its terms the loads of that.  The
/// correction delta of all coordinates obeys, to first order,
///
///     M delta'' + D delta' + K delta + G^T dlambda = -r(t),      G delta = 0
///
/// with the derivatives of the full model about the run (linear_correction.hpp); where the run begins and where
/// loads jump in time the vibrations that this starts are followed until they have died away.  r is split by the bodies it
/// acts on; the equation is linear, so each body's share of the error is known.  It says little where the
/// loss is of order one.
///
/// What a superelement knows of its own stiffness, that it is too high by a part e, is a load e K s of the deformation s that the
/// run has: what that changes of an output, be it a shape that is off or a vibration that runs ahead, is the mesh's share.
///
/// The error of an output y is y(p + delta, v + delta', v' + delta'', lambda + dlambda) - y(p, v, v',
/// lambda), both in the full model; of section forces and stresses, where what is left out follows its loads, less what the
/// run itself says.
namespace flexura::study {

struct SourceEstimate {
  std::string body;
  int available = 0;   ///< deformations of its superelement
  int kept = 0;        ///< of them in the run
  double error = 0.0;  ///< relative rms of the worst output, by this body alone
  std::string output;  ///< that output
  /// Why this is not all that the body does (beyond_first_order.hpp); empty where it is.
  std::string beyond;
};

/// What the error of a superelement's own stiffness (deformation_error.hpp) changes of the run.
struct StiffnessEstimate {
  std::string body;
  double error = 0.0;  ///< relative rms of the worst output
  std::string output;  ///< that output
};

struct TruncationEstimate {
  std::vector<OutputEstimate> outputs;
  std::vector<StiffnessEstimate> by_stiffness;  ///< of bodies that deform and know their error
  std::vector<SourceEstimate> by_body;          ///< the largest first
  int shadows = 0;                              ///< dropped deformations that were followed
  int worst = -1;      ///< the output of the largest relative rms error, -1 when there is none
  double error = 0.0;  ///< that error
  double wall = 0.0;   ///< [s] that the shadows took
  /// Rows are so far apart [s] that they miss what forces do within `missed` [s]: the error is then unknown.
  /// Both 0 where they miss nothing.
  double missed = 0.0, rows_apart = 0.0;
  /// Why the error is at least this, and no more is known (FullModel::followed_roughly); else empty.
  std::string followed_roughly;
};

class Shadows {
 public:
  /// Null where the run has every deformation of its superelements, damped, coupled and stiffened as the full
  /// model, which takes all geometric stiffening that the superelements know, and no accuracy is asked for that errors of their
  /// stiffness might exceed.
  static std::unique_ptr<Shadows> make(const mbs::PreparedMechanism& run);
  /// The same with a full model that outlives it.  Outputs cost as much as all the rest of a row: they are compared at some
  /// `most_compared` rows, where the run has so many.
  static std::unique_ptr<Shadows> make(const mbs::PreparedMechanism& run, FullModel& full,
                                       const HeldRows::Span& span = HeldRows::kOfEstimates,
                                       double most_compared = std::numeric_limits<double>::infinity());
  ~Shadows();

  /// Asks for what rows do not show: events that are known beforehand (KnownTimes::looks), and steps that the
  /// motion makes much shorter than it did so far.  `look` is to be called from RunCallbacks::look.
  void ask_for_looks(mbs::RunCallbacks& callbacks,
                     std::function<void(const mbs::State&, const Eigen::VectorXd&)> look);
  /// Nothing but rows tells of the run: what happens between them is then unknown.
  void take_rows_alone(const mbs::PreparedMechanism& run);
  /// The next row of the run.  Of long runs only every n-th row is taken, 800 to 1600 in all: true where it
  /// was.
  bool take(const mbs::State& s, const Eigen::VectorXd& v_dot);
  /// What was asked for; false where a row at that time was taken already.
  bool look(const mbs::State& s, const Eigen::VectorXd& v_dot);

  TruncationEstimate estimate() const;

  /// Of the rows taken, looks among them, one in so many has its outputs compared, the first one to begin with.
  std::size_t rows_compared() const;
  /// The outputs that are compared: quantities of the full model.
  const std::vector<int>& outputs() const;
  /// What forces that do not answer the deformations in proportion change of the worst output that counts (relative rms); of
  /// shadows that compare few rows, else 0.
  double next_order_error() const;
  /// Squared errors of the outputs, integrated until the last row compared.
  const Eigen::VectorXd& squares() const;
  /// At the last row taken: the run's state in the full model, and that state corrected.
  const mbs::State& embedded() const;
  const Eigen::VectorXd& embedded_v_dot() const;
  /// There, in the full model: the momentum balance of that state (n_v), and its derivatives.
  const Eigen::VectorXd& residual() const;
  const HeldRows& linearised() const;
  bool jumped() const;  ///< a load that is known beforehand has jumped since the row taken before
  mbs::State corrected(Eigen::VectorXd& v_dot) const;
  const Eigen::VectorXd& corrected_outputs() const;  ///< at the last row compared

 private:
  struct Impl;
  explicit Shadows(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::study
