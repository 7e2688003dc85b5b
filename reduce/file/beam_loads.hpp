// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "reduce/beams/statics.hpp"
#include "reduce/file/names.hpp"

/// Loads of a beam part file: [load.NAME].
namespace flexura::reduce {

input::TableSchema load_schema();

/// Adds a load to its case.  Throws input::InputError.
void read_load(const std::string& name, const input::Section& in, const Names& nodes, const Names& members,
               std::vector<LoadCase>& cases);

}  // namespace flexura::reduce
