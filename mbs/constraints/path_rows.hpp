// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "mbs/kinematics/body_path.hpp"

/// Rows h = a . b between sums of vectors that the markers of a path, and one more, carry: see point_on_path.hpp.
namespace flexura::mbs::path_rows {

/// Positions of the markers at work and of P, two directions of each, two axes of M.
inline constexpr int kVectors = 3 * BodyPath::kActive + 3;
using Columns = Eigen::Matrix<double, 3, kVectors>;
using Weights = Eigen::Matrix<double, kVectors, 1>;
/// Weights of the vectors in a sum, and their first two derivatives by s.
using Sum = std::array<Weights, 3>;

/// The vectors at one state, in the axes of F, the first marker at work: what is fixed in F does not move.
struct Vectors {
  Columns y = Columns::Zero(), y_t = Columns::Zero(), y_tt = Columns::Zero();
  std::array<int, kVectors> of{};            ///< the marker that carries each, as counted in `markers`
  std::array<bool, kVectors> is_position{};  ///< else a direction
  std::array<int, BodyPath::kActive + 1> markers{};  ///< F, the others at work, M
  std::array<Vector3d, BodyPath::kActive + 1> w{};   ///< their angular velocities in F
  int n = 0, n_markers = 0;                          ///< vectors and markers there are
  Sum to_point, tangent, side, up, y_M, z_M;         ///< d, tau, e_side, e_up and axes of M
};

enum class Level { position, velocity, acceleration };

/// At the place s.
Vectors see(const BodyPath& path, const Kinematics& kin, int marker_M, double s, Level level);

/// h = a . b and its derivatives, see point_on_path.hpp; `by` those by the vectors.
struct Row {
  double h = 0.0, h_s = 0.0, h_ss = 0.0, h_t = 0.0, h_st = 0.0, h_tt = 0.0;
  Columns by = Columns::Zero(), by_s = Columns::Zero(), by_t = Columns::Zero();
  void add(double factor, const Row& other);
};
Row row(const Vectors& x, const Sum& a, const Sum& b);

/// How vector j moves with the marker that carries it, turned by dtheta and shifted by dp: 3 x 6.
Eigen::Matrix<double, 3, 6> motion_of(const Vectors& x, int j);
/// The wrench on marker k about its origin (in the axes of F) of forces f on the vectors.
Vector6d wrench_on(const Vectors& x, int k, const Columns& f);

}  // namespace flexura::mbs::path_rows
