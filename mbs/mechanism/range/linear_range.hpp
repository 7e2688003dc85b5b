// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "mbs/bodies/deformation_probes.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/mechanism/range/shortening.hpp"

/// Watches whether flexible bodies stay in the range of their law of deformation.
///
/// Displacements linear in the modal coordinates miss the shortening theta^2 / 2 of a line that turns by theta,
/// relative to its length.  What is judged does not depend on the frame:
///
/// - the rotation theta of one interface against another;
/// - the displacement d of an interface, or of a probe between interfaces (deformation_probes.hpp), as another
///   interface at the distance l sees it; a cantilever under a force at its tip, and a beam whose end is
///   guided, get shorter by 3/5 (d / l)^2 of their length;
/// - the strain along edges of the surface, of an ANCF beam that of the straight line between its stations:
///   elasticity is linear;
/// - the turn of an ANCF beam's sections within an element, which interpolates their axes along the chord;
/// - what bending asks two interfaces to come closer, where the mechanism holds them apart (shortening.hpp).
///
/// Probes are read when a body first deforms by a thousandth of its size (in the mean over its mass), so that
/// bodies which stay stiff never ask for them.
namespace flexura::mbs {

struct RangeLimits {
  double rotation = 10.0 * 3.14159265358979323846 / 180.0;  ///< [rad]; 1.5 % of the length are missed there
  double displacement = 0.1;                                ///< of the distance; 0.6 % of the length
  double strain = 0.1;
  double turn = 3.14159265358979323846 / 4.0;  ///< within an ANCF element [rad]; turn^4/32 too stiff, 1.2 %
  double stiffness = 0.02;  ///< part of the stiffness that is left out where ends are held apart
  double of_size = 1.0;     ///< displacement by the body's own size: nothing of the result holds
  double across = 1e-3;     ///< of gravity, along the normal of a plane in which a body bends alone
  double runaway = 10.0;    ///< the same: it grows without bound
};

class LinearRange {
 public:
  /// `span`: how long the motion takes [s]; 0 for one that stands.
  explicit LinearRange(const Mechanism& mechanism, double span = 0.0, const RangeLimits& limits = {});

  void observe(const State& s);

  /// One for each body that left the range, with where, when and by how much.
  std::vector<std::string> sentences() const;
  /// Why the last state observed is no result any more; empty where no body is deformed beyond
  /// RangeLimits::runaway.
  std::string runaway() const;
  /// True where the body's displacements have left the range in which they are linear, or its stiffness misses what its ends,
  /// held apart, add to it.
  bool is_left(int body) const;
  /// Largest rotation of one interface against another so far [rad]; 0 for a rigid body.
  double largest(int body) const { return watched_[body].rotation.value; }

 private:
  /// The largest of its kind so far.
  struct Worst {
    double value = 0.0, t = 0.0, moved = 0.0;
    std::string what, against;
  };
  struct Watched {
    double size = 0.0;  ///< of the body [m]
    Worst rotation, displacement, strain, of_size;
    Worst turn;  ///< moved: elements that would turn by 20 degrees
    std::shared_ptr<const DeformationProbes> probes;
    std::vector<BendingLine> lines;
    double line_asked = 0.0;  ///< part of the stiffness for which it was last asked whether ends are held
    Worst held;               ///< value: part of the stiffness; moved: how much closer they should come [m]
    double tension = 0.0;     ///< there [N]
    bool asked = false;
    Worst across;  ///< of what bends in a plane alone, gravity's part along its normal
  };
  void observe_linear(int body, const State& state, const double* s);
  void ask_surface(int body, const double* s);
  void observe_lines(int body, const State& state, const Eigen::VectorXd& s);
  void observe_planes(const State& s);
  void observe_displacement(Watched& watched, double t, double moved, double distance,
                            const std::string& what, const std::string& against) const;

  const Mechanism& mechanism_;
  double span_;
  RangeLimits limits_;
  std::vector<Watched> watched_;
  std::vector<Pose> poses_;
  std::vector<int> planar_;  ///< bodies that bend in a plane alone, of a chain the first
  std::unique_ptr<Equations::Scratch> scratch_;
  std::vector<Pose> of_bodies_;
  Eigen::VectorXd strains_;
  Eigen::Matrix3Xd displacements_;
};

}  // namespace flexura::mbs
