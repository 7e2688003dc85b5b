// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "mbs/base/terminal/command_line.hpp"

/// The commands of `flexura`, one .cpp for each.  To add one: write its file, name its function here and in
/// the list of commands.cpp.
namespace flexura::app {

terminal::Command assemble_command();
terminal::Command check_command();
terminal::Command eigen_command();
terminal::Command examples_command();
terminal::Command export_command();
terminal::Command import_command();
terminal::Command linearize_command();
terminal::Command modes_command();
terminal::Command new_command();
terminal::Command outputs_command();
terminal::Command spectrum_command();
terminal::Command reduce_command();
terminal::Command report_command();
terminal::Command section_command();
terminal::Command simulate_command();
terminal::Command statics_command();
terminal::Command study_command();
terminal::Command view_command();

std::vector<terminal::Command> all_commands();

/// Lines below the version: compiler, libraries with their versions, what is there and what is missing.
std::string version_details();

/// The folder of the running program: its companions lie beside it.
std::filesystem::path program_folder();

/// Replaces this process by the companion of this name (flexura-reduce, flexura-import) with these arguments,
/// which lies beside this program.  Returns only by throwing std::runtime_error when it is not there.
[[noreturn]] void hand_over(const std::string& companion, const std::vector<std::string>& arguments);

}  // namespace flexura::app
