// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <map>

#include "mesh/import/nastran/nastran_cards.hpp"

/// Where the nodes of a Nastran deck are: GRID in coordinate systems that refer to each other and to GRIDs.
namespace flexura::mesh {

/// Rectangular, cylindrical (r, theta, z) or spherical (r, theta from z, phi), angles in degrees.
struct NastranSystem {
  char kind = 'R';
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< columns: the axes
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();

  Eigen::Vector3d place(const Eigen::Vector3d& x) const { return origin + R * rectangular(x); }
  Eigen::Vector3d rectangular(const Eigen::Vector3d& x) const;
  /// Columns: the directions 1, 2, 3 of displacements at a place of the basic system.
  Eigen::Matrix3d axes_at(const Eigen::Vector3d& x) const;
};

/// The cards are kept by address and must outlive it.
class NastranSystems {
 public:
  /// Takes CORD1R/C/S, CORD2R/C/S, GRID and GRDSET; leaves others alone.
  void add(const Card& card);

  /// Throws std::invalid_argument with file and line for systems that are missing, flat or refer to
  /// themselves.
  const NastranSystem& system(std::int64_t id, const Where& where, int depth = 0);
  /// Place of a GRID in the basic system.
  Eigen::Vector3d grid_place(std::int64_t id, const Where& where, int depth = 0);

  const std::map<std::int64_t, const Card*>& grids() const { return grid_cards_; }
  const Card* grdset() const { return grdset_; }

 private:
  std::map<std::int64_t, const Card*> system_cards_, grid_cards_;
  std::map<std::int64_t, NastranSystem> systems_;
  const Card* grdset_ = nullptr;
};

}  // namespace flexura::mesh
