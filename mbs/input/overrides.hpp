// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <toml++/toml.h>

#include <map>
#include <memory>
#include <string>

// "key.path=value" from the command line or a run table, put into a TOML tree before it is checked.  Private
// to the sources of mbs/input.
namespace flexura::input {

// The text as written, by path: for text keys, where name=12 is the text "12".
using Overrides = std::map<std::string, std::string>;

// The value of "key=value" and of a default, under the key "value": TOML if it is TOML, else text, so that
// quotes may be left out.
std::shared_ptr<toml::table> parse_value(const std::string& text);

// Throws InputError.
void apply_override(toml::table& root, const std::string& text, Overrides& overrides);

}  // namespace flexura::input
