// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <utility>

#include "mbs/kinematics/surface_mesh.hpp"
#include "mbs/kinematics/touched_surface.hpp"

namespace flexura::mbs {

/// The surface of a body as its modes deform it, smoothed over about one facet, so that nothing jumps where a point slides from
/// facet to facet.  Facet t with the middle c_t, the area vector a_t = (e_1 x e_2) / 2 and the undeformed area alpha_t sees the point p
/// at the height a_t . (p - c_t) / alpha_t over its plane; the gap is the mean of these heights,
///
///     gap = sum w_t a_t . (p - c_t) / sum w_t alpha_t,     w_t = (1 - |p - c_t|^2 / r_t^2)^3 within r_t
///
/// (implicit moving least squares: C. Shen, J. O'Brien, J. Shewchuk, ACM Trans. Graphics 23 (2004) 896; R. Kolluri, ACM Trans.
/// Algorithms 4 (2008) 18).  r_t is twice the way from the middle of the facet to its farthest corner: some ten facets take part.
/// On a plane the gap is the distance; on a sphere of the radius R its zero stands within r^2 / (10 R) of it.  Normals,
/// curvatures and velocities follow from derivatives, which are exact.
///
/// How much surface there is around p, in parts of a plane that goes on, is C = sum w_t alpha_t / (pi r_t^2 / 4): 1/2 on a
/// straight edge, 1/4 on a right-angled corner.  Beyond these the cover, a step of third degree from C = 0 to kWhole, takes
/// the contact away.
class SmoothedSurface final : public TouchedSurface {
 public:
  /// The mesh may get its shapes later.
  explicit SmoothedSurface(std::shared_ptr<const SurfaceMesh> mesh);

  void start(const double* s) const override;
  double separation(const Vector3d& p, const double* s) const override;
  double bound(const Vector3d& c, const double* s, double enough) const override;
  bool find_foot(const Vector3d& p, const double* s, bool second, Foot& foot) const override;
  int m() const override { return mesh_->m(); }
  Eigen::Ref<const Shapes> shapes(int vertex) const override { return mesh_->shapes(vertex); }
  Vector3d velocity(int vertex, const double* s_dot) const override { return mesh_->velocity(vertex, s_dot); }

  std::optional<DrawnSurface> drawn() const override { return DrawnSurface{.kind = "body"}; }

  /// Two facets, near enough to be smoothed into one, that look into opposite directions: no surface that has a side to
  /// touch.  (-1, -1) where there are none.
  std::pair<int, int> opposed() const;
  const SurfaceMesh& mesh() const { return *mesh_; }

 private:
  /// Part of full cover from which on all is covered: below that of a corner.
  static constexpr double kWhole = 0.2;
  /// A facet as it is deformed.
  struct Facet {
    Vector3d c, e_1, e_2, a;  ///< middle, edges, area vector
  };
  /// One that p is within reach of.
  struct Near {
    int t;
    const Facet* facet;
    Vector3d d;      ///< p - c
    double h, rest;  ///< a . d, 1 - |d|^2 / r^2
    double w() const { return rest * rest * rest; }
  };
  struct Placed;
  static Placed& placed();
  /// What has been asked for of these coordinates before is at hand.
  Placed& place(const double* s) const;
  const Facet& facet(int t, const double* s, Placed& at) const;
  bool look(const Vector3d& p, int t, const double* s, Placed& at, Near& near) const;
  double reach(int t) const { return reach_(t); }
  template <class Enter, class Take>
  void visit(const double* s, Placed& at, const Enter& enter, const Take& take) const;

  std::shared_ptr<const SurfaceMesh> mesh_;
  Eigen::VectorXd area_, reach_;  ///< alpha_t, r_t
  long number_;                   ///< no other surface of the program has it
};

}  // namespace flexura::mbs
