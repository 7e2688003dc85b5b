// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/modes.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mbs/superelement/checks.hpp"

namespace flexura::superelement {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

std::vector<int> free_dofs(const Superelement& se, const std::vector<std::string>& held) {
  for (const std::string& name : held) {
    const bool known = std::any_of(se.interfaces.begin(), se.interfaces.end(),
                                   [&](const Interface& interface) { return interface.name == name; });
    if (known) continue;
    std::string names;
    for (const Interface& interface : se.interfaces) names += (names.empty() ? "" : ", ") + interface.name;
    throw std::invalid_argument(
        fmt::format("there is no interface \"{}\" in superelement \"{}\"; it has {}", name, se.name, names));
  }
  std::vector<int> dofs;
  for (const Interface& interface : se.interfaces) {
    if (std::find(held.begin(), held.end(), interface.name) != held.end()) continue;
    for (std::size_t i = 0; i < interface.directions.size(); ++i) {
      dofs.push_back(interface.first_dof + static_cast<int>(i));
    }
  }
  for (int k = se.n_b; k < se.n(); ++k) dofs.push_back(k);
  for (const Interface& interface : se.interfaces) {
    if (interface.following.empty() || std::find(held.begin(), held.end(), interface.name) == held.end())
      continue;
    const Eigen::MatrixXd moved = interface.follow(Eigen::all, dofs);
    if (dofs.empty() || moved.cwiseAbs().maxCoeff() < 1e-9 * interface.follow.cwiseAbs().maxCoeff()) continue;
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": interface \"{}\" cannot be held alone, as not all of its "
                    "directions are coordinates of "
                    "their own (a body of few modes); hold the others with it",
                    se.name, interface.name));
  }
  return dofs;
}

// The rigid motions (columns in the span of R) that move no held dof. The rotations are scaled by a length of
// the body, so that singular values compare; a motion counts as held when it moves a held dof at all beyond
// round-off.
Eigen::MatrixXd free_rigid_motions(const Eigen::MatrixXd& R, const std::vector<int>& free, double length) {
  std::vector<int> held;
  for (int i = 0; i < R.rows(); ++i) {
    if (!std::binary_search(free.begin(), free.end(), i)) held.push_back(i);
  }
  Eigen::MatrixXd scaled = R;
  scaled.rightCols(3) /= length;
  if (held.empty()) return scaled;
  Eigen::MatrixXd R_held = scaled(held, Eigen::all);
  // Rotation entries of the held rows are in rad: times a length they compare with displacements.
  for (Eigen::Index i = 0; i < R_held.rows(); ++i) {
    if (R_held.row(i).head(3).isZero(0.0)) R_held.row(i) *= length;
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(R_held.transpose());
  qr.setThreshold(1e-9);  // entries are of order 1, errors of order epsilon times coordinate over length
  const Eigen::MatrixXd Q = qr.householderQ() * Eigen::MatrixXd::Identity(6, 6);
  return scaled * Q.rightCols(6 - qr.rank());
}

struct Elastic {
  Eigen::VectorXd omega2;
  Eigen::MatrixXd phi;         // in the free dofs, phi^T M phi = 1
  Eigen::MatrixXd mechanisms;  // likewise
};

// Motions that strain nothing beside the rigid ones R: eigenvectors of K, scaled, with eigenvalues that are round-off of K itself
// and of the computation that gave it.  n x count, orthogonal to R in the scaled dofs.
Eigen::MatrixXd mechanisms_of(const Eigen::MatrixXd& K, const Eigen::VectorXd& stiffness,
                              const Eigen::MatrixXd& R, const std::string& name) {
  const Eigen::Index n = K.rows(), n_r = R.cols();
  // Constraint modes leave 1e-12 and more of a unit diagonal.  Bending of a beam with n interfaces is soft, too, (4.73 / n)^4 / 24,
  // but the next mode is not far above it: what has no strain stands apart.
  constexpr double nothing = 1e-10, apart = 1e4;
  // A dof that moves the body without strain has round-off for its diagonal: it is not scaled up.
  constexpr double least = 1e-6;
  const Eigen::VectorXd s = (K.diagonal().cwiseMax(0.0) + least * stiffness).cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd Z = Eigen::MatrixXd::Identity(n, n);
  if (n_r > 0) {
    const Eigen::MatrixXd R_s = s.cwiseInverse().asDiagonal() * R;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(R_s);
    Z = (qr.householderQ() * Z).rightCols(n - n_r).eval();
  }
  Eigen::MatrixXd K_c = s.asDiagonal() * K * s.asDiagonal();
  K_c = Z.transpose() * (0.5 * (K_c + K_c.transpose())).eval() * Z;
  // Most have none: no eigenvalue is much below the least pivot.
  if (const Eigen::LLT<Eigen::MatrixXd> factor(K_c);
      factor.info() == Eigen::Success &&
      factor.matrixLLT().diagonal().cwiseAbs2().minCoeff() > 1000 * nothing)
    return Eigen::MatrixXd(n, 0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(K_c);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const Eigen::Index n_c = values.size();
  Eigen::Index count = 0;
  for (Eigen::Index k = 0; k < n_c && values(k) <= nothing; ++k)
    if (k + 1 == n_c || values(k + 1) > apart * std::max(std::abs(values(k)), epsilon)) count = k + 1;
  if (values(0) < -nothing || (count == 0 && !(values(0) > 0.0)))
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\": K_se is not positive definite beside its rigid motions; "
        "a piece of the body is loose or an interface is not tied to it; join them and reduce again",
        name));
  return s.asDiagonal() * Z * solver.eigenvectors().leftCols(count);
}

// Mass-orthonormal, and mass-orthogonal to R.
Eigen::MatrixXd with_unit_mass(Eigen::MatrixXd N, const Eigen::MatrixXd& M, const Eigen::MatrixXd& R,
                               const std::string& name) {
  for (int pass = 0; pass < 2; ++pass) N -= R * (R.transpose() * (M * N)).eval();
  const Eigen::VectorXd s = M.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (Eigen::Index k = 0; k < N.cols(); ++k)
    if (const double size = s.cwiseProduct(N.col(k)).norm(); size > 0.0) N.col(k) /= size;
  const Eigen::MatrixXd mass = N.transpose() * M * N;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(0.5 * (mass + mass.transpose()));
  if (!(own.eigenvalues()(0) > static_cast<double>(M.rows()) * epsilon))
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": a motion of its interfaces has neither stiffness nor mass (a "
                    "rotation behind a pin flag?); "
                    "leave it out of the interface's directions and reduce again",
                    name));
  return N * own.operatorInverseSqrt();
}

// Amid the squares of the frequencies, by the logarithm; 0 without any.
double middle_frequency2(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M,
                         const Eigen::VectorXd& stiffness) {
  constexpr double noise = 1e-10;
  double sum = 0.0;
  int count = 0;
  for (Eigen::Index i = 0; i < K.rows(); ++i) {
    if (!(M(i, i) > 0.0) || !(K(i, i) > noise * stiffness(i))) continue;
    sum += std::log(K(i, i) / M(i, i));
    ++count;
  }
  return count > 0 ? std::exp(sum / count) : 0.0;
}

// Elastic modes in the complement {x : (M R)^T x = 0} of the rigid motions R; `stiffness` is the size of K for dofs of that unit.
Elastic elastic_modes(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M, const Eigen::MatrixXd& R,
                      const Eigen::VectorXd& stiffness, const std::string& name) {
  const Eigen::Index n = K.rows();
  Elastic result{Eigen::VectorXd(0), Eigen::MatrixXd(n, 0), Eigen::MatrixXd(n, 0)};
  if (n == R.cols()) return result;
  result.mechanisms = mechanisms_of(K, stiffness, R, name);
  if (result.mechanisms.cols() > 0)
    result.mechanisms = with_unit_mass(std::move(result.mechanisms), M, R, name);
  Eigen::MatrixXd still(n, R.cols() + result.mechanisms.cols());  // strains nothing
  still << R, result.mechanisms;
  const Eigen::Index n_r = still.cols();
  const double sigma = middle_frequency2(K, M, stiffness);
  if (n == n_r || !(sigma > 0.0)) return result;
  const Eigen::MatrixXd A = K + sigma * M;
  Eigen::VectorXd s(n);
  for (Eigen::Index i = 0; i < n; ++i) s[i] = A(i, i) > 0.0 ? 1.0 / std::sqrt(A(i, i)) : 1.0;
  Eigen::MatrixXd A_c = s.asDiagonal() * A * s.asDiagonal(), M_c = s.asDiagonal() * M * s.asDiagonal();
  Eigen::MatrixXd Z;  // basis of the complement, orthonormal in the scaled dofs
  if (n_r > 0) {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(M_c * (s.cwiseInverse().asDiagonal() * still));
    Z = (qr.householderQ() * Eigen::MatrixXd::Identity(n, n)).rightCols(n - n_r);
    A_c = Z.transpose() * A_c * Z;
    M_c = Z.transpose() * M_c * Z;
  }
  A_c = 0.5 * (A_c + A_c.transpose()).eval();
  M_c = 0.5 * (M_c + M_c.transpose()).eval();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(M_c, A_c);
  if (solver.info() != Eigen::Success) {
    throw std::runtime_error(fmt::format(
        "superelement \"{}\": the eigenvalue problem did not converge; reduce the part again", name));
  }
  const Eigen::VectorXd& mu =
      solver.eigenvalues();  // 1 / (omega^2 + sigma), ascending, so frequencies descend
  // Massless motions have mu = 0 to round-off and no frequency.
  const double massless = 100.0 * static_cast<double>(n) * epsilon * mu[mu.size() - 1];
  Eigen::Index n_modes = 0;
  while (n_modes < mu.size() && mu[mu.size() - 1 - n_modes] > massless) ++n_modes;
  result.omega2.resize(n_modes);
  result.phi.resize(n, n_modes);
  for (Eigen::Index j = 0; j < n_modes; ++j) {
    const Eigen::Index k = mu.size() - 1 - j;
    result.omega2[j] = std::max(1.0 / mu[k] - sigma, 0.0);
    Eigen::VectorXd x = n_r > 0 ? Eigen::VectorXd(Z * solver.eigenvectors().col(k))
                                : Eigen::VectorXd(solver.eigenvectors().col(k));
    result.phi.col(j) = s.asDiagonal() * x / std::sqrt(mu[k]);  // the solver gives x^T A x = 1
  }
  return result;
}

// Rigid motions made mass-orthonormal, in their given order.
Eigen::MatrixXd mass_orthonormal(const Eigen::MatrixXd& R, const Eigen::MatrixXd& M,
                                 const std::string& name) {
  if (R.cols() == 0) return R;
  const Eigen::LLT<Eigen::MatrixXd> factor(R.transpose() * M * R);
  if (factor.info() != Eigen::Success) {
    throw std::invalid_argument(
        fmt::format("superelement \"{}\": a rigid motion moves no mass; its interfaces do not hold "
                    "all six of them; choose interfaces that do",
                    name));
  }
  return factor.matrixU().solve<Eigen::OnTheRight>(R);
}

}  // namespace

const char* kind_of(const Mode& mode) {
  if (!mode.dof.empty()) return "constraint";
  return mode.rigid ? "rigid" : mode.mechanism ? "mechanism" : "elastic";
}

std::vector<std::string> interface_names(const Superelement& se) {
  std::vector<std::string> names;
  for (const Interface& interface : se.interfaces) names.push_back(interface.name);
  return names;
}

ModeAnalysis natural_modes(const Superelement& se, const std::vector<std::string>& held, int n_elastic) {
  ModeAnalysis analysis;
  analysis.held = held;
  const InertiaIntegrals& I = se.inertia;
  analysis.mass = I.mass;
  analysis.mass_centre = I.S_x / I.mass;
  const Eigen::Matrix3d S_cc = I.S_xx - I.S_x * I.S_x.transpose() / I.mass;
  analysis.inertia = S_cc.trace() * Eigen::Matrix3d::Identity() - S_cc;

  const Eigen::MatrixXd R = rigid_motions_about(se, analysis.mass_centre);
  double length = std::sqrt(std::max(S_cc.trace(), 0.0) / I.mass);  // radius of gyration
  for (const Interface& interface : se.interfaces) {
    length = std::max(length, (interface.p_BoN_B - analysis.mass_centre).norm());
  }
  if (!(length > 0.0)) length = 1.0;

  const std::vector<int> dofs = free_dofs(se, held);
  const Eigen::MatrixXd K = se.K_se(dofs, dofs), M = se.M_se(dofs, dofs);
  const Eigen::MatrixXd R_free =
      mass_orthonormal(Eigen::MatrixXd(free_rigid_motions(R, dofs, length)(dofs, Eigen::all)), M, se.name);
  const Elastic elastic = elastic_modes(K, M, R_free, unit_sizes(se, se.K_se)(dofs), se.name);
  analysis.n_rigid = static_cast<int>(R_free.cols());

  const Eigen::MatrixXd M_R = se.M_se * R;
  const auto add = [&](const Eigen::VectorXd& phi, double omega2, bool rigid, bool mechanism = false) {
    Mode mode;
    mode.rigid = rigid;
    mode.mechanism = mechanism;
    mode.omega2 = omega2;
    mode.frequency_hz = std::sqrt(omega2) / (2 * pi);
    mode.u_se = Eigen::VectorXd::Zero(se.n());
    mode.u_se(dofs) = phi;
    mode.effective_mass = (M_R.transpose() * mode.u_se).cwiseAbs2();
    const bool strains = !rigid && !mechanism;
    if (strains)
      mode.damping = se.D_se.size() > 0 ? mode.u_se.dot(se.D_se * mode.u_se) / (2 * std::sqrt(omega2))
                                        : se.modal_damping;
    analysis.modes.push_back(std::move(mode));
  };
  for (Eigen::Index j = 0; j < R_free.cols(); ++j) add(R_free.col(j), 0.0, true);
  analysis.n_mechanisms = static_cast<int>(elastic.mechanisms.cols());
  for (Eigen::Index j = 0; j < elastic.mechanisms.cols(); ++j)
    add(elastic.mechanisms.col(j), 0.0, false, true);
  Eigen::Index n_wanted = elastic.omega2.size();
  if (n_elastic >= 0) n_wanted = std::min<Eigen::Index>(n_wanted, n_elastic);
  for (Eigen::Index j = 0; j < n_wanted; ++j) add(elastic.phi.col(j), elastic.omega2[j], false);
  return analysis;
}

ModeAnalysis constraint_modes(const Superelement& se) {
  constexpr const char* kDirections[] = {"u_x", "u_y", "u_z", "theta_x", "theta_y", "theta_z"};
  ModeAnalysis analysis;
  analysis.mass = se.inertia.mass;
  if (se.inertia.mass > 0.0) analysis.mass_centre = se.inertia.S_x / se.inertia.mass;
  for (const Interface& interface : se.interfaces)
    for (std::size_t k = 0; k < interface.directions.size(); ++k) {
      const int row = interface.first_dof + static_cast<int>(k);
      Mode mode;
      mode.dof = interface.name + "." + kDirections[static_cast<int>(interface.directions[k])];
      mode.stiffness = se.K_se(row, row);
      mode.effective_mass.setZero();
      mode.u_se = Eigen::VectorXd::Unit(se.n(), row);
      analysis.modes.push_back(std::move(mode));
    }
  return analysis;
}

}  // namespace flexura::superelement
