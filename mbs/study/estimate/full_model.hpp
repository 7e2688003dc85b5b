// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/linear_correction.hpp"

/// The mechanism of a run with every deformation of its superelements, and the way between its states and
/// those of the run.
namespace flexura::study {

/// A body's modal coordinates in the full model: its free modes, lowest first.
struct ModalBlock {
  int body = 0;
  std::string name;
  Eigen::Index p = 0, v = 0, m = 0;  ///< first entry in p, in v; number
};

/// Coordinates of the body's superelement beside its six rigid motions; 0 without one.
int deformations_of(const mbs::BodyDescription& body);

/// The body has a superelement with coordinates beside its six rigid motions; one without them (of an import) only
/// carries a rigid body's inertia and picture.
bool can_deform(const mbs::BodyDescription& body);

/// The superelement's file holds geometric stiffening terms for what loads the body: no marker follows nodes
/// of its surface, and no force puts a load case on it whose terms it lacks.
bool has_stiffening_terms(const mbs::BodyDescription& body);

/// Of what bodies a full model is made.
struct FullScope {
  std::vector<std::string> stiffened;  ///< bodies that are taken with geometric stiffening
  std::set<std::string> rigid;         ///< bodies that are taken without deformation
  std::set<std::string> as_given;      ///< bodies that are taken as the choice says
  mbs::ModelChoice besides;            ///< that the run has not
  int modes = 0;                       ///< no more than so many of each body; 0: all
  /// The file's own frames and boundary conditions instead of mean axes and free modes: a damping ratio is of the modes they
  /// make, so that what nothing was left out of is the same body.
  bool own_frames = false;
};

class FullModel {
 public:
  /// Null where the mechanism has no superelement that deforms.  Throws what ModelSource::read() throws.
  static std::unique_ptr<FullModel> make(const mbs::PreparedMechanism& run, const FullScope& scope = {});

  /// The run's state, of joints alone: deformations at rest.
  mbs::State state_of(const mbs::PreparedMechanism& run) const;

  const mbs::Mechanism& mechanism() const { return *mechanism_; }
  const std::vector<ModalBlock>& blocks() const { return blocks_; }

  /// At the state: M (n_v x n_v), G (n_lambda x n_v), K and D (n_v x n_v), the derivatives of the momentum
  /// balance along p (by tangent vectors, K = z_p T) and by v, of the bodies' own stiffness, springs,
  /// geometric and gyroscopic terms alike.
  void linearise(const mbs::State& s, const Eigen::VectorXd& v_dot, LinearisedRow& row);
  /// G (n_lambda x n_v) alone.
  void constraint_matrix(const mbs::State& s, Eigen::MatrixXd& G);
  /// r (n_v) = M v_dot - f + G^T lambda, the momentum balance; forces along the velocity coordinates [N, Nm].
  void residual(const mbs::State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd& r);
  /// y: the quantities `which` (Mechanism's numbers) at the state, each in its SI unit.
  void evaluate(const std::vector<int>& which, const mbs::State& s, const Eigen::VectorXd& v_dot,
                Eigen::VectorXd& y);
  /// What a linear correction makes of a state: the tangent vector delta (n_v), its rate (n_v), dlambda (n_lambda) and
  /// the states gamma (n_dyn) of controls and forces.
  struct Correction {
    Eigen::VectorXd delta, rate, dlambda, states;
  };
  /// s moved by it; algebraic states by the row's matrices.
  void move(const mbs::State& s, const LinearisedRow& row, const Correction& by, mbs::State& moved) const;

  /// Of what the correction is no more than like the run: sampled controls that read the motion, followed as lags of
  /// half their period, drives that follow states, formulas that read reactions.  Empty where there is none.
  const std::string& followed_roughly() const { return followed_roughly_; }

 private:
  friend class Embedding;
  explicit FullModel(std::unique_ptr<mbs::Mechanism> mechanism);
  void take_start(const mbs::PreparedMechanism& run);
  void take_states(LinearisedRow& row);

  std::shared_ptr<mbs::PreparationCache> cache_;  // of superelements that were read
  std::unique_ptr<mbs::Mechanism> mechanism_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::unique_ptr<mbs::Tangents> tangents_;
  std::unique_ptr<mbs::KinematicBlocks> kinematics_;
  std::vector<ModalBlock> blocks_;
  std::vector<std::pair<int, std::string>> samples_;  // first state of each sampled control, its name
  std::string followed_roughly_;
  Eigen::VectorXd c_rate_, b_;
};

/// Between the states of one mechanism and those of the full model: joint coordinates by their names, modal
/// coordinates by the shapes they stand for, Y_run = Y_full S + R z (the rigid part z is another choice of
/// the body's frame and no deformation).
class Embedding {
 public:
  Embedding(const mbs::Mechanism& run, const FullModel& full);

  /// The run's state and v_dot (n_v of the run) in the full model, dropped deformations at rest.
  void embed(const mbs::State& run, const Eigen::VectorXd& run_v_dot, mbs::State& full,
             Eigen::VectorXd& full_v_dot);
  /// Back, by least squares of the deformation; `run` has its sizes and keeps what the full model lacks.
  void project(const mbs::State& full, const Eigen::VectorXd& full_v_dot, mbs::State& run,
               Eigen::VectorXd& run_v_dot) const;

  /// Deformations of a block that the run has, m_full x m_run; no columns for a rigid body.
  const Eigen::MatrixXd& deformations(std::size_t block) const { return blocks_[block].S; }
  /// True where the run's body is that of the full model: all deformations, damped and coupled alike.
  bool complete(std::size_t block) const { return blocks_[block].complete; }
  /// True where the body deforms one-way, so that the run's joints do not feel it.
  bool one_way(std::size_t block) const { return blocks_[block].one_way; }

 private:
  struct Block {
    Eigen::MatrixXd S;
    Eigen::Index at = -1, rate_at = -1;  ///< in p and v of the run, of a one-way body in c
    bool one_way = false, complete = false;
  };
  const mbs::Mechanism& run_;
  const FullModel& full_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<Block> blocks_;
  std::vector<int> p_from_, v_from_, c_from_, lambda_from_;
  Eigen::VectorXd r_, c_rate_, b_;
};

}  // namespace flexura::study
