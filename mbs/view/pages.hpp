// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "mbs/superelement/superelement.hpp"

/// The pages: one HTML file each, which holds its data, its script and its style, opens from disk without a
/// network, and sums the deformation from mode shapes on the graphics card.  PAGE.md describes the data
/// inside and the object `flexura` that a page offers to scripts.
namespace flexura::view {

/// One line of the modes page.
struct PageMode {
  int number = 0;    ///< as the mode table prints it
  std::string kind;  ///< "rigid", "elastic", "constraint", ...
  double frequency_hz = 0.0;
  double damping = 0.0;                       ///< ratio to critical
  std::array<double, 6> effective_mass = {};  ///< along x, y, z [kg], about x, y, z [kg m^2]
};

struct ModesPage {
  std::vector<PageMode> modes;
  Eigen::MatrixXd columns;  ///< n x n_modes: mode j moves the body by u_se = columns.col(j), in any scale
};

/// Writes the part with its interfaces and moving modes.  `se` needs its surface and shapes.
/// Memory: one mode at a time beside what `se` holds, and its n x n Gram matrix for the MAC.
/// Throws std::invalid_argument when there is nothing to draw, sizes differ or a value is not finite, and
/// std::runtime_error when the file cannot be written; then no file of this name is left behind.
void write_modes_page(const std::filesystem::path& html, const superelement::Superelement& se,
                      const ModesPage& page);

}  // namespace flexura::view
