// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/plausibility.hpp"

#include <fmt/format.h>

#include <cmath>

#include "mbs/base/documents/plausible.hpp"
#include "mesh/model/hinges.hpp"

namespace flexura::reduce {

std::string odd_material(const Material& material, bool of_deck) {
  if (!material.plies.empty()) return "";  // a mean of others, which are asked themselves
  // In shear: what does not depend on how compressible the material is.
  return input::odd_material(
      material.name, 3.0 * material.D(3, 3), material.density,
      of_deck ? "a deck is taken in m, kg, s unless [geometry] unit says otherwise (unit = "
                "\"mm\", or --unit-system mm-t-s)"
              : "");
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
