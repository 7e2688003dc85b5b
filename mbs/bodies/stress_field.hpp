// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

/// Stresses of a flexible body in motion, from stress modes (theory: UM 11.1.3):
///
///     sigma(v, t) = S(v) Y s(t) + sum_i S_i(v) f_i(t)
///
/// with the superelement's stress modes S at the places v and the basis Y: O(m) for one place, whatever the
/// mesh.  S_i is the stress of load case i on the body with all its nodes held (of a preload; of others it is zero), f_i the
/// case's factor.  What the body does not show at its interfaces and modes (loads inside, fast waves) it has no stress
/// of; with response modes for the loads in use the static part is the superelement's.
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

  Stress at(int place, const double* s, const double* factors = nullptr) const;
  /// The elastic strain, of which the stress is; a preload's own strain is not in it.
  Strain strain_at(int place, const double* s, const double* factors = nullptr) const {
    return compliance_[material_[place]] * at(place, s, factors);
  }
  /// Over all places.
  Largest largest(const double* s, const double* factors = nullptr) const;

 private:
  const Eigen::MatrixXd& everywhere() const;

  std::shared_ptr<const Eigen::MatrixXd> given_;  // 6 n_s x n_se
  Eigen::MatrixXd Y_;
  mutable std::once_flag once_;
  mutable Eigen::MatrixXd S_;  // 6 n_s x m
  Eigen::MatrixXd of_loads_;
  Eigen::Matrix3Xd x_;  // 3 x n_s
  std::vector<int> vertices_;
  std::vector<Eigen::Matrix<double, 6, 6>> compliance_;
  std::vector<int> material_;
  std::vector<Point> points_;
};

}  // namespace flexura::mbs
