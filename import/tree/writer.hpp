// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>

#include "import/tree/start_mass.hpp"
#include "import/tree/tree.hpp"

namespace flexura::import::tree {

/// A tree as a mechanism: every link a body with the link's frame, every joint one between markers, what acts along its coordinate as force elements
/// and constraints beside it.  Readers add their own elements by the names that it gives.
class Writer {
 public:
  Writer(const Tree& tree, const StartMass& mass, Findings& findings);

  /// "ground" for -1.
  const std::string& body(int link) const;
  const std::string& joint(int j) const { return joint_names_[static_cast<std::size_t>(j)]; }
  /// "JOINT.angle" or "JOINT.position", of a joint of one coordinate.
  std::string coordinate(int j) const;
  std::string speed(int j) const { return joint(j) + ".speed"; }
  /// A new marker of the link; "BODY.NAME".
  std::string marker(int link, const std::string& wanted, const Pose& X_LM);
  /// [TABLE.NAME]; returns the name.
  std::string add(const std::string& table, const std::string& wanted, std::vector<std::string> comments,
                  std::vector<Line> lines);
  /// The inertia `size` along a sum of coordinates or along a formula of the motion: a rotor on the ground of this moment whose angle is that value.
  void add_rotor(const std::string& wanted, double size, const std::vector<std::pair<int, double>>& sum);
  void add_rotor_along(const std::string& wanted, double size, const std::string& formula);

  const Tree& tree() const { return tree_; }
  const StartMass& mass() const { return mass_; }
  Mechanism take() { return std::move(result_); }

 private:
  void add_body(const Link& link);
  void add_joint(std::size_t j);
  void add_forces(std::size_t j);
  void add_stop(std::size_t j);
  void add_forces_in_all_directions(std::size_t j);
  std::string add_rotor_body(const std::string& wanted, double size);

  const Tree& tree_;
  const StartMass& mass_;
  Findings& findings_;
  Mechanism result_;
  Names names_;
  std::vector<std::string> joint_names_;
  bool has_rotors_ = false;
};

}  // namespace flexura::import::tree
