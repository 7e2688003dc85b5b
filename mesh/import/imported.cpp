// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/imported.hpp"

#include <cmath>
#include <stdexcept>

namespace flexura::mesh {

void scale_to_si(ImportedModel& model, double length, double mass, double time) {
  if (!(length > 0 && mass > 0 && time > 0))
    throw std::invalid_argument("units of length, mass and time must be greater than zero");
  const double area = length * length, stress = mass / (length * time * time);
  model.mesh.points *= length;
  for (CellBlock& shells : model.mesh.shells)
    for (auto* lengths : {&shells.thickness, &shells.offset})
      for (double& value : *lengths) value *= length;
  for (ImportedMaterial& material : model.materials) {
    material.E *= stress, material.G *= stress;
    material.rho *= mass / (area * length);
    for (const int k : {0, 1, 2, 6, 7, 8}) material.engineering[k] *= stress;  // 3 to 5 are Poisson's ratios
    material.stiffness *= stress;
    material.alpha /= time, material.beta *= time;
    for (ImportedPly& ply : material.plies) ply.thickness *= length;
  }
  for (ImportedMass& point : model.masses) {
    point.alpha /= time;
    point.mass *= mass;
    point.offset *= length;
    point.inertia *= mass * area;
  }
  for (ImportedSpring& spring : model.springs) {
    if (spring.at) *spring.at *= length;
    for (std::size_t k = 0; k < 6; ++k) {
      const double size = k < 3 ? mass : mass * area;
      spring.stiffness[k] *= size / (time * time);
      spring.damping[k] *= size / time;
    }
  }
  for (ImportedEquation& equation : model.equations)  // of displacements in lengths and of angles
    for (ImportedEquation::Term& term : equation.terms) term.row.tail<3>() *= length;
  for (ImportedBar& bar : model.bars) {
    for (Eigen::Vector3d& offset : bar.offset) offset *= length;
    bar.A *= area;
    bar.centroid *= length, bar.extra_mass_at *= length;
    for (Eigen::Vector2d& point : bar.outline) point *= length;
    for (double* second : {&bar.I_yy, &bar.I_zz, &bar.I_yz, &bar.J}) *second *= area * area;
    bar.extra_mass_per_length *= mass / length;
  }
}

}  // namespace flexura::mesh
