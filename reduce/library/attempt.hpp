// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "reduce/cms/craig_bampton.hpp"
#include "reduce/part/make_part.hpp"
#include "reduce/superelement/surface.hpp"

namespace flexura::reduce {

/// One mesh and its reduction.
struct Attempt {
  ModelledPart modelled;
  mesh::MeshReport mesh;
  SurfacePicture picture;
  std::vector<std::int32_t> vertices;  ///< of the picture, with stress modes
  Reduction reduction;
  bool graded = false;  ///< the mesh has sizes of its own everywhere, not the one of mesh.size
  std::string missed;   ///< of reach(): that the goal is not reached, and why; else empty
};

/// Meshes, chooses interfaces, ties and reduces once.  Room for the superelement is asked for at `output`, where that is
/// given.  Throws input::InputError, std::invalid_argument for what the user can mend, std::runtime_error otherwise.
Attempt attempt(const PartInput& input, const std::filesystem::path& output, ReductionOptions how);

/// Meshes and reduces until both are within what is asked; without a goal once.  Where the modes left out cost too much, the
/// interfaces' answer at rest joins them with the next mesh.  `say` gets a line for each reduction.  Where the goal is out of
/// reach, or a finer mesh fails, the last mesh that was judged is given, with `missed`; std::runtime_error where none was.
Attempt reach(PartInput input, const std::filesystem::path& output, ReductionOptions how,
              const std::function<void(const std::string&)>& say, std::vector<std::string>& warnings);

}  // namespace flexura::reduce
