// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "beam/model/model.hpp"
#include "mbs/base/documents/document.hpp"
#include "reduce/file/names.hpp"

/// Materials and cross-sections of a beam part file.
namespace flexura::reduce {

input::TableSchema beam_material_schema();
input::TableSchema beam_section_schema();

beam::Material read_beam_material(const std::string& name, const input::Section& in);

/// Throws input::InputError where the section cannot be, with the place in the file.
beam::SectionEntry read_beam_section(const std::string& name, const input::Section& in,
                                     const std::vector<beam::Material>& materials,
                                     const Names& material_names);

}  // namespace flexura::reduce
