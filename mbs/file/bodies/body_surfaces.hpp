// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "mbs/file/bodies/read_surface_patch.hpp"
#include "mbs/file/read_model.hpp"
#include "mbs/kinematics/touched_surface.hpp"

/// Surfaces of superelements for the elements that touch or measure them, see ReadContext.  Each is noted in the
/// model, which gives it the shapes of the body's modes when these are chosen (prepare_bodies()).
namespace flexura::mbs {

/// The nodes that may touch: of `body`, the one that the element calls `body`; its name has `prefix` before it.
std::shared_ptr<const SurfacePatch> touching_surface(ReadModel& model, const std::string& prefix,
                                                     const input::Section& s, int body);
/// The facets that may be touched, made smooth.
std::shared_ptr<const TouchedSurface> touched_surface(ReadModel& model, const input::Section& s,
                                                      const SurfaceKeys& keys, int body);
/// The whole surface, whose distance is measured; `key` names the body.
std::shared_ptr<const SurfaceMesh> measured_surface(ReadModel& model, const input::Section& s,
                                                    const std::string& key, int body);

}  // namespace flexura::mbs
