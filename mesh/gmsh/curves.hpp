// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

/// Curves of CAD files and gmsh models as straight pieces, for beam members.
namespace flexura::mesh {

struct CurveOptions {
  std::filesystem::path path;  ///< STEP, IGES, BREP; gmsh's .geo or .msh
  std::string unit;            ///< overrides what the file says; gmsh files have none: m
  double turn = 0.0873;        ///< greatest angle between neighbouring pieces of a curve [rad]
  double time_limit_s = 120;
  bool run_scripts = false;      ///< take .geo files, which gmsh runs
  std::filesystem::path worker;  ///< the child program; empty = flexura-mesh beside this program or in PATH
};

struct CurvePiece {
  int first = -1, second = -1;  ///< points
  int curve = 0;                ///< number of the curve in the file
};

struct CurveGroup {
  std::string name;
  std::vector<int> curves;
};

struct CurveSet {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> points;  ///< n x 3 [m], each place once
  std::vector<CurvePiece> pieces;  ///< by curves, along each; a straight curve is one piece
  std::vector<CurveGroup> groups;  ///< physical groups of gmsh models; unnamed ones are called "group 7"
};

/// Ends that lie within 1e-6 of the model's size of each other are one point.  Pieces of bent curves have
/// their ends on the curve, so their length is short by turn^2 / 24.  Line elements of .msh files are taken
/// as they are.  Throws std::invalid_argument for what cannot be read, holds no curves, or holds faces or
/// solids in a CAD file (whose edges are no members), and for a script that may not run.
CurveSet read_curves(const CurveOptions& options);

}  // namespace flexura::mesh
