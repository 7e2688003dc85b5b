// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/html/resources.hpp"

#include <stdexcept>

// The assembler copies the files in: no generated source, no megabyte of hexadecimal for the compiler.
// clang-format off
#define FLEXURA_EMBED(symbol, file)                \
  __asm__(".section .rodata\n"                     \
          ".global " #symbol "_begin\n"            \
          ".global " #symbol "_end\n"              \
          #symbol "_begin:\n"                      \
          ".incbin \"" file "\"\n"                 \
          #symbol "_end:\n"                        \
          ".byte 0\n"                              \
          ".previous\n");                          \
  extern "C" const char symbol##_begin[];          \
  extern "C" const char symbol##_end[];
// clang-format on

FLEXURA_EMBED(flexura_page_js, FLEXURA_BUNDLE "/page.js")
FLEXURA_EMBED(flexura_page_css, FLEXURA_BUNDLE "/page.css")
FLEXURA_EMBED(flexura_report_js, FLEXURA_BUNDLE "/report.js")
FLEXURA_EMBED(flexura_report_css, FLEXURA_BUNDLE "/report.css")

namespace flexura::view {

namespace {

std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

bool has_pages() {
  return !page_script().empty() && !report_script().empty();
}

const char* const kNoPages =
    "no; Node and npm (Debian: nodejs, npm) or their registry were missing when it was built: build again "
    "with them";

void require_pages() {
  if (!has_pages())
    throw std::runtime_error(
        "this program was built without its pages: Node and npm (Debian: nodejs, npm) or their registry were "
        "missing; build it again with them, or take --json, --csv or flexura export");
}

std::string_view page_script() {
  return between(flexura_page_js_begin, flexura_page_js_end);
}

std::string_view page_style() {
  return between(flexura_page_css_begin, flexura_page_css_end);
}

std::string_view report_script() {
  return between(flexura_report_js_begin, flexura_report_js_end);
}

std::string_view report_style() {
  return between(flexura_report_css_begin, flexura_report_css_end);
}

}  // namespace flexura::view
