// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "mbs/bodies/left_out_modes.hpp"
#include "mbs/bodies/particle_acceleration.hpp"

/// Stresses of a flexible body in motion, from stress modes (theory: UM 11.1.3):
///
///     sigma(v, t) = S(v) (Y s(t) + u_left) + sum_i S_i(v) f_i(t) + G(v) z(t)
///
/// with the superelement's stress modes S at the places v and the basis Y: O(m) for one place, whatever the
/// mesh.  S_i is what load case i, of the factor f_i, adds, G what the body's own acceleration does (StressModes of the
/// superelement), u_left what the modes left out give way (left_out_modes.hpp): the stress is in balance with what loads
/// the body inside, too, as far as the superelement knows.
namespace flexura::mbs {

using Stress = Eigen::Matrix<double, 6, 1>;  ///< xx, yy, zz, xy, yz, zx [Pa], in B
using Strain = Eigen::Matrix<double, 6, 1>;  ///< likewise, shears as angles (g_xy = 2 e_xy)

/// sqrt(3 J2).
double von_mises(const Stress& sigma);

class StressField {
 public:
  /// A place of which the whole history is wanted.
  struct Point {
    std::string name;
    Eigen::Vector3d wanted;                        ///< [m] in B
    int place = 0;                                 ///< the nearest place with stress modes
    double distance = 0.0;                         ///< from there [m]
    Eigen::Matrix<double, 6, Eigen::Dynamic> S{};  ///< of that place, with the basis worked in
  };
  struct Largest {
    double von_mises = 0.0;
    int place = 0;
  };

  struct LargestStrain {
    double strain = 0.0;
    int place = 0;
  };

  /// `S` 6 n_s x n_se: stress modes at n_s places; `x` 3 x n_s where they are; `vertices` n_s their indices
  /// on the superelement's surface; `Y` n_se x m.  Throws std::invalid_argument where sizes disagree.  S times Y at all
  /// places is made where all places are asked for: for the few of stress points it costs more than a short run.
  StressField(std::shared_ptr<const Eigen::MatrixXd> S, Eigen::Matrix3Xd x, std::vector<int> vertices,
              const Eigen::MatrixXd& Y);
  StressField(const Eigen::MatrixXd& S, Eigen::Matrix3Xd x, std::vector<int> vertices,
              const Eigen::MatrixXd& Y);

  int places() const { return static_cast<int>(given_->rows() / 6); }
  Eigen::Vector3d position(int place) const { return x_.col(place); }  ///< undeformed, in B
  /// Index of the place among the vertices of the superelement's surface.
  int vertex(int place) const { return vertices_[place]; }
  void add_point(const std::string& name, const Eigen::Vector3d& wanted);
  const std::vector<Point>& points() const { return points_; }

  /// One matrix for each material [1/Pa], and the material of each place.  Throws std::invalid_argument where
  /// they do not fit.
  void set_compliance(std::vector<Eigen::Matrix<double, 6, 6>> compliance, std::vector<int> material);
  bool has_strain() const { return !compliance_.empty(); }

  /// 6 n_s x load cases; `factors` below are theirs.  Throws std::invalid_argument where the rows do not fit.
  void set_loads(Eigen::MatrixXd of_loads);
  bool has_loads() const { return of_loads_.size() > 0; }

  /// 6 n_s x (6 + n_b) as in StressModes, or empty; `rigid_motions` n_se x 6; `left_out` of the modes.
  void set_inertia(Eigen::MatrixXd of_acceleration, Eigen::MatrixXd rigid_motions, Coupling coupling,
                   std::optional<LeftOutModes> left_out, StiffeningLoads stiffening = {});
  bool has_inertia() const { return of_acceleration_.size() > 0; }
  /// True where beyond() wants to know what acts on the nodes.
  bool takes_node_loads() const { return left_out_.has_value(); }
  /// What the modes do not show of a motion: (z, u_left); empty where nothing is known of it.  For `more` below.
  Eigen::VectorXd beyond(const BodyMotion& motion, const double* factors) const;

  Stress at(int place, const double* s, const double* factors = nullptr,
            const Eigen::VectorXd* more = nullptr) const;
  /// The elastic strain, of which the stress is; a preload's own strain is not in it.
  Strain strain_at(int place, const double* s, const double* factors = nullptr,
                   const Eigen::VectorXd* more = nullptr) const {
    return compliance_[material_[place]] * at(place, s, factors, more);
  }
  /// Over all places.
  Largest largest(const double* s, const double* factors = nullptr,
                  const Eigen::VectorXd* more = nullptr) const;
  /// The principal strain of the largest size over all places, with its sign.
  LargestStrain largest_strain(const double* s, const double* factors = nullptr,
                               const Eigen::VectorXd* more = nullptr) const;

 private:
  /// At all places, one below the other.
  Eigen::VectorXd stresses(const double* s, const double* factors, const Eigen::VectorXd* more) const;
  const Eigen::MatrixXd& everywhere() const;

  std::shared_ptr<const Eigen::MatrixXd> given_;  // 6 n_s x n_se
  Eigen::MatrixXd Y_;
  mutable std::once_flag once_;
  mutable Eigen::MatrixXd S_;  // 6 n_s x m
  Eigen::MatrixXd of_loads_, of_acceleration_, rigid_motions_;
  Coupling coupling_ = Coupling::full;
  std::optional<LeftOutModes> left_out_;
  StiffeningLoads stiffening_;
  Eigen::Matrix3Xd x_;  // 3 x n_s
  std::vector<int> vertices_;
  std::vector<Eigen::Matrix<double, 6, 6>> compliance_;
  std::vector<int> material_;
  std::vector<Point> points_;
};

}  // namespace flexura::mbs
