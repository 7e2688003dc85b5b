// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/app/stage_lines.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

namespace flexura::reduce {
namespace {

// What is printed while a stage goes on for `seconds`, one after the other, called every second.
std::string printed(bool quiet, bool is_terminal, const std::vector<std::pair<std::string, int>>& stages) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), std::fclose);
  double now = 0.0;
  StageLines lines(file.get(), quiet, is_terminal, [&] { return now; });
  for (const auto& [stage, seconds] : stages)
    for (int k = 0; k < seconds; ++k, now += 1.0) lines(stage, static_cast<double>(k) / seconds);
  lines.finish();
  std::rewind(file.get());
  std::string text(1000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  return text;
}

TEST(StageLines, SayWhatLastsTenSecondsAndAgainAtTwiceItsAge) {
  EXPECT_EQ(printed(false, false, {{"edges", 9}, {"faces", 25}, {"volume", 5}}),
            "faces: 10 s, 40 % done\nfaces: 20 s, 80 % done\nfaces: 25 s, done\n");
}

TEST(StageLines, SayNothingOnATerminalOrWhenQuiet) {
  EXPECT_EQ(printed(true, false, {{"faces", 25}}), "");
  EXPECT_EQ(printed(false, true, {{"faces", 25}}), "");
}

}  // namespace
}  // namespace flexura::reduce
