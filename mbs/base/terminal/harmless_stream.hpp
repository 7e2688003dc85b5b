// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdio>

/// What a program prints, by whatever means (fmt, stdio, std::cout, a library's own words), reaches the terminal without what a
/// file made it contain: harmful characters (mbs/base/files/plain_text.hpp) are shown, not obeyed.
namespace flexura::terminal {

/// From here on stdout, stderr and std::cout of this process go through that.  Only the sequences of sequences.hpp pass, and only to
/// terminals.  Lines and tabs stay as they are.
void guard_standard_streams();

/// The descriptor behind the stream; of stdout and stderr also where they are guarded.
int descriptor_of(std::FILE* stream);

}  // namespace flexura::terminal
