// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/cad/job.hpp"

class TopoDS_Shape;

namespace flexura::import::cad {

/// The product structure of a STEP file: every leaf a part, every placement of it an instance.  Throws
/// std::runtime_error with what goes on after "FILE ".
void read_step(const AssemblyJob& job, AssemblyAnswer& answer);

/// Volume, faces, triangles and text of a shape in its own frame (OpenCASCADE's mm).
void describe_shape(const TopoDS_Shape& shape, double deflection, PartAnswer& part);

/// "fraction<tab>stage" for the parent.
void say(double fraction, const char* stage);

}  // namespace flexura::import::cad
