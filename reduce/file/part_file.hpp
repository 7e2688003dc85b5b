// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "reduce/part/part_input.hpp"

/// The part file: what `flexura reduce PART.toml` takes.  Its reference page is cases/PART_FILE.md, printed
/// from the schema below by `flexura reduce --schema`.
namespace flexura::reduce {

const input::TableSchema& part_schema();

/// kg in a mass unit of `geometry.mass_unit`.
double mass_unit(const std::string& name);

/// Reads and checks a part file.  Throws input::InputError.
PartInput read_part(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace flexura::reduce
