// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "mbs/superelement/superelement.hpp"

/// The pages: one HTML file each, which holds its data, its script and its style, opens from disk without a
/// network, and sums the deformation from mode shapes on the graphics card.  PAGE.md describes the data
/// inside and the object `flexura` that a page offers to scripts.
namespace flexura::view {

/// One line of the modes page.
struct PageMode {
  std::string set;          ///< "free", "held: big_end"; a page shows one set at a time
  int number = 0;           ///< as the mode table prints it
  std::string kind;         ///< "rigid", "elastic", "constraint", ...
  std::string detail = {};  ///< more of it, for its caption; may be empty
  bool vibrates = true;     ///< not a constraint mode, which has no frequency, damping and effective mass
  double frequency_hz = 0.0;
  double damping = 0.0;                       ///< ratio to critical
  std::array<double, 6> effective_mass = {};  ///< along x, y, z [kg], about x, y, z [kg m^2]
  /// The part file's `strike_modes` means this mode by its number: an elastic one of the free body.
  bool can_strike = false;
};

struct ModesPage {
  std::vector<PageMode> modes;
  Eigen::MatrixXd columns;  ///< n x n_modes: mode j moves the body by u_se = columns.col(j), in any scale
};

/// Writes the part with its interfaces and moving modes.  `se` needs its surface and shapes; with stress
/// modes the page colours by the von Mises stress as well. Memory: one mode at a time beside what `se` holds,
/// and its n x n Gram matrix for the MAC. Throws std::invalid_argument when there is nothing to draw, sizes
/// differ or a value is not finite, and std::runtime_error when the file cannot be written; then no file of
/// this name is left behind.
void write_modes_page(const std::filesystem::path& html, const superelement::Superelement& se,
                      const ModesPage& page);

/// What the bodies of a mechanism look like, by the bodies' names; bodies that share a file share the object.
using Pictures = std::map<std::string, std::shared_ptr<const superelement::Superelement>>;

/// Reads the superelements that the bodies of a results file name, relative to that file's folder.
/// Throws std::runtime_error, naming body, file and remedy, when one is not there.
Pictures read_pictures(const results::ModelHeader& model, const std::filesystem::path& results_file);

struct MotionPage {
  /// Quantities to plot at first, one plot for each entry; a comma puts several into one plot.  Empty: a
  /// choice by the page (energies, and the first quantities).
  std::vector<std::string> plots;
  /// The page keeps at most so many poses of each run, and so many numbers of all its quantities; longer runs
  /// are thinned evenly, and the page says so.
  int most_frames = 3000;
  double most_values = 4.0e6;
};

/// Writes the mechanism moving, its runs over one another, with plots of the stored quantities.
/// Bodies are drawn from their superelement's surface and from their primitive shapes (PAGE.md); one that has
/// neither is drawn as rods between its connections. Memory: one shape or history at a time beside what the
/// arguments hold. Throws std::invalid_argument when nothing was stored, a plot names an unknown quantity, a
/// shape is not understood or a superelement does not fit the results, and std::runtime_error when the file
/// cannot be written.
void write_motion_page(const std::filesystem::path& html, const results::Results& results,
                       const Pictures& pictures, const MotionPage& page = {});

}  // namespace flexura::view
