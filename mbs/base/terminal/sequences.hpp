// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string_view>

/// All that the programs ask of a terminal.
namespace flexura::terminal {

inline constexpr std::string_view kBold = "\033[1m", kRed = "\033[31;1m", kPlain = "\033[0m",
                                  kClearLine = "\r\033[K";
inline constexpr std::array kSequences = {kBold, kRed, kPlain, kClearLine};

}  // namespace flexura::terminal
