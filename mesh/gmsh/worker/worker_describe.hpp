// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "mesh/gmsh/job.hpp"

// For the child process: what gmsh's model says of its entities, in m.
namespace flexura::mesh {

std::array<double, 3> as_array(const Eigen::Vector3d& v);

/// gmsh gives "Shapes/assembly/part"; the last word is the entity's own.
std::string label_of(int dimension, int tag);

SolidRecord describe_solid(int tag, double to_m);

/// The same part in the same place: volume, mass centre, inertia and box agree.
bool coincide(const SolidRecord& a, const SolidRecord& b);

/// Kind and dimensions of a face, recognised from samples of it.
FaceRecord describe_face(int tag, int solid, double to_m);

}  // namespace flexura::mesh
