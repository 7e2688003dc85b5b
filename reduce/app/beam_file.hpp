// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "beam/model/mesh.hpp"
#include "mbs/input/document.hpp"
#include "mbs/input/schema.hpp"
#include "reduce/app/part_file.hpp"
#include "reduce/beams/beam_reduction.hpp"

/// The part file of a structure made of beams: nodes and members instead of a CAD file.  Reference page:
/// `flexura reduce --schema-beams`.
namespace flexura::reduce {

struct BeamPartInput {
  std::string name;
  std::string source;  ///< the file's text
  beam::Model model;
  beam::Subdivision subdivision;
  std::vector<BeamInterface> interfaces;
  ModesInput modes;
};

const input::TableSchema& beam_schema();

/// Whether the file has a table [member.NAME]: then it is a beam part.  False where it cannot be read.
bool is_beam_file(const std::filesystem::path& file);

/// Reads and checks a beam part.  Throws input::InputError.
BeamPartInput read_beam_part(const std::filesystem::path& file,
                             const std::vector<std::string>& overrides = {});

}  // namespace flexura::reduce
