// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/superelement/superelement.hpp"

/// What a superelement knows of its own errors: one place for all who tell it, so that tables, checks and runs say the same.
namespace flexura::superelement {

/// Relative, of a frequency of the free body, which both make too high; -1: not known, 1: not resolved.
struct FrequencyError {
  double mesh = -1.0;      ///< by the mesh, estimated
  double left_out = -1.0;  ///< by the modes left out, estimated
};

/// Of the elastic mode of the free body at this frequency.  Needs mesh_error; what was struck out or never judged is not known.
FrequencyError frequency_error(const Superelement& se, double frequency_hz);

/// Of the lowest frequency that was judged: by the mesh and by the modes left out, each for itself.
FrequencyError first_frequency_error(const Superelement& se);

/// The judged interface whose static compliance the mesh makes worst, and by how much; none: nullptr.
const MeshError::Interface* worst_interface(const MeshError& error);

/// Whether a mesh resolves its part where `worst` is the greatest error of its first frequency and of its interfaces' compliance;
/// `rough`: known to a factor of five only.
bool is_resolved(double worst, bool rough);

/// The same of what was judged; false where nothing was.
bool is_resolved(const MeshError& error);

/// Whether its deformation takes part in centrifugal and Coriolis forces; not where a FlexData file of another program brought no
/// inertia integrals.
bool has_inertia_integrals(const Superelement& se);

/// Whether it is made of a beam part, which has section forces and no stresses.
bool is_of_beams(const Superelement& se);

/// "1.2", "50 or more", "unknown": an error in per cent.
std::string percent_words(double error);

/// What the mesh takes of the interfaces' compliance, and how well all of this is known, in one sentence.
std::string mesh_error_words(const Superelement& se);

}  // namespace flexura::superelement
