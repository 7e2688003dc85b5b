// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/app/run_program.hpp"
#include "tests/mbs/superelement/box_beam.hpp"
#include "tests/setup/scratch_place.hpp"

/// The program `flexura` in a folder of its own, in which a superelement lies.
namespace flexura::testing {

class Flexura : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::flexura::test::scratch_place() / ("flexura_app_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    beam_ = (folder_ / "beam.se.h5").string();
    superelement::write(beam_, superelement::testing::make_box_beam());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static Outcome flexura(const std::string& arguments) {
    return run_program(FLEXURA_BIN_DIR "/flexura " + arguments);
  }

  std::filesystem::path folder_;
  std::string beam_;
};

}  // namespace flexura::testing
