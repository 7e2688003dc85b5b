// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "mbs/equations/equations.hpp"

/// Planar mechanisms written out by hand: equations of motion that owe nothing to the program's own model
/// code, for tests of the solvers.
///
/// A point is  r(q) = r0 + sum_k R(theta_k) u_k  with  theta_k = c_k . q;  then
///     dr = sum_k R'(theta_k) u_k c_k^T dq,    d2r/dt2 = J q'' - sum_k R(theta_k) u_k (c_k . q')^2.
/// Coordinates that slide enter through `slides`: r0 + axis (c . q).
namespace flexura::mbs::test {

struct PlanarPoint {
  struct Link {
    Eigen::VectorXd c;
    Eigen::Vector2d u;
  };
  Eigen::Vector2d origin{0.0, 0.0};
  std::vector<Link> links, slides;

  PlanarPoint& turn(const Eigen::VectorXd& c, double x, double y) {
    links.push_back({c, {x, y}});
    return *this;
  }
  PlanarPoint& slide(const Eigen::VectorXd& c, double x, double y) {
    slides.push_back({c, {x, y}});
    return *this;
  }
  Eigen::Vector2d position(ConstVectorRef q) const {
    Eigen::Vector2d r = origin;
    for (const Link& l : links) r += rotated(l, l.c.dot(q));
    for (const Link& l : slides) r += l.u * l.c.dot(q);
    return r;
  }
  Eigen::MatrixXd jacobian(ConstVectorRef q) const {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, q.size());
    for (const Link& l : links) {
      const Eigen::Vector2d r = rotated(l, l.c.dot(q));
      J += Eigen::Vector2d(-r.y(), r.x()) * l.c.transpose();
    }
    for (const Link& l : slides) J += l.u * l.c.transpose();
    return J;
  }
  /// J' q'
  Eigen::Vector2d bias(ConstVectorRef q, ConstVectorRef v) const {
    Eigen::Vector2d r(0.0, 0.0);
    for (const Link& l : links) r -= rotated(l, l.c.dot(q)) * std::pow(l.c.dot(v), 2);
    return r;
  }

 private:
  static Eigen::Vector2d rotated(const Link& l, double theta) {
    return {std::cos(theta) * l.u.x() - std::sin(theta) * l.u.y(),
            std::sin(theta) * l.u.x() + std::cos(theta) * l.u.y()};
  }
};

class PlanarMechanism : public Equations {
 public:
  struct Body {
    double mass, inertia;
    Eigen::VectorXd turn;  ///< orientation angle = turn . q
    PlanarPoint centre;
  };
  struct Spring {  ///< between a point and a fixed place, with a dashpot in parallel
    PlanarPoint point;
    Eigen::Vector2d anchor;
    double stiffness, length, damping;
  };
  struct Constraint {  ///< direction . point = rate * t + offset
    PlanarPoint point;
    Eigen::Vector2d direction;
    double rate = 0.0, offset = 0.0;
    std::string name;
  };
  struct Torque {
    int coordinate;
    double value;
  };

  explicit PlanarMechanism(int n) : n_(n) {}

  std::vector<Body> bodies;
  std::vector<Spring> springs;
  std::vector<Constraint> constraints;
  std::vector<Torque> torques;
  Eigen::Vector2d gravity{0.0, 0.0};

  Eigen::VectorXd unit(std::initializer_list<int> indices) const {
    Eigen::VectorXd c = Eigen::VectorXd::Zero(n_);
    for (int i : indices) c(i) += 1.0;
    return c;
  }
  void close(const PlanarPoint& point, const std::string& name) {
    constraints.push_back({point, {1.0, 0.0}, 0.0, 0.0, name + ".x"});
    constraints.push_back({point, {0.0, 1.0}, 0.0, 0.0, name + ".y"});
  }

  Sizes sizes() const override {
    Sizes s;
    s.n_p = s.n_v = n_;
    s.n_lambda = static_cast<int>(constraints.size());
    return s;
  }
  std::unique_ptr<Scratch> make_scratch() const override { return std::make_unique<Scratch>(); }
  void kinematic(ConstVectorRef, ConstVectorRef w, VectorRef p_dot) const override { p_dot = w; }
  void retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const override { p_out = p + d; }

  void momentum(const State& s, ConstVectorRef v_dot, Scratch& scratch, VectorRef r, VectorRef,
                VectorRef) const override {
    r.setZero();
    for (const Body& b : bodies) {
      const Eigen::MatrixXd J = b.centre.jacobian(s.p);
      r += J.transpose() * (b.mass * (J * v_dot + b.centre.bias(s.p, s.v) - gravity));
      r += b.turn * (b.inertia * b.turn.dot(v_dot));
    }
    for (const Spring& spring : springs) {
      const Eigen::MatrixXd J = spring.point.jacobian(s.p);
      const Eigen::Vector2d d = spring.point.position(s.p) - spring.anchor;
      const double rate = d.normalized().dot(J * s.v);
      r += J.transpose() * d.normalized() *
           (spring.stiffness * (d.norm() - spring.length) + spring.damping * rate);
    }
    for (const Torque& torque : torques) r(torque.coordinate) -= torque.value;
    Eigen::VectorXd f_c(n_);
    apply_GT(s.t, s.p, s.lambda, scratch, f_c);
    r += f_c;
  }
  void position_constraints(When when, ConstVectorRef p, Scratch&, VectorRef g) const override {
    for (std::size_t k = 0; k < constraints.size(); ++k)
      g(k) = constraints[k].direction.dot(constraints[k].point.position(p)) - constraints[k].rate * when.t -
             constraints[k].offset;
  }
  void velocity_constraints(When, ConstVectorRef p, ConstVectorRef v, Scratch&,
                            VectorRef g_dot) const override {
    for (std::size_t k = 0; k < constraints.size(); ++k)
      g_dot(k) = constraints[k].direction.dot(constraints[k].point.jacobian(p) * v) - constraints[k].rate;
  }
  void acceleration_constraints(When, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot, Scratch&,
                                VectorRef g_ddot) const override {
    for (std::size_t k = 0; k < constraints.size(); ++k)
      g_ddot(k) = constraints[k].direction.dot(constraints[k].point.jacobian(p) * v_dot +
                                               constraints[k].point.bias(p, v));
  }
  void apply_GT(When, ConstVectorRef p, ConstVectorRef x, Scratch&, VectorRef f_c) const override {
    f_c.setZero();
    for (std::size_t k = 0; k < constraints.size(); ++k)
      f_c += constraints[k].point.jacobian(p).transpose() * constraints[k].direction * x(k);
  }
  void constraint_matrix(When, ConstVectorRef p, Scratch&, MatrixRef G) const override {
    for (std::size_t k = 0; k < constraints.size(); ++k)
      G.row(k) = constraints[k].direction.transpose() * constraints[k].point.jacobian(p);
  }
  void mass_matrix(ConstVectorRef p, Scratch&, MatrixRef M) const override {
    M.setZero();
    for (const Body& b : bodies) {
      const Eigen::MatrixXd J = b.centre.jacobian(p);
      M += b.mass * J.transpose() * J + b.inertia * b.turn * b.turn.transpose();
    }
  }
  EnergyReport energy(const State& s, ConstVectorRef, Scratch&) const override {
    EnergyReport e;
    for (const Body& b : bodies) {
      e.kinetic += 0.5 * b.mass * (b.centre.jacobian(s.p) * s.v).squaredNorm() +
                   0.5 * b.inertia * std::pow(b.turn.dot(s.v), 2);
      e.potential -= b.mass * gravity.dot(b.centre.position(s.p));
    }
    for (const Spring& spring : springs) {
      const Eigen::Vector2d d = spring.point.position(s.p) - spring.anchor;
      e.potential += 0.5 * spring.stiffness * std::pow(d.norm() - spring.length, 2);
      e.dissipated_power +=
          spring.damping * std::pow(d.normalized().dot(spring.point.jacobian(s.p) * s.v), 2);
    }
    for (const Torque& torque : torques) e.input_power += torque.value * s.v(torque.coordinate);
    // A moving constraint takes lambda_k g_t,k out of the mechanism: -(G v)_k lambda_k with G v = -g_t =
    // rate.
    for (std::size_t k = 0; k < constraints.size(); ++k) e.input_power -= s.lambda(k) * constraints[k].rate;
    return e;
  }
  void roots(const State&, Scratch&, VectorRef) const override {}
  bool on_root(int, State&, Scratch&) const override { return false; }
  std::string name_of_position(int i) const override { return "q" + std::to_string(i); }
  std::string name_of_velocity(int i) const override { return "q" + std::to_string(i); }
  std::string name_of_dynamic(int i) const override { return "c" + std::to_string(i); }
  std::string name_of_constraint(int i) const override { return constraints[i].name; }
  std::string name_of_algebraic(int i) const override { return "a" + std::to_string(i); }

 private:
  int n_;
};

/// Andrews' squeezing mechanism: seven bodies, three loops, no gravity, a constant torque on the crank.  Data
/// and reference values: tests/mbs/solver/data/README.md.
inline PlanarMechanism andrews() {
  PlanarMechanism m(7);
  const double xa = -.06934, ya = -.00227, xb = -.03635, yb = .03273, xc = .014, yc = .072;
  const double d = .028, da = .0115, e = .02, ea = .01421, rr = .007, ra = .00092, ss = .035, sa = .01874,
               sb = .01043, sc = .018, sd = .02, ta = .02308, tb = .00916, u = .04, ua = .01228, ub = .00449,
               zf = .02, zt = .04, fa = .01421;
  const auto b = m.unit({0}), bT = m.unit({0, 1}), g = m.unit({2}), Pd = m.unit({3, 4}), del = m.unit({4}),
             Oe = m.unit({5, 6}), eps = m.unit({6});
  auto at = [](double x, double y) {
    PlanarPoint p;
    p.origin = {x, y};
    return p;
  };
  m.bodies = {{.04325, 2.194e-6, b, at(0, 0).turn(b, ra, 0)},
              {.00365, 4.410e-7, bT, at(0, 0).turn(b, rr, 0).turn(bT, -da, 0)},
              {.02373, 5.255e-6, g, at(xb, yb).turn(g, sb, -sa)},
              {.00706, 5.667e-7, Pd, at(xa, ya).turn(del, zt, 0).turn(Pd, 0, -(e - ea))},
              {.07050, 1.169e-5, del, at(xa, ya).turn(del, ta, tb)},
              {.00706, 5.667e-7, Oe, at(xa, ya).turn(eps, 0, -u).turn(Oe, zf - fa, 0)},
              {.05498, 1.912e-5, eps, at(xa, ya).turn(eps, -ub, -ua)}};
  m.springs = {{at(xb, yb).turn(g, sd, -sc), {xc, yc}, 4530.0, .07785, 0.0}};
  m.torques = {{0, .033}};
  m.close(at(-xb, -yb).turn(b, rr, 0).turn(bT, -d, 0).turn(g, 0, ss), "K3");
  m.close(at(-xa, -ya).turn(b, rr, 0).turn(bT, -d, 0).turn(Pd, 0, e).turn(del, -zt, 0), "K4");
  m.close(at(-xa, -ya).turn(b, rr, 0).turn(bT, -d, 0).turn(Oe, -zf, 0).turn(eps, 0, u), "K6");
  return m;
}

/// Crank of length r about the origin, rod of length l, piston on the x axis; q = (crank angle, rod angle,
/// piston x). Closing: r cos a + l cos b = x, r sin a + l sin b = 0.
inline PlanarMechanism slider_crank(double r = 0.1, double l = 0.3) {
  PlanarMechanism m(3);
  const auto a = m.unit({0}), b = m.unit({1}), x = m.unit({2});
  m.bodies = {{1.0, 1e-3, a, PlanarPoint().turn(a, r / 2, 0)},
              {0.6, 5e-3, b, PlanarPoint().turn(a, r, 0).turn(b, l / 2, 0)},
              {0.8, 0.0, Eigen::VectorXd::Zero(3), PlanarPoint().slide(x, 1, 0)}};
  m.close(PlanarPoint().turn(a, r, 0).turn(b, l, 0).slide(x, -1, 0), "rod_end");
  return m;
}

/// IFToMM A02: N windows of 2 N + 1 rods (1 m, 1 kg); uprights first (angles 0..N), then the N horizontal
/// rods. Each horizontal rod hangs on upright i and closes on upright i + 1.
inline PlanarMechanism windows(int N) {
  PlanarMechanism m(2 * N + 1);
  m.gravity = {0.0, -9.81};
  for (int i = 0; i <= N; ++i) {
    PlanarPoint centre;
    centre.origin = {static_cast<double>(i), 0.0};
    m.bodies.push_back({1.0, 1.0 / 12.0, m.unit({i}), centre.turn(m.unit({i}), 0.5, 0.0)});
  }
  for (int i = 0; i < N; ++i) {
    PlanarPoint centre, loop;
    centre.origin = {static_cast<double>(i), 0.0};
    const auto rod = m.unit({N + 1 + i});
    m.bodies.push_back({1.0, 1.0 / 12.0, rod, centre.turn(m.unit({i}), 1.0, 0.0).turn(rod, 0.5, 0.0)});
    loop.origin = {-1.0, 0.0};
    m.close(loop.turn(m.unit({i}), 1.0, 0.0).turn(rod, 1.0, 0.0).turn(m.unit({i + 1}), -1.0, 0.0),
            "window" + std::to_string(i));
  }
  return m;
}

}  // namespace flexura::mbs::test
