// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/mechanism/motion/tree_motion.hpp"

/// The sweep inwards: the recursive Newton-Euler algorithm (Featherstone, Rigid Body Dynamics Algorithms, ch. 5) with
/// flexible bodies in floating frames, and deformations that follow the motion without acting back on it
/// (FlexibleBody::acts_back).
namespace flexura::mbs {

/// What acts at one state.
struct Wrenches {
  struct Body {
    Spatial F;              ///< wrench on the body about Bo that its motion needs, in W, less what is applied
    Spatial through_joint;  ///< wrench on this body about the outer marker's origin, in W
    std::unique_ptr<FlexibleBody::Scratch> flexible;
    Eigen::VectorXd no_acceleration;  ///< of a deformation that does not act back
  };
  std::vector<Body> bodies;
  Eigen::VectorXd
      r;  ///< n_v forces along the velocity coordinates, then those of deformations that do not act back
  std::vector<Spatial> on_marker;  ///< all applied to a marker that is carried, about its origin, in W
  /// What force elements put on the coordinate of a joint that closes a loop, on M about Mo in F; empty where nobody asks.
  std::vector<Vector6d> on_closure;
};

class InverseDynamics {
 public:
  using Level = TreeMotion::Level;

  explicit InverseDynamics(const Topology& tree) : tree_(tree) {}
  void size(Wrenches& wrenches) const;

  /// The integrals of deformed bodies, after forward(); what asks for positions and velocities alone does without.
  void set_deformations(const Motion& motion, Wrenches& wrenches) const;
  /// What the motion of every body needs, after forward() on level acceleration and with kin.c; sets the integrals that this takes,
  /// set_deformations() all.
  void body_forces(const Motion& motion, Wrenches& wrenches) const;
  void clear_loads(Wrenches& wrenches) const;
  /// All wrenches inwards to the coordinates (n_v).
  void backward(const Motion& motion, Wrenches& wrenches, double* r) const;

  /// Rates of the deformations that do not act back, after backward(); c_rate holds all dynamic states.
  void following_rates(const Motion& motion, const Wrenches& wrenches, double* c_rate) const;

  /// Energies of the bodies, and what their dampers take out; after set_deformations() on level velocity.
  void add_energies(const Motion& motion, const Wrenches& wrenches, EnergyReport& report) const;
  /// Angular momentum about the world's origin and linear momentum, in W; after set_deformations().
  Vector6d total_momentum(const Motion& motion, const Wrenches& wrenches) const;

 private:
  void following_need(int body, const Spatial& V, const Spatial& A, const Motion& motion,
                      Wrenches& wrenches) const;

  const Topology& tree_;
};

/// Takes loads into the wrenches, times `factor`.
class BodyLoads final : public Loads {
 public:
  BodyLoads(const Topology& tree, const Motion& motion, Wrenches& wrenches, double factor)
      : tree_(tree), motion_(motion), wrenches_(wrenches), factor_(factor) {}
  using Loads::apply;
  void apply(int marker, const Spatial& wrench_W) override;
  void apply(CoordinateRef c, double force) override;
  void apply_modal(int body, const Eigen::VectorXd& f, double factor) override;

 private:
  const Topology& tree_;
  const Motion& motion_;
  Wrenches& wrenches_;
  double factor_;
};

}  // namespace flexura::mbs
