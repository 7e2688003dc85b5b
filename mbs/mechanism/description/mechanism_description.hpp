// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mbs/bodies/flexible_body.hpp"
#include "mbs/bodies/modal_data.hpp"
#include "mbs/bodies/section_points.hpp"
#include "mbs/bodies/stress_field.hpp"
#include "mbs/bodies/surface_points.hpp"
#include "mbs/constraints/constraint.hpp"
#include "mbs/constraints/rotation_drive.hpp"
#include "mbs/controls/control.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/joints/joint.hpp"
#include "mbs/measures/measure.hpp"
#include "mbs/superelement/superelement.hpp"

/// What a mechanism is made of, before it is one: bodies, markers, joints and elements by their indices.
namespace flexura::mbs {

struct MarkerDescription {
  std::string name;  ///< "crank.pin"
  int body = 0;      ///< 0 is ground
  Pose X_BP;         ///< in the undeformed body; on a node: relative to the node
  int node =
      -1;  ///< of a flexible body: loads here deform it, and where the deformation acts back it moves the marker
};

struct BodyDescription {
  std::string name;
  RigidInertia inertia = {};                           ///< of a rigid body
  std::shared_ptr<const FlexibleBody> flexible = {};   ///< or this
  std::shared_ptr<const StressField> stress = {};      ///< of a deforming body
  std::shared_ptr<const SectionPoints> sections = {};  ///< of a deforming beam part
  std::shared_ptr<const SurfacePoints> surface_points = {};
  std::optional<Pose> X_WB = {};  ///< guess for the assembly, in [m]
  std::string superelement = {};  ///< file, for pictures
  /// Of a beam that is rigid or deforms in modal coordinates: its small deformations (beam_superelement.hpp).
  std::shared_ptr<const superelement::Superelement> of_beam = {};
  /// What deforms is described by a superelement, whatever its fidelity.
  bool is_reduced() const { return of_beam || !superelement.empty(); }
  bool follows_surface = false;      ///< markers follow nodes of the superelement's surface
  std::vector<BodyLoad> loads = {};  ///< load cases of its superelement
  bool is_loaded_by_case = false;    ///< a force puts one of them on it
  std::string shape_json = {};       ///< primitive shapes, for pictures
};

struct JointDescription {
  std::string name;
  std::shared_ptr<const Joint> joint;
  int marker_F = -1, marker_M = -1;
  bool cut = false;           ///< keep out of the tree
  bool keep_in_tree = false;  ///< even in a long branch, see split_branches.cpp
  bool splits = false;        ///< the program cut it there
  bool bends = false;         ///< between pieces of a beam: its coordinates are deformations
  /// The program decides what it becomes: a joint of the tree where one is needed, the one with the fewest
  /// freedoms first, else a constraint; its initial values are then of no account.
  bool is_connection = false;
  std::map<int, double> initial_coordinates;  ///< by index
  std::map<int, double> initial_speeds;
  /// Coordinates, by the index of their speeds, as formulas of time.
  std::map<int, std::shared_ptr<const Expression>> drives;
  std::map<int, std::shared_ptr<const Expression>> speed_drives,
      acceleration_drives;                           ///< the same of its rates
  std::optional<PrescribedRotation> rotation_drive;  ///< of a joint with a quaternion
  bool is_driven() const {
    return !drives.empty() || !speed_drives.empty() || !acceleration_drives.empty() || rotation_drive;
  }
  /// What is driven, by speeds: a rotation, then coordinates of `drives`.
  std::vector<int> driven() const;
  /// Where the coordinate whose rate this speed is stands among coordinates.
  int coordinate_of_speed(int speed) const { return speed + joint->n_p() - joint->n_v(); }
  /// "angle", "x"; of a ball's rotation "omega_x".
  std::string driven_name(int speed) const;
  /// What the drive of a coordinate exerts, as results name it: "drive_force", of several "drive_force_angle".
  std::string drive_force_name(int speed) const;
};

/// A formula of the motion.
struct FormulaDescription {
  std::shared_ptr<const Expression> expression;
  bool drives = false;  ///< prescribes a motion, by t alone
};

/// An input u of the mechanism: a function of time that formulas read by its name.
struct InputDescription {
  std::string name;
  std::shared_ptr<const Expression> value;
};

struct MechanismDescription {
  std::string name;
  Vector3d gravity = Vector3d::Zero();  ///< in W [m/s^2]
  std::vector<BodyDescription> bodies{{.name = "ground"}};
  std::vector<MarkerDescription> markers;
  std::vector<JointDescription> joints;
  std::vector<std::shared_ptr<const Constraint>> constraints;
  std::vector<std::shared_ptr<const ForceElement>> forces;
  std::vector<std::shared_ptr<const Measure>> measures;
  std::vector<std::shared_ptr<const Control>> controls;
  std::vector<InputDescription> inputs;
  /// Of inputs and controls, by name, where it is given; formulas are computed in SI all the same.
  std::map<std::string, input::Dimension> units;
  /// Formulas that forces, controls, measures and drives are made of.
  std::vector<FormulaDescription> formulas;
  /// What formulas may read: "t", then any "joint.coordinate", "joint.speed", "measure" they name.
  SignalNames signals;

  int add_body(BodyDescription body);
  int add_marker(int body, const std::string& name, const Pose& X_BP = {}, int node = -1);
  int add_joint(const std::string& name, const std::string& type, int marker_F, int marker_M);

  /// Where a marker stands in its undeformed body.
  Pose undeformed(int marker) const;
  /// Takes a body's deformation away: what is left moves as a rigid body.
  void make_rigid(int body);
};

}  // namespace flexura::mbs
