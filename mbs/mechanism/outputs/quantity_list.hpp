// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/mechanism/elements/constraint_rows.hpp"

namespace flexura::mbs {

/// Something that can be stored by name: what it is, of which joint, body, element (`index`), and which of its numbers.
struct Quantity {
  enum class Kind {
    coordinate,
    speed,
    acceleration,
    reaction,
    drive,
    body_position,
    body_velocity,
    body_acceleration,
    mode,
    strain_energy,
    largest_stress,
    largest_strain,
    point_stress,
    section_force,
    surface_point,
    largest_displacement,
    measure,
    contact,
    input,
    control,
    force,
    constraint,
    momentum,
    energy
  };
  static constexpr int kOfPoint = 13;  ///< numbers of a point_stress: six stresses, von Mises', six strains

  OutputInfo info;
  Kind kind;
  int index, component;
  bool usual;  ///< stored when the user does not say which
};

/// Everything that a mechanism can store: coordinates, reactions, bodies, stresses, measures, elements, momenta, energies.
std::vector<Quantity> list_quantities(const Topology& tree, const ConstraintRows& rows, int n_algebraic);

}  // namespace flexura::mbs
