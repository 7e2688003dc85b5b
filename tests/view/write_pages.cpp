// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Writes the pages that the browser tests open:  view_write_pages DIRECTORY
#include <cstdio>
#include <filesystem>

#include "tests/view/synthetic.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: view_write_pages DIRECTORY\n");
    return 2;
  }
  using namespace flexura::view;
  const std::filesystem::path directory = argv[1];
  std::filesystem::create_directories(directory);
  const auto se = synthetic::tube(48, 60, 12);
  write_modes_page(directory / "modes.html", se, synthetic::tube_modes(se));
  Pictures pictures;
  const auto engine = synthetic::engine(pictures);
  MotionPage motion;
  motion.plots = {"slider.position", "crank.speed", "rod.deflection", "energy.kinetic, energy.strain"};
  write_motion_page(directory / "motion.html", engine, pictures, motion);
}
