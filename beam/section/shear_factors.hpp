// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "beam/section/shapes.hpp"

namespace flexura::beam {

/// kappa for a force along z: by the formula asked for, or by Cowper (hollow ellipses: the thin wall's at nu = 0).  Infinite
/// for ShearFormula::rigid.  Throws std::invalid_argument where there is no such formula for the shape.
double shear_factor(const Shape& shape, double nu, std::optional<ShearFormula> choice);

/// The shape with y and z exchanged.
Shape turned(const Shape& shape);

}  // namespace flexura::beam
