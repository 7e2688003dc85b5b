// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/text_file.hpp"

#include <fstream>
#include <stdexcept>
#include <system_error>

namespace flexura::superelement {

void write_whole(const std::filesystem::path& path, std::string_view content) {
  const std::filesystem::path beside = path.string() + ".part";
  std::error_code failure;
  {
    std::ofstream out(beside, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (out) std::filesystem::rename(beside, path, failure);
    if (out && !failure) return;
  }
  std::filesystem::remove(beside, failure);
  throw std::runtime_error(path.string() +
                           ": cannot be written; check the folder, its permissions and the disk");
}

}  // namespace flexura::superelement
