// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "mbs/superelement/exchange/exchange.hpp"

namespace flexura::superelement::exchange {

void write_whole(const std::filesystem::path& path, std::string_view content) {
  const std::filesystem::path beside = path.string() + ".part";
  std::error_code failure;
  {
    std::ofstream out(beside, std::ios::binary);
    out.write(content.data(), static_cast<std::streamsize>(content.size()));
    out.close();
    if (out) std::filesystem::rename(beside, path, failure);
    if (out && !failure) return;
  }
  std::filesystem::remove(beside, failure);
  throw std::runtime_error(path.string() +
                           ": cannot be written; check the folder, its permissions and the disk");
}

Eigen::MatrixXd elastic_shapes(const Superelement& se, const ModeAnalysis& modes) {
  Eigen::MatrixXd Y(se.n(), static_cast<Eigen::Index>(modes.modes.size()) - modes.n_rigid);
  for (Eigen::Index j = 0; j < Y.cols(); ++j) {
    Y.col(j) = modes.modes[static_cast<std::size_t>(modes.n_rigid + j)].u_se;
  }
  return Y;
}

double largest_displacement(const Eigen::VectorXf& surface_shape) {
  float largest = 0.0F;
  for (Eigen::Index v = 0; v + 2 < surface_shape.size(); v += 3) {
    largest = std::max(largest, surface_shape.segment<3>(v).squaredNorm());
  }
  return std::sqrt(static_cast<double>(largest));
}

double display_scale(const Superelement& se, const Eigen::VectorXf& surface_shape) {
  const auto& x = se.surface.vertices;
  const double size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();
  const double largest = largest_displacement(surface_shape);
  return largest > 0.0 ? 0.1 * size / largest : 1.0;
}

}  // namespace flexura::superelement::exchange
