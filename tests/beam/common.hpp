// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>
#include <string>

#include "beam/section/section.hpp"

/// What every test of beams needs.
namespace flexura::beam::testing {

inline const Material kSteel = isotropic("steel", 2.1e11, 0.3, 7850.0);

/// The text with which `function` refuses bad input, or "no refusal".
template <class Function>
std::string refusal(Function&& function) {
  try {
    function();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no refusal";
}

}  // namespace flexura::beam::testing
