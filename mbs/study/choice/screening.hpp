// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mbs/mechanism/range/linear_range.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/choice/follower.hpp"
#include "mbs/study/estimate/full_model.hpp"
#include "mbs/study/estimate/shadows.hpp"

/// What a run with rigid bodies says about the deformation that each body needs.
///
/// The shadows of that run (shadows.hpp) say what rigidity costs.  A candidate, that is the lowest n free
/// modes of one body and the response modes of what acts on it, is judged by the same linear correction,
/// solved in the candidate's deformations alone (other bodies rigid) and compared with the one in all of the
/// body's: so joint forces and the motion of other bodies count as well as the body's own deflection.
///
/// Beside it, for the words that explain a choice: how far the load's spectrum reaches, what the spin is to
/// the first frequency, and by how much spin, acceleration and interface loads change the body's stiffness
/// (the largest eigenvalue of the geometric stiffness against the elastic one: at -1 the body buckles).
namespace flexura::study {

struct Screened {
  std::string body;
  int available = 0;              ///< free modes of its superelement
  double rigid_error = 0.0;       ///< relative rms of the worst output
  std::string output;             ///< that output
  double excitation_hz = 0.0;     ///< 99.9 % of the strain energy of the loads' static response lies below
  double highest_hz = 0.0;        ///< of its free modes
  double first_hz = 0.0;          ///< first frequency as the body's joint holds it
  double ringing_time = 0.0;      ///< [s] in which a vibration of that frequency falls to 1/e
  double spin = 0.0;              ///< [rad/s], largest angular velocity
  double stiffness_change = 0.0;  ///< largest |change| / elastic stiffness; 0 without stiffening terms
  double most_negative_change = 0.0;
  bool has_stiffening_terms = false;
};

/// n eigenmodes and the response modes or not; n = 0: response modes alone ("static").
struct Candidate {
  int modes = 0, responses = 0;
  bool all = false;         ///< every deformation, without response modes
  bool plain = false;       ///< eigenmodes alone
  bool held = false;        ///< eigenmodes alone, of the body as its joint holds it
  double loss = 0.0;        ///< relative rms of the worst output
  double highest_hz = 0.0;  ///< of the eigenmodes kept; 0 without any
};

class Screening {
 public:
  /// `run` has every open body rigid; `full` is its full model.
  Screening(const mbs::PreparedMechanism& run, FullModel& full);

  /// For what happens between rows.
  void ask_for_looks(mbs::RunCallbacks& callbacks);
  /// The next row of the run: state and v_dot (n_v), times ascending.
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot);

  bool has_shadows() const { return shadows_ != nullptr; }
  /// What rigidity costs over the rows so far; needs has_shadows().
  TruncationEstimate estimate() const;
  /// Whether the body's deformation has left the range in which it is linear (LinearRange), as the shadows follow it.
  bool leaves_linear_range(const std::string& body) const;
  /// Time [s] between the first row and the last.
  double span() const { return rows_.empty() ? 0.0 : rows_.back().s.t - rows_.front().s.t; }

  /// What the run says about each body; `for_bodies` limits the more expensive part to these.
  std::vector<Screened> bodies(const std::vector<std::string>& for_bodies);

  /// Of a run that is under way, `whole` [s] long: what the best candidate that is worth it has lost so far, whatever comes, since
  /// squares only add up; relative to the outputs' sizes so far.  Infinite where that is more than `share` with each.
  double least_loss(const std::string& body, double share, double whole);

  /// The cheapest candidate for the body whose loss (relative rms of the worst output) stays within `share`;
  /// the finest where none does.
  Candidate cheapest(const std::string& body, double share);

  /// What that has cost so far: corrections that were followed, and their rows.
  struct Effort {
    long candidates = 0, rows = 0;
  };
  const Effort& effort() const { return effort_; }

 private:
  // What a candidate is judged by: the outputs in all deformations of the body, their sizes, and what may be lost.
  struct Goal {
    WholeBody whole;
    std::vector<OutputEstimate> outputs;
    double share = 0.0;
    double time = 0.0;  // [s] of the whole run
  };
  std::size_t rows_between() const;
  std::size_t rows_compared() const;
  double time_of(std::size_t row, std::size_t every) const;
  void keep(bool is_look);
  const ModalBlock& block_of(const std::string& body) const;
  // Deformations that the body has with this model, and how they are damped there [1/s].
  struct Basis {
    Eigen::MatrixXd S, damping;
  };
  std::optional<Basis> basis_of(const std::string& body, const mbs::BodyModel& model) const;
  const Eigen::MatrixXd& responses_of(const std::string& body);
  const std::optional<Basis>& held_of(const std::string& body);
  std::vector<int> ladder_beside(const ModalBlock& block, const Eigen::MatrixXd& responses) const;
  std::vector<int> ladder_alone(const ModalBlock& block, int more_than, int fewer_than) const;
  std::optional<Candidate> fewest_held(const std::string& body, const std::vector<int>& ladder, Goal& goal);
  WholeBody whole_of(const ModalBlock& block);
  const Transients& transients(const ModalBlock& block);
  bool asks_next_order() const;
  double loss_of(const ModalBlock& block, const Eigen::MatrixXd& S, const Eigen::MatrixXd& extra_damping,
                 Goal& goal);
  Candidate judge(const ModalBlock& block, int modes, const Eigen::MatrixXd& responses, Goal& goal);
  std::optional<Candidate> fewest(const ModalBlock& block, const std::vector<int>& ladder,
                                  const Eigen::MatrixXd& responses, Goal& goal);
  double excitation(const ModalBlock& block);
  void change_of_stiffness(const ModalBlock& block, Screened& out);

  const mbs::PreparedMechanism& run_;
  FullModel& full_;
  std::unique_ptr<Shadows> shadows_;
  mbs::LinearRange range_;
  std::vector<ScreenedRow> rows_;
  std::size_t n_rows_ = 0;  // of them, without looks
  long last_number_ = 0;    // of the linearised rows kept
  double memory_ = 0.0;     // [B], of these
  Effort effort_;
  double least_share_ = 0.0;  // that is asked of a candidate
  std::map<std::string, Eigen::MatrixXd> responses_;
  std::map<std::string, std::optional<Basis>> held_;
  std::map<std::string, Transients> transients_;
};

}  // namespace flexura::study
