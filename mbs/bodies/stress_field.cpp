// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/stress_field.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flexura::mbs {

double von_mises(const Stress& s) {
  const double xy = s(0) - s(1), yz = s(1) - s(2), zx = s(2) - s(0);
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * s.tail<3>().squaredNorm());
}

StressField::StressField(const Eigen::MatrixXd& S, Eigen::Matrix3Xd x, std::vector<int> vertices,
                         const Eigen::MatrixXd& Y)
    : StressField(std::make_shared<const Eigen::MatrixXd>(S), std::move(x), std::move(vertices), Y) {}

StressField::StressField(std::shared_ptr<const Eigen::MatrixXd> S, Eigen::Matrix3Xd x,
                         std::vector<int> vertices, const Eigen::MatrixXd& Y)
    : given_(std::move(S)), Y_(Y), x_(std::move(x)), vertices_(std::move(vertices)) {
  if (given_->cols() != Y.rows() || given_->rows() != 6 * x_.cols() ||
      x_.cols() != static_cast<Eigen::Index>(vertices_.size()) || x_.cols() == 0)
    throw std::invalid_argument(fmt::format("stress modes of {} x {} do not fit {} places and {} shapes",
                                            given_->rows(), given_->cols(), x_.cols(), Y.rows()));
}

const Eigen::MatrixXd& StressField::everywhere() const {
  std::call_once(once_, [this] { S_ = *given_ * Y_; });
  return S_;
}

void StressField::set_compliance(std::vector<Eigen::Matrix<double, 6, 6>> compliance,
                                 std::vector<int> material) {
  const auto n = static_cast<int>(compliance.size());
  if (material.size() != vertices_.size() ||
      std::ranges::any_of(material, [&](int k) { return k < 0 || k >= n; }))
    throw std::invalid_argument("the materials of the stress modes do not fit their places");
  compliance_ = std::move(compliance);
  material_ = std::move(material);
}

void StressField::add_point(const std::string& name, const Eigen::Vector3d& wanted) {
  Point point{name, wanted};
  point.distance = std::sqrt((x_.colwise() - wanted).colwise().squaredNorm().minCoeff(&point.place));
  point.S = given_->middleRows(6 * point.place, 6) * Y_;
  points_.push_back(std::move(point));
}

void StressField::set_loads(Eigen::MatrixXd of_loads) {
  if (of_loads.size() > 0 && of_loads.rows() != given_->rows())
    throw std::invalid_argument("the stresses of preloads do not fit the places of the stress modes");
  of_loads_ = std::move(of_loads);
}

void StressField::set_inertia(Eigen::MatrixXd of_acceleration, Eigen::MatrixXd rigid_motions,
                              Coupling coupling, std::optional<LeftOutModes> left_out,
                              StiffeningLoads stiffening) {
  if (of_acceleration.size() > 0 && of_acceleration.rows() != given_->rows())
    throw std::invalid_argument("the stresses of acceleration do not fit the places of the stress modes");
  of_acceleration_ = std::move(of_acceleration);
  rigid_motions_ = std::move(rigid_motions);
  coupling_ = coupling;
  left_out_ = std::move(left_out);
  stiffening_ = std::move(stiffening);
}

Eigen::VectorXd StressField::beyond(const BodyMotion& motion, const double* factors) const {
  const Eigen::Index n_z = of_acceleration_.cols(), n_se = given_->cols(), n_b = n_z - 6, m = Y_.cols();
  Eigen::VectorXd out = Eigen::VectorXd::Zero(n_z + (left_out_ ? n_se : 0));
  if (out.size() == 0) return out;
  const ParticleAcceleration by(motion, static_cast<int>(m));
  if (n_z > 0) {
    // A less its turning, [alpha]x, which the rigid motions have.
    const Eigen::Matrix3d A = by.c.tail<9>().reshaped(3, 3), even = 0.5 * (A + A.transpose());
    out.head<6>() << even.diagonal(), even(0, 1), even(1, 2), even(2, 0);
    Eigen::Matrix<double, 6, 1> rigid;
    rigid << motion.a, motion.alpha;
    out.segment(6, n_b) = rigid_motions_.topRows(n_b) * rigid +
                          Y_.topRows(n_b) * Eigen::Map<const Eigen::VectorXd>(motion.s_ddot, m);
  }
  if (!left_out_) return out;
  auto u_left = out.tail(n_se);
  u_left = left_out_->of_acceleration * by.c + left_out_->of_deformation * by.B;
  if (left_out_->dropped_acceleration.size() > 0) {
    const ParticleAcceleration dropped = dropped_inertia(motion, static_cast<int>(m), coupling_);
    u_left += left_out_->dropped_acceleration * dropped.c + left_out_->dropped_deformation * dropped.B;
  }
  if (!left_out_->of_stiffening.empty()) {
    const Eigen::VectorXd loads = stiffening_.at(motion, factors);
    const Eigen::Map<const Eigen::VectorXd> s(motion.s, m);
    for (Eigen::Index k = 0; k < loads.size(); ++k)
      if (loads(k) != 0.0) u_left += loads(k) * (left_out_->of_stiffening[static_cast<std::size_t>(k)] * s);
  }
  if (motion.on_nodes.size() > 0 && left_out_->of_nodes.cols() > 0)
    u_left += left_out_->of_nodes * motion.on_nodes;
  if (factors && left_out_->of_loads.cols() > 0)
    u_left += left_out_->of_loads * Eigen::Map<const Eigen::VectorXd>(factors, left_out_->of_loads.cols());
  return out;
}

Stress StressField::at(int place, const double* s, const double* factors, const Eigen::VectorXd* more) const {
  const Eigen::Map<const Eigen::VectorXd> by(s, Y_.cols());
  const auto point = std::ranges::find(points_, place, &Point::place);
  Stress sigma =
      point != points_.end() ? Stress(point->S * by) : Stress(everywhere().middleRows(6 * place, 6) * by);
  if (factors && has_loads())
    sigma +=
        of_loads_.middleRows(6 * place, 6) * Eigen::Map<const Eigen::VectorXd>(factors, of_loads_.cols());
  if (more && more->size() > 0) {
    const Eigen::Index n_z = of_acceleration_.cols();
    if (n_z > 0) sigma += of_acceleration_.middleRows(6 * place, 6) * more->head(n_z);
    if (left_out_) sigma += given_->middleRows(6 * place, 6) * more->tail(given_->cols());
  }
  return sigma;
}

Eigen::VectorXd StressField::stresses(const double* s, const double* factors,
                                      const Eigen::VectorXd* more) const {
  Eigen::VectorXd sigma = everywhere() * Eigen::Map<const Eigen::VectorXd>(s, Y_.cols());
  if (factors && has_loads())
    sigma += of_loads_ * Eigen::Map<const Eigen::VectorXd>(factors, of_loads_.cols());
  if (more && more->size() > 0) {
    if (of_acceleration_.cols() > 0) sigma += of_acceleration_ * more->head(of_acceleration_.cols());
    if (left_out_) sigma += *given_ * more->tail(given_->cols());
  }
  return sigma;
}

StressField::Largest StressField::largest(const double* s, const double* factors,
                                          const Eigen::VectorXd* more) const {
  const Eigen::VectorXd sigma = stresses(s, factors, more);
  Largest out;
  for (int k = 0; k < places(); ++k)
    if (const double value = von_mises(sigma.segment<6>(6 * k)); value > out.von_mises) out = {value, k};
  return out;
}

StressField::LargestStrain StressField::largest_strain(const double* s, const double* factors,
                                                       const Eigen::VectorXd* more) const {
  const Eigen::VectorXd sigma = stresses(s, factors, more);
  LargestStrain out;
  for (int k = 0; k < places(); ++k) {
    const Strain e = compliance_[static_cast<std::size_t>(material_[static_cast<std::size_t>(k)])] *
                     sigma.segment<6>(6 * k);
    Eigen::Matrix3d tensor;
    tensor << e(0), 0.5 * e(3), 0.5 * e(5), 0.5 * e(3), e(1), 0.5 * e(4), 0.5 * e(5), 0.5 * e(4), e(2);
    const Eigen::Vector3d principal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor, Eigen::EigenvaluesOnly).eigenvalues();
    for (const double value : principal)
      if (std::abs(value) > std::abs(out.strain)) out = {value, k};
  }
  return out;
}

}  // namespace flexura::mbs
