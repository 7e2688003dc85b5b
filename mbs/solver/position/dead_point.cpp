// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/dead_point.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/position/assemble.hpp"

namespace flexura::mbs {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A mechanism assembled at a dead point is there to the square root of round-off, and so are the singular values.
constexpr double kLost = 1e-7;
/// An integrator gives up before the dead point that it cannot pass: speeds there grow as 1 / sigma.
constexpr double kNearlyLost = 1e-2;
/// Loops are closed to 1e-9 of the mechanism's size and better (PositionSolver), double roots to the root of that.
constexpr double kMostDoubt = 1e-3;
/// A row that bends by less than this part of its size does not bend: what is left of its second derivative is round-off.
constexpr double kBends = 1e-6;
/// Dense decompositions of larger mechanisms take longer than their message is worth.
constexpr int kMostRows = 600;

/// Four at most: a message is read, not studied.
std::string list(const std::vector<std::string>& names) {
  const std::size_t shown = std::min<std::size_t>(names.size(), 4);
  return fmt::format("{}{}", fmt::join(names.begin(), names.begin() + static_cast<long>(shown), ", "),
                     shown < names.size() ? fmt::format(" and {} more", names.size() - shown) : "");
}

class ScaledRows {
 public:
  ScaledRows(const Equations& eq, const State& s)
      : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()), s_(s) {
    MatrixXd M = MatrixXd::Zero(n_.n_v, n_.n_v);
    B.setZero(n_.n_lambda, n_.n_v);
    eq.mass_matrix(s.p, *scratch_, M);
    eq.constraint_matrix(s, s.p, *scratch_, B);
    D = M.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    const VectorXd lost = nearly_vanishing(B);
    B = (B * D.asDiagonal()).eval();
    E = B.rowwise().norm().cwiseMax(lost);
    for (double& x : E) x = x > 0.0 ? 1.0 / x : 1.0;
    B = (E.asDiagonal() * B).eval();
    for (int k = 0; k < n_.n_lambda; ++k)
      if (lost(k) > 0.0) B.row(k).setZero();
  }

  int rank() const {
    Eigen::ColPivHouseholderQR<MatrixXd> qr(B.transpose());
    qr.setThreshold(kLost);
    return static_cast<int>(qr.rank());
  }
  /// gamma of speeds w, scaled.
  VectorXd gamma(const VectorXd& w) const { return E.cwiseProduct(gamma_of(w)); }
  /// Those with a share in any of the left vectors.
  std::vector<std::string> rows(const MatrixXd& Y) const {
    std::vector<std::string> names;
    const double largest = Y.cwiseAbs().maxCoeff();
    for (int k = 0; k < n_.n_lambda; ++k)
      if (Y.row(k).cwiseAbs().maxCoeff() > 0.1 * largest)
        names.push_back("\"" + eq_.name_of_constraint(k) + "\"");
    return names;
  }
  /// Those that a right vector moves.
  std::vector<std::string> speeds(const MatrixXd& N) const {
    std::vector<std::string> names;
    const MatrixXd moves = D.asDiagonal() * N;
    const double largest = moves.cwiseAbs().maxCoeff();
    for (int i = 0; i < n_.n_v && names.size() < 4; ++i)
      if (moves.row(i).cwiseAbs().maxCoeff() > 0.1 * largest)
        names.push_back("\"" + eq_.name_of_velocity(i) + "\"");
    return names;
  }

  /// Whether a row vanishes there but for what positions are wrong by.
  bool is_inexact() const { return is_inexact_; }

  MatrixXd B;     // E G D
  VectorXd D, E;  // scales of columns and rows

 private:
  VectorXd gamma_of(const VectorXd& w) const {
    VectorXd out(n_.n_lambda);
    eq_.acceleration_constraints(s_, s_.p, w, VectorXd::Zero(n_.n_v), *scratch_, out);
    return out;
  }
  /// Where loops are closed at a double root (a parallelogram drawn beside its dead point and driven there), positions are
  /// right to the root of what the row is open by, |g| = bend w^2 / 2, and of round-off. What that leaves of a row that
  /// vanishes there is no direction, and made a unit it would pass for one: it is taken
  /// for zero, and measured by its second derivative along motions as large as the mechanism. Zero for the others.
  VectorXd nearly_vanishing(const MatrixXd& G) {
    VectorXd scale(n_.n_v), lost = VectorXd::Zero(n_.n_lambda);
    for (int i = 0; i < n_.n_v; ++i) scale(i) = eq_.velocity_scale(i);
    const VectorXd largest = (G * scale.asDiagonal()).cwiseAbs().rowwise().maxCoeff();
    VectorXd g(n_.n_lambda);
    eq_.position_constraints(s_, s_.p, *scratch_, g);
    // A row bends by not much more than its size: the others need no second look.
    const VectorXd size = eq_.constraint_sizes(s_, s_.p, *scratch_).size.cwiseMax(1e-300);
    const auto doubt = [&](Eigen::Index k, double bends) {
      return std::clamp(4.0 * std::sqrt(std::abs(g(k)) / bends), kLost, kMostDoubt);
    };
    bool looks = false;
    for (int k = 0; k < n_.n_lambda; ++k) looks = looks || largest(k) < 10.0 * doubt(k, size(k)) * size(k);
    if (!looks) return lost;
    const VectorXd rest = VectorXd::Zero(n_.n_v), still = gamma_of(rest);
    VectorXd bends = lost, as_row = lost, w = rest;
    for (int i = 0; i < n_.n_v; ++i) {
      w(i) = scale(i);
      const VectorXd bend = (gamma_of(w) - still).cwiseAbs();
      w(i) = 0.0;
      bends = bends.cwiseMax(bend);
      as_row = as_row.cwiseMax(bend * (D(i) / scale(i)));
    }
    for (int k = 0; k < n_.n_lambda; ++k)
      if (bends(k) > kBends * size(k) && largest(k) < doubt(k, bends(k)) * bends(k)) {
        lost(k) = as_row(k);
        is_inexact_ = is_inexact_ || largest(k) > 1e-12 * bends(k);
      }
    return lost;
  }

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  const State& s_;
  bool is_inexact_ = false;
};

}  // namespace

bool loses_rank(const Equations& eq, const State& s) {
  const Sizes n = eq.sizes();
  return n.n_lambda > 0 && n.n_v > 0 && n.n_lambda <= kMostRows && ScaledRows(eq, s).rank() < n.n_lambda;
}

std::string require_one_branch(const Equations& eq, const State& s, const VectorXd& v_dot) {
  const Sizes n = eq.sizes();
  if (n.n_lambda == 0 || n.n_v == 0 || n.n_lambda > kMostRows) return {};
  const ScaledRows rows(eq, s);
  const int rank = rows.rank();
  if (rank == n.n_lambda) return {};
  const Eigen::JacobiSVD<MatrixXd> svd(rows.B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const MatrixXd Y = svd.matrixU().rightCols(n.n_lambda - rank), N = svd.matrixV().rightCols(n.n_v - rank);
  // Along N, where the speeds point or, from rest, soon will.
  const auto along = [&](const VectorXd& w) { return VectorXd(N.transpose() * w.cwiseQuotient(rows.D)); };
  const auto largest = [&](const VectorXd& w) { return w.cwiseQuotient(rows.D).norm(); };
  const std::string rows_here = list(rows.rows(Y));
  const VectorXd nothing = rows.gamma(VectorXd::Zero(n.n_v));
  const auto Q = [&](const VectorXd& speed) {
    return VectorXd(Y.transpose() * (rows.gamma(speed) - nothing));
  };
  const auto direction = [&](Eigen::Index j) { return VectorXd(rows.D.cwiseProduct(N.col(j))); };
  double steepest = 0.0;
  for (Eigen::Index j = 0; j < N.cols(); ++j) steepest = std::max(steepest, Q(direction(j)).norm());
  // Bodies whose modes bend them and do not stretch them hold a straight loop so.
  const auto too_few_modes = [&] {
    int i_p = 0;
    double k = 0.0, d = 0.0;
    for (int i = 0; i < n.n_v; ++i)
      if (N.row(i).norm() > 0.1 * N.rowwise().norm().maxCoeff() && !eq.elastic_coordinate(i, i_p, k, d))
        return false;
    return true;
  };
  const auto refuse = [&] {
    // One second-order condition along v + N z,  z^T A z + b^T z + c = 0: is there any motion that meets it?
    if (Y.cols() == 1) {
      const auto condition = [&](const VectorXd& w) { return Y.col(0).dot(rows.gamma(w)); };
      MatrixXd A(N.cols(), N.cols());
      VectorXd b(N.cols());
      for (Eigen::Index i = 0; i < N.cols(); ++i) {
        b(i) = 0.5 * (condition(s.v + direction(i)) - condition(s.v - direction(i)));
        for (Eigen::Index j = 0; j <= i; ++j)
          A(i, j) = A(j, i) = 0.25 * (Q(direction(i) + direction(j)) - Q(direction(i) - direction(j)))(0);
      }
      const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(A);
      const VectorXd& bends = eigen.eigenvalues();
      const double least = 1e-9 * bends.cwiseAbs().maxCoeff(), c = condition(s.v);
      const bool up = bends(0) > least, down = bends(bends.size() - 1) < -least;
      if (up || down) {
        const VectorXd b_i = eigen.eigenvectors().transpose() * b;
        const double extreme = c - 0.25 * b_i.cwiseAbs2().cwiseQuotient(bends).sum();
        const double size = std::abs(c) + 0.25 * b_i.cwiseAbs2().cwiseQuotient(bends).cwiseAbs().sum();
        if (up ? extreme >= -1e-9 * size : extreme <= 1e-9 * size)
          throw AssemblyError(
              fmt::format("the mechanism is stretched out or locked at t = {:.6g} s: the constraints {} let "
                          "it move to first "
                          "order and forbid it in second, and its drives, speeds or loads ask for that "
                          "motion; change the "
                          "lengths or the drives, or start where the parts have play",
                          s.t, rows_here));
      }
    }
    throw AssemblyError(fmt::format(
        "the mechanism starts at a dead point: at t = {:.6g} s the constraints {} depend on each "
        "other for an "
        "instant, and which way it goes on is ambiguous; give {}speeds of one branch of the motion "
        "for {}, or start "
        "beside it{}",
        s.t, rows_here, rows.is_inexact() ? "the exact positions of that point and " : "",
        list(rows.speeds(N)),
        too_few_modes()
            ? "; where bodies bend there they may lack the modes that stretch them: attachments = "
              "\"used\" keeps these"
            : ""));
  };
  // G v' = -gamma has no solution where these speeds leave the constraints in second order.
  const VectorXd gamma = rows.gamma(s.v);
  const double speed = largest(s.v);
  if ((Y.transpose() * gamma).norm() > 1e-6 * (gamma.norm() + steepest * speed * speed)) refuse();
  if (along(s.v).norm() > 1e-9 * (speed + 1e-3 * std::sqrt(largest(v_dot)))) return {};
  // From rest the motion begins along the accelerations; those of least constraint (Gauss) among all that the
  // rows allow to first order are the least among those of the branches, too, where they lie on one.
  const double start = largest(v_dot);
  const bool moves = start > 0.0 && along(v_dot).norm() > 1e-9 * start;
  if (moves && Q(v_dot / start).norm() > 1e-6 * steepest) refuse();
  return fmt::format(
      "the mechanism starts from rest at a dead point, where the constraints {} depend on each other for an "
      "instant "
      "and motions cross: {}; give speeds for {} to choose another branch",
      rows_here,
      moves ? "it begins along the one that its loads ask for" : "nothing moves it away from there",
      list(rows.speeds(N)));
}

std::string with_rank_loss(const Equations& eq, const State& s, const std::string& trouble) {
  const Sizes n = eq.sizes();
  if (n.n_lambda == 0 || n.n_v == 0 || n.n_lambda > kMostRows || !s.p.allFinite()) return trouble;
  const ScaledRows rows(eq, s);
  if (!rows.B.allFinite()) return trouble;
  const Eigen::JacobiSVD<MatrixXd> svd(rows.B, Eigen::ComputeFullU | Eigen::ComputeThinV);
  const VectorXd& sigma = svd.singularValues();
  const double least = n.n_lambda > n.n_v ? 0.0 : sigma(sigma.size() - 1);
  if (least > kNearlyLost * sigma(0)) return trouble;
  // One sentence: of the integrator's own only what it could not do, not when.
  const std::size_t end = std::min(trouble.find_first_of(":;,"), trouble.find(" at t = "));
  return fmt::format(
      "the mechanism locks or stands at a dead point at t = {:.9g} s: the constraints {} lose rank there "
      "(smallest "
      "singular value {:.1e}); change the lengths, end the drive before it, or drive another joint ({})",
      s.t, list(rows.rows(svd.matrixU().rightCols(1))), least / sigma(0), trouble.substr(0, end));
}

std::string near_rank_loss(const Equations& eq, const RankWatch::Nearness& nearness, double misfit,
                           double tolerance) {
  // Rows that are near to dependent wherever the mechanism stands (a heavy body on a light one) lose no rank.
  constexpr double kComesNear = 0.1;
  const double sigma = nearness.sigma;
  if (nearness.p.size() == 0 || !nearness.p.allFinite()) return {};
  const double by_misfit = sigma < kComesNear * nearness.largest ? misfit / (sigma * sigma) : 0.0;
  if (!(nearness.doubt > tolerance || by_misfit > 10.0 * tolerance)) return {};
  const double doubt = std::max(nearness.doubt, by_misfit);
  std::string which = "rows";
  const Sizes n = eq.sizes();
  if (n.n_lambda <= kMostRows) {
    State s = make_state(eq);
    s.t = nearness.t;
    s.p = nearness.p;
    const ScaledRows rows(eq, s);
    if (rows.B.allFinite()) {
      const Eigen::JacobiSVD<MatrixXd> svd(rows.B, Eigen::ComputeFullU);
      which = "constraints " + list(rows.rows(svd.matrixU().rightCols(1)));
    }
  }
  return fmt::format(
      "near t = {:.6g} s the {} come close to depending on each other (singular value {:.1e}): speeds, "
      "accelerations, "
      "forces and the energy balance there are right to {} of themselves, not to the tolerance; {}",
      nearness.t, which, sigma, doubt < 1.0 ? fmt::format("{:.1e}", doubt) : "nothing",
      misfit > 4.0 * std::numeric_limits<double>::epsilon()
          ? "give markers with more digits, or lead the mechanism not through there"
          : "lead the mechanism not through there");
}

}  // namespace flexura::mbs
