// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/commands.hpp"

namespace flexura::app {

std::vector<terminal::Command> all_commands() {
  return {
      // In the order of use.
      examples_command(), new_command(),       import_command(),   reduce_command(),   section_command(),
      modes_command(),    simulate_command(),  outputs_command(),  spectrum_command(), statics_command(),
      eigen_command(),    linearize_command(), study_command(),    view_command(),     check_command(),
      report_command(),   export_command(),    assemble_command(),
  };
}

}  // namespace flexura::app
