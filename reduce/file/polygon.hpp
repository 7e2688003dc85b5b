// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mesh/gmsh/planar.hpp"

/// What polygons of a section file are asked before the geometry kernel takes them, which aborts for some that are none.
namespace flexura::reduce {

/// Corners that lie nearer to each other than this are one [m]: ten times OpenCASCADE's tolerance.
inline constexpr double kSamePlace = 1e-9;

/// Without corners that stand in the place of the one before, the last one that closes it among them.
mesh::PlaneLoop without_repeated(const mesh::PlaneLoop& loop, bool closed);

/// Of a polygon without repeated corners: why it bounds no area (it crosses or touches itself, folds back, has less than three
/// corners); empty where it does.  Corners count from 1.
std::string polygon_fault(const mesh::PlaneLoop& loop);

/// Area that two polygons without fault share [m^2], to round-off of the larger one: over strips between all corners and crossings,
/// in which no sides cross.
double shared_area(const mesh::PlaneLoop& a, const mesh::PlaneLoop& b);

}  // namespace flexura::reduce
