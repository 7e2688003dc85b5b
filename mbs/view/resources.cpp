// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/resources.hpp"

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

FLEXURA_EMBED(flexura_page_js, FLEXURA_PAGE_JS)
FLEXURA_EMBED(flexura_page_css, FLEXURA_PAGE_CSS)

namespace flexura::view {

std::string_view page_script() {
  return {flexura_page_js_begin, static_cast<std::size_t>(flexura_page_js_end - flexura_page_js_begin)};
}

std::string_view page_style() {
  return {flexura_page_css_begin, static_cast<std::size_t>(flexura_page_css_end - flexura_page_css_begin)};
}

}  // namespace flexura::view
