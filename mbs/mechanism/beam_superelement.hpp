// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "mbs/mechanism/beam_part.hpp"
#include "mbs/superelement/superelement.hpp"

/// A beam of a mechanism file, [body.NAME.beam], as a superelement that no file holds: for the fidelities of small
/// deformation, and for what a rigid beam leaves out.
///
/// Craig and Bampton's shapes (superelement.hpp) of straight elements that are exact for end loads (beam/element/element.hpp),
/// so many of them over the length as the part asks for, 16 at least and 64 at most, and a node at every station.  Interfaces are the stations; where several lie in one place, the
/// others follow the first.  `modes` modes with the stations at rest are kept.  With the stiffening terms of
/// axial forces, and as mesh_error what the length h of the elements costs of each frequency, by the wave number k of the
/// free waves there (as beam::elements_of):
///
///     bending (k h)^4 / 1440,    its shear (k h)^2 phi / 48, phi = EI k^2 / (G A),    stretch and torsion (k h)^2 / 48
///
/// relative, of the largest; statics under loads at the stations are exact.
namespace flexura::mbs {

/// The frame is the body's.  Throws std::invalid_argument for a beam without length or mass.
std::shared_ptr<const superelement::Superelement> beam_superelement(const BeamPart& part, int modes = 60);

/// The same for parts that are the same.
std::string key_of(const BeamPart& part);

}  // namespace flexura::mbs
