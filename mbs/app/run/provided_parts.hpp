// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>

#include "mbs/app/run/one_run.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/study/parts_on_demand.hpp"

/// `flexura simulate --reduce`: superelements made because the runs want them (mbs/study/parts_on_demand.hpp).
namespace flexura::app {

/// Reduces what the chosen runs want and puts the overrides that name it behind those of the command line.  `bin`: where the
/// programs are.  The result tells of its work through `progress` and on stderr, and must not outlive it.
std::unique_ptr<study::PartsOnDemand> provide_parts(SimulateArguments& arguments,
                                                    const std::filesystem::path& bin,
                                                    terminal::Progress& progress,
                                                    const terminal::Verbosity& verbosity);

/// Overrides that name finer reductions where the meshes of the bodies that deform take more than their share of the
/// accuracy; none where they do not, or where no accuracy was asked.
std::vector<std::string> finer_parts(study::PartsOnDemand& parts, const mbs::PreparedMechanism& prepared);

}  // namespace flexura::app
