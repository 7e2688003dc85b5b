// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/terminal/terminal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>

namespace flexura::terminal {
namespace {

using ::testing::HasSubstr;

TEST(Terminal, NumbersAndTimesAreShort) {
  EXPECT_EQ(number(1234.5678), "1234.6");
  EXPECT_EQ(number(-0.0), "0");
  EXPECT_EQ(number(2.1e11, 3), "2.1e+11");
  EXPECT_EQ(duration(0.42), "0.4 s");
  EXPECT_EQ(duration(9.99), "10 s");
  EXPECT_EQ(duration(185), "3 min 05 s");
  EXPECT_EQ(duration(7805), "2 h 10 min");
  EXPECT_EQ(bytes(812), "812 B");
  EXPECT_EQ(bytes(3.14e6), "3.14 MB");
  EXPECT_EQ(bytes(999600), "1 MB");
}

TEST(Terminal, TablesFitAndNumbersStayWhole) {
  Table table({{"mode", Align::right}, {"kind", Align::left}, {"frequency [Hz]", Align::right}});
  table.add_row({"1", "Biegung in z, sehr ausführlich beschrieben", "123.456"});
  table.add_row({"12", "µ", "7"});
  EXPECT_EQ(table.text(),
            "mode  kind                                        frequency [Hz]\n"
            "----------------------------------------------------------------\n"
            "   1  Biegung in z, sehr ausführlich beschrieben         123.456\n"
            "  12  µ                                                        7\n");
  EXPECT_EQ(table.text(40),
            "mode  kind                frequency [Hz]\n"
            "----------------------------------------\n"
            "   1  Biegung in z, seh…         123.456\n"
            "  12  µ                                7\n");
  EXPECT_THAT(table.text(80, true), HasSubstr("\033[1mmode"));
}

TEST(Terminal, TablesTooWideForTheTerminalAreContinuedBelow) {
  Table table({{"run", Align::left}, {"time [s]"}, {"error [J]"}, {"drift"}}, 1);
  table.add_row({"rigid", "0.5", "1.25e-12", "3e-16"});
  table.add_row({"flexible", "0.5", "-2.5e-07", "1e-11"});
  EXPECT_EQ(table.text(30),
            "run       time [s]  error [J]\n"
            "-----------------------------\n"
            "rigid          0.5   1.25e-12\n"
            "flexible       0.5   -2.5e-07\n"
            "\n"
            "run       drift\n"
            "---------------\n"
            "rigid     3e-16\n"
            "flexible  1e-11\n");

  // A name is shortened to a third of the width, and not to an ending or two.
  Table named({{"", Align::left}, {"rigid"}, {"flexible"}});
  named.add_row({"crosshead_pin.angle", "-0.2527 .. 0.2527", "0 .. 1"});
  EXPECT_EQ(named.text(36),
            "                          rigid\n"
            "-------------------------------\n"
            "crosshead_p…  -0.2527 .. 0.2527\n"
            "\n"
            "              flexible\n"
            "----------------------\n"
            "crosshead_p…    0 .. 1\n");
}

// Runs a progress line against a clock of our own and returns what it printed.
template <typename Use>
std::string printed(bool quiet, bool is_terminal, Use&& use, bool verbose = false) {
  char* buffer = nullptr;
  std::size_t size = 0;
  std::FILE* stream = ::open_memstream(&buffer, &size);
  double now = 0.0;
  {
    Progress progress(
        stream, quiet, is_terminal, [&now] { return now; }, verbose);
    use(progress, now);
  }
  std::fclose(stream);
  const std::unique_ptr<char, void (*)(void*)> owner(buffer, std::free);
  return std::string(buffer, size);
}

TEST(Terminal, ProgressSaysHowFarAndHowLong) {
  const auto work = [](Progress& progress, double& now) {
    progress("meshing", 0.0);
    now = 12.0;
    progress("meshing", 0.48);
    now = 12.05;
    progress("meshing", 0.49);  // too soon to draw again
    now = 25.0;
    progress("solving", -1.0);
    progress.finish();
  };
  const std::string line = printed(false, true, work);
  EXPECT_THAT(line, HasSubstr("meshing  [############            ]  48 %  12 s, 13 s left"));
  EXPECT_THAT(line, ::testing::Not(HasSubstr("49 %")));
  EXPECT_THAT(line, HasSubstr("meshing: 25 s\n"));
  EXPECT_EQ(printed(false, false, work), "") << "quiet where no terminal is";
  EXPECT_EQ(printed(true, true, work), "");
  EXPECT_EQ(printed(false, false, work, true), "meshing: 25 s\nsolving: 0.0 s\n");
}

TEST(Terminal, PipesGetNoColour) {
  std::FILE* file = std::tmpfile();
  EXPECT_FALSE(takes_colour(file));
  ::setenv("COLUMNS", "100", 1);
  EXPECT_EQ(width(file), 100);
  ::unsetenv("COLUMNS");
  EXPECT_EQ(width(file), 80);
  std::fclose(file);
}

}  // namespace
}  // namespace flexura::terminal
