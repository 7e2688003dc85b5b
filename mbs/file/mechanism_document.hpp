// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"

namespace flexura::mbs {

/// The keys of a mechanism file alone, as read_mechanism() reads them: numbers may be formulas of its parameters, and
/// overrides of keys in a subsystem's file are left to it.  Nothing is built, no other file is read.  Throws InputError.
input::Section read_mechanism_document(const std::filesystem::path& file, const input::TableSchema& solver,
                                       const std::vector<std::string>& overrides);

/// A mechanism file that another one places as [subsystem.name].
struct PlacedFile {
  std::string name;
  std::filesystem::path file;
  std::vector<std::string>
      overrides;  ///< with which it is read: the parameters given to it, and keys of its own
};

/// Those that a document places by itself, in its order; `overrides` are those that it was read with.  None is read.  Throws InputError.
std::vector<PlacedFile> placed_files(const input::Section& root, const std::vector<std::string>& overrides);

}  // namespace flexura::mbs
