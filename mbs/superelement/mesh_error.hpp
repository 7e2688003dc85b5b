// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace flexura::superelement {

/// What the mesh of the reduction costs in accuracy, estimated from one mesh (docs/theory/mesh_error.md).  Errors are relative;
/// 1 means that the mesh does not resolve what is asked, -1 that it is not known.
struct MeshError {
  struct Stress {
    double mean =
        -1.0;  ///< of the elements' own stresses, root mean square over the part in the measure of energy
    double peak = -1.0;  ///< of the greatest stress at a vertex where it is finite
    int vertex = -1;     ///< of the surface: where that is
    /// The greatest stress lies at a re-entrant corner or the edge of a rigid tie, where that of an elastic body is unbounded
    /// and what a mesh gives grows with its fineness.
    bool singular = false;
    bool operator==(const Stress&) const = default;
  };
  struct Mode {  ///< elastic, of the free body, ascending
    double frequency_hz = 0.0, error = -1.0;
    Stress stress = {};
    bool operator==(const Mode&) const = default;
  };
  struct Interface {
    std::string name;
    double compliance_error = -1.0;  ///< in the worst direction while all others are held
    Stress stress = {};              ///< under its loads, of the worst
    bool operator==(const Interface&) const = default;
  };
  bool rough = false;  ///< by recovered stresses alone, to a factor of five
  std::vector<Mode> modes;
  std::vector<Interface> interfaces;  ///< where there are two or more
  /// n_v or empty: the error of stress in the elements at each vertex of the surface over the root mean square of the stress
  /// in the part, of the mode or load for which it is greatest; both in the measure of energy.
  Eigen::VectorXf at_vertices;
};

}  // namespace flexura::superelement
