// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mesh/gmsh/cad.hpp"
#include "reduce/app/part_file.hpp"
#include "reduce/cms/reduction.hpp"

namespace flexura::reduce {

/// What the reduction did and how far to trust it, for people and for programs.
struct Report {
  std::string text;     ///< a few lines for the terminal, ending with a newline
  nlohmann::json json;  ///< kept in the superelement
};

Report make_report(const PartInput& input, const mesh::CadMesh& cad, const Reduction& reduction,
                   const std::vector<std::string>& notes, double seconds);

}  // namespace flexura::reduce
