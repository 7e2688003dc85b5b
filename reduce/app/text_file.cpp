// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/text_file.hpp"

#include <fstream>
#include <stdexcept>
#include <system_error>

namespace flexura::reduce {

void write_text(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::path beside = file;
  beside += ".part";
  std::ofstream out(beside);
  out << text;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(beside, file, error);
  if (out && !error) return;
  std::filesystem::remove(beside, error);
  throw std::runtime_error(file.string() +
                           " cannot be written: the folder does not allow it or its disk is full");
}

}  // namespace flexura::reduce
