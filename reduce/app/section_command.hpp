// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/terminal/command_line.hpp"

namespace flexura::reduce {

/// `flexura section FILE`: a cross-section from polygons, thin walls or a CAD face; table, drawing, section
/// file.
terminal::Command section_command();

}  // namespace flexura::reduce
