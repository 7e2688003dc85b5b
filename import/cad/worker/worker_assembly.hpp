// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <TopoDS_Shape.hxx>
#include <vector>

#include "import/cad/job.hpp"

namespace flexura::import::cad {

/// The product structure of a STEP file: every leaf a part, every placement of it an instance.  Throws
/// std::runtime_error with what goes on after "FILE ".
void read_step(const AssemblyJob& job, AssemblyAnswer& answer);

/// Volume, faces, triangles and text of a shape in its own frame (OpenCASCADE's mm).
void describe_shape(const TopoDS_Shape& shape, double deflection, PartAnswer& part);

/// Pairs of placed shapes (OpenCASCADE's mm) whose common volume is thicker than `more_than` [m]: by its volume V and its surface A,
/// 2 V / A, which of a layer is the thickness.
std::vector<OverlapAnswer> find_overlaps(const std::vector<TopoDS_Shape>& shapes, double more_than);

/// "fraction<tab>stage" for the parent.
void say(double fraction, const char* stage);

}  // namespace flexura::import::cad
