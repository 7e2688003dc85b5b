// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <string>

namespace flexura::input {

/// The tree of a TOML file, unchecked.  Throws InputError, with the line where there is one, for what is not there, no TOML file, larger
/// than 50 MB or nested too deep.  For this folder's own files: nobody else sees toml++.
toml::table read_toml(const std::filesystem::path& file);
/// The same of a text, called `name` in messages.
toml::table parse_toml(const std::string& text, const std::string& name);

}  // namespace flexura::input
