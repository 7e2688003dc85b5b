// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

/// Pieces of beam and section files that several tests are put together from.
namespace flexura::beam::testing {

inline const std::string kSteelText = R"(
[material.steel]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"
)";

inline const std::string kRoundText = R"(
[section.round]
type = "circle"
diameter = "50 mm"
)";

/// A channel of sheet metal, 5 mm thick, by its mid-lines: h = 95 mm, b = 47.5 mm, open towards +y.
inline const std::string kChannelText = R"(
[wall.profile]
thickness = "5 mm"
points = [[47.5, -47.5], [0, -47.5], [0, 47.5], [47.5, 47.5]]
)";

/// A box girder, 100 mm by 200 mm, walls of 10 and 15 mm.
inline const std::string kBoxText = R"(
[region.box]
points = [[-50, -100], [50, -100], [50, 100], [-50, 100]]
[hole.inside]
region = "box"
points = [[-40, -85], [40, -85], [40, 85], [-40, 85]]
)";

}  // namespace flexura::beam::testing
