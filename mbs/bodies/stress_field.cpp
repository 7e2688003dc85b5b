// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/stress_field.hpp"

#include <fmt/format.h>

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

Stress StressField::at(int place, const double* s, const double* factors) const {
  const Eigen::Map<const Eigen::VectorXd> by(s, Y_.cols());
  const auto point = std::ranges::find(points_, place, &Point::place);
  Stress sigma =
      point != points_.end() ? Stress(point->S * by) : Stress(everywhere().middleRows(6 * place, 6) * by);
  if (factors && has_loads())
    sigma +=
        of_loads_.middleRows(6 * place, 6) * Eigen::Map<const Eigen::VectorXd>(factors, of_loads_.cols());
  return sigma;
}

StressField::Largest StressField::largest(const double* s, const double* factors) const {
  Eigen::VectorXd sigma = everywhere() * Eigen::Map<const Eigen::VectorXd>(s, Y_.cols());
  if (factors && has_loads())
    sigma += of_loads_ * Eigen::Map<const Eigen::VectorXd>(factors, of_loads_.cols());
  Largest out;
  for (int k = 0; k < places(); ++k)
    if (const double value = von_mises(sigma.segment<6>(6 * k)); value > out.von_mises) out = {value, k};
  return out;
}

}  // namespace flexura::mbs
