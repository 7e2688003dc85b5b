// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/superelement/exchange/exchange.hpp"
#include "reduce/cms/result/reduction.hpp"

namespace flexura::reduce {

/// All integrals of [R Phi], Phi the body's elastic shapes: a rigid motion k is t_k + A_k x, the rotations about the centre of mass:
/// about an origin far away they would be translations but for round-off.
InertiaIntegrals integrals_of(const superelement::FlexDataBody& body);

/// Throws std::invalid_argument, beginning with `file`, for a mass and moments that no body has.
void check_body(const superelement::FlexDataBody& body, const std::string& file);

}  // namespace flexura::reduce
