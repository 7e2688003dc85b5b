// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/cms/result/load_case.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/factor/factor_store.hpp"

/// What a reduction is asked for.
namespace flexura::linalg {
class Team;
}

namespace flexura::reduce {

/// Which shapes stand beside the interface dofs.
enum class ModeSet {
  craig_bampton,  ///< constraint modes and fixed-interface normal modes
  craig_chang,    ///< free-free modes and inertia-relief attachment modes (craig_chang.hpp)
  guyan,          ///< constraint modes only (R. J. Guyan, AIAA J. 3 (1965), 380)
};

enum class Eigensolver {
  block_lanczos,  ///< our own, on blocks of right-hand sides: the fast way
  krylov_schur,   ///< SLEPc's
};

/// How many interface modes (shapes/interface_modes.hpp): by number, up to a frequency (whichever asks for more), or to an accuracy of the static
/// stiffness between the interfaces.
struct InterfaceModesRequest {
  int count = 0;
  double omega_max = 0.0;  ///< [rad/s]
  double accuracy = 0.0;   ///< relative; instead of the others
  double tolerance = 1e-8;
};

struct ReductionOptions {
  ModeSet set = ModeSet::craig_bampton;
  int n_modes = 20;        ///< the lowest n ...
  double omega_max = 0.0;  ///< ... or all up to this [rad/s], whichever asks for more; clusters stay whole
  /// Instead of both: what it takes to have this relative accuracy up to omega_max (mode_choice.hpp).
  double accuracy = 0.0;
  double effective_mass = 0.0;  ///< or this fraction of the interior's mass and inertia
  int most_modes = 500;         ///< to reach accuracy or effective mass
  bool certify = false;         ///< count the modes by Sylvester's law; std::runtime_error if one is missing
  InterfaceModesRequest interface_modes = {.count = 20};  ///< of elastic ties, where there are any
  std::vector<double> response_omegas;                    ///< [rad/s]: response modes at these frequencies
  std::vector<LoadField> loads;
  double tolerance = 1e-9;  ///< relative residual of every mode
  Eigensolver eigensolver = Eigensolver::block_lanczos;
  std::vector<mesh::Index> shape_nodes;  ///< nodes at which shapes are wanted (the surface)
  bool all_nodes = false;                ///< fills Reduction::nodes
  bool estimate_error = true;
  bool estimate_mesh = false;             ///< fills Reduction::mesh
  bool stiffening = false;                ///< geometric stiffening terms
  std::vector<mesh::Index> stress_nodes;  ///< nodes at which stress modes are wanted
  const linalg::Team* team = nullptr;     ///< whose ranks share elements, factors and solves (serve())
  linalg::FactorStorage storage;          ///< of the factor; room for the eigensolver is added here
  linalg::Progress progress;
};

}  // namespace flexura::reduce
