// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mbs/solver/prepare.hpp"
#include "mbs/solver/run.hpp"
#include "mbs/study/integrator_check.hpp"
#include "mbs/study/shadows.hpp"

/// What a run says about its own error, by source:
///
/// - integrator: a second run with another tolerance (mbs/study/integrator_check.hpp) where the user asked
/// for
///   it; else the energy balance, relative to the largest energy, which knows nothing of the tolerance and is
///   a lower bound at best;
/// - modes of a body: the shadows of what the run leaves out of it (mbs/study/shadows.hpp), the rms of the
///   error over the rms of the output, of the output where that is largest;
/// - mesh of a body: its reduction's report, twice the estimated relative error of its first free frequency
///   (stiffness goes with its square) and the mesh's volume against CAD; a part of the body's deformation.
///   It counts in full, as if the output were nothing but deformation.
namespace flexura::app {

struct MeshShare {
  std::string body;
  double of_deformation = 0.0;  ///< relative; negative where the report says nothing
  bool is_beam = false;         ///< of no superelement: nothing says what its elements leave out
};

/// Of the bodies that deform.  Reads the reports from their files.
std::vector<MeshShare> mesh_shares(const mbs::PreparedMechanism& prepared);

/// One line: the estimated error, its parts and the largest contributor.  `truncation` may be null (nothing
/// was left out), `integrator` too (not asked for).
std::string estimated_error_line(const std::vector<MeshShare>& meshes,
                                 const study::TruncationEstimate* truncation,
                                 const study::IntegratorEstimate* integrator, const mbs::RunResult& result);

/// The same for the summary in the results file: {"error", "shadows", "wall_time", "integrator",
/// "integrator_check": {"error", "output", "factor", "wall_time"}, "by_body", "mesh", "outputs": {name:
/// {"max", "rms", "size_max", "size_rms", "final"}}}.
nlohmann::json estimated_error_json(const std::vector<MeshShare>& meshes,
                                    const study::TruncationEstimate* truncation,
                                    const study::IntegratorEstimate* integrator,
                                    const mbs::RunResult& result);

}  // namespace flexura::app
