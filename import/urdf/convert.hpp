// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "import/model/mechanism.hpp"
#include "import/urdf/robot.hpp"

namespace flexura::import::urdf {

struct Choices {
  bool floating_base = false;              ///< the root floats free; otherwise it stands on the ground
  bool stops = true;                       ///< limits become bump stops
  std::vector<std::string> packages = {};  ///< "NAME=FOLDER" for package://NAME/...
  /// The surface of a STEP file [m]; throws std::invalid_argument or std::runtime_error.  Empty: such meshes are not read.
  std::function<Surface(const std::filesystem::path&)> read_cad = {};
};

/// The robot as a mechanism: every link a body with the link's frame, every joint a joint between markers whose
/// z axis is the URDF's axis, so that coordinates are those of the URDF. Limits become bump stops (a URDF has no stiffness
/// for them: one is chosen, and said), damping and friction forces on the coordinates, mimic a coupler, a
/// transmission an input "u_ACTUATOR" and a joint force within the limit's effort.
///
/// Throws std::invalid_argument where links that have no inertia move by themselves: the mass matrix in the
/// coordinates, H, would be singular at the start.
Mechanism to_mechanism(const Robot& robot, const Choices& choices);

/// H (n x n) at the start position in the coordinates of the movable joints in the order of `robot.order`, by composite bodies:
/// H_ij = S_i^T I_c S_j with the composite inertia I_c behind the outer one of i and j (Featherstone, Rigid Body Dynamics
/// Algorithms, section 6.2). `joint_of` names the joint of each coordinate. The root stands.
Eigen::MatrixXd start_mass_matrix(const Robot& robot, const std::vector<double>& q,
                                  std::vector<int>& joint_of);

/// Coordinate of every joint at the start: 0, the nearest limit where 0 is beyond it, what mimic asks for.
std::vector<double> start_coordinates(const Robot& robot);

}  // namespace flexura::import::urdf
