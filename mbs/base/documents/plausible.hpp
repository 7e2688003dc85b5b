// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace flexura::input {

/// What no solid material has, most often a value without its unit: a sentence for the user, or empty.
/// `stiffness`: three times the shear modulus [Pa], about Young's modulus, which does not depend on how compressible the
/// material is; `density` [kg/m^3]. `remedy` replaces what is said of keys of our own files.
std::string odd_material(const std::string& name, double stiffness, double density,
                         const std::string& remedy = "");

}  // namespace flexura::input
