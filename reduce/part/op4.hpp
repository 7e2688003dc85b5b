// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace flexura::reduce {

/// A matrix of Nastran's OUTPUT4, as its first record has it.
struct Op4Head {
  std::string name;
  std::int64_t rows = 0, columns = 0;
};

/// Whether the file's name ends with .op4.
bool is_op4(const std::filesystem::path& path);

/// Reads a real matrix of an OUTPUT4 file, binary (words of 4 or 8 bytes, of either order of bytes) or formatted, whole columns or
/// strings of what is not zero (BIGMAT or not).  Of several the one whose name begins with `letter` is taken (K, but not K4, M, B: KGG,
/// MAA, BGG); a single one may have any name.  Calls begin() once, then take(row, column, value) from 0.  Reference: MSC Nastran
/// DMAP Programmer's Guide, OUTPUT4.  Throws std::invalid_argument, with the file, for none, for several, for complex ones and
/// where the file contradicts itself or ends too early.
void read_op4(const std::filesystem::path& path, char letter,
              const std::function<void(const Op4Head&)>& begin,
              const std::function<void(std::int64_t row, std::int64_t column, double value)>& take);

}  // namespace flexura::reduce
