// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "tests/mbs/random/scene/scene.hpp"

namespace flexura::mbs::chance {

/// Up to six rigid bodies in a tree, a loop, a planar linkage, a door on many hinges or a gear train, with springs,
/// dampers, loads and drives, which may contradict each other.
Scene random_scene(std::uint64_t seed);

}  // namespace flexura::mbs::chance
