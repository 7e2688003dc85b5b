// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <functional>
#include <utility>

#include "tests/mbs/random/simbody/simbody_system.hpp"

/// Weight, springs and loads: Simbody's elements, or a law on its bodies and coordinates.
namespace flexura::mbs::chance {

namespace sim = SimTK;

namespace {

/// On bodies and along coordinates.
using Act =
    std::function<void(const sim::State&, sim::Vector_<sim::SpatialVec>& on_bodies, sim::Vector& along)>;

class Acting : public sim::Force::Custom::Implementation {
 public:
  explicit Acting(Act act) : act_(std::move(act)) {}
  void calcForce(const sim::State& state, sim::Vector_<sim::SpatialVec>& on_bodies, sim::Vector_<sim::Vec3>&,
                 sim::Vector& along) const override {
    act_(state, on_bodies, along);
  }
  sim::Real calcPotentialEnergy(const sim::State&) const override { return 0.0; }

 private:
  const Act act_;
};

}  // namespace

void SimbodySystem::add_forces() {
  if (!scene_.gravity.isZero(0.0)) sim::Force::Gravity(forces_, matter_, to_simbody(scene_.gravity));
  for (const SceneForce& force : scene_.forces) add_force(force);
}

void SimbodySystem::add_force(const SceneForce& f) {
  if (f.type == "spring_damper") {
    const sim::Vec3 P = on_body(f.F).p(), Q = on_body(f.M).p();
    sim::Force::TwoPointLinearSpring(forces_, body_at(f.F), P, body_at(f.M), Q, f.stiffness, f.rest);
    sim::Force::TwoPointLinearDamper(forces_, body_at(f.F), P, body_at(f.M), Q, f.damping);
  } else if (f.type == "bushing") {
    add_bushing(f);
  } else if (f.type == "joint_spring_damper") {
    const Coordinate q = coordinate(f.joint, f.coordinate);
    sim::MobilizedBody& body = matter_.updMobilizedBody(q.body);
    sim::Force::MobilityLinearSpring(forces_, body, sim::MobilizerQIndex(q.q), f.stiffness, f.rest);
    sim::Force::MobilityLinearDamper(forces_, body, sim::MobilizerUIndex(q.q), f.damping);
  } else if (f.is_along_joint()) {
    add_along_joint(f);
  } else {
    add_load(f);
  }
}

// The same in all directions: a pull to F's origin and a twist back along the rotation vector.  Simbody's own bushing counts three
// angles.
void SimbodySystem::add_bushing(const SceneForce& f) {
  const sim::MobilizedBody A = body_at(f.F), B = body_at(f.M);
  const sim::Transform X_AF = on_body(f.F), X_BM = on_body(f.M);
  sim::Force::Custom(
      forces_,
      new Acting([=, &f](const sim::State& s, sim::Vector_<sim::SpatialVec>& on_bodies, sim::Vector&) {
        const sim::Transform X_GF = A.getBodyTransform(s) * X_AF, X_GM = B.getBodyTransform(s) * X_BM;
        const sim::Vec3 on_A = A.findStationAtGroundPoint(s, X_GM.p());
        const sim::Vec4 turn = (~X_GF.R() * X_GM.R()).convertRotationToAngleAxis();
        const sim::Vec3 theta = X_GF.R() * (turn[0] * turn.getSubVec<3>(1));
        const sim::Vec3 slip =
            B.findStationVelocityInGround(s, X_BM.p()) - A.findStationVelocityInGround(s, on_A);
        const sim::Vec3 spin = B.getBodyAngularVelocity(s) - A.getBodyAngularVelocity(s);
        const sim::Vec3 pull = -f.stiffness * (X_GM.p() - X_GF.p()) - f.damping * slip,
                        twist = -f.turn_stiffness * theta - f.turn_damping * spin;
        B.applyForceToBodyPoint(s, X_BM.p(), pull, on_bodies);
        A.applyForceToBodyPoint(s, on_A, -pull, on_bodies);
        B.applyBodyTorque(s, twist, on_bodies);
        A.applyBodyTorque(s, -twist, on_bodies);
      }));
}

void SimbodySystem::add_load(const SceneForce& f) {
  const sim::MobilizedBody B = body_at(f.M);
  const sim::Vec3 at = on_body(f.M).p();
  sim::Force::Custom(forces_, new Acting([=, &f](const sim::State& s,
                                                 sim::Vector_<sim::SpatialVec>& on_bodies, sim::Vector&) {
                       const double t = s.getTime();
                       const sim::Vec3 value(f.law[0].value(t), f.law[1].value(t), f.law[2].value(t));
                       if (f.type == "torque")
                         B.applyBodyTorque(s, value, on_bodies);
                       else
                         B.applyForceToBodyPoint(s, at, value, on_bodies);
                     }));
}

void SimbodySystem::add_along_joint(const SceneForce& f) {
  const Coordinate c = coordinate(f.joint, f.coordinate);
  const sim::MobilizedBody body = matter_.getMobilizedBody(c.body);
  sim::Force::Custom(
      forces_, new Acting([=, &f](const sim::State& s, sim::Vector_<sim::SpatialVec>&, sim::Vector& along) {
        const double q = body.getOneQ(s, c.q), rate = body.getOneU(s, c.q);
        const double size = f.type == "actuator" ? f.actuator_force(s.getTime())
                            : f.type == "joint_force"
                                ? f.level[q > f.at ? 1 : 0]
                                : -f.coulomb * std::tanh(rate / f.transition) - f.damping * rate;
        body.applyOneMobilityForce(s, c.q, size, along);
      }));
}

}  // namespace flexura::mbs::chance
