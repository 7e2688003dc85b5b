// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "mbs/equations/equations.hpp"

/// Derivatives of the equations of motion about one state, for Newton matrices and linearisation
/// (TangentMatrices), with M and G.
///
/// They come exactly from Equations::tangents(); of equations that have none by forward differences with
/// relative step sqrt(eps): errors of about 1e-8 of the entries' scale.  (dg/dp needs none: it is G T^+,
/// since g does not depend on the norm of a quaternion.)
namespace flexura::mbs {

class Tangents : public TangentMatrices {
 public:
  explicit Tangents(const Equations& eq);

  void evaluate(const State& s, const Eigen::VectorXd& v_dot, TangentScope scope = TangentScope::everything);
  /// Coordinates for which TangentScope::newton does: what belongs to a body with a stiffness of its own for each.
  /// Where the stiffness is a matrix the body bends as far as it likes, and its motion moves all that hangs on it.
  bool has_elastic_coordinates() const { return !elastic_.empty() && !bends_far_; }

  Eigen::MatrixXd M, G;
  long evaluations = 0;

 private:
  struct Elastic {
    int i_p, i_v;
    double stiffness, damping;
  };
  void set_elastic_columns(const State& s);
  void momentum(const State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd& z);
  void difference(Eigen::VectorXd& x, double scale_floor, int j, const Eigen::VectorXd& v_dot,
                  Eigen::MatrixXd& columns);

  void by_differences(const Eigen::VectorXd& v_dot, bool skips);
  double step_of(double x, double scale) const;

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::vector<Elastic> elastic_;
  std::vector<bool> elastic_p_, elastic_v_;
  bool bends_far_ = false;
  Eigen::VectorXd position_scale_, velocity_scale_;
  State s_;
  Eigen::VectorXd z_, z_plus_, h_, h_plus_;
};

}  // namespace flexura::mbs
