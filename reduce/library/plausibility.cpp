// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/plausibility.hpp"

#include <fmt/format.h>

#include <cmath>

#include "mesh/model/hinges.hpp"

namespace flexura::reduce {

std::string odd_material(const Material& material, bool of_deck) {
  if (!material.plies.empty()) return "";              // a mean of others, which are asked themselves
  constexpr double kSoftest = 1e3, kStiffest = 2e12;   // [Pa]: gels, diamond
  constexpr double kLightest = 1.0, kHeaviest = 25e3;  // [kg/m^3]: aerogels, osmium
  // [m/s], of sound in a bar: 17e3 in diamond, some 40 in soft rubber.
  constexpr double kSlowest = 20.0, kFastest = 25e3;
  const auto remedy = [&](const char* own) -> std::string {
    return of_deck ? "a deck is taken in m, kg, s unless [geometry] unit says otherwise (unit = \"mm\", or "
                     "--unit-system mm-t-s)"
                   : own;
  };
  // In shear: what does not depend on how compressible the material is.
  const double stiffness = 3.0 * material.D(3, 3);
  if (!(stiffness > kSoftest && stiffness < kStiffest))
    return fmt::format("material \"{}\" has a stiffness of about {:.3g} Pa, as no material has; {}",
                       material.name, stiffness,
                       remedy("is the unit of its Young's modulus missing (young = \"210 GPa\")?"));
  if (!(material.density > kLightest && material.density < kHeaviest))
    return fmt::format("material \"{}\" has a density of {:.3g} kg/m^3, as no material has; {}",
                       material.name, material.density,
                       remedy("is its unit missing (density = \"7850 kg/m^3\")?"));
  if (const double speed = std::sqrt(stiffness / material.density); speed > kFastest || speed < kSlowest)
    return fmt::format(
        "material \"{}\" has a stiffness of about {:.3g} Pa and {:.3g} kg/m^3, in which sound would be as {} "
        "as in no material ({:.2g} km/s); {}",
        material.name, stiffness, material.density, speed > kFastest ? "fast" : "slow", 1e-3 * speed,
        remedy("are the units of Young's modulus and density right (\"210 GPa\", \"7850 kg/m^3\")?"));
  return "";
}

std::string odd_size(const mesh::Mesh& mesh) {
  constexpr double kLongest =
      200.0;  // [m]: hardly a solid mesh of a machine's part, and 20 cm in millimetres
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(HUGE_VAL), high = -low;
  for (const mesh::CellBlock& block : mesh.solids)
    for (const mesh::Index node : block.nodes.reshaped()) {
      low = low.cwiseMin(mesh.points.row(node));
      high = high.cwiseMax(mesh.points.row(node));
    }
  if (mesh.solids.empty() || !((high - low).maxCoeff() > kLongest)) return "";
  return fmt::format(
      "the part is {:.4g} m long, its mesh being taken in metres; is it in millimetres (unit = \"mm\" in "
      "[geometry], or --unit-system mm-t-s)? unit = \"m\" says that it is not",
      (high - low).maxCoeff());
}

std::string odd_thickness(const mesh::Mesh& mesh) {
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(HUGE_VAL), high = -low;
  double thickest = 0.0;
  for (const mesh::CellBlock& block : mesh.shells) {
    for (const mesh::Index node : block.nodes.reshaped()) {
      low = low.cwiseMin(mesh.points.row(node));
      high = high.cwiseMax(mesh.points.row(node));
    }
    for (const double thickness : block.thickness) thickest = std::max(thickest, thickness);
  }
  const double length = (high - low).norm();
  if (mesh.shells.empty() || !(thickest > length / 3.0)) return "";
  return fmt::format(
      "a shell is {:.3g} m thick where all shells together are {:.3g} m long; is its thickness in the "
      "deck's unit of length?",
      thickest, length);
}

std::string odd_joint(const mesh::Mesh& mesh) {
  if (!mesh.shells.empty()) return "";
  const auto hinge = mesh::find_hinge(mesh);
  if (!hinge) return "";
  return fmt::format(
      "solids share nothing but {} at ({:.4g}, {:.4g}, {:.4g}) m: there they turn freely, unless an "
      "interface or "
      "a tie binds them; let them share faces, or tie them",
      hinge->line ? "an edge" : "a node", hinge->at.x(), hinge->at.y(), hinge->at.z());
}

}  // namespace flexura::reduce
