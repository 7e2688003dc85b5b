// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "mbs/model/equations.hpp"
#include "mbs/solver/column_groups.hpp"

/// Derivatives of the equations of motion about one state, for Newton matrices and linearisation.
///
/// With z = (r, c_rate, b), r = M v_dot - f + G^T lambda, stacked (n_z = n_v + n_dyn + n_alg):
///     z_p = dz/dp, z_v = dz/dv, z_c = dz/dc, z_a = dz/da      at fixed v_dot and lambda
///     M, G                                                      exact, from the equations
///     h_p = d(G v + g_t)/dp
/// by forward differences with relative step sqrt(eps): errors of about 1e-8 of the entries' scale.
/// (dg/dp needs none: it is G T^+, since g does not depend on the norm of a quaternion.)
///
/// Of a large mechanism most entries are zero.  Its columns are then taken in groups (column_groups.hpp),
/// whose pattern is found by single differences at the state and at one beside it, again after
/// forget_structure().
namespace flexura::mbs {

/// What the differences are taken for.
enum class TangentScope {
  everything,  ///< all columns
  newton,      ///< the columns of elastic coordinates hold their stiffness and damping alone, see
               ///< Equations::elastic_coordinate: the cost is then that of the rigid mechanism
};

class Tangents {
 public:
  explicit Tangents(const Equations& eq);

  void evaluate(const State& s, const Eigen::VectorXd& v_dot, TangentScope scope = TangentScope::everything);
  bool has_elastic_coordinates() const { return !elastic_.empty(); }
  /// Call where forces may have come or gone: after a switch, where Newton's method fails.
  void forget_structure() { structure_known_ = false; }

  Eigen::MatrixXd z_p, z_v, z_c, z_a, M, G, h_p;
  Eigen::VectorXd z;  ///< at the state itself
  long evaluations = 0;

 private:
  struct Elastic {
    int i_p, i_v;
    double stiffness, damping;
  };
  void momentum(const State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd& z);
  void difference(Eigen::VectorXd& x, double scale_floor, int j, const Eigen::VectorXd& v_dot,
                  Eigen::MatrixXd& columns);

  void by_single_columns(const Eigen::VectorXd& v_dot, bool skips);
  void by_groups(const Eigen::VectorXd& v_dot);
  bool find_structure(const Eigen::VectorXd& v_dot, bool skips);
  double step_of(double x, double scale) const;

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  ColumnGroups groups_p_, groups_v_, groups_h_;
  bool structure_known_ = false, structure_skips_ = false;
  std::vector<Elastic> elastic_;
  std::vector<bool> elastic_p_, elastic_v_;
  Eigen::VectorXd position_scale_, velocity_scale_;
  State s_;
  Eigen::VectorXd z_plus_, h_, h_plus_, x_0_;
};

}  // namespace flexura::mbs
