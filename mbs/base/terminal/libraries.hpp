// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace flexura::terminal {

/// The shared libraries of numerics and files that this process runs with, each by the name of its file with its version:
/// "libhdf5_serial.so.103.3.0, libsundials_ida.so.6.4.1".
std::string loaded_libraries();

}  // namespace flexura::terminal
