// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

/// One example of every force and of every constraint of the mechanism file: what several tests hold all types against
/// (derivatives, results).  A new type gets its keys here; those tests fail without.
namespace flexura::mbs {

/// By type: the keys of an element "x" between the bodies of kThreeBodies (mechanism_file.hpp).
using Examples = std::map<std::string, std::string>;

const Examples& force_examples();
const Examples& constraint_examples();

inline constexpr const char* kEnds = "from = \"a.out\"\nto = \"b.in\"\n";
/// A path on a, with an element's other keys.
std::string on_rail(const std::string& keys);

}  // namespace flexura::mbs
