// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "import/sdf/reader.hpp"

namespace flexura::import::sdf {
namespace {

/// From the ground outwards, along the joints in their order.
class Spanning {
 public:
  Spanning(tree::Tree& tree, const std::vector<Pose>& X_WL)
      : tree_(tree),
        X_WL_(X_WL),
        reached_(tree.links.size(), false),
        used_(tree.joints.size(), false),
        at_(tree.links.size() + 1) {
    for (std::size_t j = 0; j < tree.joints.size(); ++j) {
      at_[static_cast<std::size_t>(tree.joints[j].parent + 1)].push_back(j);
      at_[static_cast<std::size_t>(tree.joints[j].child + 1)].push_back(j);
    }
  }

  void hold(int link, tree::JointKind kind) {
    const auto l = static_cast<std::size_t>(link);
    tree::Joint joint{.name = tree_.links[l].name + (kind == tree::JointKind::free ? "_free" : "_fixed"),
                      .kind = kind,
                      .child = link};
    (kind == tree::JointKind::free ? joint.X_FM : joint.X_PF) = X_WL_[l];
    order_.push_back(joint);
    reach_from(link);
  }

  bool reached(int link) const { return reached_[static_cast<std::size_t>(link)]; }

  void reach_from(int start) {
    if (start >= 0) reached_[static_cast<std::size_t>(start)] = true;
    std::vector<int> front = {start};
    for (std::size_t i = 0; i < front.size(); ++i)
      for (const std::size_t j : at_[static_cast<std::size_t>(front[i] + 1)]) {
        if (used_[j]) continue;
        used_[j] = true;
        tree::Joint joint = tree_.joints[j];
        joint.reversed = joint.child == front[i];
        const int outer = joint.outer();
        if (outer < 0 || reached(outer)) {
          joint.reversed = false;
          joint.closes_loop = true;
          loops_.push_back(joint);
          continue;
        }
        reached_[static_cast<std::size_t>(outer)] = true;
        order_.push_back(joint);
        front.push_back(outer);
      }
  }

  void finish() {
    order_.insert(order_.end(), loops_.begin(), loops_.end());
    tree_.joints = std::move(order_);
  }

 private:
  tree::Tree& tree_;
  const std::vector<Pose>& X_WL_;
  std::vector<bool> reached_, used_;
  std::vector<std::vector<std::size_t>> at_;  ///< joints at the ground and at each link
  std::vector<tree::Joint> order_, loops_;
};

}  // namespace

void span(tree::Tree& tree, const std::vector<bool>& stands, const std::vector<Pose>& X_WL, bool floating) {
  Spanning spanning(tree, X_WL);
  const int n = static_cast<int>(tree.links.size());
  std::vector<bool> is_child(tree.links.size(), false);
  for (const tree::Joint& joint : tree.joints)
    if (joint.child >= 0) is_child[static_cast<std::size_t>(joint.child)] = true;
  for (int l = 0; l < n; ++l)
    if (stands[static_cast<std::size_t>(l)]) spanning.hold(l, tree::JointKind::fixed);
  spanning.reach_from(-1);
  const auto kind = floating ? tree::JointKind::free : tree::JointKind::fixed;
  for (const bool roots : {true, false})  // of rings the first link
    for (int l = 0; l < n; ++l)
      if (!spanning.reached(l) && (!roots || !is_child[static_cast<std::size_t>(l)])) spanning.hold(l, kind);
  spanning.finish();
}

}  // namespace flexura::import::sdf
