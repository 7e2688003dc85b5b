// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/documents/document.hpp"
#include "mbs/formulas/curve.hpp"

/// [table.NAME] of a mechanism file.
namespace flexura::mbs {

input::TableSchema table_schema();

/// All tables of the file.  Points stand in it or in a text file beside it.  Throws InputError.
Curves read_tables(const input::Section& root);

}  // namespace flexura::mbs
