// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <stdexcept>

#include "mesh/gmsh/cad.hpp"
#include "mesh/gmsh/child.hpp"
#include "mesh/gmsh/job.hpp"

/// One question to the child process, one answer; shared by all that uses it.
namespace flexura::mesh {

/// A failure of one try that another try may mend; the text goes on after "it ".
struct TryFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A sentence about the file itself ("holds no solid ..."), as the child found it.
struct PartRefused : TryFailed {
  using TryFailed::TryFailed;
};

struct Answer {
  ResultRecord record;
  Arrays arrays;
};

/// The child ended with a signal or a code.
struct WorkerCrashed : TryFailed {
  using TryFailed::TryFailed;
};

/// What the child waited for a processor is given back to the allowance that the time is taken from.  Throws TryFailed or
/// one of its kinds; std::runtime_error where the program is missing.
Answer ask_worker(const std::filesystem::path& worker, const Job& job, double limit_s,
                  const Progress& progress, Allowance* allowance = nullptr);

/// What the child wrote, taken apart; every count and node number is held against what is there.  Throws
/// TryFailed.
Answer read_answer(const std::string& bytes, int nodes_per_tetrahedron);

}  // namespace flexura::mesh
