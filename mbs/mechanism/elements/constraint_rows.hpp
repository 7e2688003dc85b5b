// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/mechanism/motion/tree_motion.hpp"

/// The rows of g: closures of joints, drives, and the description's constraints; those that are kept and those that were
/// left out because they follow from them.
namespace flexura::mbs {

/// What rows follow, see followed_signals.hpp.
struct FollowedValues {
  std::vector<Jet> of_constraints;  ///< all that constraints follow, one behind the other
  std::vector<Jet> signals;  ///< of each signal, as far as it is needed; empty where nothing is followed
  Eigen::VectorXd c_rate, c_rate_2;
  Eigen::VectorXd seen;  ///< values of signals as forces see them, while algebraic states are eliminated
};

/// What ConstraintRows leaves of one state.
struct RowValues {
  Eigen::VectorXd x, g;          ///< one entry for each row, redundant ones included
  std::vector<double> contacts;  ///< of each constraint, where it has one: see OwnStates::contact
  FollowedValues followed;
};

/// Elements whose derivatives are known, those that are differenced, or all.
enum class Which { all, with_derivatives, without_derivatives };

/// What a row belongs to; -1 where it is not.
struct RowPlace {
  int joint = -1;       ///< whose loop it closes, or which it drives
  int driven = -1;      ///< what it drives of the joint, by its speed
  int constraint = -1;  ///< of the description's
  int row = 0;          ///< of the joint or the constraint
};

class ConstraintRows {
 public:
  explicit ConstraintRows(const Topology& tree);
  void size(RowValues& rows) const;

  const std::vector<std::shared_ptr<const Constraint>>& constraints() const { return constraints_; }
  int first_row(std::size_t constraint) const { return first_row_[constraint]; }
  /// The place in FollowedValues::of_constraints of what the constraint follows first.
  std::size_t first_followed(std::size_t constraint) const { return first_followed_[constraint]; }
  int n_all() const { return first_row_.back(); }
  /// Of all rows those that are kept and those left out; of each of these the kept ones that it is a combination of.
  struct Choice {
    std::vector<int> kept, left_out;
    std::vector<std::vector<int>> follows_from;
  };
  const Choice& choice() const { return choice_; }
  void take_choice(Choice choice) { choice_ = std::move(choice); }
  const std::vector<int>& kept() const { return choice_.kept; }
  const std::vector<int>& left_out() const { return choice_.left_out; }
  const std::vector<int>& contacts() const { return contacts_; }  ///< constraints with a contact on a curve
  /// The joint as a loop's closure, and its index among the constraints; null where the joint is in the tree or locks
  /// nothing.
  std::pair<const RelativeConstraint*, std::size_t> closure(int joint) const { return closures_[joint]; }
  /// The row, among all, that drives a coordinate, by its speed; -1 where none does.
  int drive_of(CoordinateRef c) const;
  /// The first of the description's own constraints.
  std::size_t first_own() const { return constraints_.size() - tree_.d.constraints.size(); }
  void keep_all();
  /// Of all rows: whether they are on positions; and whether they say where the mechanism may be at all times (a drive's
  /// does so now only).  After forward() on level position.
  void list_kinds(Motion& motion, RowValues& rows, std::vector<bool>& of_positions,
                  std::vector<bool>& lasts) const;

  /// The constraint's place for its contact and what it follows, into kin.own.
  void own_contact(std::size_t constraint, Motion& motion, RowValues& rows) const;
  /// Contacts from the algebraic states behind the first n_before; and b of them.
  void take_contacts(const Eigen::VectorXd& algebraic, int n_before, RowValues& rows) const;
  void contact_equations(const Eigen::VectorXd& algebraic, int n_before, const Motion& motion,
                         VectorRef b) const;
  void start_contacts(const Motion& motion, int n_before, State& s) const;

  // Of the rows that are kept, after forward() on that level (n_lambda).
  void position(Motion& motion, RowValues& rows, VectorRef g) const;
  void velocity(Motion& motion, RowValues& rows, VectorRef g_dot) const;
  void acceleration(Motion& motion, RowValues& rows, VectorRef g_ddot) const;
  /// Of the constraint forces: -G^T lambda have the power -lambda . G v = lambda . g_t.
  double power(const double* lambda, Motion& motion, RowValues& rows) const;
  /// Loads G^T lambda of the kept rows' constraints; rows.x holds lambda among all rows then.
  void add_constraint_loads(const double* lambda, Which which, Motion& motion, RowValues& rows,
                            Loads& loads) const;
  /// Those of rows.x.
  void apply_all(Motion& motion, RowValues& rows, Loads& loads) const;
  /// Of the rows that were left out.
  void left_out_constraints(bool to_acceleration, Motion& motion, RowValues& rows, VectorRef g,
                            VectorRef g_dot, VectorRef g_ddot) const;
  /// After forward() on level position; `length` is the mechanism's extent.
  ConstraintSizes sizes(const std::vector<int>& which, double length, Motion& motion, RowValues& rows) const;

  bool is_holonomic(int kept_row) const;
  std::size_t constraint_of_row(int row) const;
  RowPlace place_of_row(int row) const;
  std::string name_of_row(int row) const;
  std::vector<std::string> names_of_left_out(int i) const;

 private:
  template <class Evaluate>
  void evaluate(const Evaluate& one, Motion& motion, RowValues& rows, VectorRef out) const;

  const Topology& tree_;
  std::vector<std::shared_ptr<const Constraint>> constraints_;  ///< closures, drives, then the description's
  std::vector<std::pair<const RelativeConstraint*, std::size_t>> closures_;  ///< of each joint
  std::vector<CoordinateRef>
      driven_;                  ///< of each constraint, by its first row; joint = -1 where it is no drive
  std::vector<int> first_row_;  ///< of each constraint among all rows, and their number at the end
  std::vector<std::size_t> first_followed_;  ///< likewise of what constraints follow
  Choice choice_;
  std::vector<int> contacts_;
};

}  // namespace flexura::mbs
