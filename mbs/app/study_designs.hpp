// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/study/designs.hpp"

/// What `flexura study` says of designs: on the terminal and as a page.
namespace flexura::app {

void print_designs(const study::StudyFile& study, const study::Designs& designs);
void write_designs_page(const std::string& html, const study::StudyFile& study,
                        const study::Designs& designs);

}  // namespace flexura::app
