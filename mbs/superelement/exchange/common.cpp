// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/superelement/exchange/exchange.hpp"

namespace flexura::superelement::exchange {

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

void require_surface(const Superelement& se) {
  if (se.surface.vertices.rows() == 0 || se.shapes.rows() != 3 * se.surface.vertices.rows()) {
    throw std::invalid_argument(
        fmt::format("superelement \"{}\" holds no surface with shapes, so there is nothing to draw; reduce "
                    "the part again with its surface",
                    se.name));
  }
}

std::string mode_name(const ModeAnalysis& modes, std::size_t j) {
  const Mode& mode = modes.modes[j];
  if (!mode.dof.empty()) return fmt::format("constraint mode {}", mode.dof);
  return fmt::format("mode {} ({:.2f} Hz)", j + 1, mode.frequency_hz);
}

Eigen::VectorXf drawn_shape(const Superelement& se, const Mode& mode) {
  Eigen::VectorXf shape = se.shapes * mode.u_se.cast<float>();
  shape *= static_cast<float>(display_scale(se, shape));
  return shape;
}

std::string base64(const std::string& bytes) {
  static const char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) -> unsigned {
      return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U;
    };
    const unsigned group = byte(0) << 16 | byte(1) << 8 | byte(2);
    text += alphabet[group >> 18];
    text += alphabet[group >> 12 & 63];
    text += i + 1 < bytes.size() ? alphabet[group >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? alphabet[group & 63] : '=';
  }
  return text;
}

}  // namespace flexura::superelement::exchange
