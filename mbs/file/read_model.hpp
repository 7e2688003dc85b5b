// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mbs/bodies/preparation_cache.hpp"
#include "mbs/file/bodies/read_flexible_body.hpp"
#include "mbs/file/bodies/read_surface_patch.hpp"
#include "mbs/file/fidelities.hpp"
#include "mbs/file/read_mechanism.hpp"
#include "mbs/kinematics/surface_mesh.hpp"
#include "mbs/mechanism/beam_part.hpp"

namespace flexura::mbs {

/// What all files of a mechanism are read into.
struct ReadModel {
  PreparationCache& cache;
  MechanismDescription description = {};
  std::vector<std::string> notes = {};
  std::map<int, input::Section> sections = {};  ///< of bodies
  std::map<int, std::vector<std::pair<std::string, Vector3d>>> interfaces = {};
  std::set<int> joined = {};  ///< bodies with a joint
  /// Of deforming bodies; they are prepared when it is known what acts on them.
  std::map<int, std::shared_ptr<const superelement::Superelement>> to_prepare = {};
  std::map<int, std::vector<BodyNode>> linked = {};  ///< nodes of deforming bodies beside their interfaces
  std::map<int, Segments> segments = {};             ///< beams cut into pieces, by the piece at the root
  std::vector<BlindSpot> blind_spots = {};
  /// Bodies, by name, whose surfaces forces act on; their superelements, and the parts of the surfaces.
  std::set<std::string> surfaces_in_use = {};
  std::map<int, std::shared_ptr<const superelement::Superelement>> with_surface = {};
  std::multimap<int, PatchOfSurface> patches = {};
  std::multimap<int, std::shared_ptr<SurfaceMesh>> meshes = {};  ///< whole surfaces that measures see

  /// Of subsystems, which a few files can place without end.
  int n_subsystems = 0;
  std::uintmax_t bytes_of_subsystems = 0;

  bool deforms(int body) const { return to_prepare.contains(body) || description.bodies[body].flexible; }
};

}  // namespace flexura::mbs
