// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "mbs/kinematics/picture.hpp"

namespace flexura::mbs {

/// What nodes of a surface touch (SurfaceContact): a surface in the axes of F, which may move with modal coordinates s of its own.
///
/// All that is said of a point follows z = (p, y_1 ... y_V): the point and the vertices of the surface that it depends on, none of a
/// shape that does not deform.  A function of z is blind to a common motion of the point and all of these vertices, so that forces
/// along its gradient balance.
class TouchedSurface {
 public:
  struct Foot {
    double gap = 0.0;           ///< of p, negative: it has gone in
    double cover = 1.0;         ///< 1 on the surface, falls to 0 where the surface ends
    std::vector<int> vertices;  ///< that z holds
    Eigen::VectorXd gap_z, cover_z;
    Eigen::MatrixXd gap_zz, cover_zz;  ///< of second order
    Eigen::VectorXd share;    ///< of the vertices, sum 1: what is touched moves with sum share_k y_k'
    Eigen::MatrixXd share_z;  ///< of second order
    bool is_at_end = false;   ///< cover_z and cover_zz are not 0 (and set)
    void start() {
      cover = 1.0;
      is_at_end = false;
      vertices.clear();
      share.resize(0);
    }
    int n() const { return 3 + 3 * static_cast<int>(vertices.size()); }
  };
  using Shapes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  virtual ~TouchedSurface() = default;
  /// What follows on this thread is asked of these coordinates: said before many points are asked for, so that what they share is done
  /// once.
  virtual void start(const double* /*s*/) const {}
  /// Less than 0 where p touches, greater the farther it is.
  virtual double separation(const Vector3d& p, const double* s) const = 0;
  /// Points within r of c have no separation below bound() - r; it may be any number above `enough` where it is above that.
  virtual double bound(const Vector3d& c, const double* s, double enough) const = 0;
  /// False where the gap is above 0 or nothing is there.  Second order only where asked for.
  virtual bool find_foot(const Vector3d& p, const double* s, bool second, Foot& foot) const = 0;

  /// Modal coordinates that it follows; shapes of a vertex by them (3 x m) and its velocity.
  virtual int m() const { return 0; }
  virtual Eigen::Ref<const Shapes> shapes(int /*vertex*/) const {
    static const Shapes none(3, 0);
    return none;
  }
  virtual Vector3d velocity(int /*vertex*/, const double* /*s_dot*/) const { return Vector3d::Zero(); }
  virtual std::optional<DrawnSurface> drawn() const { return std::nullopt; }
};

}  // namespace flexura::mbs
