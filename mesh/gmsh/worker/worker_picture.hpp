// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/gmsh/job.hpp"

// For the child process: the faces of a part as triangles for a picture.
namespace flexura::mesh {

/// Triangles of result.faces and the edges between them (pairs of nodes, arrays.integers), in m.  A face that gmsh cannot
/// mesh has none, and result.messages says so.
Arrays collect_picture(const Job& job, ResultRecord& result);

}  // namespace flexura::mesh
