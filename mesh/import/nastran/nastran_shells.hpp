// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "mesh/import/nastran/nastran_deck.hpp"

/// Shells of a Nastran deck (CQUAD4, CQUADR, CTRIA3, CTRIAR, CQUAD8, CTRIA6) with PSHELL and PCOMP.
namespace flexura::mesh {

class NastranShells {
 public:
  explicit NastranShells(NastranDeck& deck) : deck_(deck) {}

  void read();

 private:
  struct ShellLayer {
    Index material;
    double thickness, angle;  ///< from the element's first material axis [rad]
  };
  struct ShellProperty {
    Index material;
    double thickness, extra_mass_per_area;
    double angle = 0,
           height = 0;  ///< from the element's first material axis; of the middle over the element's
    std::vector<ShellLayer> layers = {};  ///< where they are unlike
  };
  ShellProperty shell_property(const Card& card);
  /// PCOMP; layers that are all of one material in one direction are one, as thick as all of them.
  ShellProperty layered_property(const Card& card);
  /// The axes of a shell card's material (columns, the third is the normal): along its THETA (from side 1-2) or the first axis
  /// of its MCID, in the field `place`.
  Eigen::Matrix3d axes_of_shell(const Card& card, const std::vector<Index>& nodes, std::size_t n_corners,
                                std::size_t place);
  Index material_along(Index material, const Eigen::Matrix3d& axes, double angle);
  /// Of the property of a shell card in its axes.
  Index material_of_shell(const ShellProperty& property, const Card& card, const std::vector<Index>& nodes,
                          std::size_t n_corners, std::size_t place);

  NastranDeck& deck_;
  std::map<std::pair<std::string, std::string>, Index> laminates_;  // by the property's name and the axes
};

}  // namespace flexura::mesh
