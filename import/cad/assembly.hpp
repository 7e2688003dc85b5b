// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "import/model/mechanism.hpp"
#include "mesh/model/face.hpp"

/// A CAD assembly as its file has it: distinct parts, and where each of them stands how often. All in m and kg, angles in
/// rad; parts in their own frames.
namespace flexura::import::cad {

/// A face of a part: what it is (mesh::Face), and its triangles.
struct Face {
  mesh::Face shape;
  /// Of kind other, but carried along itself by the turns about axis and axis_point, or by a screw of this lead [m].
  bool is_turned = false;
  double lead = 0.0;
  std::vector<Eigen::Vector3i> triangles;  ///< indices of the part's surface vertices
};

struct Part {
  std::string name, color;  ///< as the file has them; "#rrggbb" or empty
  double density = 0.0;     ///< [kg/m^3]; 0 where the file gives none
  int solids = 0;
  double volume = 0.0;                  ///< [m^3]
  Vector3d center = Vector3d::Zero();   ///< of the volume
  Matrix3d moments = Matrix3d::Zero();  ///< of inertia of the volume about its centre, density 1 [m^5]
  std::vector<Face> faces;
  Surface surface;
  std::string brep;  ///< the exact shape as OpenCASCADE's text, in mm
};

struct Instance {
  int part = -1;
  std::string name, path;  ///< path: the names of the assemblies above it, "engine / crank unit"
  Pose X_WP;
};

struct Assembly {
  std::vector<Part> parts;
  std::vector<Instance> instances;
  std::vector<std::string> notes;  ///< sentences: what was left out, by which rule it was read
};

/// What two instances have in common, more than a contact.
struct Overlap {
  int a = -1, b = -1;
  double volume = 0.0, thickness = 0.0;  ///< [m^3]; [m], 2 V / A of what is common, A its surface
  Vector3d place = Vector3d::Zero();     ///< its centre, in the world
};

/// Instances of the file that overlap by more than `more_than` [m], by the exact shapes, in a second child process. Throws
/// std::runtime_error where that fails or takes longer than the limit: the assembly is as good without.
std::vector<Overlap> find_overlaps(const std::filesystem::path& file, const Assembly& assembly,
                                   double more_than, double time_limit_s);

/// Reads a STEP file in a child process, flexura-assembly beside this program. Throws std::invalid_argument (the
/// file: one sentence) or std::runtime_error (the child's program is missing).
Assembly read_assembly(const std::filesystem::path& file, double time_limit_s);

}  // namespace flexura::import::cad
