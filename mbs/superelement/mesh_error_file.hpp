// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/hdf5/file.hpp"
#include "mbs/superelement/superelement.hpp"

/// The group `mesh_error` of the file (FORMAT.md); for file.cpp.
namespace flexura::superelement {

void write_mesh_error(hdf5::Group root, const MeshError& error);
/// Leaves se.mesh_error empty where the file has none.
void read_mesh_error(const hdf5::Group& root, Superelement& se);

}  // namespace flexura::superelement
