// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/elements/constraint_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace flexura::mbs {
namespace {

/// Takes up the largest that a row applies, a force by the length along which its marker may move.
class RowLoads final : public Loads {
 public:
  RowLoads(const Topology& tree, const Motion& motion, double length)
      : tree_(tree), motion_(motion), length_(length) {
    for (std::size_t i = 0; i < tree_.d.markers.size(); ++i)
      farthest_ = std::max({farthest_, motion.kin.markers[i].X_WP.p.norm(), motion.local[i].X_BP.p.norm()});
  }
  using Loads::apply;
  void apply(int /*marker*/, const Spatial& wrench_W) override {
    const double force = wrench_W.linear.norm(), torque = wrench_W.angular.norm();
    add(force, torque, force * length_ + torque, force * farthest_ + torque);
  }
  void apply(CoordinateRef c, double force) override {
    const JointPlace& place = tree_.places[c.joint];
    const bool is_angle = place.joint->speeds()[c.index].dimension == input::dim::angular_velocity;
    const double f = std::abs(force);
    // A coordinate's own value, where it turns on and on.
    const double value = place.in_tree() && place.joint->n_p() == place.joint->n_v()
                             ? std::abs(motion_.kin.p[place.i_p + c.index])
                             : 0.0;
    const double reach = is_angle ? 1.0 : length_;
    add(is_angle ? 0.0 : f, is_angle ? f : 0.0, f * reach, f * std::max(value, is_angle ? 1.0 : farthest_));
  }
  void apply_modal(int /*body*/, const Eigen::VectorXd& /*f*/, double /*factor*/) override {}

  void clear() { force_ = torque_ = size_ = numbers_ = 0.0; }
  double size() const { return size_; }
  /// A position in the world is a sum over the joints before it, each right to half a unit of the last place.
  double round_off() const { return 8.0 * std::numeric_limits<double>::epsilon() * numbers_; }
  /// A rack's row, x - r phi, is a length too; so is a distance without direction, which loads nothing.
  bool is_length() const { return force_ > 0.0 || torque_ == 0.0; }

 private:
  void add(double force, double torque, double size, double numbers) {
    force_ = std::max(force_, force);
    torque_ = std::max(torque_, torque);
    size_ = std::max(size_, size);
    numbers_ = std::max(numbers_, numbers);
  }

  const Topology& tree_;
  const Motion& motion_;
  double length_, farthest_ = 0.0;
  double force_ = 0.0, torque_ = 0.0, size_ = 0.0, numbers_ = 0.0;
};

}  // namespace

ConstraintRows::ConstraintRows(const Topology& tree) : tree_(tree), closures_(tree.d.joints.size()) {
  for (std::size_t j = 0; j < tree_.d.joints.size(); ++j) {
    const JointDescription& joint = tree_.d.joints[j];
    if (!tree_.places[j].in_tree() && joint.joint->n_rows() > 0) {
      const auto closure =
          std::make_shared<RelativeConstraint>(joint.name, joint.marker_F, joint.marker_M, joint.joint);
      closures_[j] = {closure.get(), constraints_.size()};
      constraints_.push_back(closure);
    }
    const auto drive = [&](int index, const std::shared_ptr<const Expression>& motion, DriveLevel level,
                           double start_speed = 0.0) {
      const CoordinateRef c{static_cast<int>(j), index};
      driven_.resize(constraints_.size() + 1);
      driven_.back() = c;
      if (level == DriveLevel::acceleration && !motion->reads().empty())
        throw std::invalid_argument(
            fmt::format("{} = \"{}\": an acceleration that follows signals is a state; drive the speed by a "
                        "control of type "
                        "state with this rate",
                        motion->where(), motion->text()));
      constraints_.push_back(std::make_shared<DriveConstraint>(
          joint.name, c, joint.coordinate_of_speed(index), motion, level, start_speed));
    };
    if (joint.rotation_drive) {
      driven_.resize(constraints_.size() + 1);
      driven_.back() = {static_cast<int>(j), 0};
      constraints_.push_back(std::make_shared<RotationDrive>(joint.name, static_cast<int>(j), joint.marker_F,
                                                             joint.marker_M, *joint.rotation_drive));
    }
    for (const auto& [index, motion] : joint.drives) drive(index, motion, DriveLevel::position);
    for (const auto& [index, motion] : joint.speed_drives) drive(index, motion, DriveLevel::speed);
    for (const auto& [index, motion] : joint.acceleration_drives) {
      const auto given = joint.initial_speeds.find(index);
      drive(index, motion, DriveLevel::acceleration,
            given == joint.initial_speeds.end() ? 0.0 : given->second);
    }
  }
  constraints_.insert(constraints_.end(), tree_.d.constraints.begin(), tree_.d.constraints.end());
  driven_.resize(constraints_.size());
  int row = 0;
  std::size_t followed = 0;
  for (const auto& constraint : constraints_) {
    first_followed_.push_back(followed);
    followed += static_cast<std::size_t>(constraint->n_followed());
    if (constraint->has_contact()) contacts_.push_back(static_cast<int>(first_row_.size()));
    first_row_.push_back(row);
    row += constraint->n_rows();
  }
  first_row_.push_back(row);
  first_followed_.push_back(followed);
  keep_all();
}

void ConstraintRows::size(RowValues& rows) const {
  rows.x.setZero(n_all());
  rows.g.setZero(n_all());
  rows.contacts.assign(constraints_.size(), std::numeric_limits<double>::quiet_NaN());
  rows.followed.of_constraints.assign(first_followed_.back(), Jet{});
}

void ConstraintRows::keep_all() {
  choice_ = {};
  for (int i = 0; i < n_all(); ++i) choice_.kept.push_back(i);
}

void ConstraintRows::list_kinds(Motion& motion, RowValues& rows, std::vector<bool>& of_positions,
                                std::vector<bool>& lasts) const {
  of_positions.assign(static_cast<std::size_t>(n_all()), false);
  lasts = of_positions;
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    const Constraint& constraint = *constraints_[k];
    own_contact(k, motion, rows);
    const bool follows = constraint.n_followed() > 0;
    if (!follows) constraint.rate(motion.kin, rows.g.data() + first_row_[k]);
    for (int i = 0; i < constraint.n_rows(); ++i) {
      const int place = first_row_[k] + i;
      const auto row = static_cast<std::size_t>(place);
      of_positions[row] = constraint.is_holonomic(i);
      lasts[row] =
          of_positions[row] && !follows && !constraint.reads_time(i) && rows.g(first_row_[k] + i) == 0.0;
    }
  }
}

void ConstraintRows::own_contact(std::size_t constraint, Motion& motion, RowValues& rows) const {
  motion.kin.own.contact = &rows.contacts[constraint];
  motion.kin.own.followed = rows.followed.of_constraints.data() + first_followed_[constraint];
}

void ConstraintRows::take_contacts(const Eigen::VectorXd& algebraic, int n_before, RowValues& rows) const {
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    rows.contacts[contacts_[k]] = algebraic(n_before + static_cast<Eigen::Index>(k));
}

void ConstraintRows::contact_equations(const Eigen::VectorXd& algebraic, int n_before, const Motion& motion,
                                       VectorRef b) const {
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(n_before + k);
    b(i) = constraints_[contacts_[k]]->contact_residual(motion.kin, algebraic(i));
  }
}

void ConstraintRows::start_contacts(const Motion& motion, int n_before, State& s) const {
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    s.a(static_cast<Eigen::Index>(n_before + k)) = constraints_[contacts_[k]]->start_contact(motion.kin);
}

template <class Evaluate>
void ConstraintRows::evaluate(const Evaluate& one, Motion& motion, RowValues& rows, VectorRef out) const {
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, motion, rows);
    one(*constraints_[k], rows.g.data() + first_row_[k]);
  }
  for (std::size_t i = 0; i < choice_.kept.size(); ++i) out(i) = rows.g(choice_.kept[i]);
}

void ConstraintRows::position(Motion& motion, RowValues& rows, VectorRef g) const {
  evaluate([&](const Constraint& c, double* out) { c.position(motion.kin, out); }, motion, rows, g);
}

void ConstraintRows::velocity(Motion& motion, RowValues& rows, VectorRef g_dot) const {
  evaluate([&](const Constraint& c, double* out) { c.velocity(motion.kin, out); }, motion, rows, g_dot);
}

void ConstraintRows::acceleration(Motion& motion, RowValues& rows, VectorRef g_ddot) const {
  evaluate([&](const Constraint& c, double* out) { c.acceleration(motion.kin, out); }, motion, rows, g_ddot);
}

double ConstraintRows::power(const double* lambda, Motion& motion, RowValues& rows) const {
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, motion, rows);
    constraints_[k]->rate(motion.kin, rows.g.data() + first_row_[k]);
  }
  double power = 0.0;
  for (std::size_t i = 0; i < choice_.kept.size(); ++i) power += lambda[i] * rows.g(choice_.kept[i]);
  return power;
}

void ConstraintRows::add_constraint_loads(const double* lambda, Which which, Motion& motion, RowValues& rows,
                                          Loads& loads) const {
  if (choice_.kept.empty()) return;
  rows.x.setZero();
  for (std::size_t i = 0; i < choice_.kept.size(); ++i) rows.x(choice_.kept[i]) = lambda[i];
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    if (which != Which::all && constraints_[k]->has_derivatives() != (which == Which::with_derivatives))
      continue;
    own_contact(k, motion, rows);
    constraints_[k]->apply_GT(motion.kin, rows.x.data() + first_row_[k], loads);
  }
}

void ConstraintRows::apply_all(Motion& motion, RowValues& rows, Loads& loads) const {
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, motion, rows);
    constraints_[k]->apply_GT(motion.kin, rows.x.data() + first_row_[k], loads);
  }
}

void ConstraintRows::left_out_constraints(bool to_acceleration, Motion& motion, RowValues& rows, VectorRef g,
                                          VectorRef g_dot, VectorRef g_ddot) const {
  const auto evaluate = [&](auto&& level, VectorRef out) {
    std::size_t i = 0;
    for (std::size_t k = 0; k < constraints_.size() && i < choice_.left_out.size(); ++k) {
      if (choice_.left_out[i] >= first_row_[k + 1]) continue;
      own_contact(k, motion, rows);
      level(*constraints_[k], rows.g.data() + first_row_[k]);
      for (; i < choice_.left_out.size() && choice_.left_out[i] < first_row_[k + 1]; ++i)
        out(static_cast<Eigen::Index>(i)) = rows.g(choice_.left_out[i]);
    }
  };
  evaluate([&](const Constraint& c, double* out) { c.position(motion.kin, out); }, g);
  evaluate([&](const Constraint& c, double* out) { c.velocity(motion.kin, out); }, g_dot);
  if (to_acceleration)
    evaluate([&](const Constraint& c, double* out) { c.acceleration(motion.kin, out); }, g_ddot);
}

ConstraintSizes ConstraintRows::sizes(const std::vector<int>& which, double length, Motion& motion,
                                      RowValues& rows) const {
  const auto n = static_cast<Eigen::Index>(which.size());
  ConstraintSizes out{Eigen::VectorXd(n), Eigen::VectorXd(n), std::vector<bool>(which.size())};
  RowLoads loads(tree_, motion, length);
  rows.x.setZero();
  for (std::size_t i = 0; i < which.size(); ++i) {
    const std::size_t k = constraint_of_row(which[i]);
    own_contact(k, motion, rows);
    loads.clear();
    rows.x(which[i]) = 1.0;
    constraints_[k]->apply_GT(motion.kin, rows.x.data() + first_row_[k], loads);
    rows.x(which[i]) = 0.0;
    out.size(static_cast<Eigen::Index>(i)) = loads.size();
    out.round_off(static_cast<Eigen::Index>(i)) = loads.round_off();
    out.is_length[i] = loads.is_length();
  }
  return out;
}

bool ConstraintRows::is_holonomic(int row) const {
  const int full = choice_.kept[row];
  const std::size_t k = constraint_of_row(full);
  return constraints_[k]->is_holonomic(full - first_row_[k]);
}

std::size_t ConstraintRows::constraint_of_row(int row) const {
  std::size_t k = 0;
  while (first_row_[k + 1] <= row) ++k;
  return k;
}

int ConstraintRows::drive_of(CoordinateRef c) const {
  for (std::size_t k = 0; k < driven_.size(); ++k)
    if (const int row = c.index - driven_[k].index;
        driven_[k].joint == c.joint && row >= 0 && row < constraints_[k]->n_rows())
      return first_row_[k] + row;
  return -1;
}

RowPlace ConstraintRows::place_of_row(int row) const {
  const std::size_t k = constraint_of_row(row);
  RowPlace place;
  place.row = row - first_row_[k];
  if (k >= first_own()) {
    place.constraint = static_cast<int>(k - first_own());
  } else if (driven_[k].joint >= 0) {
    place.joint = driven_[k].joint;
    place.driven = driven_[k].index + place.row;
  } else {
    const auto closes = [k](const auto& closure) { return closure.first && closure.second == k; };
    place.joint = static_cast<int>(std::ranges::find_if(closures_, closes) - closures_.begin());
  }
  return place;
}

std::string ConstraintRows::name_of_row(int row) const {
  const std::size_t k = constraint_of_row(row);
  const std::string name = constraints_[k]->name() + "." + constraints_[k]->row_name(row - first_row_[k]);
  const CoordinateRef driven = driven_[k];
  if (driven.joint < 0) return name;
  // Of several driven coordinates of a joint it says which, as the drives' forces do.
  const JointDescription& joint = tree_.d.joints[driven.joint];
  if (joint.driven().size() < 2) return name;
  return name + "_" + joint.driven_name(driven.index + row - first_row_[k]);
}

std::vector<std::string> ConstraintRows::names_of_left_out(int i) const {
  std::vector<std::string> names{name_of_row(choice_.left_out[i])};
  for (const int row : choice_.follows_from[i]) names.push_back(name_of_row(row));
  return names;
}

}  // namespace flexura::mbs
