// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

namespace flexura::mesh {

/// The corners of the triangles of an STL file, nine numbers each: a binary one, whose length agrees with its count, or text.
/// Throws std::runtime_error for what is neither, and for more than `most` triangles.
std::vector<double> read_stl(const std::string& path, std::size_t most);

}  // namespace flexura::mesh
