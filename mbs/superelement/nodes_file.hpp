// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/hdf5/file.hpp"
#include "mbs/superelement/superelement.hpp"

/// The group `nodes` of the file (FORMAT.md); for file.cpp.
namespace flexura::superelement {

void write_nodes(hdf5::Group root, const NodalMotions& nodes);
/// Leaves se.nodes empty where the file has none.
void read_nodes(const hdf5::Group& root, Superelement& se);

}  // namespace flexura::superelement
