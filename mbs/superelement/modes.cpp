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
  Eigen::MatrixXd phi;              // in the free dofs, phi^T M phi = 1
  Eigen::MatrixXd mechanisms = {};  // likewise
};

// Eigenvectors of K_c, whose diagonal was one, with eigenvalues that are round-off: of K_c itself and of the computation that
// gave it.
Eigen::MatrixXd without_strain(const Eigen::MatrixXd& K_c, const std::string& name) {
  const auto n = K_c.rows();
  // Constraint modes leave 1e-12 and more of a unit diagonal.  Bending of a beam with n interfaces is soft, too, (4.73 / n)^4 / 24,
  // but the next mode is not far above it: what has no strain stands apart.
  constexpr double nothing = 1e-10, apart = 1e4;
  // Most have none: no eigenvalue is much below the least pivot.
  if (const Eigen::LLT<Eigen::MatrixXd> factor(K_c);
      factor.info() == Eigen::Success &&
      factor.matrixLLT().diagonal().cwiseAbs2().minCoeff() > 1000 * nothing)
    return Eigen::MatrixXd(n, 0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(K_c);
  const Eigen::VectorXd& values = solver.eigenvalues();
  Eigen::Index count = 0;
  for (Eigen::Index k = 0; k < n && values(k) <= nothing; ++k)
    if (k + 1 == n || values(k + 1) > apart * std::max(std::abs(values(k)), epsilon)) count = k + 1;
  if (values(0) < -nothing || (count == 0 && !(values(0) > 0.0)))
    throw std::invalid_argument(fmt::format(
        "superelement \"{}\": K_se is not positive definite beside its rigid motions; "
        "a piece of the body is loose or an interface is not tied to it; join them and reduce again",
        name));
  return solver.eigenvectors().leftCols(count);
}

// Elastic modes in the complement {x : (M R)^T x = 0} of the rigid motions R.
Elastic elastic_modes(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M, const Eigen::MatrixXd& R,
                      const std::string& name) {
  const Eigen::Index n = K.rows(), n_r = R.cols();
  if (n == n_r) return {Eigen::VectorXd(0), Eigen::MatrixXd(n, 0), Eigen::MatrixXd(n, 0)};
  // Dofs of different units are brought to comparable stiffness first.
  Eigen::VectorXd s(n);
  for (Eigen::Index i = 0; i < n; ++i) s[i] = K(i, i) > 0.0 ? 1.0 / std::sqrt(K(i, i)) : 1.0;
  Eigen::MatrixXd K_c = s.asDiagonal() * K * s.asDiagonal(), M_c = s.asDiagonal() * M * s.asDiagonal();
  Eigen::MatrixXd Z;  // basis of the complement, orthonormal in the scaled dofs
  if (n_r > 0) {
    const Eigen::MatrixXd R_s = s.cwiseInverse().asDiagonal() * R;
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(M_c * R_s);
    Z = (qr.householderQ() * Eigen::MatrixXd::Identity(n, n)).rightCols(n - n_r);
    K_c = Z.transpose() * K_c * Z;
    M_c = Z.transpose() * M_c * Z;
  }
  K_c = 0.5 * (K_c + K_c.transpose()).eval();
  M_c = 0.5 * (M_c + M_c.transpose()).eval();
  if (const Eigen::MatrixXd N = without_strain(K_c, name); N.cols() > 0) {
    const Eigen::MatrixXd mass = N.transpose() * M_c * N;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(mass);
    if (!(own.eigenvalues()(0) > static_cast<double>(n) * epsilon * M_c.cwiseAbs().maxCoeff()))
      throw std::invalid_argument(
          fmt::format("superelement \"{}\": a motion of its interfaces has neither stiffness nor mass (a "
                      "rotation behind a pin flag?); "
                      "leave it out of the interface's directions and reduce again",
                      name));
    const Eigen::MatrixXd x = N * own.operatorInverseSqrt();
    const Eigen::MatrixXd mechanisms = s.asDiagonal() * (n_r > 0 ? Eigen::MatrixXd(Z * x) : x);
    Eigen::MatrixXd all(n, n_r + mechanisms.cols());
    all << R, mechanisms;
    Elastic rest = elastic_modes(K, M, all, name);
    Eigen::MatrixXd joined(n, mechanisms.cols() + rest.mechanisms.cols());
    joined << mechanisms, rest.mechanisms;
    rest.mechanisms = std::move(joined);
    return rest;
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(M_c, K_c);
  if (solver.info() != Eigen::Success) {
    throw std::runtime_error(fmt::format(
        "superelement \"{}\": the eigenvalue problem did not converge; reduce the part again", name));
  }
  const Eigen::VectorXd& mu = solver.eigenvalues();  // ascending, so frequencies descend
  Elastic result;
  result.mechanisms.resize(n, 0);
  Eigen::Index n_modes = 0;  // massless motions have mu = 0 to round-off and no frequency
  while (n_modes < mu.size() &&
         mu[mu.size() - 1 - n_modes] > static_cast<double>(n) * epsilon * mu[mu.size() - 1])
    ++n_modes;
  result.omega2.resize(n_modes);
  result.phi.resize(n, n_modes);
  for (Eigen::Index j = 0; j < n_modes; ++j) {
    const Eigen::Index k = mu.size() - 1 - j;
    result.omega2[j] = 1.0 / mu[k];
    Eigen::VectorXd x = n_r > 0 ? Eigen::VectorXd(Z * solver.eigenvectors().col(k))
                                : Eigen::VectorXd(solver.eigenvectors().col(k));
    result.phi.col(j) = s.asDiagonal() * x / std::sqrt(mu[k]);  // the solver gives x^T K x = 1
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
  const Elastic elastic = elastic_modes(K, M, R_free, se.name);
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
    mode.damping = strains ? se.modal_damping : 0.0;
    if (strains && se.D_se.size() > 0) {
      mode.damping += mode.u_se.dot(se.D_se * mode.u_se) / (2 * std::sqrt(omega2));
    }
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

}  // namespace flexura::superelement
