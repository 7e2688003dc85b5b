// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace flexura::reduce {

/// An entry of a DMIG matrix; component 1 to 6 of a grid, 0 of a scalar point.
struct DmigEntry {
  std::array<std::int64_t, 2> point;  ///< row, column
  std::array<int, 2> component;
  double value;
  int line;
};

/// Whether the file is bulk data of Nastran: its first line that is no comment begins with a letter.
bool is_nastran_text(const std::filesystem::path& path);

/// Calls with each entry of a real DMIG matrix in bulk data or a punch file (PCH), in free, small (columns of 8) or large field
/// (DMIG*, columns of 16), gzipped or not; other cards are passed over.  Form 6 (symmetric) gives one triangle, form 1 all.
/// Of several matrices in the file the one is taken whose name begins with `letter` (K, but not K4, M, B: KAAX, M2GG, BFLEX); a
/// single one may have any name.  Reference: MSC Nastran Quick Reference Guide, bulk data entry DMIG.
/// Throws std::invalid_argument, with file and line, for none, for several, for complex and for rectangular ones.
void read_dmig(const std::filesystem::path& path, char letter,
               const std::function<void(const DmigEntry&)>& take);

}  // namespace flexura::reduce
