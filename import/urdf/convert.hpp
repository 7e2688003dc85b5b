// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "import/model/findings.hpp"
#include "import/model/mechanism.hpp"
#include "import/urdf/robot.hpp"

namespace flexura::import::urdf {

/// What becomes of joints that move nothing with inertia, so that their acceleration would be anything.
enum class Massless {
  derive,      ///< the links behind get the inertia of their shapes; where there are none, as kinematics
  kinematics,  ///< a drive holds the joint at its start and can prescribe its motion
  refuse
};

struct Choices {
  bool floating_base = false;  ///< the root floats free; otherwise it stands on the ground
  bool stops = true;           ///< limits become bump stops
  bool controllers = false;    ///< every motor follows a target by a PD law
  bool contacts = false;       ///< collision shapes of links that move touch the floor (contacts.hpp)
  Massless massless = Massless::derive;
  double density = 1000.0;                 ///< of shapes that give a link its inertia [kg/m^3]
  std::vector<std::string> packages = {};  ///< "NAME=FOLDER" for package://NAME/...
  /// The surface of a STEP file [m]; throws std::invalid_argument or std::runtime_error.  Empty: such meshes are not read.
  std::function<Surface(const std::filesystem::path&)> read_cad = {};
};

/// The robot as a mechanism: every link a body with the link's frame, every joint a joint between markers whose
/// z axis is the URDF's axis, so that coordinates are those of the URDF. Limits become bump stops (a URDF has no stiffness
/// for them: one is chosen, and said), damping and friction forces on the coordinates, mimic a coupler, a
/// transmission an input "u_ACTUATOR" and a joint force within the limit's effort.  Joints without travel are fixed.
///
/// Throws Faults where links that have no inertia move by themselves and that is to be refused: the mass matrix in the
/// coordinates, H, would be singular at the start.
Mechanism to_mechanism(Robot robot, const Choices& choices, Findings& findings);

}  // namespace flexura::import::urdf
