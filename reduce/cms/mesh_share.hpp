// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reduce/cms/reduction.hpp"

/// What the mesh costs in accuracy, by frequency and by interface, from the energies it leaves
/// (reduce/estimate/mesh_error.hpp).
///
/// A mesh makes the part too stiff.  With x the share of the energy that is error,
///
///     frequency:   f_h / f - 1 = (1 - x)^(-1/2) - 1,    x = y^T E y / (y^T K y) of the free body's mode y,
///     compliance:  1 - C_h / C = x,                     x = (C E C)_dd / C_dd,  C = K_kk^-1,
///
/// the latter of a direction d of an interface k while all others are held.  Exact for a single shape; x from 1 on
/// says no more than that the mesh does not resolve it.
namespace flexura::reduce {

struct MeshShare {
  struct Mode {
    double omega2;  ///< of the reduced free body [rad^2/s^2]
    double error;   ///< relative, of the frequency; infinite where the mesh does not resolve it
  };
  struct Interface {
    std::string name;
    double error;  ///< relative, of the static compliance in the worst direction; infinite likewise
  };
  std::vector<Mode> modes;            ///< the elastic ones, ascending
  std::vector<Interface> interfaces;  ///< where there are two or more
};

/// None where the mesh's error is not known.
std::optional<MeshShare> mesh_share(const Reduction& reduction);

}  // namespace flexura::reduce
