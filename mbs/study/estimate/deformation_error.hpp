// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/superelement/superelement.hpp"

namespace flexura::study {

/// What a superelement says of itself, as errors of its deformation: that of the lowest frequency counts twice (f ~ k^(1/2)),
/// those of the compliance between interfaces as they are; of the elements the worst.  Nothing where the mesh was not judged or does
/// not resolve the part.
struct DeformationError {
  std::optional<double> elements, left_out;
  double volume = 0.0;
  std::string note;  ///< which of the elements' errors that is
};

DeformationError deformation_error(const superelement::Superelement& se);
/// What it sums up to: the part by which the body's deformation is off, too stiff; 0 where nothing is known.
double known_error(const DeformationError& error);
/// Of a body that deforms by a superelement.
DeformationError deformation_error(const mbs::BodyDescription& body);

}  // namespace flexura::study
