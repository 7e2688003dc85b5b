// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/bodies/body_node.hpp"
#include "mbs/bodies/particle_acceleration.hpp"

namespace flexura::mbs {

/// What stresses a body and so changes its stiffness, as superelement::StiffeningTerms have it: acceleration less gravity,
/// angular acceleration, products of spins, forces on the interface dofs, factors of the load cases.
class StiffeningLoads {
 public:
  static constexpr Eigen::Index kOfMotion = 12;

  StiffeningLoads() = default;
  /// `nodes` of the body; those on its surface carry none, and without nodes forces are not known.
  StiffeningLoads(const superelement::Superelement& se, const std::vector<BodyNode>& nodes)
      : to_interfaces_(Eigen::MatrixXd::Zero(se.n_b, 6 * static_cast<Eigen::Index>(nodes.size()))),
        n_cases_(static_cast<Eigen::Index>(se.load_cases.size())) {
    for (std::size_t k = 0; k < nodes.size(); ++k)
      if (nodes[k].is_on_interfaces)
        to_interfaces_.middleCols<6>(6 * static_cast<Eigen::Index>(k)) =
            nodes[k].rows.leftCols(se.n_b).transpose();
  }

  Eigen::Index size() const { return kOfMotion + to_interfaces_.rows() + n_cases_; }
  /// `factors` of the load cases; null: none acts.
  Eigen::VectorXd at(const BodyMotion& motion, const double* factors) const {
    const Vector3d& w = motion.w;
    Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
    out.head<kOfMotion>() << motion.a, motion.alpha, w.cwiseAbs2(), w.x() * w.y(), w.y() * w.z(),
        w.z() * w.x();
    if (motion.on_nodes.size() == to_interfaces_.cols())
      out.segment(kOfMotion, to_interfaces_.rows()) = to_interfaces_ * motion.on_nodes;
    if (factors && n_cases_ > 0) out.tail(n_cases_) = Eigen::Map<const Eigen::VectorXd>(factors, n_cases_);
    return out;
  }

 private:
  Eigen::MatrixXd to_interfaces_;  // n_b x 6 nodes
  Eigen::Index n_cases_ = 0;
};

}  // namespace flexura::mbs
