// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace flexura::input {

/// Characters that no formula has, assignments, decimal commas: what is wrong with the formula, or nothing.
std::string wrong_with_formula(const std::string& formula);

/// Letters, digits, _ and the point: what names in formulas are made of.
bool is_name_character(char c);
inline constexpr const char* name_characters =
    "0123456789_.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

}  // namespace flexura::input
