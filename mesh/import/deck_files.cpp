// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/deck_files.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "mbs/base/files/inputs.hpp"
#include "mesh/import/builder.hpp"

namespace flexura::mesh {

std::ifstream DeckFiles::open(const std::filesystem::path& path, int depth) {
  constexpr int most_files = 1000, deepest = 10;
  constexpr std::uintmax_t most_again = 1'000'000'000;
  require_file(path);
  files::note_input(path);
  std::ifstream file(path);
  if (!file) throw std::invalid_argument(path.string() + ": no such file, or it cannot be read");
  if (++n_files_ > most_files)
    throw std::invalid_argument(
        fmt::format("{}: {} reads more than {} files; files that include one another?", path.string(),
                    keyword_, most_files));
  if (depth > deepest)
    throw std::invalid_argument(fmt::format("{}: {} goes deeper than {} files; a file that includes itself?",
                                            path.string(), keyword_, deepest));
  if (std::error_code none; names_.contains(path.string()))
    if (const std::uintmax_t size = std::filesystem::file_size(path, none); !none) bytes_read_again_ += size;
  if (bytes_read_again_ > most_again)
    throw std::invalid_argument(
        fmt::format("{}: {} reads the same files again and again, more than {} bytes of them; is that meant?",
                    path.string(), keyword_, most_again));
  return file;
}

}  // namespace flexura::mesh
