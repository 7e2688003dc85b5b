// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/maker.hpp"

/// Planar linkages, and doors on many hinges.
namespace flexura::mbs::chance {

namespace {

Matrix3d about_z(double angle) {
  return rotation_exp({0.0, 0.0, angle});
}
const Matrix3d& quarter_about_x() {
  static const Matrix3d R = rotation_exp({0.5 * std::numbers::pi, 0, 0});
  return R;
}
const Matrix3d& quarter_about_y() {
  static const Matrix3d R = rotation_exp({0, 0.5 * std::numbers::pi, 0});
  return R;
}

}  // namespace

Pose Plane::at(const InPlane& p) const {
  return X_W * Pose{about_z(p.turn), {p.x, p.y, p.height}};
}
Pose Plane::sideways(const InPlane& p) const {
  return X_W * Pose{about_z(p.turn) * quarter_about_y(), {p.x, p.y, p.height}};
}
double Crank::x() const {
  return length * std::cos(angle);
}
double Crank::y() const {
  return length * std::sin(angle);
}

double Maker::height() {
  return chance_.flip(0.5) ? 0.0 : chance_.between(-0.1, 0.1);
}

// A body of the linkage, its frame anywhere.
int Maker::link(const Plane& plane) {
  return body(plane.at({chance_.between(-0.5, 0.5), chance_.between(-0.5, 0.5), height(), angle()}));
}

int Maker::pin(const Plane& plane, int A, int B, double x, double y) {
  const Pose X = plane.at({x, y, height(), angle()});
  return join("revolute", A, X, B, X * Pose{about_z(angle()), Vector3d::Zero()});
}

// Bodies that move in one plane, on joints whose axes stand across it.
void Maker::planar() {
  s_.what = "planar linkage";
  const Plane plane{
      {chance_.flip(0.5) ? Matrix3d(Matrix3d::Identity()) : chance_.rotation(), chance_.vector(1.0)}};
  const int kind = chance_.below(4);
  const Crank crank{chance_.between(0.1, 0.3), chance_.between(0.3, 2.6)};
  const int closing = kind == 0   ? slider_crank(plane, crank)
                      : kind == 1 ? four_bar(plane, crank)
                      : kind == 2 ? parallelogram(plane, crank)
                                  : led_end(plane, crank);
  if (closing >= 0) s_.joints[closing].closes = true;
  if (chance_.flip(0.12))
    misalign(plane);
  else if (chance_.flip(0.3))
    s_.digits = 9 + chance_.below(6);
  if (chance_.flip(0.5)) give_speeds(0.15);
  drives(chance_.below(3));
  if (kind == 2 && s_.joints[0].drives.empty() && chance_.flip(0.5)) drive_both_cranks();
}

// Each of these returns the joint that closes its loop, or -1.
int Maker::slider_crank(const Plane& plane, const Crank& crank) {
  s_.what += ", slider-crank";
  const int arm = link(plane), rod = link(plane), slider = link(plane);
  const struct { double x, offset; } end{crank.x() + chance_.between(0.5, 0.8), chance_.between(-0.05, 0.05)};
  pin(plane, 0, arm, 0, 0);
  pin(plane, arm, rod, crank.x(), crank.y());
  const int wrist = pin(plane, rod, slider, end.x, end.offset);
  const Pose guide = plane.sideways({chance_.between(-0.2, 0.2), chance_.between(-0.1, 0.1), height(), 0.0});
  Pose on_slider = guide;
  on_slider.p += chance_.between(-0.3, 0.3) * guide.R.col(2);
  const int slides = join("prismatic", 0, guide, slider, on_slider);
  if (!chance_.flip(0.5)) return slides;
  std::swap(s_.joints[wrist], s_.joints[slides]);
  return wrist + 1;
}

int Maker::four_bar(const Plane& plane, const Crank& crank) {
  s_.what += ", four-bar";
  const int arm = link(plane), rod = link(plane), rocker = link(plane);
  const struct {
    double ground, up, lean;
  } size{chance_.between(0.4, 0.6), chance_.between(0.3, 0.5), chance_.between(-0.1, 0.2)};
  pin(plane, 0, arm, 0, 0);
  pin(plane, arm, rod, crank.x(), crank.y());
  pin(plane, rod, rocker, size.ground + size.lean, size.up);
  return pin(plane, rocker, 0, size.ground, 0);
}

// At times with a third crank, which may not be parallel.
int Maker::parallelogram(const Plane& plane, const Crank& crank) {
  s_.what += ", parallelogram";
  const int arm = link(plane), rod = link(plane);
  const int cranks = 2 + chance_.below(2);
  pin(plane, 0, arm, 0, 0);
  pin(plane, arm, rod, crank.x(), crank.y());
  int closing = -1;
  for (int i = 1; i < cranks; ++i) {
    const int other = link(plane);
    const double along = 0.4 * i, aside = chance_.flip(0.7) ? 0.0 : chance_.between(-0.1, 0.1);
    pin(plane, 0, other, along, aside);
    closing = pin(plane, other, rod, crank.x() + along, crank.y() + aside);
    s_.joints[closing].closes = true;
  }
  return closing;
}

// A double pendulum whose end is led.
int Maker::led_end(const Plane& plane, const Crank& crank) {
  s_.what += ", led end";
  const int arm = link(plane), rod = link(plane);
  pin(plane, 0, arm, 0, 0);
  pin(plane, arm, rod, crank.x(), crank.y());
  const Pose end = plane.at({crank.x() + 0.3, crank.y() + chance_.between(-0.2, 0.2), height(), 0.0});
  const char* const types[] = {"distance", "point_on_plane", "point_on_line", "parallel", "planar"};
  const std::string type = chance_.one_of(types);
  if (type == "planar")
    return join("planar", 0, plane.at({0.1, 0.1, 0.0, 0.3}), rod, plane.at({0.2, -0.1, 0.0, 1.0}));
  SceneConstraint c;
  c.type = type;
  Pose X_F = end;
  if (type == "distance") {
    X_F.p += plane.X_W.R * Vector3d(0.4, -0.3, 0.0);
    c.length = 0.5;
  } else if (type == "point_on_plane" || type == "point_on_line") {
    // Its z axis lies in the plane.
    X_F.R = rotation_exp(chance_.between(-1, 1) * plane.X_W.R.col(2)) * plane.X_W.R * quarter_about_x();
  }
  c.F = marker_at(0, X_F);
  c.M = marker_at(rod, end);
  s_.constraints.push_back(c);
  return -1;
}

// One hinge out of line: closed as it stands, and stuck.
void Maker::misalign(const Plane& plane) {
  const int j = chance_.below(static_cast<int>(s_.joints.size()));
  const double tilts[] = {0.2, 0.02, 1e-3};
  s_.what += ", misaligned";
  const Matrix3d tilt = rotation_exp(chance_.one_of(tilts) * (plane.X_W.R * Vector3d(0.6, 0.8, 0.0)));
  for (const int m : {s_.joints[j].F, s_.joints[j].M}) {
    const Matrix3d& R_WB = s_.bodies[s_.markers[m].body].X_WB.R;
    s_.markers[m].X_BP.R = R_WB.transpose() * tilt * R_WB * s_.markers[m].X_BP.R;
  }
}

// Alike or not.
void Maker::drive_both_cranks() {
  const Law law = drive_law(0, 0, 0.0);
  const bool agrees = chance_.flip(0.6);
  s_.what += agrees ? ", two motors that agree" : ", two motors that do not";
  for (const int j : {0, 2}) {
    s_.joints[j].speeds.clear();
    s_.joints[j].drives.clear();
    Law own = law;
    own.a = start_of(j) - law.c * std::sin(law.phi);
    if (j == 2 && !agrees) own.b += 0.5;
    s_.joints[j].drives = {{0, own, 0}};
  }
}

// Two bodies on several joints that allow the same motion.
void Maker::door() {
  s_.what = "door";
  const bool slides = chance_.flip(0.4);
  const int first = chance_.flip(0.4) ? grow("revolute", 0) : 0;
  const Pose axis = {chance_.rotation(), chance_.vector(1.0)};
  const int leaf = body(axis * pose(0.5));
  const int n = 2 + chance_.below(3);
  const char* const turning[] = {"revolute",  "revolute",      "cylindrical",
                                 "spherical", "point_on_line", "parallel"};
  const char* const sliding[] = {"prismatic",   "prismatic", "cylindrical",
                                 "orientation", "parallel",  "planar"};
  for (int i = 0; i < n; ++i) {
    const std::string type = i == 0 ? (slides ? "prismatic" : "revolute")
                                    : (slides ? chance_.one_of(sliding) : chance_.one_of(turning));
    Pose X = axis * Pose{about_z(angle()), {0, 0, i * chance_.between(0.3, 0.6)}};
    if (slides) X.p += axis.R * Vector3d{chance_.between(-0.3, 0.3), chance_.between(-0.3, 0.3), 0.0};
    if (type == "planar") X.R = axis.R * quarter_about_y();
    Pose on_leaf = X;
    if (slides && type != "planar") on_leaf.p += chance_.between(-0.1, 0.1) * axis.R.col(2);
    if (!slides && type == "revolute") on_leaf.R = X.R * about_z(angle());
    const int j = join(type, first, X, leaf, on_leaf);
    if (i > 0) s_.joints[j].closes = true;
    if (i > 0) s_.joints[j].is_connection = chance_.flip(0.3);
  }
  s_.digits = chance_.flip(0.5) ? 17 : 9 + chance_.below(7);
  if (chance_.flip(0.5)) give_speeds(0.5);
  if (chance_.flip(0.3)) drives(1);
}

}  // namespace flexura::mbs::chance
