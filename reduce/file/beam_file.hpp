// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "reduce/part/beam_part_input.hpp"

/// The part file of a structure made of beams.  Reference page: cases/BEAM_FILE.md, printed by `flexura reduce
/// --schema-beams`.
namespace flexura::reduce {

const input::TableSchema& beam_schema();

/// Whether the file has a table [member.NAME] or [curves.NAME]: then it is a beam part.  False where it
/// cannot be read.
bool is_beam_file(const std::filesystem::path& file);

/// Reads and checks a beam part; `attach` is asked for each solid, `run_scripts` takes curves of .geo files.  Throws
/// input::InputError.
BeamPartInput read_beam_part(const std::filesystem::path& file,
                             const std::vector<std::string>& overrides = {}, const AttachSolid& attach = {},
                             bool run_scripts = false);

}  // namespace flexura::reduce
