// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/cad/assembly.hpp"
#include "import/cad/contacts.hpp"

/// Joints, proposed from what touches what.
///
/// 1. Two parts on one plane with two or more holes in common are bolted: fixed.
/// 2. Parts that are fixed to one another are one group. The contacts between two groups, all together, leave a freedom
///    (freedom.hpp): none joins the groups into one, others are the joint of that form.
/// 3. A pin, a body of revolution that runs in two or more groups on one axis, is fixed to the one that it fits tightest:
///    its spin moves nothing. A fastener, the same through two parts that are fixed already, is fixed to them.
/// 4. What screws into one another leaves a screw; a nut or bolt that touches others from one side only is tightened: fixed.
/// 5. Two groups that touch without holding each other from both sides in any direction make no joint, unless
///    one of them has no other.
namespace flexura::import::cad {

enum class Confidence { high, medium, low };
const char* name_of(Confidence confidence);

struct ProposedJoint {
  JointForm form;
  int a = -1, b = -1;  ///< instances that carry its markers
  Confidence confidence = Confidence::high;
  std::vector<std::string> evidence;       ///< one line for each pair of faces, or the rule
  std::string doubt;                       ///< why the confidence is not high
  std::vector<std::pair<int, int>> faces;  ///< (instance, face number) that it sits on
  int redundant = 0;                       ///< of its rows follow from those of the joints before it
};

/// Two bodies without a joint between them that come near each other, where and by which faces.
struct ContactCandidate {
  int a = -1, b = -1;  ///< instances
  int face_a = 0, face_b = 0;
  double distance = 0.0;  ///< [m]
  Vector3d place = Vector3d::Zero();
};

struct Proposal {
  int ground = -1;  ///< instance
  std::vector<ProposedJoint> joints;
  std::vector<std::string> doubts;           ///< pairs that are no joint and are to be looked at
  std::vector<ContactCandidate> candidates;  ///< the nearest first
  /// Degrees of freedom of the whole in this position; nothing where the groups are too many to be counted.
  std::optional<int> freedom;
};

struct ProposeOptions {
  double clearance = 2e-4;  ///< greatest gap between faces that touch [m]
  std::string ground;       ///< name of an instance; empty: the one with the largest box
};

/// `names`: of the instances, as the mechanism calls them. Throws std::invalid_argument where the named ground is not there
/// or not one.
Proposal propose(const Assembly& assembly, const std::vector<std::string>& names,
                 const ProposeOptions& options);

}  // namespace flexura::import::cad
