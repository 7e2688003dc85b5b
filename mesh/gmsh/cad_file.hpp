// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace flexura::mesh {

struct CadFile {
  std::string format;  ///< "step", "iges" or "brep", told from the content
  std::string unit;    ///< what its numbers are in: "mm", "inch", ...; empty where it does not say
};

/// Looks into a file before OpenCASCADE does.  Throws std::invalid_argument with one sentence for files that
/// are missing, empty, cut short or no CAD files at all.
CadFile inspect_cad_file(const std::filesystem::path& path);

/// Metres in a unit of length: "m", "mm", "cm", "um", "km", "inch" ("in"), "ft", "mil".  Throws
/// std::invalid_argument for any other name.
double metres_in(const std::string& unit);

}  // namespace flexura::mesh
