// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "beam/element/element.hpp"
#include "beam/section/shapes.hpp"

/// A structure of beams as the user states it: nodes, members between them, sections, point masses.
/// Lengths in m, everything expressed in the part's frame B, indices from 0.
namespace flexura::beam {

struct Node {
  std::string name;
  Eigen::Vector3d p_BoN_B = Eigen::Vector3d::Zero();
};

/// A section as members use it.  `shape` is kept so that a member can taper between two of the same kind.
struct SectionEntry {
  Section section;
  std::optional<Shape> shape;
  std::optional<ShearFormula> formula;
  /// Without a shape: (sigma_xx, tau_xy, tau_xz) by the resultants at each point of the outline; empty: not known.
  std::vector<Eigen::Matrix<double, 3, 6>> outline_stress = {};
};

struct MemberEnd {
  int node = -1;
  Eigen::Vector3d offset_B = Eigen::Vector3d::Zero();  ///< rigid, from the node to the member's end
  std::bitset<6> released;    ///< u, v, w, theta_x, theta_y, theta_z of the member's axes
  bool warping_free = false;  ///< the joint lets the end warp (no warning)
};

struct Member {
  std::string name;
  std::array<MemberEnd, 2> end;
  int section = -1;
  int section_at_end = -1;  ///< tapered: the section at end 2; -1: uniform
  Theory theory = Theory::timoshenko;
  std::optional<Eigen::Vector3d> direction_B;  ///< points to the side of +y (width)
  int direction_node = -1;  ///< instead: the third node, in the x-y plane on the side of +y
  int elements = 0;         ///< 0: by the rule of Subdivision
};

struct PointMass {
  int node = -1;
  double mass = 0.0;                                 ///< [kg]
  Eigen::Vector3d p_NC_B = Eigen::Vector3d::Zero();  ///< node to centre of mass [m]
  Eigen::Matrix3d I_C_B = Eigen::Matrix3d::Zero();   ///< about the centre of mass [kg m^2]
};

struct Model {
  std::vector<Node> nodes;
  std::vector<SectionEntry> sections;
  std::vector<Member> members;
  std::vector<PointMass> point_masses;
  std::vector<int> anchors;  ///< nodes tied to something else (solids): a part that holds one may stand apart
};

/// How members are divided into elements.  The finest of the rules counts.
struct Subdivision {
  int elements_per_member = 1;
  double max_length = std::numeric_limits<double>::infinity();  ///< [m]
  double max_frequency_hz = 0.0;                                ///< resolve waves up to here; 0: no rule
  double frequency_error = 1e-3;                                ///< relative error wanted at max_frequency
};

/// Refuses what cannot be computed, with std::invalid_argument naming node or member, value, rule and remedy:
/// indices out of range, a node no member uses, members in separate parts, zero length, a direction parallel
/// to the axis, a taper between different kinds, a negative mass, an inertia no body can have, releases by which a member slides or
/// spins by itself.
void check(const Model& model);

/// Warnings in sentences: a mechanism that releases leave (mechanism.hpp); members of open thin-walled section whose ends cannot warp freely and which are not
/// long against the decay length sqrt(E I_w / (G I_t)); a 12-dof element twists too much there.  `fixed`
/// lists nodes held or tied from outside (interfaces).
std::vector<std::string> warnings(const Model& model, const std::vector<int>& fixed);

/// Axes and length of a member.
Placement placement_of(const Model& model, const Member& member);

/// Elements a member needs for the rule.  For a target error e the element length h obeys, with the wave
/// numbers k of the member's free waves at max_frequency: linear elements (stretch, torsion) (k h)^2 / 24 <=
/// e, bending (k h)^4 / 720 <= e (Euler-Bernoulli), and (k h)^2 phi / 24 <= e for the shear part phi = EI k^2
/// / (G A_s).
int elements_of(const Model& model, const Member& member, const Subdivision& rule);

}  // namespace flexura::beam
