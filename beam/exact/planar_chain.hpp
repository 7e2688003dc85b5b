// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "beam/exact/element.hpp"
#include "beam/exact/planar_field.hpp"
#include "beam/exact/plane.hpp"

/// A geometrically exact beam whose axis stays in a plane of its own, all elements together, in the axes of the section it
/// starts with: x along the beam, y in the plane.
///
/// The elements are those of element.hpp, strains and masses at the same points, so that in its plane it moves as the spatial
/// beam does.  In a plane one angle turns the section, and what it says of all elements beyond is linear in the
/// strains: with p_h = E c at Gauss' points (c = e_1 + gamma, E = exp(i theta)),
///
///     theta' = (linear in s'),   p' = i theta' p + E c',   p'' = (i theta'' - theta'^2) p + 2 i theta' E c' + E c''
///
/// A strain s_j of one element moves all that lies beyond its end B as one piece: with u = dr_B/ds_j and t = dtheta_B/ds_j
///
///     d(r - r_B) = t i(r - r_B),   d(v - v_B) = t i(v - v_B),   d(a - a_B) = t i(a - a_B)       by s_j
///     d a by s'_j = 2 (d v by s_j)
///
/// so forces cost O(elements), derivatives and the mass matrix O(elements^2) with small constants.
namespace flexura::beam::exact {

class PlanarChain {
 public:
  static constexpr int kPoints = Element::kPoints, kMost = PlanarField::kMost;
  using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;  ///< angular, linear
  using Modal3 = Eigen::Matrix<double, Eigen::Dynamic, 3>;

  /// `curvature` of the stress-free axis.
  PlanarChain(PlanarField field, int elements, double element_length, const SectionInertia& inertia,
              double curvature);

  PlanarChain one_element() const { return {field_, 1, l_, inertia_, curvature_}; }
  int elements() const { return elements_; }
  int n() const { return elements_ * field_.n(); }
  double length() const { return elements_ * l_; }
  double mass() const { return length() * inertia_.m; }
  /// K of one element, those of the others are the same.
  const Eigen::MatrixXd& stiffness() const { return field_.K; }

  /// A section by its element and its distance from the element's start.
  struct Place {
    int element = 0;
    double x = 0.0;
    std::array<double, kPoints> weight{};  ///< int_0^x of the points' polynomials [m]
    std::array<double, kMost> angle{};     ///< by the element's coordinates
  };
  Place place(int element, double x) const;

  /// Of one state, in the axes at the start: what the start's own motion adds is not in it.
  struct Pass {
    struct Point {
      Vec2 e;            ///< cosine and sine of the section's angle
      Vec2 p, p_v, p_a;  ///< E c and its derivatives by time
      Vec2 r, v, a;      ///< of the section's mass centre
      double w = 0.0, w_dot = 0.0;
    };
    struct End {
      Vec2 e{1.0, 0.0}, r, v, a;
      double w = 0.0, w_dot = 0.0;
    };
    std::vector<Point> points;  ///< kPoints of each element
    std::vector<End> ends;      ///< the start, then each element's end
  };
  Pass make_pass() const;
  /// Velocities and accelerations only where s_dot and s_ddot are given (else nullptr); elements before `end`.
  void move(const double* s, const double* s_dot, const double* s_ddot, Pass& out, int end) const;
  void move(const double* s, const double* s_dot, const double* s_ddot, Pass& out) const {
    move(s, s_dot, s_ddot, out, elements_);
  }

  /// After move(); V and A as far as it went.
  Element::Motion motion(const Place& place, const double* s, const double* s_dot, const double* s_ddot,
                         const Pass& pass) const;
  /// V = map s'; `r` is where the place is.
  void map(const Place& place, const Vec2& r, const Pass& pass, Columns& out) const;
  /// After move() with accelerations; r, v, a are those of the place.
  void motion_tangents(const Place& place, const Vec2& r, const Vec2& v, const Vec2& a,
                       const Vector6d& wrench, const Pass& pass, Element::MotionTangents& out) const;

  /// About the start; after move().
  void integrate(const Pass& pass, Element::Integrals& out) const;

  /// As of Element; after move() with accelerations.  The start may move in space.
  Vector6d inertia_force(const Pass& pass, const Element::Carried& start, double* need) const;
  /// True where the start moves in the plane alone, but for round-off: what the two below take for granted.
  bool stays_in_plane(const Element::Carried& start) const;
  /// Of both by s and s'.
  void inertia_tangents(const Pass& pass, const Element::Carried& start, Element::InertiaTangents& out) const;
  /// Of both by w, at s'' = alpha = a = 0.
  void turning_tangents(const Pass& pass, const Vector3d& w, Eigen::Matrix<double, 6, 3>& wrench_w,
                        Modal3& need_w) const;

 private:
  /// dr, dv, da by the coordinates of the element in which the place stands.
  struct Moved {
    std::array<Vec2, kMost> r, v, a;
  };
  struct Beyond;  // planar_beyond.hpp
  using PerCoordinate = std::array<double, kMost>;

  const Pass::Point* points_of(const Pass& pass, int element) const {
    return pass.points.data() + static_cast<std::size_t>(kPoints * element);
  }
  Moved moved(const Pass::Point* points, const std::array<double, kPoints>& weight, bool with_motion) const;
  Moved moved_mass(const Pass::Point* points, std::size_t g, bool with_motion) const;
  /// Moments of inertia per length about the mass centre, in the axes at the start.
  Matrix3d rotary(const Vec2& e) const;

  PlanarField field_;
  int elements_;
  double l_;
  SectionInertia inertia_;
  double curvature_;
  double offset_;           ///< of the mass centre along y [m]
  double I_x_, I_y_, I_z_;  ///< of the section about its mass centre, per length
  std::array<double, kPoints> x_, mass_weight_, end_weight_;
  std::array<std::array<double, kPoints>, kPoints> weight_;     ///< [point][h]
  std::array<PerCoordinate, kPoints> angle_, stretch_, shear_;  ///< at Gauss' points, by the coordinates
  PerCoordinate end_angle_;
};

}  // namespace flexura::beam::exact
