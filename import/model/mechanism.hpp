// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// A mechanism as an import has understood it, before it is written as a mechanism file.
///
/// All in SI. X_WB is the pose of a body's frame B in the world, X_BM that of a marker in its body.
namespace flexura::import {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A rigid motion: x_A = R x_B + p.
struct Pose {
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();

  Pose operator*(const Pose& b) const { return {R * b.R, R * b.p + p}; }
  Vector3d operator*(const Vector3d& x) const { return R * x + p; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

struct Marker {
  std::string name;
  Pose X_BM;
  std::string on = {};  ///< interface of the body's superelement that carries it where the body deforms
};

/// Triangles for pictures, counter-clockwise from outside.
struct Surface {
  std::vector<Vector3d> vertices;               ///< [m], frame B
  std::vector<Eigen::Vector3i> triangles;       ///< indices of vertices
  std::vector<std::pair<int, int>> edges = {};  ///< feature edges to be drawn

  bool empty() const { return triangles.empty(); }
  void append(const Surface& other, const Pose& X);
};
/// Of a box about the origin with half edges h [m] along its axes.
Surface box_surface(const Vector3d& h);

/// "key = value" with the value as TOML writes it.
using Line = std::pair<std::string, std::string>;

struct Body {
  std::string name;
  std::vector<std::string> comments = {};  ///< lines above its table: what it was called, its colour, ...
  double mass = 0.0;
  Vector3d center = Vector3d::Zero();   ///< of mass, frame B
  Matrix3d inertia = Matrix3d::Zero();  ///< about the centre of mass, axes of B
  std::vector<Marker> markers = {};
  Surface surface = {};                        ///< drawn by a rigid superelement where there is any
  std::vector<std::vector<Line>> shapes = {};  ///< simple solids of the mechanism file
  Pose X_WB = {};
  /// Places of the superelement that become interfaces where the part is reduced; rigid it carries markers there.
  std::vector<std::pair<std::string, Vector3d>> interfaces = {};
  std::vector<int> triangle_interface =
      {};  ///< of each triangle of the surface, -1: none; empty: all of them
  std::string part =
      {};  ///< bodies of one part share its superelement, "parts/PART.se.h5"; empty: of its own

  const std::string& file() const { return part.empty() ? name : part; }
};

/// A joint, constraint, force element or input.
struct Element {
  std::string table, name;  ///< [TABLE.NAME]
  std::vector<std::string> comments = {};
  std::vector<Line> lines = {};
};

struct Mechanism {
  std::string name;
  std::vector<std::string> comments = {};  ///< at the head of the file
  std::vector<Line> head = {};             ///< behind the name: gravity
  std::vector<Body> bodies = {};
  std::vector<Marker> ground = {};
  std::vector<std::vector<Line>> ground_shapes = {};
  std::vector<Element> elements = {};
  std::vector<Line> solver = {};        ///< of the table [solver]
  std::vector<std::string> notes = {};  ///< sentences for the user: what was not taken over, what is doubtful
  std::vector<std::pair<std::string, std::string>> renamed = {};  ///< what the file calls it, its name here
  std::string note_count = {};  ///< how many there are of each kind, for the end of what is printed
};

/// Names for bodies, joints and the like out of names that may hold anything: ASCII letters, digits and "_"
/// stay, every run of others becomes one "_", at most 60 of them; a digit in front, an empty name and a name
/// that is taken (or means something to formulas and results) get something added.  The same names in the same order
/// give the same result.
class Names {
 public:
  std::string add(const std::string& wanted);

 private:
  std::map<std::string, int> taken_;  ///< names, and the number that was tried last behind each
};

/// A text of a foreign file as it may stand in a comment or on a terminal: one line, no control
/// characters, at most 120 bytes.
std::string shown(const std::string& text);

/// As TOML: shortest digits that read back as the same double; throws std::invalid_argument where not finite.
std::string toml(double value);
std::string toml(const Vector3d& v);
std::string toml(const std::string& text);

/// "position" and "quaternion", as far as they differ from the identity.
std::vector<Line> pose_lines(const Pose& X);

/// The file's text.  Bodies with a surface refer to "parts/NAME.se.h5".
std::string mechanism_text(const Mechanism& mechanism);

}  // namespace flexura::import
