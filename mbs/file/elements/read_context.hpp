// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "mbs/base/documents/document.hpp"
#include "mbs/kinematics/surface_mesh.hpp"
#include "mbs/kinematics/surface_patch.hpp"
#include "mbs/kinematics/touched_surface.hpp"
#include "mbs/mechanism/mechanism.hpp"

/// What the readers of joints, constraints, forces and measures need: names of the file become places in the
/// model. Every refusal is an InputError that names file, line and key.
namespace flexura::mbs {

class ReadContext {
 public:
  /// The body that a marker is on, of a beam in pieces that at its root, and where it stands there undeformed.
  using Undeformed = std::function<std::pair<int, Pose>(int marker)>;
  /// The part of a body's surface that an element's section names; its shapes come when the body is prepared.
  using Surface = std::function<std::shared_ptr<const SurfacePatch>(const input::Section&, int body)>;

  /// What may touch such a part of the surface of the body that a key names, likewise; `prefix`: before the names of the other keys.
  using Touched = std::function<std::shared_ptr<const TouchedSurface>(
      const input::Section&, const std::string& key, const std::string& prefix, int body)>;
  /// The whole surface of the body that a key names, likewise.
  using Mesh = std::function<std::shared_ptr<const SurfaceMesh>(const input::Section&, const std::string& key,
                                                                int body)>;

  /// `prefix` of a subsystem: names within it are found without.
  ReadContext(MechanismDescription& description, std::map<std::string, double> parameters, Curves tables,
              std::string prefix, Undeformed undeformed, Surface surface, Touched touched, Mesh mesh)
      : d_(description),
        parameters_(std::move(parameters)),
        tables_(std::move(tables)),
        prefix_(std::move(prefix)),
        undeformed_(std::move(undeformed)),
        surface_(std::move(surface)),
        touched_(std::move(touched)),
        mesh_(std::move(mesh)) {}

  /// The marker "body.marker" (or "body" for the body's own frame) that a key names.
  int marker(const input::Section& section, const std::string& key) const;
  /// The same for one entry `name` of a list.
  int marker_of(const input::Section& section, const std::string& key, const std::string& name) const;
  std::pair<int, Pose> undeformed(int marker) const { return undeformed_(marker); }
  std::shared_ptr<const SurfacePatch> surface(const input::Section& section, int body) const {
    return surface_(section, body);
  }
  std::shared_ptr<const TouchedSurface> touched(const input::Section& section, const std::string& key,
                                                const std::string& prefix, int body) const {
    return touched_(section, key, prefix, body);
  }
  std::shared_ptr<const SurfaceMesh> mesh(const input::Section& section, const std::string& key,
                                          int body) const {
    return mesh_(section, key, body);
  }
  /// The body that a key names.
  int body(const input::Section& section, const std::string& key) const;
  /// The joint that a key names.
  int joint(const input::Section& section, const std::string& key) const;
  /// The speed of a joint that two keys name; the second may be left out where the joint has one only.
  CoordinateRef speed(const input::Section& section, const std::string& joint_key,
                      const std::string& coordinate_key) const;
  /// Name ("joint.coordinate") and kind of a coordinate.
  CoordinateInfo coordinate_info(CoordinateRef c) const;
  /// What a force along a coordinate is: a torque along an angle, a force along a length.
  input::Dimension force_along(CoordinateRef c) const;
  /// The coordinate that `name` = "joint" (with one coordinate) or "joint.coordinate" means; `key` held it.
  CoordinateRef coordinate(const input::Section& section, const std::string& key,
                           const std::string& name) const;
  /// A formula of time, parameters, joint coordinates and measures.
  std::shared_ptr<const Expression> expression(const input::Section& section, const std::string& key) const;
  /// The same for one entry `formula` of a list.
  std::shared_ptr<const Expression> expression_of(const input::Section& section, const std::string& key,
                                                  const std::string& formula) const;
  /// The same whose comparisons are always as they are, not held between events.
  std::shared_ptr<const Expression> plain_expression(const input::Section& section,
                                                     const std::string& key) const;
  /// The formula of a measure that is nothing else; null for another.
  std::shared_ptr<const Expression> formula_of(const Measure& measure) const;
  /// The value of a formula of parameters.
  double number(const input::Section& section, const std::string& key) const;
  double number_of(const input::Section& section, const std::string& key, const std::string& formula) const;
  /// A formula of time and parameters that prescribes a motion.
  std::shared_ptr<const Expression> time_expression(const input::Section& section,
                                                    const std::string& key) const;
  /// The same, or one of signals (a control's states), known by their names once controls are read.
  std::shared_ptr<const Expression> motion_expression(const input::Section& section,
                                                      const std::string& key) const;
  std::shared_ptr<const Expression> motion_expression_of(const input::Section& section,
                                                         const std::string& key,
                                                         const std::string& formula) const;
  /// A formula of one signal, `name` or near to it, whose rate is `rate`: a new state.
  std::shared_ptr<const Expression> state_expression(const input::Section& section, const std::string& key,
                                                     const std::string& name,
                                                     std::shared_ptr<const Expression> rate,
                                                     double start) const;
  /// The same for an input, which moves nothing unless a formula reads it.
  std::shared_ptr<const Expression> input_expression(const input::Section& section,
                                                     const std::string& key) const;
  std::shared_ptr<const Expression> time_expression_of(const input::Section& section, const std::string& key,
                                                       const std::string& formula) const;

  /// Adds a measure that formulas read by its name from here on; refused where the name is taken.
  void add_measure(const input::Section& section, std::shared_ptr<const Measure> measure) const;

  /// The table that a key names.
  std::shared_ptr<const Curve> table(const input::Section& section, const std::string& key) const;

  const MechanismDescription& description() const { return d_; }
  /// Of the subsystem, before the names of its elements.
  const std::string& prefix() const { return prefix_; }

 private:
  MechanismDescription& d_;
  std::map<std::string, double> parameters_;
  Curves tables_;
  std::string prefix_;
  Undeformed undeformed_;
  Surface surface_;
  Touched touched_;
  Mesh mesh_;
};

/// The key "unit" of an element that gives a plain number: an SI unit for tables and plots.
input::Key unit_key(const std::string& of_what);
/// What it says; none without it.
input::Dimension read_unit(const input::Section& s);

}  // namespace flexura::mbs
