// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/interface_modes.hpp"
#include "reduce/cms/load_case.hpp"
#include "reduce/cms/reduction.hpp"
#include "reduce/linalg/eigen_problem.hpp"

/// Craig-Bampton reduction (R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968), 1313).
///
///     Psi = -K_ii^-1 K_ib                      constraint modes, one for each boundary dof
///     K_ii phi = omega^2 M_ii phi              fixed-interface normal modes, Phi^T M_ii Phi = 1
///     T = [ 1 0 ; Psi Phi ],   K_se = diag(K_bb + K_bi Psi, Omega^2),   M_se = T^T M T
///
/// Averaging ties (tied_model.hpp) enter as A Psi = 1 on their dofs, A Phi = 0; K_bb then gains minus the
/// reactions.  Elastic ties are rigid for Psi and Phi and add interface modes (interface_modes.hpp); the
/// basis of all is brought to the form of shape_change.hpp.
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
  bool estimate_error = true;
  bool estimate_mesh = false;             ///< fills Reduction::mesh_error
  bool stiffening = false;                ///< geometric stiffening terms
  std::vector<mesh::Index> stress_nodes;  ///< nodes at which stress modes are wanted
  const linalg::Team* team = nullptr;     ///< whose ranks share elements, factors and solves (serve())
  linalg::FactorStorage storage;          ///< of the factor; room for the eigensolver is added here
  linalg::Progress progress;
};

/// Reduces a part with any set of modes.  Needs a linalg::Session.  Throws std::invalid_argument for parts
/// that cannot be reduced (see TiedModel, TiedSolver) and std::runtime_error when a computation fails.
Reduction craig_bampton(const Part& part, const ReductionOptions& options);

/// The fixed-interface eigenproblem of a model and its solver, which must outlive it.
linalg::EigenProblem fixed_interface_problem(const TiedModel& model, const TiedSolver& solver);

/// Peak resident memory of this process [bytes].
double peak_memory();

}  // namespace flexura::reduce
