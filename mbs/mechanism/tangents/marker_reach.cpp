// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/tangents/marker_reach.hpp"

namespace flexura::mbs {

void MarkerReach::size(int n_v) {
  twist.setZero(6, n_v);
  D.setZero(6, n_v);
  rigid.setZero(6, n_v);
  list.reserve(n_v);
}

void ReachMarks::collect(std::initializer_list<const MarkerReach*> reaches, std::vector<int>& out) {
  out.clear();
  ++marks_;
  for (const MarkerReach* reach : reaches)
    for (std::size_t k = 0; reach && k < reach->n_own; ++k) {
      const int j = reach->list[k];
      if (mark_[j] == marks_) continue;
      mark_[j] = marks_;
      out.push_back(j);
    }
}

int MarkerReaches::base_of(std::initializer_list<int> markers) const {
  const auto depth = [&](int body) { return inertia_.bodies[body].depth; };
  int base = -1;
  for (const int marker : markers) {
    if (marker < 0) return 0;
    int b = tree_.d.markers[marker].body;
    if (base < 0) base = b;
    while (base != b) {
      int& outer = depth(base) > depth(b) ? base : b;
      outer = tree_.bodies[outer].parent;
    }
  }
  return base;
}

void MarkerReaches::reach(int marker, const Vector3d& point, int base, MarkerReach& out) const {
  for (const int j : out.list) {
    out.twist.col(j).setZero();
    out.D.col(j).setZero();
    out.rigid.col(j).setZero();
  }
  out.list.clear();
  out.n_own = 0;
  if (marker < 0) return;
  const InertiaVariations& T = inertia_;
  bool own = true;
  for (int b = tree_.d.markers[marker].body, child = -1; b != 0; child = b, b = tree_.bodies[b].parent) {
    const TreeBody& t = tree_.bodies[b];
    const Vector3d from_origin = point - T.bodies[b].origin;
    const auto take = [&](int j) {
      const Vector6d phi = shift_twist(Spatial::from(T.phi.col(j)), from_origin).vector();
      out.twist.col(j) += phi;
      out.rigid.col(j) += phi;
      out.D.col(j) += shift_twist(Spatial::from(T.D.col(j)), from_origin).vector();
      out.list.push_back(j);
    };
    const int through = child < 0 ? marker : tree_.bodies[child].marker_in;
    for (int l = 0; l < t.m; ++l) {
      const int j = t.i_v + l;
      if (tree_.is_carried[through]) {
        const InertiaVariations::MovedNode& node = T.markers[through];
        out.twist.col(j) = shift_twist(Spatial::from(node.eta.col(l)), from_origin).vector();
        out.D.col(j) = shift_twist(Spatial::from(node.D.col(l)), from_origin).vector();
        if (child >= 0) out.rigid.col(j) = out.twist.col(j);
      }
      take(j);
    }
    if (b == base) {
      own = false;
      out.n_own = out.list.size();
    }
    for (int j = tree_.places[t.joint].i_v; j < t.i_v; ++j) take(j);
  }
  if (own) out.n_own = out.list.size();
}

}  // namespace flexura::mbs
