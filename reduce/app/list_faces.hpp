// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <iosfwd>

namespace flexura::reduce {

/// `flexura reduce --list-faces`: the solids and faces of a CAD file, or of the file a part file names, as a
/// table with an interface table ready to copy.
void print_faces(const std::filesystem::path& file, std::ostream& out);

/// The same as a page: the part with numbers on its faces, and the [interface] tables of those that are ticked there. Throws
/// std::invalid_argument for sheets, of which no picture is made.
void write_faces_page(const std::filesystem::path& file, const std::filesystem::path& html);

}  // namespace flexura::reduce
