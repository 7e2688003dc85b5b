// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "mbs/base/documents/document.hpp"

/// The table [parameters] of a mechanism file: names for formulas, each a number, a quantity or a formula of
/// the others, in any order but not in a circle.
namespace flexura::mbs {

/// Values [SI] by name.  Throws InputError.
std::map<std::string, double> read_parameters(const input::Section& root);

/// Lets numbers of the file be formulas of these parameters (input::FormulaReader).
input::FormulaEvaluator evaluate_with(const std::map<std::string, double>& parameters);

}  // namespace flexura::mbs
