// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/terminal/command_line.hpp"

// What a command declares, for the pages that are made of it: completion script and manual page.
namespace flexura::terminal {

struct Entry {
  std::string names;  // "-o,--output", or the name of an argument
  std::string what;   // name of the value, "" for a flag
  std::string doc;
  std::vector<std::string> choices;
  std::string fallback;
  bool is_argument = false, is_required = false;
};

struct Description {
  std::vector<Entry> entries;
  std::vector<std::pair<std::string, std::string>> examples;
};

Description describe(const Command& command);

/// Scripts that complete commands, options and the values of choices.
std::string bash_completion(const Program& program);
std::string zsh_completion(const Program& program);
std::string fish_completion(const Program& program);

/// The manual page in roff, for man(1).
std::string manual_page(const Program& program);
/// The page of one of its commands: flexura-modes(1).
std::string manual_page(const Program& program, const Command& command);
/// One command's part of the page, under its full name.
std::string manual_section(const std::string& full_name, const Command& command);
/// Its options in one line, for completion.
std::string option_list(const Command& command);

}  // namespace flexura::terminal
