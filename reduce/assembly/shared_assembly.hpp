// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "reduce/assembly/tied_matrices.hpp"
#include "reduce/linalg/factor/distributed_factor.hpp"

namespace flexura::reduce {

/// What one rank of a team has of a model: its own elements, by the numbers of the whole.
class ModelShare {
 public:
  /// Takes the numbering from a message (TiedNumbering::put) and assembles.
  ModelShare(linalg::Message& numbering, const Part& part, const AssemblyOptions& options);

  const TiedMatrices& matrices() const { return matrices_; }

 private:
  TiedNumbering numbering_;
  TiedMatrices matrices_;
};

/// What the ranks of a team have computed of a model, and what this rank has of it; without a team the model is this process's
/// alone.
struct ModelShares {
  const linalg::Team* team = nullptr;
  linalg::RowShares rows;
  std::unique_ptr<ModelShare> own;
};

/// On the rank that leads: all ranks of options.team compute their elements; `sum` holds those of all then.
ModelShares assemble_together(const Part& part, const AssemblyOptions& options,
                              const TiedNumbering& numbering, TiedMatrices& sum);

/// On the ranks that do not lead: takes a share of a model's elements, computes it and sends the matrices to rank 0; null where
/// its elements are bad, which rank 0 then says.
std::unique_ptr<ModelShare> take_share(const linalg::Team& team, linalg::RowShares& rows);

}  // namespace flexura::reduce
