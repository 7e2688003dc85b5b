// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "mbs/superelement/superelement.hpp"

namespace flexura::superelement {

/// Parts of the file, each a group that is read only when asked for.
struct Parts {
  bool matrices = true;  ///< K_se, M_se, D_se, omega2
  bool inertia = true;
  bool stiffening = false;
  bool surface = false;
  bool shapes = false;
  bool stress = false;
  bool sections = false;  ///< section forces of beams
  bool mesh_error = false;
  bool nodes = false;  ///< motions of all nodes
};

/// Validates and writes beside, then renames: a file of this name is whole or not there.
/// Throws std::invalid_argument (what is wrong with se) or std::runtime_error (the file system).
void write(const std::filesystem::path& path, const Superelement& se);

/// Reads the header and the wanted parts.  Throws std::runtime_error with one sentence that names the file,
/// the dataset and the reason: not there, not a superelement, a newer version, cut short, checksum, shape,
/// NaN.
Superelement read(const std::filesystem::path& path, const Parts& parts = {});

}  // namespace flexura::superelement
