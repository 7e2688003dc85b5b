// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/text_file.hpp"

#include "mbs/base/files/output.hpp"

namespace flexura::superelement {

void write_whole(const std::filesystem::path& path, std::string_view content) {
  files::write_whole(path, content);
}

}  // namespace flexura::superelement
