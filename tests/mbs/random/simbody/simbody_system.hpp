// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Simbody.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/mbs/random/simbody/simbody_scene.hpp"

namespace flexura::mbs::chance {

SimTK::Vec3 to_simbody(const Vector3d& x);
SimTK::Transform to_simbody(const Pose& X);

/// See SimbodyScene.
class SimbodySystem {
 public:
  explicit SimbodySystem(const Scene& scene);
  static std::string lacks(const Scene& scene);
  void place(double t, const std::vector<BodyMotion>& motion);
  long run(double t, double accuracy, double disturbance);
  std::vector<BodyMotion> motion() const;
  SimbodyScene::Rows rows() const { return {n_kept_, least_pivot_, largest_left_, open_}; }

 private:
  // A joint is one mobilizer, or several with massless bodies between.
  struct Step {
    SimTK::MobilizedBody body;
    SimTK::Rotation axes;              ///< of the mobilizer in the joint's markers
    bool turns = true, slides = true;  ///< what part of the joint's pose it takes
  };
  struct Branch {
    int joint = -1;  ///< -1: the body stands free
    int A = 0, B = 0;
    SimTK::Transform X_AF, X_BM;
    bool is_reversed = false;  ///< grows from B
    std::vector<Step> steps;
  };
  struct Coordinate {
    SimTK::MobilizedBodyIndex body;
    SimTK::MobilizerQIndex q;
  };

  void grow_tree();
  void add_branch(Branch branch);
  void count_turns();
  SimTK::Body body_of(int b) const;
  const Branch* branch_of(int joint) const;  ///< nullptr: it closes a loop
  Coordinate coordinate(int joint, int coordinate) const;
  SimTK::Transform on_body(int marker) const { return to_simbody(scene_.markers[marker].X_BP); }
  SimTK::MobilizedBody& body_at(int marker) { return bodies_[scene_.markers[marker].body]; }

  // simbody_constraints.cpp
  void add_constraints();
  void choose_rows();
  void close(const std::string& type, int F, int M);
  void couple(const SceneConstraint& constraint);
  void drive(int joint, const SceneDrive& drive);

  // simbody_forces.cpp
  void add_forces();
  void add_force(const SceneForce& force);
  void add_bushing(const SceneForce& force);
  void add_load(const SceneForce& force);
  void add_along_joint(const SceneForce& force);

  const Scene& scene_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  std::vector<SimTK::MobilizedBody> bodies_;  ///< by the scene's numbers
  std::vector<Branch> branches_;
  std::vector<SimTK::Constraint> rows_;
  SimTK::State state_;
  std::map<std::pair<int, int>, double> angles_;  ///< by joint and coordinate, at the last place()
  int n_kept_ = 0;
  double least_pivot_ = 1.0, largest_left_ = 0.0, open_ = 0.0;
};

}  // namespace flexura::mbs::chance
