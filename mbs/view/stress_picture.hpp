// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/superelement/superelement.hpp"

namespace flexura::view {

/// Stresses on all vertices of a surface, from the stress modes of its superelement:
///
///     sigma(v) = sum_k S_k(v) u_se,k,    sigma_vM^2 = ((xx - yy)^2 + (yy - zz)^2 + (zz - xx)^2) / 2
///                                                     + 3 (xy^2 + yz^2 + zx^2)
///
/// A vertex for which none were kept (`groups` of the part file) has none (0).
class StressField {
 public:
  /// `se` needs its surface and stress modes and must outlive this object.
  explicit StressField(const superelement::Superelement& se);

  /// 6 n_v: xx, yy, zz, xy, yz, zx [Pa] of vertex 0, then of vertex 1, ...  What is round-off of the sum is
  /// zero: a rigid motion has no stress.
  Eigen::VectorXf components(const Eigen::Ref<const Eigen::VectorXd>& u_se) const;
  /// n_v [Pa]
  Eigen::VectorXf von_mises(const Eigen::Ref<const Eigen::VectorXd>& u_se) const;

 private:
  const superelement::StressModes& modes_;
  Eigen::Index n_vertices_;
};

}  // namespace flexura::view
