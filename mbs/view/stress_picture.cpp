// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/stress_picture.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace flexura::view {

StressField::StressField(const superelement::Superelement& se)
    : modes_(*se.stress), n_vertices_(se.surface.vertices.rows()) {
  const auto n_places = static_cast<Eigen::Index>(modes_.vertices.size());
  if (modes_.S.rows() != 6 * n_places || modes_.S.cols() != se.n() ||
      (n_places > 0 && modes_.vertices.back() >= n_vertices_)) {
    throw std::invalid_argument(fmt::format(
        "the stress modes of superelement '{}' are {} x {} for {} places, with {} shape functions and {} "
        "vertices they must be {} x {}",
        se.name, modes_.S.rows(), modes_.S.cols(), n_places, se.n(), n_vertices_, 6 * n_places, se.n()));
  }
}

Eigen::VectorXf StressField::components(const Eigen::Ref<const Eigen::VectorXd>& u_se) const {
  const Eigen::VectorXd at_places = modes_.S * u_se;
  Eigen::VectorXf sigma = Eigen::VectorXf::Zero(6 * n_vertices_);
  // A sum of n products is round-off below n eps of its largest term: with eps = 6e-8 of modes kept in 32
  // bits and tens of shapes some 4e-6, with 64 bits (and shapes computed to 1e-12) 1e-10.  Colours show 4e-3.
  const double round_off = modes_.double_precision ? 1e-10 : 4e-6;
  double largest = 0.0;
  for (Eigen::Index k = 0; k < u_se.size(); ++k) {
    if (u_se[k] != 0.0)
      largest = std::max(largest, modes_.S.col(k).cwiseAbs().maxCoeff() * std::abs(u_se[k]));
  }
  if (at_places.size() == 0 || at_places.cwiseAbs().maxCoeff() <= round_off * largest) return sigma;
  for (std::size_t s = 0; s < modes_.vertices.size(); ++s) {
    sigma.segment<6>(6 * modes_.vertices[s]) =
        at_places.segment<6>(6 * static_cast<Eigen::Index>(s)).cast<float>();
  }
  return sigma;
}

Eigen::VectorXf StressField::von_mises(const Eigen::Ref<const Eigen::VectorXd>& u_se) const {
  const Eigen::VectorXf sigma = components(u_se);
  Eigen::VectorXf result(n_vertices_);
  for (Eigen::Index v = 0; v < n_vertices_; ++v) {
    const Eigen::Matrix<double, 6, 1> s = sigma.segment<6>(6 * v).cast<double>();
    const Eigen::Vector3d d(s[0] - s[1], s[1] - s[2], s[2] - s[0]);
    result[v] = static_cast<float>(std::sqrt(0.5 * d.squaredNorm() + 3.0 * s.tail<3>().squaredNorm()));
  }
  return result;
}

}  // namespace flexura::view
