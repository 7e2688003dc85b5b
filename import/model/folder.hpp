// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "import/model/mechanism.hpp"
#include "mbs/superelement/superelement.hpp"

namespace flexura::import {

/// The body as a superelement of six rigid coordinates: one interface "origin" at Bo, those of the body without
/// coordinates of their own, no stiffness, the exact inertia integrals, the surface for pictures.  Throws std::invalid_argument where the mass is not positive.
superelement::Superelement rigid_superelement(const Body& body, const std::string& source);

/// ".step" of "part.STEP": in small letters of ASCII, whatever the locale.
std::string ending_of(const std::filesystem::path& file);

/// A text file beside the mechanism: a part file, a CAD file.
struct TextFile {
  std::filesystem::path name;  ///< below the folder, "parts/crank.toml"
  std::string text;
};

/// Writes FOLDER/mechanism.toml, the texts and FOLDER/parts/NAME.se.h5 of every body with a surface, the mechanism last.
/// The folder and its "parts" are made where they are not there.  Throws std::invalid_argument, before
/// anything is written, where one of the files, or of those that are written `later`, is there already (unless `force`),
/// the folder is a file or "parts" is a link that leads elsewhere.
void write_folder(const std::filesystem::path& folder, const Mechanism& mechanism,
                  const std::vector<TextFile>& texts, bool force,
                  const std::vector<std::filesystem::path>& later = {});

}  // namespace flexura::import
