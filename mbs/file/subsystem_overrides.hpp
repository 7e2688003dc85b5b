// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"

/// Overrides of keys in the files of subsystems.
namespace flexura::mbs {

/// "subsystem.left.body.arm.mass=3" goes to the subsystem's own file as "body.arm.mass=3" (into `below`, by the
/// subsystem's name), unless it is about how the subsystem is placed.  Returns those that stay.
std::vector<std::string> take_overrides_below(const std::vector<std::string>& overrides,
                                              std::map<std::string, std::vector<std::string>>& below);

/// With which the file of [subsystem.NAME] `s` is read: the parameters that are given there, as numbers made of the
/// `parameters` of the file that places it, then `below`.  Throws InputError.
std::vector<std::string> overrides_of_placed(const input::Section& s,
                                             const std::map<std::string, double>& parameters,
                                             const std::vector<std::string>& below);

}  // namespace flexura::mbs
