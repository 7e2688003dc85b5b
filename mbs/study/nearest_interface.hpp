// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>

#include "mbs/superelement/superelement.hpp"

namespace flexura::study {

/// The interface of the triangle of the surface that is nearest to a place in B; empty where that triangle is of none, or there is no
/// surface.
std::string nearest_interface(const superelement::Superelement& se, const Eigen::Vector3d& place);

}  // namespace flexura::study
