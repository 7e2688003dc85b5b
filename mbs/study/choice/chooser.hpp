// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mbs/bodies/preparation_cache.hpp"
#include "mbs/study/choice/body_choice.hpp"
#include "mbs/study/choice/choose.hpp"
#include "mbs/study/choice/screening.hpp"
#include "mbs/study/choice/tolerance_choice.hpp"
#include "mbs/study/estimate/later_global_error.hpp"

namespace flexura::study {

/// The accuracy that a run is asked for; 0: none.
double accuracy_of(const mbs::PreparedMechanism& run);
/// A superelement or a beam whose fidelity is to be chosen.
bool is_open(const mbs::PreparedMechanism& run, const mbs::BodyDescription& body);

/// The part of a wanted accuracy that is for what bodies leave out: at 0.8 three of the trade's 18 cases missed their
/// accuracy, at 0.5 none.
inline constexpr double kShareOfModes = 0.5;

/// One run within a wanted accuracy (choose.hpp): what is chosen in chooser.cpp, the run that follows, and how it goes on
/// with more where it has to, in chosen_run.cpp; what a later run takes over in choice_memory.cpp.
class Chooser {
 public:
  Chooser(const mbs::PreparedMechanism& given, const mbs::RunCallbacks& callbacks, bool integrator);

  ChosenRun run();

 private:
  // A row in the full model from which a better choice may go on.
  struct Good {
    mbs::State state;
    Eigen::VectorXd v_dot;
    mbs::EnergyAccount energy;
    Eigen::VectorXd squares;  // of the errors until there
    std::size_t rows = 0;
    bool is_there = false;
  };

  mbs::PreparedMechanism prepared() const;
  mbs::ModelChoice of_integrator() const;
  mbs::ModelChoice choice() const;
  mbs::ModelChoice choice_of_exact() const;
  std::set<std::string> exact() const;
  void make_full(const mbs::PreparedMechanism& screened, const std::vector<std::string>& stiffened);
  void take_sizes(const mbs::PreparedMechanism& run);
  std::vector<std::string> keys() const;
  void leave_out(const mbs::PreparedMechanism& rigid);
  void screen(ChosenRun& out);
  void choose();
  void keep_all();
  void keep_all_because(const std::string& why);
  void keep_all_of(const std::string& body, int available, const std::string& why);
  bool is_interrupted() const { return callbacks_.stop_wanted && callbacks_.stop_wanted(); }
  bool all_are_lost();
  bool make_exact_beyond_range(const std::string& body);
  double share_of_each() const;
  bool has_output_of_its_own(const std::string& body) const;
  void choose_body(const Screened& s, double share);
  std::vector<std::string> judged_with_stiffening() const;

  // choice_memory.cpp
  std::string key_of_choice() const;
  mbs::PreparationCache::Matrices packed() const;
  bool recall(const mbs::PreparationCache::Matrices& kept, const mbs::PreparedMechanism& rigid);

  ChosenRun simulate(const mbs::PreparedMechanism& screened);
  void refine_beams(ChosenRun& out);
  std::vector<std::string> run_until_over(ChosenRun& out, const mbs::State& state,
                                          const Eigen::VectorXd& v_dot, const Good& start, Good& good,
                                          bool may_stop);
  std::string given_up_by_integrator(const ChosenRun& out);
  bool has_to_run_finer(const ChosenRun& out);
  std::vector<std::string> worst_choices(const TruncationEstimate& estimate) const;
  void go_on(ChosenRun& out, const Good& start, mbs::State& state, Eigen::VectorXd& v_dot);
  void add_part_before(ChosenRun& out, const Eigen::VectorXd& squares) const;
  void move_rows(ChosenRun& out, const mbs::Mechanism& to, std::size_t rows) const;

  double accuracy_;
  const mbs::PreparedMechanism& as_given_;
  const mbs::RunCallbacks& callbacks_;
  bool tells_integrator_;
  std::optional<ToleranceChoice> tolerance_;  // where an accuracy is asked for
  std::map<std::string, BodyChoice> choices_;
  std::set<std::string> without_influence_;  // open bodies that are rigid whatever they do
  std::unique_ptr<FullModel> full_;
  std::optional<Screening> screening_;
  std::unique_ptr<LaterGlobalError> steps_;  // of the run with the open bodies rigid
  std::set<std::string> of_rigid_;           // names of quantities with the open bodies rigid
  TruncationEstimate sizes_;                 // what the screening says about the outputs' sizes
  double span_ = 0.0;
  bool looks_whether_lost_ = true;  // while that may be
  double lost_at_ =
      -1.0;  // [s], where the screening was sure that every open body needs all its deformations; else -1
  double integrator_spent_ = 0.0;  // of the run that was given up for it; else 0
  std::vector<std::string> restarts_;
  std::set<std::string> beyond_range_;  // beams whose deformation has left its linear range
  std::set<std::string> refined_;       // bodies with which the run has gone on with more
};

}  // namespace flexura::study
