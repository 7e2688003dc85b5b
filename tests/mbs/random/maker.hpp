// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/random/scene/scene.hpp"

namespace flexura::mbs::chance {

/// A place in the plane of a linkage: from its origin, above it, and the turn about its normal.
struct InPlane {
  double x, y, height, turn;
};
struct Plane {
  Pose X_W;
  Pose at(const InPlane& place) const;
  /// With the z axis in the plane.
  Pose sideways(const InPlane& place) const;
};

/// A crank of a linkage: its length, its angle, and where its pin stands in the plane.
struct Crank {
  double length, angle;
  double x() const;
  double y() const;
};

/// Makes a scene of random numbers.  What has been added since draws from numbers of its own, so that mechanisms that were
/// known stay what they were: `second` from every third seed, `third` from every eighth, `fourth` from every twenty-fifth.
class Maker {
 public:
  explicit Maker(std::uint64_t seed);
  Scene make();

 private:
  // maker.cpp: parts
  int body(const Pose& X_WB);
  Pose pose(double size) { return {chance_.rotation(), chance_.vector(size)}; }
  /// A marker of `body` where X_W stands in the world.
  int marker_at(int b, const Pose& X_W) { return s_.add_marker(b, s_.bodies[b].X_WB.inverse() * X_W); }
  Pose joint_pose(const SceneJoint& joint);
  /// Joins two bodies that stand where they are.
  int join(const std::string& type, int from, const Pose& X_WF, int to, const Pose& X_WM);
  /// A new body on a joint of this type at a random place of `parent`.
  int grow(const std::string& type, int parent);
  void grow_tree(int n, bool is_grounded);
  void give_speeds(double probability);
  double start_of(int joint, int coordinate = 0) const;
  Law drive_law(int joint, int coordinate, double start);
  void drives(int n);

  // loops.cpp
  void tree();
  void spatial_loops();
  void close(std::string type, int A, int B);

  // linkages.cpp
  void planar();
  double height();
  double angle() { return chance_.between(-3, 3); }
  int link(const Plane& plane);
  int pin(const Plane& plane, int A, int B, double x, double y);
  int slider_crank(const Plane& plane, const Crank& crank);
  int four_bar(const Plane& plane, const Crank& crank);
  int parallelogram(const Plane& plane, const Crank& crank);
  int led_end(const Plane& plane, const Crank& crank);
  void misalign(const Plane& plane);
  void drive_both_cranks();
  void door();

  // gears.cpp: shafts[i] turns `ratio` times as fast as the first one
  struct Train {
    std::vector<int> shafts;
    std::vector<double> ratio;
    bool ends_in_rack = false;
    int n() const { return static_cast<int>(shafts.size()); }
    bool is_rack(int i) const { return ends_in_rack && i == n() - 1; }
  };
  void gears();
  int shaft(int carrier, const Pose& X_W, bool is_rack);
  void mesh(Train& train, int i, int k);
  void close_ring(const Train& train);
  void drive(const Train& train);

  // decorations.cpp
  void decorate();
  bool spring(SceneForce& f);
  bool joint_spring(SceneForce& f);
  bool load(SceneForce& f);

  // more_decorations.cpp, from second_
  void decorate_more();
  void add_wheel();
  void add_curve();
  Pose bushing(SceneForce& f, const Pose& X_W);
  Pose contact(SceneForce& f, const Pose& X_W);
  bool along_joint(SceneForce& f);

  // random_scene.cpp
  void choose_kind();
  void choose_start();
  bool is_held(int b) const;
  void round_markers();
  void guess();
  void make_flexible();
  void make_beams();
  void keep_a_joint_undriven();

  Chance chance_, second_, third_, fourth_;
  bool has_second_, has_third_, has_fourth_;
  Scene s_;
};

}  // namespace flexura::mbs::chance
