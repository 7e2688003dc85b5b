// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/elements_check.hpp"
#include "mbs/study/estimate/integrator_check.hpp"
#include "mbs/study/estimate/shadows.hpp"

/// What a run says about its own error, by source:
///
/// - integrator: a second run with another tolerance (mbs/study/estimate/integrator_check.hpp) where the user asked for
///   it; else unknown: the energy balance, relative to the largest energy, is a lower bound at best;
/// - modes of a body: the shadows of what the run leaves out of it (mbs/study/estimate/shadows.hpp), the rms of the
///   error over the rms of the output, of the output where that is largest;
/// - mesh of a body: its reduction's report, twice the estimated relative error of its first free frequency
///   (stiffness goes with its square) and the mesh's volume against CAD; a part of the body's deformation.
///   Where shadows follow the run (modes are left out, or an accuracy is asked for) it is what that error of its stiffness
///   changes of the worst output; else it counts in full, as if the output were nothing but deformation;
/// - stress of a body, where it is stored: what its reduction says of the greatest under loads on its interfaces,
///   unknown where that is unbounded and at stress points; beside what the mesh makes of deformation;
/// - section forces and stress by a body's own loads (weight, inertia, load cases, tension): unknown where its superelement
///   does not know what these add between the interfaces; else they are in the figures, and cost nothing;
/// - section forces of one-way bodies: unknown;
/// - elements of beams: two runs more with other numbers of them (mbs/study/estimate/elements_check.hpp), where the user
///   asked for it or for an accuracy.
///
/// What nothing judged is unknown, and the total is then "at least" what is known: elements of beams without
/// those runs, rigid links, elements of users' own libraries, geometric stiffening of bodies whose
/// superelement has no terms for it, a mesh whose reduction reports no estimate, and what switches (contact,
/// clearance, stick-slip) as long as nothing but an estimate linear about the run has looked at it.
namespace flexura::study {

struct ErrorSource {
  std::string
      kind;  ///< "integrator", "modes", "mesh", "stress", "section_forces", "stress_of_own_loads", "elements", "plane", "link", "user_element", "surface_contact", "stiffening", "switch", "vibration", "dead_point"
  std::string name;             ///< of the body or element; empty for the integrator
  std::optional<double> error;  ///< relative; nothing where it is unknown
  double at_least = 0.0;        ///< of an unknown one
  std::string note;             ///< what the figure is, or how an unknown one can be judged
};

struct ErrorEstimate {
  std::vector<ErrorSource> sources;
  double at_least = 0.0;  ///< sum of what is known
  bool is_whole = true;   ///< nothing is unknown: at_least is the estimate
  std::string of;         ///< of which output's rms it is a part
  bool is_large = false;  ///< beyond what an estimate to first order can tell
};

/// What has looked at a run; each may be null: nothing was left out, not asked for, no beams.
struct Judges {
  const TruncationEstimate* truncation = nullptr;
  const IntegratorEstimate* integrator = nullptr;
  const ElementsEstimate* elements = nullptr;
};

ErrorEstimate estimate_error(const mbs::PreparedMechanism& prepared, const Judges& judges,
                             const mbs::RunResult& result);

/// The estimated error, and a line for each part of it, the largest first, and for what is unknown.
std::string estimated_error_text(const ErrorEstimate& estimate);

/// A sentence where the accuracy asked for is not met, where the estimate of modes and integrator comes nearer to it than it is
/// right, or where something that may well exceed it is unknown (modes that no row judges, elements of beams, switching);
/// empty else.
std::string missed_accuracy(const ErrorEstimate& estimate, double accuracy);

/// What the mesh costs the stresses that are stored, a source for each body.
void add_stresses(const mbs::PreparedMechanism& prepared, std::vector<ErrorSource>& sources);

/// What the bodies' modes, meshes and elements cost, as far as it is known before a run.
std::vector<ErrorSource> discretisation_of(const mbs::PreparedMechanism& prepared);
/// For commands that estimate no error: "discretisation: mesh and reduction of rod 1.2 % of its deformation;
/// unknown: elements of blade (a run with ... tells)"; empty where nothing that deforms was left to chance.
std::string discretisation_line(const mbs::PreparedMechanism& prepared);

/// The estimate for the summary in the results file: {"error" (null where a source is unknown), "at_least",
/// "unknown": [{"source", "name", "remedy"}], "truncation", "shadows", "wall_time", "integrator" (null without
/// a second run), "energy_balance", "integrator_check": {"error", "output", "factor", "wall_time"}, "by_body",
/// "mesh" (null for a body without estimate), "outputs": {name: {"max", "rms", "size_max", "size_rms",
/// "scale", "final"}}, "elements_check": {"error" (null where unknown), "at_least", "output", "bodies", "note",
/// "wall_time"}}.
nlohmann::json estimated_error_json(const ErrorEstimate& estimate, const Judges& judges,
                                    const mbs::RunResult& result);

}  // namespace flexura::study
