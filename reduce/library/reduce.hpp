// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/linalg/session/user_options.hpp"
#include "reduce/part/beam_part_input.hpp"
#include "reduce/part/flexdata_input.hpp"
#include "reduce/part/part_input.hpp"

/// From a part to a superelement, in a program of one's own:
///
///     linalg::Session session;                       // PETSc and SLEPc live as long as this does
///     reduce::PartInput part = ...;                  // or reduce::read_part("rod.toml")
///     part.modes.count = 20;
///     reduce::Reduced rod = reduce::reduce(part);
///     superelement::write("rod.se.h5", rod.superelement);
///
/// All functions throw std::invalid_argument (input::InputError where a file's entry is at fault) for what the user can mend and
/// std::runtime_error otherwise; they print nothing but PETSc's own reports, where those are asked for, and need no Session of
/// the caller's, who keeps one to reduce more than once (MPI cannot be started again).
namespace flexura::reduce {

/// How a reduction goes, beside what its part asks for.
struct ReduceOptions {
  linalg::Progress progress = {};
  std::function<void(const std::string&)> say = {};  ///< a line for each mesh on the way to an accuracy
  std::filesystem::path output =
      {};           ///< where it is going to be written: room is made sure of; empty: not written
  int compare = 0;  ///< free frequencies to compare with the full model, which is solved, too; 0: none
  const linalg::Team* team = nullptr;          ///< of processes that share the work; null: this one alone
  std::vector<linalg::UserOption> petsc = {};  ///< options of PETSc and SLEPc, after those of the part
  bool factor_in_file = false;  ///< the factor goes to a temporary file even where memory has room
};

/// A superelement and what is to be said of it.
struct Reduced {
  superelement::Superelement superelement;
  std::string text;     ///< a few lines for a terminal, the verdict last, each ending with a newline
  nlohmann::json json;  ///< the acceptance report, which the superelement holds, too
  std::vector<std::string> warnings;
  std::string
      too_coarse;  ///< what to say of a mesh that does not resolve the part; empty where it does or is not judged
  std::string
      missed;  ///< that an accuracy asked for is not reached, and why; empty where it is, or none was asked for
  mesh::Mesh mesh;  ///< of solids and shells; empty for beams and finished modes
  std::vector<Material> materials;
};

/// Meshes or reads a part, chooses its interfaces, ties, reduces and judges it.
Reduced reduce(const PartInput& part, const ReduceOptions& options = {});
/// Divides and reduces a structure of beams.  Warnings of restrained warping and of lost digits are in the text.
Reduced reduce(const BeamPartInput& part, const ReduceOptions& options = {});
/// Takes the finished modes of a FlexData file.
Reduced reduce(const FlexDataInput& part, const ReduceOptions& options = {});

/// Reduces a mesh in memory with its materials and interfaces, without a report.
superelement::Superelement reduce(const Part& part, const std::string& name, ReductionOptions options);

}  // namespace flexura::reduce
