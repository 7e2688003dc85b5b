// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <string>

#include "mbs/superelement/superelement.hpp"

namespace flexura::mbs {

/// What a choice of modes asks for cannot be; `key` is that of the choice.
class BasisError : public std::invalid_argument {
 public:
  BasisError(std::string key, const std::string& text) : std::invalid_argument(text), key_(std::move(key)) {}
  const std::string& key() const { return key_; }

 private:
  std::string key_;
};

/// Deformations side by side and their eigenvalues.
struct ModeSet {
  Eigen::MatrixXd Y;
  Eigen::VectorXd omega2;  ///< [rad^2/s^2]
};

/// Modes X = Y C of a set Y of deformations, rigid motions aside.
struct ModesWithin {
  Eigen::MatrixXd C;  ///< m x m
  Eigen::VectorXd omega2;
};

/// The eigenvalue problem (K - omega^2 M) y = 0 of a superelement with its rigid motions R known, scaled to a
/// unit diagonal of M: displacements, rotations and modal coordinates differ in size.  Modes are given and
/// taken in these scaled coordinates.  Behind modal_basis.hpp, which says what the steps are for.
class ModalProblem {
 public:
  /// `ties` n_se x k: motions along them are held at zero.  Throws std::invalid_argument where the
  /// superelement cannot carry its rigid motions or nothing is left to deform.  `se` outlives it.
  ModalProblem(const superelement::Superelement& se, const Eigen::MatrixXd& ties);

  /// The modes u_se = scale x.
  Eigen::MatrixXd to_coordinates(const Eigen::MatrixXd& X) const { return scale_.asDiagonal() * X; }

  /// Eigenmodes among the vectors orthogonal to `held`, without rigid motions; phi^T M phi = 1.
  ModeSet eigenmodes(const Eigen::MatrixXd& held) const;
  /// Response modes for the loads at the circular frequency omega, mean axes.  BasisError where that is a
  /// natural frequency: all would be its mode.
  Eigen::MatrixXd responses(const Eigen::MatrixXd& loads, double omega) const;

  /// Takes a rigid motion from each column: none of its momentum is left ...
  void to_mean_axes(Eigen::MatrixXd& S) const;
  /// ... these directions do not move ...
  void to_held_frame(const Eigen::MatrixXd& held, Eigen::MatrixXd& S) const;
  /// ... the interface is at rest.
  void to_fixed_interface(int interface, Eigen::MatrixXd& S) const;

  /// Y^T M Y = 1, Y^T K Y = Omega^2 in the span of S; directions that depend on the others are dropped.
  ModeSet orthonormalised(Eigen::MatrixXd S) const;

  /// The deformations Y (n x m, orthonormalised) by the eigenmodes among them under the condition of `held` (empty: free), a rigid
  /// motion added to each.  Where the condition leaves fewer than m, those that are orthogonal to them follow, by their own
  /// frequencies.
  ModesWithin eigenmodes_within(const ModeSet& basis, const Eigen::MatrixXd& held) const;

 private:
  Eigen::MatrixXd to_loads(const Eigen::MatrixXd& P) const { return scale_.asDiagonal() * P; }
  Eigen::MatrixXd conditions_of(const Eigen::MatrixXd& held) const;
  Eigen::MatrixXd complement(const Eigen::MatrixXd& columns) const;
  ModeSet eigenmodes_in(const Eigen::MatrixXd& N) const;

  const superelement::Superelement& se_;
  int n_;
  Eigen::VectorXd scale_;
  Eigen::MatrixXd M_, K_, R_, MR_, ties_;
  Eigen::MatrixXd free_;  ///< n x k: what is neither rigid nor tied
};

}  // namespace flexura::mbs
