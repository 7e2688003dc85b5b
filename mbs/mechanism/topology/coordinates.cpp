// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/topology/coordinates.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace flexura::mbs {

using Eigen::MatrixXd;

Coordinates::Coordinates(const Topology& tree) : tree_(tree), own_frequency_(tree.d.bodies.size()) {
  for (int b : tree_.order) {
    const int m = tree_.bodies[b].m;
    if (m == 0) continue;
    const FlexibleBody& flexible = *tree_.d.bodies[b].flexible;
    std::vector<double>& omega = own_frequency_[static_cast<std::size_t>(b)];
    for (int k = 0; k < m; ++k) omega.push_back(std::sqrt(flexible.spring(k).stiffness));
    if (std::ranges::any_of(omega, [](double own) { return own > 0.0; })) continue;
    // Its stiffness is a matrix.
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(m);
    MatrixXd K = MatrixXd::Zero(m, m), D = K;
    flexible.add_tangents(rest.data(), rest.data(), K, D);
    for (int k = 0; k < m; ++k) {
      const auto alone = flexible.alone(k);
      const double mass = alone ? alone->mass : flexible.M_e()(k, k);
      omega[static_cast<std::size_t>(k)] = std::sqrt(std::max(0.0, K(k, k) / mass));
    }
  }
}

void Coordinates::kinematic(ConstVectorRef p, ConstVectorRef w, VectorRef p_dot) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    const JointPlace& place = tree_.places[body.joint];
    place.joint->kinematic(p.data() + place.i_p, w.data() + place.i_v, p_dot.data() + place.i_p);
    p_dot.segment(body.i_p, body.m) = w.segment(body.i_v, body.m);
  }
}

void Coordinates::retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    const JointPlace& place = tree_.places[body.joint];
    place.joint->retract(p.data() + place.i_p, d.data() + place.i_v, p_out.data() + place.i_p);
    p_out.segment(body.i_p, body.m) = p.segment(body.i_p, body.m) + d.segment(body.i_v, body.m);
  }
}

bool Coordinates::elastic_coordinate(int i_v, int& i_p, double& k, double& d) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    if (i_v < body.i_v || i_v >= body.i_v + body.m) continue;
    const FlexibleBody::Spring own = tree_.d.bodies[b].flexible->spring(i_v - body.i_v);
    i_p = body.i_p + i_v - body.i_v;
    k = own.stiffness;
    d = own.damping;
    return true;
  }
  return false;
}

void Coordinates::add_elastic_tangents(const State& s, MatrixRef r_p, MatrixRef r_v) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    if (body.m == 0) continue;
    tree_.d.bodies[b].flexible->add_tangents(s.p.data() + body.i_p, s.v.data() + body.i_v,
                                             r_p.block(body.i_v, body.i_p, body.m, body.m),
                                             r_v.block(body.i_v, body.i_v, body.m, body.m));
  }
}

double Coordinates::position_scale(int i) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    if (i >= body.i_p && i < body.i_p + body.m)
      return 1.0 / tree_.d.bodies[b].flexible->amplitude(i - body.i_p);
  }
  return 1.0;
}

double Coordinates::velocity_scale(int i) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    if (i >= body.i_v && i < body.i_v + body.m)
      return 1.0 / tree_.d.bodies[b].flexible->amplitude(i - body.i_v);
  }
  return 1.0;
}

double Coordinates::rate_scale(int i) const {
  // Markers that vibrate take their joints along, and through the reactions all that hangs on them: every
  // rate may be wrong by the highest frequency times the amplitude allowed.  Slow motion is held by its
  // positions.
  double omega = 1.0;
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    const std::vector<double>& own = own_frequency_[static_cast<std::size_t>(b)];
    if (i >= body.i_v && i < body.i_v + body.m)
      return std::max(1.0, own[static_cast<std::size_t>(i - body.i_v)]) * velocity_scale(i);
    for (const double frequency : own) omega = std::max(omega, frequency);
  }
  return omega * velocity_scale(i);
}

std::string Coordinates::name_of_position(int i) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    const JointPlace& place = tree_.places[body.joint];
    if (i < body.i_p)
      return tree_.d.joints[body.joint].name + "." + place.joint->coordinates()[i - place.i_p].name;
    if (i < body.i_p + body.m) return fmt::format("{}.mode_{}", tree_.d.bodies[b].name, i - body.i_p + 1);
  }
  return {};
}

std::string Coordinates::name_of_velocity(int i) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    const JointPlace& place = tree_.places[body.joint];
    if (i < body.i_v)
      return tree_.d.joints[body.joint].name + "." + place.joint->speeds()[i - place.i_v].name;
    if (i < body.i_v + body.m)
      return fmt::format("{}.mode_{}_rate", tree_.d.bodies[b].name, i - body.i_v + 1);
  }
  return {};
}

const double* Coordinates::modal_coordinates(int body, const State& s) const {
  if (tree_.bodies[body].i_c >= 0) return s.c.data() + tree_.bodies[body].i_c;
  return tree_.d.bodies[body].flexible ? s.p.data() + tree_.bodies[body].i_p : nullptr;
}

std::string Coordinates::name_of_following(int i) const {
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    const int k = i - body.i_c, m = body.i_c >= 0 ? body.n_need : 0;
    if (k >= 0 && k < m) return fmt::format("{}.mode_{}", tree_.d.bodies[b].name, k + 1);
    if (k >= m && k < 2 * m) return fmt::format("{}.mode_{}_rate", tree_.d.bodies[b].name, k - m + 1);
  }
  return {};
}

void Coordinates::take_to_coordinates(const double* p, const MatrixXd& by_tangent, MatrixXd& by_p) const {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 7, 6> N;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 7> N_plus;
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    const JointPlace& place = tree_.places[t.joint];
    const int n_p = place.joint->n_p(), n_v = place.joint->n_v();
    N.resize(n_p, n_v);
    for (int j = 0; j < n_v; ++j) {
      const Eigen::Matrix<double, 6, 1> e = Eigen::Matrix<double, 6, 1>::Unit(j);
      place.joint->kinematic(p + place.i_p, e.data(), N.col(j).data());
    }
    const auto from = by_tangent.middleCols(place.i_v, n_v);
    auto to = by_p.middleCols(place.i_p, n_p);
    if (n_p == n_v && N.isIdentity(0.0)) {
      to = from;
    } else {
      const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> gram = N.transpose() * N;
      N_plus = gram.inverse() * N.transpose();
      to.noalias() = from.lazyProduct(N_plus);
    }
    by_p.middleCols(t.i_p, t.m) = by_tangent.middleCols(t.i_v, t.m);
  }
}

Eigen::VectorXd Coordinates::kinematic_scale(double extent) const {
  Eigen::VectorXd scale(tree_.n_v);
  for (int i = 0; i < tree_.n_v; ++i) scale(i) = extent * velocity_scale(i);
  for (const int b : tree_.order) {
    const JointPlace& place = tree_.places[tree_.bodies[b].joint];
    const std::vector<CoordinateInfo> speeds = place.joint->speeds();
    for (int i = 0; i < place.joint->n_v(); ++i)
      if (speeds[i].dimension == input::dim::angular_velocity) scale(place.i_v + i) = 1.0;
  }
  return scale;
}

}  // namespace flexura::mbs
