// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mbs/bodies/body_load.hpp"
#include "mbs/bodies/body_node.hpp"
#include "mbs/bodies/modal_damping.hpp"
#include "mbs/bodies/modal_data.hpp"
#include "mbs/superelement/superelement.hpp"

/// From a superelement to a body's modal coordinates (theory: UM eq. 11.4, 11.5; Simpack's modal approach).
///
/// 1. Eigenmodes under the boundary condition that the body's joint gives, K_se y = omega^2 M_se y with
///    h^T y = 0 for every held direction h, without the rigid motions that the condition leaves.  Without
///    held directions they are the free-free modes.
/// 2. Frequency response modes for unit loads p of the joints and forces that act on the body,
///
///        (K_se - Omega_0^2 M_se) phi = p - M_se R (R^T M_se R)^-1 R^T p,     R^T M_se phi = 0,
///
///    R the rigid motions: attachment modes with inertia relief for Omega_0 = 0.  With them the body gives
///    way under its interface loads as the superelement does, whatever eigenmodes were dropped.
/// 3. The frame: a rigid motion is taken from each so that R^T M_se y = 0 (mean axes, Tisserand), so that one
///    interface neither moves nor turns in the frame (joint-fixed), or so that given directions do not move
///    in it (held by its joints; what these leave of the rigid motions by mean axes).  All describe the same
///    deformations.
/// 4. Orthonormalised: Y^T M_se Y = 1, Y^T K_se Y = Omega^2; what depends on the others is dropped.
///
/// Without steps 1's truncation all n - 6 deformations of the superelement are kept and step 2 adds nothing.
/// Rigid links (body_node.hpp) leave of all this what keeps ties^T u_se = 0.
namespace flexura::mbs {

class PreparationCache;

struct BasisOptions {
  int modes = std::numeric_limits<int>::max();  ///< eigenmodes: at most so many, lowest first
  std::vector<int> numbers = {};  ///< eigenmodes with strain by their numbers from 1, instead, in any order
  /// Eigenmodes until they hold this share of what all have of the mass and inertia in every held direction; 0: no bound.
  double effective_mass = 0.0;
  double max_frequency = std::numeric_limits<double>::infinity();  ///< [Hz], eigenmodes: none above
  Eigen::MatrixXd held;             ///< n_se x k, held directions of the eigenmodes; empty: free
  Eigen::MatrixXd loads;            ///< n_se x j, unit loads for response modes; empty: none
  double response_frequency = 0.0;  ///< [Hz] Omega_0 / 2 pi; must not be a natural frequency
  int fixed_interface = -1;         ///< joint-fixed frame at this interface; -1: mean axes
  Eigen::MatrixXd frame;            ///< n_se x k <= 6, independent: directions that do not move in the frame
  std::vector<BodyNode> nodes;      ///< beside the interfaces; behind them in ModalData::nodes
  std::optional<double> damping;    ///< ratio for all modes; short for damping_law.ratio
  DampingLaw damping_law;
  Coupling coupling = Coupling::full;
  bool stiffening = false;  ///< take the superelement's stiffening terms
};

struct BasisReport {
  int available = 0;                         ///< eigenmodes under the boundary condition
  int kept = 0;                              ///< of them
  int responses = 0;                         ///< independent response modes beside them
  double lowest_hz = 0.0, highest_hz = 0.0;  ///< of the body's modes
  double first_dropped_hz = 0.0;             ///< the lowest eigenmode left out; 0 when all are kept
  std::vector<double> eigen_hz;              ///< of the kept eigenmodes, under their boundary condition
};

/// Throws std::invalid_argument when the superelement cannot carry its rigid motions, keeps no mode, has no
/// stiffening terms where they are asked for, or when the fixed interface lacks directions.
/// Steps that the cache knows are taken from there.
ModalData modal_data(const superelement::Superelement& se, const BasisOptions& options = {},
                     BasisReport* report = nullptr, PreparationCache* cache = nullptr);

/// n_se x 6: the loads p_se of unit wrenches (torque, then force, in B's axes, about a point `offset` from
/// the interface's node) on an interface.  Directions that the interface does not keep take no load.
Eigen::MatrixXd interface_loads(const superelement::Superelement& se, int interface,
                                const Vector3d& offset = Vector3d::Zero());

/// interface_loads of all these interfaces side by side.
Eigen::MatrixXd interface_loads(const superelement::Superelement& se, const std::vector<int>& interfaces);

/// The integrals with the columns of Y in place of the shapes.
superelement::InertiaIntegrals transform(const superelement::InertiaIntegrals& integrals,
                                         const Eigen::MatrixXd& Y);

/// The second-order integrals of the shapes Y: K0t, and N_ab (int x_a u2_b dm = s^T N_ab s / 2) from
///
///     K0r_c = N_ab - N_ba,  (a, b, c) cyclic,      K0omega_aa = N_aa - tr N,      K0omega_ab = N_ab + N_ba
SecondOrderIntegrals second_order_integrals(const superelement::StiffeningTerms& terms,
                                            const Eigen::MatrixXd& Y);

/// The superelement's load cases on a body of the shapes Y (n_se x m), or on a rigid one (Y empty).
std::vector<BodyLoad> body_loads(const superelement::Superelement& se, const Eigen::MatrixXd& Y = {});

/// The body of fidelity "rigid": mass, centre and inertia of the undeformed superelement.
RigidInertia rigid_inertia(const superelement::Superelement& se);

}  // namespace flexura::mbs
