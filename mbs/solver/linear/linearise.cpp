// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/linearise.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/saddle.hpp"
#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/independent.hpp"

namespace flexura::mbs {

namespace {

class Lineariser {
 public:
  Lineariser(const Equations& eq, const State& s) : eq_(eq), n_(eq.sizes()), s_0_(s), accelerations_(eq) {
    accelerations_.solve(s_0_, v_dot_0_);
    choose_coordinates();
    keep_.keep_position.assign(n_.n_v, false);
    for (const int i : independent_) keep_.keep_position[i] = true;
    keep_.keep_velocity = keep_.keep_position;
    prepare_kinematics();
  }

  LinearSystem system(const LineariseOptions& options);

 private:
  struct Sample {
    State s;
    Eigen::VectorXd v_dot, c_rate;
  };

  void choose_coordinates();
  void prepare_kinematics();
  bool has_exact_system();
  void set_exactly(LinearSystem& out);
  Sample at(int column, double step);
  Eigen::VectorXd rates(const Sample& sample) const;
  Sample with_input(int input, double step);
  Eigen::VectorXd c_rates(const State& s, const Eigen::VectorXd& v_dot);

  const Equations& eq_;
  Sizes n_;
  State s_0_;
  Eigen::VectorXd v_dot_0_, p_dot_0_;
  AccelerationSolver accelerations_;
  AssembleOptions keep_;
  std::vector<int> independent_;
  std::vector<std::string> coordinate_name_;  ///< of each velocity coordinate's integral
  Eigen::MatrixXd M_, G_, N_, T_inverse_, T_dot_;
};

void Lineariser::choose_coordinates() {
  auto scratch = eq_.make_scratch();
  M_.setZero(n_.n_v, n_.n_v);
  G_.setZero(n_.n_lambda, n_.n_v);
  eq_.mass_matrix(s_0_.p, *scratch, M_);
  eq_.constraint_matrix(s_0_, s_0_.p, *scratch, G_);
  IndependentCoordinates z = independent_coordinates(M_, G_);
  independent_ = std::move(z.independent);
  N_ = std::move(z.N);
}

void Lineariser::prepare_kinematics() {
  // dq = T^+ dp; with v != 0 also dT/dt, for the rate of dq in the moving coordinates.
  KinematicBlocks kinematics(eq_, s_0_.p);
  p_dot_0_.setZero(n_.n_p);
  eq_.kinematic(s_0_.p, s_0_.v, p_dot_0_);
  T_inverse_.setZero(n_.n_v, n_.n_p);
  T_dot_.setZero(n_.n_p, n_.n_v);
  const double dt = 1e-5;
  auto scatter = [&](double sign) {
    kinematics.update(s_0_.p + sign * dt * p_dot_0_, s_0_.v);
    for (const auto& b : kinematics.blocks())
      for (std::size_t i = 0; i < b.p.size(); ++i)
        for (std::size_t j = 0; j < b.v.size(); ++j) T_dot_(b.p[i], b.v[j]) += sign * b.T(i, j) / (2 * dt);
  };
  scatter(1.0);
  scatter(-1.0);
  kinematics.update(s_0_.p, s_0_.v);
  coordinate_name_.resize(n_.n_v);
  for (const auto& b : kinematics.blocks()) {
    if (b.v.empty()) continue;
    for (const int j : b.v)
      coordinate_name_[j] =
          b.p.size() == 1 ? eq_.name_of_position(b.p[0]) : "integral of " + eq_.name_of_velocity(j);
    const Eigen::MatrixXd inverse = b.T.completeOrthogonalDecomposition().pseudoInverse();
    for (std::size_t i = 0; i < b.p.size(); ++i)
      for (std::size_t j = 0; j < b.v.size(); ++j) T_inverse_(b.v[j], b.p[i]) = inverse(j, i);
  }
}

Lineariser::Sample Lineariser::at(int column, double step) {
  const int n_z = static_cast<int>(independent_.size());
  Sample out;
  out.s = s_0_;
  if (column < n_z) {
    Eigen::VectorXd p(n_.n_p);
    eq_.retract(s_0_.p, step * N_.col(column), p);
    out.s.p = p;
    assemble_positions(eq_, out.s, keep_);
  } else if (column < 2 * n_z) {
    out.s.v += step * N_.col(column - n_z);
  } else {
    out.s.c(column - 2 * n_z) += step;
    if (eq_.follows_states()) assemble_positions(eq_, out.s, keep_);
  }
  AssembleReport ignored;
  assemble_velocities(eq_, out.s, keep_, ignored);
  accelerations_.solve(out.s, out.v_dot);
  out.c_rate = accelerations_.c_rate();
  return out;
}

Lineariser::Sample Lineariser::with_input(int input, double step) {
  Sample out{s_0_, {}, {}};
  out.s.u = step * Eigen::VectorXd::Unit(eq_.n_inputs(), input);
  accelerations_.solve(out.s, out.v_dot);
  out.c_rate = accelerations_.c_rate();
  return out;
}

// Rates of (z, z', c) relative to those of the linearisation state.
Eigen::VectorXd Lineariser::rates(const Sample& sample) const {
  const int n_z = static_cast<int>(independent_.size());
  Eigen::VectorXd p_dot(n_.n_p), out(2 * n_z + n_.n_dyn);
  eq_.kinematic(sample.s.p, sample.s.v, p_dot);
  const Eigen::VectorXd dq = T_inverse_ * (sample.s.p - s_0_.p);
  const Eigen::VectorXd dq_dot = T_inverse_ * (p_dot - p_dot_0_ - T_dot_ * dq);
  for (int k = 0; k < n_z; ++k) {
    out(k) = dq_dot(independent_[k]);
    out(n_z + k) = sample.v_dot(independent_[k]) - v_dot_0_(independent_[k]);
  }
  out.tail(n_.n_dyn) = sample.c_rate;
  return out;
}

Eigen::VectorXd Lineariser::c_rates(const State& s, const Eigen::VectorXd& v_dot) {
  Eigen::VectorXd r(n_.n_v), c(n_.n_dyn), b(n_.n_alg);
  eq_.momentum(s, v_dot, *eq_.make_scratch(), r, c, b);
  return c;
}

// At rest, and where there are constraints with accelerations that are no more than what a solver left, on rows that
// hold still: the derivatives of the momentum rows are then all there is. Dynamic states that answer to accelerations
// or reactions are left to differences.
bool Lineariser::has_exact_system() {
  // Of all that moves [m/s^2, rad/s^2]: as much as the curvature of constraints adds to squares of frequencies.
  constexpr double kNoAcceleration = 1e-5;
  if (!s_0_.v.isZero(0.0) || eq_.follows_states() || eq_.algebraic_is_coupled()) return false;
  if (n_.n_lambda == 0) return true;
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!eq_.is_holonomic(k)) return false;
  if (std::sqrt(v_dot_0_.dot(M_ * v_dot_0_)) > kNoAcceleration * std::sqrt(M_.diagonal().maxCoeff()))
    return false;
  auto scratch = eq_.make_scratch();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n_.n_v);
  Eigen::VectorXd g_t(n_.n_lambda), g_tt(n_.n_lambda);
  eq_.velocity_constraints(s_0_, s_0_.p, rest, *scratch, g_t);
  eq_.acceleration_constraints(s_0_, s_0_.p, rest, rest, *scratch, g_tt);
  return g_t.isZero(0.0) && g_tt.isZero(0.0);
}

// With y = (c, a) and a from its own rows, b_a a = -(b_p z + b_v z' + b_c c).
void Lineariser::set_exactly(LinearSystem& out) {
  const int n_z = static_cast<int>(independent_.size()), n_c = n_.n_dyn, n_a = n_.n_alg;
  Tangents t(eq_);
  t.evaluate(s_0_, v_dot_0_);
  if (t.c_v_dot.size() > 0 || t.c_lambda.size() > 0) return;
  KinematicBlocks kinematics(eq_, s_0_.p);
  kinematics.update(s_0_.p, s_0_.v);
  Eigen::MatrixXd K;
  kinematics.multiply_T(t.z_p, K);
  // Columns of (z, z', c) for the rows (r, c', b).
  Eigen::MatrixXd Z(n_.n_v + n_c + n_a, 2 * n_z + n_c);
  Z << K * N_, t.z_v * N_, t.z_c;
  if (n_a > 0) {
    const Eigen::FullPivLU<Eigen::MatrixXd> b_a(t.z_a.bottomRows(n_a));
    if (!b_a.isInvertible()) return;
    const Eigen::MatrixXd by_a = b_a.solve(Z.bottomRows(n_a));
    Z -= t.z_a * by_a;
  }
  out.A.topRows(n_z).setZero();
  out.A.block(0, n_z, n_z, n_z).setIdentity();
  const Eigen::MatrixXd M_z = N_.transpose() * M_ * N_;
  const Eigen::VectorXd unit = M_z.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> llt(unit.asDiagonal() * M_z * unit.asDiagonal());
  if (llt.info() != Eigen::Success) return;
  const Eigen::MatrixXd forces = unit.asDiagonal() * (N_.transpose() * Z.topRows(n_.n_v));
  out.A.middleRows(n_z, n_z) = -(unit.asDiagonal() * llt.solve(forces));
  out.A.bottomRows(n_c) = Z.middleRows(n_.n_v, n_c);
  out.relative_error = 1e-14;
}

LinearSystem Lineariser::system(const LineariseOptions& options) {
  const int n_z = static_cast<int>(independent_.size()), n_x = 2 * n_z + n_.n_dyn;
  LinearSystem out;
  out.independent = independent_;
  out.N = N_;
  out.x_0.setZero(n_x);
  for (int k = 0; k < n_z; ++k) {
    out.states.push_back(coordinate_name_[independent_[k]]);
    out.x_0(n_z + k) = s_0_.v(independent_[k]);
  }
  const Eigen::VectorXd q_0 = T_inverse_ * s_0_.p;
  for (int k = 0; k < n_z; ++k) {
    out.x_0(k) = q_0(independent_[k]);
    out.states.push_back(eq_.name_of_velocity(independent_[k]));
  }
  for (int k = 0; k < n_.n_dyn; ++k) {
    out.states.push_back(eq_.name_of_dynamic(k));
    out.x_0(2 * n_z + k) = s_0_.c(k);
  }
  if (options.outputs) {
    out.y_0 = options.outputs(s_0_, v_dot_0_);
    out.outputs = options.output_names;
  }
  out.A.setZero(n_x, n_x);
  out.V.setZero(n_.n_v, n_z);
  out.C.setZero(out.y_0.size(), n_x);
  if (has_exact_system()) set_exactly(out);
  const bool is_exact = out.relative_error < 1e-12;
  for (int j = 0; j < n_x && !(is_exact && !options.outputs); ++j) {
    // Central differences: eps^(1/3) of the typical size.
    const double size =
        j < 2 * n_z ? eq_.velocity_scale(independent_[j % n_z]) : std::max(1.0, std::abs(out.x_0(j)));
    const double step = 1e-5 * size;
    const Sample up = at(j, step), down = at(j, -step);
    if (!is_exact) out.A.col(j) = (rates(up) - rates(down)) / (2.0 * step);
    if (j < n_z) out.V.col(j) = (up.s.v - down.s.v) / (2.0 * step);
    if (options.outputs)
      out.C.col(j) = (options.outputs(up.s, up.v_dot) - options.outputs(down.s, down.v_dot)) / (2.0 * step);
  }
  // A unit force on a coordinate changes the accelerations by the saddle-point system's first block.
  const int n_f = static_cast<int>(options.inputs.size()),
            n_u = n_f + static_cast<int>(options.signals.size());
  out.B.setZero(n_x, n_u);
  out.D.setZero(out.y_0.size(), n_u);
  out.u_0.setZero(n_u);
  SaddleSolver saddle;
  if (n_f > 0) saddle.factor(eq_, M_, G_);
  for (int k = 0; k < n_f; ++k) {
    Eigen::VectorXd a, lambda;
    saddle.solve(Eigen::VectorXd::Unit(n_.n_v, options.inputs[k]), Eigen::VectorXd::Zero(n_.n_lambda), a,
                 lambda);
    for (int i = 0; i < n_z; ++i) out.B(n_z + i, k) = a(independent_[i]);
    out.inputs.push_back("force on " + eq_.name_of_velocity(options.inputs[k]));
    // Dynamic states and outputs see accelerations and reactions linearly.
    State loaded = s_0_;
    loaded.lambda += lambda;
    out.B.col(k).tail(n_.n_dyn) = c_rates(loaded, v_dot_0_ + a) - c_rates(s_0_, v_dot_0_);
    if (options.outputs) {
      out.D.col(k) = options.outputs(loaded, v_dot_0_ + a) - out.y_0;
    }
  }
  for (int k = n_f; k < n_u; ++k) {
    const int input = options.signals[k - n_f];
    out.inputs.push_back(eq_.name_of_input(input));
    out.u_0(k) = eq_.input_value(input, s_0_.t);
    const double step = 1e-5 * std::max(1.0, std::abs(out.u_0(k)));
    const Sample up = with_input(input, step), down = with_input(input, -step);
    out.B.col(k) = (rates(up) - rates(down)) / (2.0 * step);
    if (options.outputs)
      out.D.col(k) = (options.outputs(up.s, up.v_dot) - options.outputs(down.s, down.v_dot)) / (2.0 * step);
  }
  return out;
}

}  // namespace

LinearSystem linearise(const Equations& eq, const State& s, const LineariseOptions& options) {
  return Lineariser(eq, s).system(options);
}

LinearSystem in_turning_axes(LinearSystem system, const Eigen::MatrixXd& W) {
  // dq = exp(t W) dq_K, so that dq_K' = dq' - W dq at t = 0, and dv likewise.
  const auto n_z = static_cast<Eigen::Index>(system.independent.size());
  const Eigen::MatrixXd by_z = (W * system.N)(system.independent, Eigen::all),
                        by_v = (W * system.V)(system.independent, Eigen::all);
  system.A.topLeftCorner(n_z, n_z) -= by_z;
  system.A.block(n_z, 0, n_z, n_z) -= by_v;
  system.A.block(n_z, n_z, n_z, n_z) -= by_z;
  return system;
}

namespace {

// Units of the coordinates, powers of 2, in which rows and columns of A are of one size: B. N. Parlett, C. Reinsch,
// Numer. Math. 13 (1969) 293.
Eigen::VectorXd balance(const Eigen::MatrixXd& A) {
  const Eigen::Index n = A.rows();
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(n);
  constexpr int kMostPasses = 100;
  bool changes = true;
  for (int pass = 0; pass < kMostPasses && changes; ++pass) {
    changes = false;
    for (Eigen::Index i = 0; i < n; ++i) {
      double row = 0.0, column = 0.0;
      for (Eigen::Index j = 0; j < n; ++j)
        if (j != i) {
          row += std::abs(A(i, j)) * unit(j) / unit(i);
          column += std::abs(A(j, i)) * unit(i) / unit(j);
        }
      if (!(row > 0.0) || !(column > 0.0)) continue;
      const double factor = std::exp2(std::round(0.5 * std::log2(row / column)));
      if (column * factor + row / factor >= 0.95 * (row + column)) continue;
      unit(i) *= factor;
      changes = true;
    }
  }
  return unit;
}

}  // namespace

std::vector<NaturalMode> natural_modes(const LinearSystem& system) {
  if (system.A.rows() == 0) return {};
  const Eigen::VectorXd unit = balance(system.A);
  const Eigen::MatrixXd A = unit.cwiseInverse().asDiagonal() * system.A * unit.asDiagonal();
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(A);
  // What rounding makes of the eigenvalues shows where A^T has others.
  const Eigen::VectorXcd again =
      Eigen::EigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(A.transpose()), false).eigenvalues();
  const auto n_z = static_cast<Eigen::Index>(system.independent.size());
  std::vector<NaturalMode> modes;
  for (Eigen::Index i = 0; i < system.A.rows(); ++i) {
    std::complex<double> value = solver.eigenvalues()(i);
    if (value.imag() < 0.0) continue;
    NaturalMode mode;
    mode.eigenvalue = value;
    constexpr double kOfSample = 10.0;
    mode.noise =
        kOfSample * (again.array() - value).abs().minCoeff() + system.relative_error * std::abs(value);
    if (std::abs(value.real()) <= mode.noise) mode.eigenvalue.real(0.0);
    if (std::abs(value.imag()) <= mode.noise) mode.eigenvalue.imag(0.0);
    value = mode.eigenvalue;
    mode.frequency_hz = value.imag() / (2.0 * M_PI);
    mode.damping = std::abs(value) > 0.0 ? -value.real() / std::abs(value) : 0.0;
    mode.shape = system.N.cast<std::complex<double>>() *
                 (unit.head(n_z).asDiagonal() * solver.eigenvectors().col(i).head(n_z));
    Eigen::Index largest = 0;
    if (mode.shape.size() > 0 && mode.shape.cwiseAbs().maxCoeff(&largest) > 0.0)
      mode.shape /= mode.shape(largest);
    modes.push_back(std::move(mode));
  }
  std::stable_sort(modes.begin(), modes.end(), [](const NaturalMode& a, const NaturalMode& b) {
    return std::abs(a.eigenvalue.imag()) != std::abs(b.eigenvalue.imag())
               ? std::abs(a.eigenvalue.imag()) < std::abs(b.eigenvalue.imag())
               : a.eigenvalue.real() < b.eigenvalue.real();
  });
  return modes;
}

std::vector<Eigen::MatrixXcd> frequency_response(const LinearSystem& system,
                                                 const Eigen::VectorXd& frequencies_hz) {
  std::vector<Eigen::MatrixXcd> out;
  const Eigen::MatrixXcd A = system.A.cast<std::complex<double>>();
  for (const double f : frequencies_hz) {
    Eigen::MatrixXcd dynamic = -A;
    dynamic.diagonal().array() += std::complex<double>(0.0, 2.0 * M_PI * f);
    out.push_back(system.C.cast<std::complex<double>>() *
                      dynamic.partialPivLu().solve(system.B.cast<std::complex<double>>()) +
                  system.D.cast<std::complex<double>>());
  }
  return out;
}

}  // namespace flexura::mbs
