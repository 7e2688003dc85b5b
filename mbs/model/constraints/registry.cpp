// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/constraints/types.hpp"
#include "mbs/model/user_library.hpp"

namespace flexura::mbs {

const std::vector<ConstraintType>& constraint_types() {
  static const std::vector<ConstraintType> types = {
      point_on_line_constraint(),   point_on_plane_constraint(), point_on_curve_constraint(),
      orientation_constraint(),     parallel_constraint(),       perpendicular_constraint(),
      distance_constraint(),        coupler_constraint(),        gear_constraint(),
      rack_and_pinion_constraint(), rolling_disc_constraint(),   user_constraint(),
  };
  return types;
}

}  // namespace flexura::mbs
