// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/commands.hpp"

int main(int argc, char** argv) {
  using namespace flexura;
  // The heavy side reads its own command line, --help included.
  const std::string command = argc > 1 ? argv[1] : "";
  if (command == "reduce" || command == "import")
    return terminal::guarded([&]() -> int { app::hand_over("flexura-" + command, {argv + 2, argv + argc}); });
  if (command == "section")
    return terminal::guarded([&]() -> int { app::hand_over("flexura-reduce", {argv + 1, argv + argc}); });
  const terminal::Program program{
      .name = "flexura",
      .version = FLEXURA_VERSION,
      .summary = "Flexible bodies from CAD in multibody simulation.",
      .commands = app::all_commands(),
      .examples = {{"flexura reduce conrod.toml -o conrod.se.h5", "make a superelement of a CAD part"},
                   {"flexura modes conrod.se.h5", "list its modes"},
                   {"flexura simulate engine.toml -o engine.h5", "simulate a mechanism with it"},
                   {"flexura view engine.h5 -o engine.html", "write a page that shows it move"}},
      .details = app::version_details};
  return terminal::run(program, argc, argv);
}
