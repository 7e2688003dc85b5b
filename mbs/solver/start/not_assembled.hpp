// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mbs/solver/position/openings.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/solver/start/warning_mark.hpp"

namespace flexura::mbs {

/// What prepare() throws for a mechanism whose loops do not close.
class NotAssembled : public input::InputError {
 public:
  NotAssembled(const std::string& what, std::shared_ptr<const PreparedMechanism> where,
               std::vector<Opening> open)
      : InputError(what), as_it_stands(std::move(where)), openings(std::move(open)) {}
  /// Its state is where the loops are open the least; not consistent, and without redundancy taken out.
  std::shared_ptr<const PreparedMechanism> as_it_stands;
  std::vector<Opening> openings;  ///< there, the widest first
};

}  // namespace flexura::mbs
