// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/tangents/inertia_tangents.hpp"

namespace flexura::mbs {

/// Derivatives of the inverse dynamics by deformations: the blocks of bodies' own coordinates.
class ModeTangents {
 public:
  explicit ModeTangents(const Topology& tree) : tree_(tree) {}

  /// The modal blocks, see mode_tangents.cpp; before InertiaTangents::joint_columns().
  void mode_columns(const Motion& motion, Wrenches& wrenches, InertiaVariations& variations,
                    Eigen::MatrixXd& z_q, Eigen::MatrixXd& z_v) const;
  /// z_c of deformations that do not act back, by themselves.
  void following_columns(const Motion& motion, Wrenches& wrenches, InertiaVariations& variations,
                         Eigen::MatrixXd& z_c) const;

 private:
  void vary_nodes(int body, const Motion& motion, const Wrenches& wrenches, InertiaVariations& variations,
                  Eigen::MatrixXd& z_q) const;

  const Topology& tree_;
};

}  // namespace flexura::mbs
