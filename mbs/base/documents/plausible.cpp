// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/plausible.hpp"

#include <fmt/format.h>

#include <cmath>

namespace flexura::input {

std::string odd_material(const std::string& name, double stiffness, double density,
                         const std::string& remedy) {
  constexpr double kSoftest = 1e3, kStiffest = 2e12;   // [Pa]: gels, diamond
  constexpr double kLightest = 1.0, kHeaviest = 25e3;  // [kg/m^3]: aerogels, osmium
  // [m/s], of sound in a bar: 17e3 in diamond, some 40 in soft rubber.
  constexpr double kSlowest = 20.0, kFastest = 25e3;
  const auto or_own = [&](const char* own) { return remedy.empty() ? std::string(own) : remedy; };
  if (!(stiffness > kSoftest && stiffness < kStiffest))
    return fmt::format("material \"{}\" has a stiffness of about {:.3g} Pa, as no material has; {}", name,
                       stiffness,
                       or_own("is the unit of its Young's modulus missing (young = \"210 GPa\")?"));
  if (!(density > kLightest && density < kHeaviest))
    return fmt::format("material \"{}\" has a density of {:.3g} kg/m^3, as no material has; {}", name,
                       density, or_own("is its unit missing (density = \"7850 kg/m^3\")?"));
  if (const double speed = std::sqrt(stiffness / density); speed > kFastest || speed < kSlowest)
    return fmt::format(
        "material \"{}\" has a stiffness of about {:.3g} Pa and {:.3g} kg/m^3, in which sound would be as {} "
        "as in no material ({:.2g} km/s); {}",
        name, stiffness, density, speed > kFastest ? "fast" : "slow", 1e-3 * speed,
        or_own("are the units of Young's modulus and density right (\"210 GPa\", \"7850 kg/m^3\")?"));
  return "";
}

}  // namespace flexura::input
