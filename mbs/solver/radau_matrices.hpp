// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <vector>

#include "mbs/solver/newton_matrix.hpp"
#include "mbs/solver/stabilised_index2.hpp"

namespace flexura::mbs {

/// The stabilised index-2 form F(t, y, y') with its Newton matrices dF/dy + cj dF/dy' for the real and the
/// complex cj of a step of Radau IIA (radau.hpp), from derivatives taken once.
class RadauMatrices {
 public:
  RadauMatrices(const Equations& eq, const State& start)
      : n_(eq.sizes()),
        form_(eq, start),
        scratch_state_(start),
        kinematics_(eq, start.p),
        tangents_(eq),
        real_(n_, holonomic_rows(eq)),
        complex_(n_, holonomic_rows(eq)) {}

  StabilisedIndex2& form() { return form_; }
  const StabilisedIndex2& form() const { return form_; }
  bool has_elastic_coordinates() const { return tangents_.has_elastic_coordinates(); }
  long evaluations() const { return form_.evaluations() + tangents_.evaluations; }

  /// Takes the derivatives at (t, y, y').
  void linearise(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& yp, TangentScope scope) {
    form_.unpack(t, y, scratch_state_);
    v_dot_ = yp.segment(form_.at_v(), n_.n_v);
    tangents_.evaluate(scratch_state_, v_dot_, scope);
    kinematics_.update(scratch_state_.p, scratch_state_.v);
    kinematics_.invert(1.0);  // for T^+
  }
  /// From the derivatives taken last; false when a matrix is not finite.
  bool factor(double real, std::complex<double> complex) {
    return real_.factor(tangents_, kinematics_, form_.S(), real) &&
           complex_.factor(tangents_, kinematics_, form_.S(), complex);
  }
  /// x = (dF/dy + cj dF/dy')^-1 rhs, of the size of y, for the real or the complex cj.
  void solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& x) { real_.solve(tangents_, rhs, x); }
  void solve(const Eigen::VectorXcd& rhs, Eigen::VectorXcd& x) { complex_.solve(tangents_, rhs, x); }
  /// out = dF/dy' x.
  void multiply_rates(const Eigen::VectorXd& x, Eigen::VectorXd& out) const {
    out = x;
    out.segment(form_.at_v(), n_.n_v).noalias() = tangents_.M * x.segment(form_.at_v(), n_.n_v);
    out.tail(form_.size() - form_.at_a()).setZero();
  }

 private:
  static std::vector<bool> holonomic_rows(const Equations& eq) {
    std::vector<bool> out;
    for (int k = 0; k < eq.sizes().n_lambda; ++k) out.push_back(eq.is_holonomic(k));
    return out;
  }

  Sizes n_;
  StabilisedIndex2 form_;
  State scratch_state_;
  Eigen::VectorXd v_dot_;
  KinematicBlocks kinematics_;
  Tangents tangents_;
  NewtonMatrix<double> real_;
  NewtonMatrix<std::complex<double>> complex_;
};

}  // namespace flexura::mbs
