// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "beam/model/model.hpp"
#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "reduce/file/names.hpp"

/// Members from the curves of a CAD file or gmsh model: [curves.NAME] of a beam part file.
namespace flexura::reduce {

input::TableSchema curves_schema();

/// Adds a member for each straight piece.  An end that lies at a node of the model (of the file, of a solid,
/// of curves read before) is that node; the others become nodes "NAME.1", "NAME.2", ...  Throws
/// input::InputError.
void read_curve_members(const std::string& name, const input::Section& in, const Names& sections,
                        bool run_scripts, beam::Model& model);

}  // namespace flexura::reduce
