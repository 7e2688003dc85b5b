// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/app/write_reduced.hpp"

namespace flexura::reduce {

/// The solid of a beam part: reduces its part file to `FOLDER/STEM.NAME.se.h5` beside `output`
/// (FOLDER/STEM.se.h5), or reads the superelement given.  Throws input::InputError for superelements that no
/// beam can hold (interfaces that are not six boundary dofs each), else like reduce_part.
AttachedSolid attach_solid(const SolidInput& solid, const std::filesystem::path& output,
                           const OutputOptions& options);

}  // namespace flexura::reduce
