// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/kinematics/kinematics.hpp"
#include "mbs/mechanism/description/mechanism_description.hpp"

/// Which joints span the tree, and where the coordinates of all bodies stand in p, v and c.
namespace flexura::mbs {

/// A body in the tree.
struct TreeBody {
  int parent = -1;
  int joint = -1;         ///< index in description().joints
  bool reversed = false;  ///< the parent carries the joint's M
  int marker_in = -1;     ///< the joint's marker on the parent
  int marker_out = -1;    ///< the joint's marker on this body
  int i_p = 0, i_v = 0;   ///< coordinates of its deformation (after those of the joint)
  int m = 0;              ///< their number; 0 where it is rigid or the deformation does not act back
  int i_c = -1;  ///< of a deformation that does not act back: its coordinates, then their rates, in c
  /// What the deformation needs in Work::r: m numbers at i_v, or of one that does not act back behind those of all
  /// velocities.
  int i_need = 0, n_need = 0;
};

/// Constant once it is built.
class Topology {
 public:
  /// Throws std::invalid_argument with one sentence for a description that is no mechanism.
  explicit Topology(MechanismDescription description);
  Topology(const Topology&) = delete;
  Topology& operator=(const Topology&) = delete;

  /// With the joints of free bodies, and with joints cut that long branches were split at.
  MechanismDescription d;
  std::vector<TreeBody> bodies;
  std::vector<int> order;        ///< bodies outwards, without ground
  std::vector<int> whole_order;  ///< the same before long branches were split; empty where none was
  std::vector<int> split_joint;  ///< of a body whose branch begins there: the joint that led to it, or -1
  std::vector<JointPlace> places;
  std::vector<std::vector<int>> markers_of_body;
  std::vector<char> on_node;     ///< of each marker: it stands on a node of a deformation,
  std::vector<char> is_carried;  ///< which moves it
  int n_p = 0, n_v = 0, n_flx = 0;
  int n_need = 0;  ///< n_v and the coordinates of deformations that do not act back
  int n_own = 0;   ///< dynamic states of controls and forces, the first in c
  int n_dyn = 0;   ///< with those of deformations that do not act back, which come last

  bool is_reversed(int joint) const;
  const FlexibleBody* flexible(int body) const { return d.bodies[body].flexible.get(); }

 private:
  void build_tree();
  void grow_tree();
  bool split_branches();
  void place_joint(int body, int joint, bool reversed);
  void number_states();
};

}  // namespace flexura::mbs
