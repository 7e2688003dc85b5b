// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// Superelements of FlexData files: frequencies and shapes of the free body's modes at its interface nodes, as MotionSolve's
/// Reference_FlexData holds them (mbs/superelement/exchange/exchange.hpp).
///
///     W = [ R  Phi ],   M_W = diag(M_rigid, 1),   K_W = diag(0, omega^2)
///
/// with Phi mass-normalised modes of the free body and R its rigid motions, brought to interface coordinates by
/// canonical_shapes (shape_change.hpp).  The format has no mass: it comes from the comment that `flexura export` writes, with all
/// inertia integrals, or from the part file.  Without the integrals those that do not follow from orthogonality (the stretch by
/// centrifugal forces) are zero, which is said.
namespace flexura::reduce {

struct FlexDataInput {
  std::string name, source, where;
  std::filesystem::path file;
  std::optional<int> id;                      ///< of the body, in a file of several
  double unit_length = 1.0, unit_mass = 1.0;  ///< of the file, in SI
  bool has_units = false;                     ///< these were given
  std::optional<double> mass;                 ///< [kg]
  std::optional<Eigen::Vector3d> centre;      ///< [m]
  std::optional<Eigen::Matrix3d> inertia;     ///< about the centre [kg m^2]
  std::vector<std::string> names;             ///< of the interface nodes; empty: the file's
};

}  // namespace flexura::reduce
