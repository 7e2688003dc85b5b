// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "mbs/bodies/modal_basis.hpp"

namespace flexura::mbs {

/// [Hz]
double frequency_of(double omega2);

/// Which eigenmodes the options keep, by their places from 0, ascending.  Modes without strain are always kept: they are no
/// approximation's to leave out.  `omega2` [rad^2/s^2], ascending; `shapes` gives the modes in superelement coordinates
/// (n_se x modes, phi^T M_se phi = 1), which effective masses take.  Throws BasisError.
std::vector<int> chosen_modes(const superelement::Superelement& se, const BasisOptions& options,
                              const Eigen::VectorXd& omega2, const std::function<Eigen::MatrixXd()>& shapes);

}  // namespace flexura::mbs
