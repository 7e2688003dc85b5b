// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/plain_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/files/table_text.hpp"
#include "mbs/base/terminal/terminal.hpp"

namespace flexura::files {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(PlainText, ShowsWhatATerminalObeys) {
  EXPECT_EQ(plain_text("\033[2J\033]0;x\007"), "\\x1b[2J\\x1b]0;x\\x07");
  EXPECT_EQ(plain_text("\u009b31m \u202Eevil"), "\\u009b31m \\u202eevil");
  EXPECT_EQ(plain_text("a\x9b"
                       "b\xC3"),
            "a\\x9b"
            "b\\xc3");  // no UTF-8
  EXPECT_EQ(plain_text("\x7f\U000E0041"), "\\u007f\\udb40\\udc41");
  EXPECT_EQ(plain_text("one\ntwo\r\n\tthree"), "one two   three");
}

TEST(PlainText, LeavesLettersOfAllScriptsAlone) {
  for (const char* text : {"Größe µ · ²", "звено", "连杆", "👩\u200D🔧", "نظام", "e\u0301", ""}) {
    EXPECT_TRUE(is_plain_text(text)) << text;
    EXPECT_EQ(plain_text(text), text);
  }
}

// A byte that begins nothing, a character cut short, an overlong one, a surrogate, one beyond the last.
TEST(PlainText, TakesBytesThatAreNoUtf8OneByOne) {
  EXPECT_EQ(plain_text("\x80"
                       "a"),
            "\\x80"
            "a");
  EXPECT_EQ(plain_text("\xE2\x82"), "\\xe2\\x82");
  EXPECT_EQ(plain_text("\xC0\x9B"), "\\xc0\\x9b");
  EXPECT_EQ(plain_text("\xED\xA0\x80"), "\\xed\\xa0\\x80");
  EXPECT_EQ(plain_text("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");
}

TEST(PlainText, OfMessagesIsOneLine) {
  EXPECT_EQ(input::shown_message("a\nb"), "a\\nb");
  EXPECT_EQ(input::shown_text("a\tb\u009b"), "a b\\u009b");
}

// Colour is put around a text; the text brings none of its own.
TEST(PlainText, IsAllThatTablesAndBoldLettersHold) {
  terminal::Table table({{"name", terminal::Align::left}, {"value"}});
  table.add_row({"\033[1mx\u202E\ny", "1"});
  EXPECT_THAT(table.text(80, true), HasSubstr("\\x1b[1mx\\u202e y      1\n"));
  EXPECT_EQ(terminal::bold("\033[0mx", true), "\033[1m\\x1b[0mx\033[0m");
}

TEST(TableText, IsNoFormulaNoHtmlAndNoCellOfItsOwn) {
  EXPECT_EQ(csv_field("=cmd|' /C calc'!A0"), "'=cmd|' /C calc'!A0");
  EXPECT_EQ(csv_field("@a,b"), "\"'@a,b\"");
  EXPECT_EQ(csv_field("say \"x\""), "\"say \"\"x\"\"\"");
  EXPECT_EQ(csv_field("a.b [m]"), "a.b [m]");
  EXPECT_EQ(markdown_text("a | <b>&[c](d)\n`e`"), "a \\| \\<b\\>\\&\\[c\\](d) \\`e\\`");
}

}  // namespace
}  // namespace flexura::files
