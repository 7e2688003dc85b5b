// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/constraints/point_on_path.hpp"

#include <cmath>
#include <utility>

#include "mbs/constraints/path_rows.hpp"

namespace flexura::mbs {

namespace dim = input::dim;
using path_rows::Columns;
using path_rows::kVectors;
using path_rows::Level;
using path_rows::Row;
using path_rows::Sum;
using path_rows::Vectors;

/// All rows at one state.
struct PointOnPath::Instant {
  Instant(const PointOnPath& c, const Kinematics& kin, Level level)
      : given(static_cast<bool>(c.law_.place)),
        s(c.place(kin)),
        x(path_rows::see(*c.path_, kin, c.marker_M_, s.value, level)) {
    foot = path_rows::row(x, x.tangent, x.to_point);
    n = c.n_rows();
    for (int i = 0; i < n; ++i) {
      const auto [a, b] = factors(i);
      rows[i] = path_rows::row(x, *a, *b);
      // Without s' and s'', where these follow from the foot.
      mu[i] = given ? 0.0 : -rows[i].h_s / foot.h_s;
      if (given) continue;
      const double h = rows[i].h;
      rows[i].add(mu[i], foot);
      rows[i].h = h;
    }
    if (!given) s.first = -foot.h_t / foot.h_s;
  }
  std::pair<const Sum*, const Sum*> factors(int i) const {
    if (i == 0) return {&x.side, &x.to_point};
    if (i == 1) return {&x.up, &x.to_point};
    if (given && i == 2) return {&x.tangent, &x.to_point};
    switch (i - (given ? 3 : 2)) {
      case 0:
        return {&x.tangent, &x.y_M};
      case 1:
        return {&x.tangent, &x.z_M};
      default:
        return {&x.side, &x.z_M};
    }
  }
  /// The sum of the rows, each times its multiplier.
  Row sum(const double* multipliers) const {
    Row total;
    for (int i = 0; i < n; ++i) total.add(multipliers[i], rows[i]);
    return total;
  }

  bool given;
  Jet s;  ///< its second derivative only where it is given
  Vectors x;
  Row foot, rows[6];
  double mu[6] = {};
  int n = 0;
};

PointOnPath::PointOnPath(std::string name, std::shared_ptr<const BodyPath> path, int marker_M, Law law)
    : Constraint(std::move(name)), path_(std::move(path)), marker_M_(marker_M), law_(std::move(law)) {}

int PointOnPath::n_rows() const {
  const int turns = law_.orientation == PathOrientation::free    ? 0
                    : law_.orientation == PathOrientation::along ? 2
                                                                 : 3;
  return 2 + (law_.place ? 1 : 0) + turns;
}

std::string PointOnPath::row_name(int i) const {
  if (i < 2) return i == 0 ? "side" : "up";
  if (law_.place && i == 2) return "along";
  static const char* const turns[] = {"rotation_z", "rotation_y", "rotation_x"};
  return turns[i - (law_.place ? 3 : 2)];
}

std::vector<int> PointOnPath::markers() const {
  std::vector<int> all = path_->markers();
  all.push_back(marker_M_);
  return all;
}

Jet PointOnPath::place(const Kinematics& kin) const {
  if (law_.place) return law_.place.at(kin);
  double* const contact = kin.own.contact;
  const bool known = contact && std::isfinite(*contact);
  const double s = path_->foot(kin, kin.markers[marker_M_].X_WP.p, known ? *contact : law_.near);
  if (contact) *contact = s;
  return {s, 0.0, 0.0};
}

void PointOnPath::position(const Kinematics& kin, double* g) const {
  const Instant now(*this, kin, Level::position);
  for (int i = 0; i < now.n; ++i) g[i] = now.rows[i].h;
}

void PointOnPath::velocity(const Kinematics& kin, double* g_dot) const {
  const Instant now(*this, kin, Level::velocity);
  for (int i = 0; i < now.n; ++i)
    g_dot[i] = now.rows[i].h_t + (now.given ? now.rows[i].h_s * now.s.first : 0.0);
}

void PointOnPath::acceleration(const Kinematics& kin, double* g_ddot) const {
  const Instant now(*this, kin, Level::acceleration);
  const Jet& s = now.s;
  for (int i = 0; i < now.n; ++i) {
    const Row& row = now.rows[i];
    g_ddot[i] = row.h_tt + 2.0 * row.h_st * s.first + row.h_ss * s.first * s.first;
    if (now.given) g_ddot[i] += row.h_s * s.second;
  }
}

void PointOnPath::rate(const Kinematics& kin, double* g_t) const {
  for (int i = 0; i < n_rows(); ++i) g_t[i] = 0.0;
  if (!law_.place) return;
  const Instant now(*this, kin, Level::position);
  for (int i = 0; i < now.n; ++i) g_t[i] = now.rows[i].h_s * now.s.first;
}

void PointOnPath::by_followed(const Kinematics& kin, int, double* g_y, double* h_y, double* h_y_dot) const {
  const Instant now(*this, kin, Level::velocity);
  for (int i = 0; i < now.n; ++i) {
    g_y[i] = h_y_dot[i] = now.rows[i].h_s;
    h_y[i] = now.rows[i].h_st + now.rows[i].h_ss * now.s.first;
  }
}

void PointOnPath::apply_GT(const Kinematics& kin, const double* x, Loads& loads) const {
  const Instant now(*this, kin, Level::position);
  const Row total = now.sum(x);
  const int F = now.x.markers[0];
  for (int k = 1; k < now.x.n_markers; ++k)
    loads.apply_between(kin, F, now.x.markers[static_cast<std::size_t>(k)],
                        path_rows::wrench_on(now.x, k, total.by));
}

// With T = sum x_i (row_i + mu_i foot) at fixed mu, f_j = T.by_j the force on vector j changes by
//
//     df_j = sum_l S_jl dy_l + T.by_s_j ds + foot.by_j dmu,    S = sum of factors times (a b^T + b a^T),
//     ds = - foot.by . dy / foot_s,    dmu = -(T.by_s . dy + T_ss ds) / foot_s;
//
// and in the rates of rows, of which that of the foot is 0, no change of mu has a part.
void PointOnPath::differentiate(const Kinematics& kin, const double* multipliers, Derivatives& d) const {
  const Instant now(*this, kin, Level::velocity);
  const Vectors& x = now.x;
  const Row total = now.sum(multipliers);
  Eigen::Matrix<double, kVectors, kVectors> S = Eigen::Matrix<double, kVectors, kVectors>::Zero();
  const auto add_product = [&](double factor, const Sum& a, const Sum& b) {
    S += factor * (a[0] * b[0].transpose() + b[0] * a[0].transpose());
  };
  double of_foot = 0.0;
  for (int i = 0; i < now.n; ++i) {
    const auto [a, b] = now.factors(i);
    add_product(multipliers[i], *a, *b);
    of_foot += multipliers[i] * now.mu[i];
  }
  if (!now.given) add_product(of_foot, x.tangent, x.to_point);

  // Of each marker's turn and shift: what the place and the multiplier of the foot do.
  using Row6 = Eigen::Matrix<double, 1, 6>;
  Row6 place[BodyPath::kActive + 1], mu[BodyPath::kActive + 1];
  for (int k = 1; k < x.n_markers; ++k) {
    place[k].setZero();
    mu[k].setZero();
    if (now.given) continue;
    for (int j = 0; j < x.n; ++j) {
      if (x.of[static_cast<std::size_t>(j)] != k) continue;
      const Eigen::Matrix<double, 3, 6> moves = path_rows::motion_of(x, j);
      place[k] -= now.foot.by.col(j).transpose() * moves / now.foot.h_s;
      mu[k] -= total.by_s.col(j).transpose() * moves / now.foot.h_s;
    }
    mu[k] -= total.h_ss / now.foot.h_s * place[k];
  }

  const int F = x.markers[0];
  for (int on = 1; on < x.n_markers; ++on) {
    d.between(F, x.markers[static_cast<std::size_t>(on)], path_rows::wrench_on(x, on, total.by));
    for (int k = 1; k < x.n_markers; ++k) {
      Eigen::Matrix<double, 6, 12> wrench = Eigen::Matrix<double, 6, 12>::Zero();
      for (int j = 0; j < x.n; ++j) {
        if (x.of[static_cast<std::size_t>(j)] != on) continue;
        const Eigen::Matrix<double, 3, 6> moves = path_rows::motion_of(x, j);
        Eigen::Matrix<double, 3, 6> f = total.by_s.col(j) * place[k] + now.foot.by.col(j) * mu[k];
        for (int l = 0; l < x.n; ++l)
          if (x.of[static_cast<std::size_t>(l)] == k && S(j, l) != 0.0)
            f += S(j, l) * path_rows::motion_of(x, l);
        wrench.leftCols<6>() += moves.transpose() * f;
        if (on == k && !x.is_position[static_cast<std::size_t>(j)])
          wrench.topLeftCorner<3, 6>() -= skew(total.by.col(j)) * moves;
      }
      d.by_relative(F, x.markers[static_cast<std::size_t>(k)], wrench);
    }
  }

  d.rows();
  for (int k = 1; k < x.n_markers; ++k) {
    Eigen::Matrix<double, 6, 12> rates = Eigen::Matrix<double, 6, 12>::Zero();
    for (int i = 0; i < now.n; ++i) {
      const Row& row = now.rows[i];
      rates.row(i).head<6>() = (row.h_st + row.h_ss * now.s.first) * place[k];
      for (int j = 0; j < x.n; ++j) {
        if (x.of[static_cast<std::size_t>(j)] != k) continue;
        const Eigen::Matrix<double, 3, 6> moves = path_rows::motion_of(x, j);
        rates.row(i).head<6>() += (row.by_t.col(j) + now.s.first * row.by_s.col(j)).transpose() * moves;
        rates.row(i).tail<6>() += row.by.col(j).transpose() * moves;
        if (!x.is_position[static_cast<std::size_t>(j)])  // y' = w x y turns with y
          rates.row(i).head<3>() +=
              row.by.col(j).transpose() * skew(x.w[static_cast<std::size_t>(k)]) * moves.leftCols<3>();
      }
    }
    d.by_relative(F, x.markers[static_cast<std::size_t>(k)], rates.topRows(now.n));
  }
}

double PointOnPath::contact_residual(const Kinematics& kin, double a) const {
  const Vectors x = path_rows::see(*path_, kin, marker_M_, a, Level::position);
  return path_rows::row(x, x.tangent, x.to_point).h;
}

void PointOnPath::differentiate_contact(const Kinematics& kin, double a, Derivatives& d) const {
  const Vectors x = path_rows::see(*path_, kin, marker_M_, a, Level::position);
  const Row foot = path_rows::row(x, x.tangent, x.to_point);
  d.rows();
  for (int k = 1; k < x.n_markers; ++k) {
    Eigen::Matrix<double, 1, 12> by = Eigen::Matrix<double, 1, 12>::Zero();
    by.head<6>() = path_rows::wrench_on(x, k, foot.by).transpose();
    d.by_relative(x.markers[0], x.markers[static_cast<std::size_t>(k)], by);
  }
  d.by_algebraic(foot.h_s);
}

double PointOnPath::start_contact(const Kinematics& kin) const {
  return path_->foot(kin, kin.markers[marker_M_].X_WP.p, law_.near);
}

std::vector<OutputInfo> PointOnPath::outputs() const {
  std::vector<OutputInfo> infos = {{"place", dim::length, "where along the path, by the undeformed body"},
                                   {"speed", dim::velocity, "rate of the place"},
                                   {"force", dim::force, "size of the force between the bodies"},
                                   {"force_x", dim::force,
                                    "force on the body of `to`, in the axes of the path there: along it "
                                    "(what drives a given place, or guides M along a bend)"},
                                   {"force_y", dim::force, "the same, to its side"},
                                   {"force_z", dim::force, "the same, up"}};
  if (law_.orientation == PathOrientation::free) return infos;
  infos.push_back({"torque", dim::torque, "size of the torque between the bodies"});
  for (const char* axis : {"x", "y", "z"})
    infos.push_back({std::string("torque_") + axis, dim::torque,
                     "torque on the body of `to` about its marker, in the axes of the path there"});
  return infos;
}

void PointOnPath::evaluate_outputs(const Kinematics& kin, const double* x, double* values) const {
  const Instant now(*this, kin, Level::velocity);
  const Vector6d on_M = -path_rows::wrench_on(now.x, now.x.n_markers - 1, now.sum(x).by);
  Matrix3d axes;  // in those of F
  const Vector3d side = now.x.y * now.x.side[0];
  axes.col(0) = (now.x.y * now.x.tangent[0]).normalized();
  axes.col(1) = (side - side.dot(axes.col(0)) * axes.col(0)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Vector3d force = axes.transpose() * on_M.tail<3>(), torque = axes.transpose() * on_M.head<3>();
  *values++ = now.s.value;
  *values++ = now.s.first;
  *values++ = force.norm();
  for (int i = 0; i < 3; ++i) *values++ = force(i);
  if (law_.orientation == PathOrientation::free) return;
  *values++ = torque.norm();
  for (int i = 0; i < 3; ++i) *values++ = torque(i);
}

}  // namespace flexura::mbs
