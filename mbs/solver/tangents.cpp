// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/tangents.hpp"

#include <cmath>
#include <stdexcept>

namespace flexura::mbs {
namespace {

// Below, the search for the structure costs more than it saves.
constexpr int kGroupsFrom = 40;

}  // namespace

Tangents::Tangents(const Equations& eq) : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()) {
  const int n_z = n_.n_v + n_.n_dyn + n_.n_alg;
  z_p.setZero(n_z, n_.n_p);
  z_v.setZero(n_z, n_.n_v);
  z_c.setZero(n_z, n_.n_dyn);
  z_a.setZero(n_z, n_.n_alg);
  M.setZero(n_.n_v, n_.n_v);
  G.setZero(n_.n_lambda, n_.n_v);
  h_p.setZero(n_.n_lambda, n_.n_p);
  z.setZero(n_z);
  z_plus_ = z;
  h_.setZero(n_.n_lambda);
  h_plus_ = h_;
  position_scale_.resize(n_.n_p);
  velocity_scale_.resize(n_.n_v);
  for (int i = 0; i < n_.n_p; ++i) position_scale_(i) = eq.position_scale(i);
  elastic_p_.assign(n_.n_p, false);
  elastic_v_.assign(n_.n_v, false);
  for (int i = 0; i < n_.n_v; ++i) {
    velocity_scale_(i) = eq.velocity_scale(i);
    Elastic e{-1, i, 0.0, 0.0};
    if (!eq.elastic_coordinate(i, e.i_p, e.stiffness, e.damping)) continue;
    elastic_.push_back(e);
    elastic_p_[e.i_p] = elastic_v_[i] = true;
  }
}

void Tangents::momentum(const State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd& out) {
  eq_.momentum(s, v_dot, *scratch_, out.head(n_.n_v), out.segment(n_.n_v, n_.n_dyn), out.tail(n_.n_alg));
  ++evaluations;
}

// sqrt(eps) balances round-off against truncation.
double Tangents::step_of(double x, double scale) const {
  return 1.5e-8 * std::max(std::abs(x), scale);
}

void Tangents::difference(Eigen::VectorXd& x, double scale_floor, int j, const Eigen::VectorXd& v_dot,
                          Eigen::MatrixXd& columns) {
  const double x_j = x(j);
  x(j) = x_j + step_of(x_j, scale_floor);
  const double up = x(j);
  momentum(s_, v_dot, z_plus_);
  columns.col(j) = (z_plus_ - z) / (up - x_j);
  x(j) = x_j;
}

void Tangents::by_single_columns(const Eigen::VectorXd& v_dot, bool skips) {
  for (int j = 0; j < n_.n_p; ++j)
    if (!skips || !elastic_p_[j]) difference(s_.p, position_scale_(j), j, v_dot, z_p);
  for (int j = 0; j < n_.n_v; ++j)
    if (!skips || !elastic_v_[j]) difference(s_.v, velocity_scale_(j), j, v_dot, z_v);
  if (n_.n_lambda == 0) return;
  eq_.velocity_constraints(s_.t, s_.p, s_.v, *scratch_, h_);
  for (int j = 0; j < n_.n_p; ++j) {
    if (skips && elastic_p_[j]) {
      h_p.col(j).setZero();
      continue;
    }
    const double p_j = s_.p(j);
    s_.p(j) = p_j + step_of(p_j, position_scale_(j));
    eq_.velocity_constraints(s_.t, s_.p, s_.v, *scratch_, h_plus_);
    h_p.col(j) = (h_plus_ - h_) / (s_.p(j) - p_j);
    s_.p(j) = p_j;
  }
}

void Tangents::by_groups(const Eigen::VectorXd& v_dot) {
  const auto all = [&](const ColumnGroups& groups, Eigen::VectorXd& x, const Eigen::VectorXd& scale,
                       const Eigen::VectorXd& low, Eigen::VectorXd& high, Eigen::MatrixXd& columns,
                       const auto& evaluate) {
    columns.setZero();
    x_0_ = x;
    for (int k = 0; k < groups.size(); ++k) {
      for (const int j : groups.group(k)) x(j) += step_of(x(j), scale(j));
      evaluate();
      for (const int j : groups.group(k)) {
        const double step = x(j) - x_0_(j);
        for (const int i : groups.rows(j)) columns(i, j) = (high(i) - low(i)) / step;
        x(j) = x_0_(j);
      }
    }
  };
  const auto forces = [&] { momentum(s_, v_dot, z_plus_); };
  all(groups_p_, s_.p, position_scale_, z, z_plus_, z_p, forces);
  all(groups_v_, s_.v, velocity_scale_, z, z_plus_, z_v, forces);
  if (n_.n_lambda == 0) return;
  eq_.velocity_constraints(s_.t, s_.p, s_.v, *scratch_, h_);
  all(groups_h_, s_.p, position_scale_, h_, h_plus_, h_p,
      [&] { eq_.velocity_constraints(s_.t, s_.p, s_.v, *scratch_, h_plus_); });
}

bool Tangents::find_structure(const Eigen::VectorXd& v_dot, bool skips) {
  by_single_columns(v_dot, skips);
  Eigen::MatrixXd of_p = z_p.cwiseAbs(), of_v = z_v.cwiseAbs(), of_h = h_p.cwiseAbs();
  // Beside the state, where nothing rests and no axes coincide: there what happens to be zero shows.
  const State here = s_;
  const Eigen::VectorXd z_here = z;
  Eigen::VectorXd d(n_.n_v), v_dot_beside = v_dot;
  for (int i = 0; i < n_.n_v; ++i) {
    d(i) = 1e-3 * velocity_scale_(i) * (1.0 + std::cos(1.7 * i));
    s_.v(i) += velocity_scale_(i) * (1.5 + std::sin(2.3 * i));
    v_dot_beside(i) += velocity_scale_(i) * (1.5 + std::cos(3.1 * i));
  }
  eq_.retract(here.p, d, s_.p);
  bool found = true;
  try {
    momentum(s_, v_dot_beside, z);
    by_single_columns(v_dot_beside, skips);
    of_p += z_p.cwiseAbs();
    of_v += z_v.cwiseAbs();
    of_h += h_p.cwiseAbs();
    found = of_p.allFinite() && of_v.allFinite() && of_h.allFinite();
  } catch (const std::runtime_error&) {
    found = false;  // a formula has no value there
  }
  s_ = here;
  z = z_here;
  if (!found) return false;
  const std::vector<bool> none_p(n_.n_p, false), none_v(n_.n_v, false);
  groups_p_.find(of_p, skips ? elastic_p_ : none_p);
  groups_v_.find(of_v, skips ? elastic_v_ : none_v);
  groups_h_.find(of_h, skips ? elastic_p_ : none_p);
  structure_skips_ = skips;
  return true;
}

void Tangents::evaluate(const State& s, const Eigen::VectorXd& v_dot, TangentScope scope) {
  const bool skips = scope == TangentScope::newton;
  s_ = s;
  eq_.mass_matrix(s.p, *scratch_, M);
  eq_.constraint_matrix(s.t, s.p, *scratch_, G);
  momentum(s_, v_dot, z);
  if (n_.n_v >= kGroupsFrom && (!structure_known_ || structure_skips_ != skips))
    structure_known_ = find_structure(v_dot, skips);
  if (structure_known_)
    by_groups(v_dot);
  else
    by_single_columns(v_dot, skips);
  for (int j = 0; j < n_.n_dyn; ++j) difference(s_.c, 1.0, j, v_dot, z_c);
  for (int j = 0; j < n_.n_alg; ++j) difference(s_.a, 1.0, j, v_dot, z_a);
  if (!skips) return;
  for (const Elastic& e : elastic_) {
    z_p.col(e.i_p).setZero();
    z_v.col(e.i_v).setZero();
    z_p(e.i_v, e.i_p) = e.stiffness;
    z_v(e.i_v, e.i_v) = e.damping;
  }
  eq_.add_elastic_tangents(s, z_p.topRows(n_.n_v), z_v.topRows(n_.n_v));
}

}  // namespace flexura::mbs
