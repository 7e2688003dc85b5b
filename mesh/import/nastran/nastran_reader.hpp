// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "mesh/import/builder.hpp"
#include "mesh/import/imported.hpp"
#include "mesh/import/nastran/nastran_cards.hpp"
#include "mesh/import/nastran/nastran_systems.hpp"

namespace flexura::mesh {

/// One deck: cards by name, what they become, and what was passed over.  Materials, nodes, solids, ties and masses are
/// read in nastran.cpp, shells in nastran_shells.cpp, beams, rods and springs in nastran_bars.cpp.
class NastranReader {
 public:
  ImportedModel read(const std::filesystem::path& path);

 private:
  const std::vector<const Card*>& all(const std::string& name);
  void refuse_repeated() const;  ///< elements and properties of one number
  void read_materials();
  Index material(std::int64_t id, const Where& where) const;
  /// PARAM,WTMASS: all masses times it.  Read in the bulk data and in the case control of `path`.
  void read_parameters(const std::filesystem::path& path);
  void read_grids();
  static std::array<bool, 6> components(const std::string& digits, const Card& card);
  void read_solids();
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
  Index shell_material(std::int64_t id, const Where& where) const;
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
  void read_shells();

  static std::vector<Eigen::Vector2d> stress_points(const Card& card);
  // PBARL, PBEAML.
  ImportedBar shaped_section(const Card& card);
  // CROD with PROD, CONROD alone: stretch and, with J, torsion.
  void read_rods();
  void read_tubes();
  // One component of two nodes.  Between nodes that stand apart only stretch along their line leaves the body free to
  // turn.
  void add_scalar_spring(const Card& card, double stiffness, std::size_t first);
  // The vector of an orientation: a GRID or three numbers in these axes (columns).
  Eigen::Vector3d orientation(const Card& card, const Eigen::Vector3d& from, const Eigen::Matrix3d& axes);
  static std::string axes_of_vectors(const Card& card, const Card* defaults);
  void read_springs();
  void add_bush(const Card& card, const std::array<double, 6>& stiffness);
  ImportedBar section(std::int64_t property, const Card& bar);
  void read_bars();
  void read_ties();
  /// MPC of the set that the case control of `path` chooses, with MPCADD; RBAR.
  void read_constraints(const std::filesystem::path& path);
  void read_rigid_bars();
  void read_rbe1();
  /// Columns: the displacement axes of a GRID (CD).
  Eigen::Matrix3d axes_at(std::int64_t grid, const Where& where);
  void read_masses();
  /// The grids of a list that may say "1, THRU, 9".
  std::vector<std::int64_t> grid_list(const Card& card, std::size_t first);
  void read_dofs();
  /// Weights of RBE3 on rotations matter where nodes have some.
  void note_turning_weights();
  void finish();

  ImportedModel model_;
  ModelBuilder builder_;
  Unused unused_, approximated_;
  std::set<std::string> names_, used_;
  std::vector<Card> cards_;
  std::map<std::string, std::vector<const Card*>> by_name_;
  std::map<std::int64_t, Index> material_, property_, lamina_;      // lamina: MAT8
  std::map<std::pair<Index, std::string>, Index> turned_;           // materials along other axes
  std::map<std::pair<std::string, std::string>, Index> laminates_;  // by the property's name and the axes
  std::set<std::int64_t> bubbles_, no_scheme_;                      // PSOLID whose IN is BUBBLE, blank
  double mass_factor_ = 1;                                          // WTMASS
  NastranSystems systems_;
  std::map<Index, double> extra_mass_;  // of shells' NSM
  std::vector<std::pair<Index, Where>> turning_weights_;
};

}  // namespace flexura::mesh
