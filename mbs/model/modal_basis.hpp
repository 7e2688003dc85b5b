// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <optional>

#include "mbs/model/flexible_body.hpp"
#include "mbs/superelement/superelement.hpp"

/// From a superelement to a body's modal coordinates (theory: UM eq. 11.4, 11.5; mean-axis frame of
/// Tisserand).
///
/// The free-free modes of the superelement, K_se y = omega^2 M_se y, without its six rigid motions R: sought
/// among the vectors M_se-orthogonal to R, so that
///
///     Y^T M_se Y = 1,   Y^T K_se Y = Omega^2,   R^T M_se Y = 0     (C_t = 0 and C_r = 0 at s = 0)
///
/// With all n - 6 of them the body deforms exactly as the superelement does; a truncated basis is stiffer
/// under loads at its interfaces than the superelement.
namespace flexura::mbs {

struct BasisOptions {
  int modes = std::numeric_limits<int>::max();                     ///< keep at most so many, lowest first
  double max_frequency = std::numeric_limits<double>::infinity();  ///< [Hz], keep none above
  std::optional<double> damping;  ///< ratio for all modes; without it that of the superelement, or its D_se
};

struct BasisReport {
  int available = 0;
  int kept = 0;
  double lowest_hz = 0.0, highest_hz = 0.0;  ///< of the kept ones
  double first_dropped_hz = 0.0;             ///< 0 when all are kept
};

/// Throws std::invalid_argument when the superelement cannot carry its rigid motions or keeps no mode.
ModalData modal_data(const superelement::Superelement& se, const BasisOptions& options = {},
                     BasisReport* report = nullptr);

/// The integrals with the columns of Y in place of the shapes.
superelement::InertiaIntegrals transform(const superelement::InertiaIntegrals& integrals,
                                         const Eigen::MatrixXd& Y);

/// The body of fidelity "rigid": mass, centre and inertia of the undeformed superelement.
RigidInertia rigid_inertia(const superelement::Superelement& se);

}  // namespace flexura::mbs
