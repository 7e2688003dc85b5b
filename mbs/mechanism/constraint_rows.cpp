// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <limits>

#include "mbs/mechanism/work.hpp"

/// What is asked of single constraint rows: names, sizes, and those that were left out.
namespace flexura::mbs {

/// Takes up the largest that a row applies, a force by the length along which its marker may move.
class Mechanism::RowLoads final : public Loads {
 public:
  RowLoads(const Mechanism& mechanism, const Work& work, double length)
      : mechanism_(mechanism), work_(work), length_(length) {
    for (std::size_t i = 0; i < mechanism_.d_.markers.size(); ++i)
      farthest_ = std::max({farthest_, work.kin.markers[i].X_WP.p.norm(), work.local[i].X_BP.p.norm()});
  }
  using Loads::apply;
  void apply(int /*marker*/, const Spatial& wrench_W) override {
    const double force = wrench_W.linear.norm(), torque = wrench_W.angular.norm();
    add(force, torque, force * length_ + torque, force * farthest_ + torque);
  }
  void apply(CoordinateRef c, double force) override {
    const JointPlace& place = mechanism_.places_[c.joint];
    const bool is_angle = place.joint->speeds()[c.index].dimension == input::dim::angular_velocity;
    const double f = std::abs(force);
    // A coordinate's own value, where it turns on and on.
    const double value = place.in_tree() && place.joint->n_p() == place.joint->n_v()
                             ? std::abs(work_.kin.p[place.i_p + c.index])
                             : 0.0;
    const double reach = is_angle ? 1.0 : length_;
    add(is_angle ? 0.0 : f, is_angle ? f : 0.0, f * reach,
        f * std::max(value, is_angle ? 1.0 : farthest_));
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

  const Mechanism& mechanism_;
  const Work& work_;
  double length_, farthest_ = 0.0;
  double force_ = 0.0, torque_ = 0.0, size_ = 0.0, numbers_ = 0.0;
};

std::size_t Mechanism::constraint_of_row(int row) const {
  std::size_t k = 0;
  while (first_row_[k + 1] <= row) ++k;
  return k;
}

std::string Mechanism::name_of_row(int row) const {
  const std::size_t k = constraint_of_row(row);
  const std::string name = constraints_[k]->name() + "." + constraints_[k]->row_name(row - first_row_[k]);
  const auto* const drive = dynamic_cast<const DriveConstraint*>(constraints_[k].get());
  if (!drive) return name;
  // Of several driven coordinates of a joint it says which, as the drives' forces do.
  const JointDescription& joint = d_.joints[drive->coordinate().joint];
  if (joint.drives.size() + joint.speed_drives.size() + joint.acceleration_drives.size() < 2) return name;
  return name + "_" + joint.joint->coordinates()[drive->coordinate().index].name;
}

std::vector<std::string> Mechanism::names_of_left_out(int i) const {
  std::vector<std::string> names{name_of_row(left_out_[i])};
  for (const int row : follows_from_[i]) names.push_back(name_of_row(row));
  return names;
}

/// The box around all markers and centres of mass, after forward(): corner to corner, at least a micrometre.
double Mechanism::extent(const Work& work) const {
  const double none = std::numeric_limits<double>::infinity();
  Vector3d low = Vector3d::Constant(none), high = -low;
  const auto take = [&](const Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (std::size_t i = 0; i < d_.markers.size(); ++i) take(work.kin.markers[i].X_WP.p);
  for (const int b : order_)
    if (const RigidInertia& I = d_.bodies[b].inertia; I.mass > 0.0)
      take(work.bodies[b].X_WB * Vector3d(I.mass_center / I.mass));
  return d_.markers.empty() ? 1e-6 : std::max(1e-6, (high - low).norm());
}

/// What a coordinate changes by in a motion about as large as the mechanism: 1 rad, its extent, a mode's
/// amplitude of that size.
Eigen::VectorXd Mechanism::kinematic_scale(double extent) const {
  Eigen::VectorXd scale(n_v_);
  for (int i = 0; i < n_v_; ++i) scale(i) = extent * velocity_scale(i);
  for (const int b : order_) {
    const JointPlace& place = places_[bodies_[b].joint];
    const std::vector<CoordinateInfo> speeds = place.joint->speeds();
    for (int i = 0; i < place.joint->n_v(); ++i)
      if (speeds[i].dimension == input::dim::angular_velocity) scale(place.i_v + i) = 1.0;
  }
  return scale;
}

ConstraintSizes Mechanism::sizes_of_rows(const std::vector<int>& rows, double t, ConstVectorRef p,
                                         Work& work) const {
  forward(Level::position, t, p.data(), nullptr, nullptr, work);
  const auto n = static_cast<Eigen::Index>(rows.size());
  ConstraintSizes out{Eigen::VectorXd(n), Eigen::VectorXd(n), std::vector<bool>(rows.size())};
  RowLoads loads(*this, work, extent(work));
  work.rows_x.setZero();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::size_t k = constraint_of_row(rows[i]);
    own_contact(k, work);
    loads.clear();
    work.rows_x(rows[i]) = 1.0;
    constraints_[k]->apply_GT(work.kin, work.rows_x.data() + first_row_[k], loads);
    work.rows_x(rows[i]) = 0.0;
    out.size(static_cast<Eigen::Index>(i)) = loads.size();
    out.round_off(static_cast<Eigen::Index>(i)) = loads.round_off();
    out.is_length[i] = loads.is_length();
  }
  return out;
}

ConstraintSizes Mechanism::constraint_sizes(double t, ConstVectorRef p, Scratch& scratch) const {
  return sizes_of_rows(kept_rows_, t, p, work_of(scratch));
}

ConstraintSizes Mechanism::left_out_sizes(double t, ConstVectorRef p, Scratch& scratch) const {
  return sizes_of_rows(left_out_, t, p, work_of(scratch));
}

void Mechanism::left_out_constraints(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                     Scratch& scratch, VectorRef g, VectorRef g_dot,
                                     VectorRef g_ddot) const {
  if (left_out_.empty()) return;
  Work& work = work_of(scratch);
  const bool to_acceleration = v_dot.size() > 0;
  forward(to_acceleration ? Level::acceleration : Level::velocity, t, p.data(), v.data(), v_dot.data(), work);
  const auto evaluate = [&](auto&& level, VectorRef out) {
    std::size_t i = 0;
    for (std::size_t k = 0; k < constraints_.size() && i < left_out_.size(); ++k) {
      if (left_out_[i] >= first_row_[k + 1]) continue;
      own_contact(k, work);
      level(*constraints_[k], work.rows_g.data() + first_row_[k]);
      for (; i < left_out_.size() && left_out_[i] < first_row_[k + 1]; ++i)
        out(static_cast<Eigen::Index>(i)) = work.rows_g(left_out_[i]);
    }
  };
  evaluate([&](const Constraint& c, double* out) { c.position(work.kin, out); }, g);
  evaluate([&](const Constraint& c, double* out) { c.velocity(work.kin, out); }, g_dot);
  if (to_acceleration) evaluate([&](const Constraint& c, double* out) { c.acceleration(work.kin, out); }, g_ddot);
}

}  // namespace flexura::mbs
