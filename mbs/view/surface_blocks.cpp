// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/surface_blocks.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace flexura::view {

namespace {

using Vertices = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// 16 bits are more than any picture shows: with the largest displacement over a whole 4K screen a step is
/// 1/8 pixel. Large parts with many modes make do with 12 bits: at a tenth of the screen, still a step of
/// 1/10 pixel; surfaces of a third of a million vertices with 10: there, a step of 4/10 pixel. A million
/// vertices that are all on the surface, with 46 modes, have 8 bits, so that the page keeps to 40 MB: a step
/// of half a pixel where the largest displacement is a tenth of a window 1,300 pixels wide. The page says so.
constexpr int fewest_levels = 127;
int choose_levels(Eigen::Index n_vertices, int n_shapes) {
  const double values = static_cast<double>(n_vertices) * n_shapes;
  return values > 2.5e7 ? fewest_levels : values > 1.5e7 ? 511 : values > 6.0e6 ? 2047 : 32767;
}

/// Multiples of a power of two, at most 1/32768 of the box's diagonal: 1/30 pixel on a window of 1,000, and
/// the last of a number's four bytes is nearly always zero.
Vertices rounded(const superelement::Surface& surface) {
  const double size = (surface.vertices.colwise().maxCoeff() - surface.vertices.colwise().minCoeff()).norm();
  if (!(size > 0.0)) return surface.vertices.cast<float>();
  const double step = std::exp2(std::floor(std::log2(size)) - 15.0);
  return ((surface.vertices.array() / step).round() * step).matrix().cast<float>();
}

template <typename Indices>
void require_range(const Indices& indices, Eigen::Index n_vertices, const std::string& what,
                   const char* kind) {
  if (indices.size() > 0 && (indices.minCoeff() < 0 || indices.maxCoeff() >= n_vertices)) {
    throw std::invalid_argument(fmt::format(
        "the surface of {} has {} vertices, but its {} refer to vertices {} to {}: the surface is damaged",
        what, n_vertices, kind, indices.minCoeff(), indices.maxCoeff()));
  }
}

}  // namespace

SurfaceBlocks::SurfaceBlocks(PageFile& page, std::string key, const superelement::Surface& surface,
                             const std::string& what, int shapes_expected)
    : page_(page),
      key_(std::move(key)),
      n_triangles_(surface.triangles.rows()),
      n_edges_(surface.edges.rows()),
      levels_(choose_levels(surface.vertices.rows(), shapes_expected)) {
  const Eigen::Index n_vertices = surface.vertices.rows();
  require_range(surface.triangles, n_vertices, what, "triangles");
  require_range(surface.edges, n_vertices, what, "edges");
  if (!surface.vertices.allFinite()) {
    throw std::invalid_argument(fmt::format("the surface of {} holds a vertex that is not finite", what));
  }
  if (!surface.triangle_interface.empty() &&
      static_cast<Eigen::Index>(surface.triangle_interface.size()) != n_triangles_) {
    throw std::invalid_argument(fmt::format("the surface of {} has {} triangles but interface numbers for {}",
                                            what, n_triangles_, surface.triangle_interface.size()));
  }
  const Traversal traversal = traverse(surface.triangles);
  Triangles triangles(n_triangles_, 3);
  std::vector<std::int32_t> painted;
  for (Eigen::Index k = 0; k < n_triangles_; ++k) {
    const auto t = traversal.order[static_cast<std::size_t>(k)];
    triangles.row(k) = surface.triangles.row(t);
    if (!surface.triangle_interface.empty()) {
      painted.push_back(surface.triangle_interface[static_cast<std::size_t>(t)]);
    }
  }
  predictions_ = predictions(triangles, traversal.parent, static_cast<int>(n_vertices));

  const Vertices vertices =
      levels_ == fewest_levels ? rounded(surface) : Vertices(surface.vertices.cast<float>());
  const auto span = [](const auto& m) { return std::span(m.data(), static_cast<std::size_t>(m.size())); };
  page_.add(key_ + "/vertices", span(vertices));
  page_.add<std::int32_t>(key_ + "/triangles", span(triangles));
  page_.add(key_ + "/parent", std::span<const std::int32_t>(traversal.parent));
  page_.add<std::int32_t>(key_ + "/edges", span(surface.edges));
  page_.add(key_ + "/interface", std::span<const std::int32_t>(painted));
}

void SurfaceBlocks::add_shape(const Eigen::Ref<const Eigen::VectorXf>& u) {
  const EncodedField shape = encode_field(u, 3, predictions_, levels_);
  page_.add_block(fmt::format("{}/shape/{}", key_, scales_.size()), "u2", shape.text);
  scales_.push_back(shape.scale);
}

void SurfaceBlocks::add_stress(const Eigen::Ref<const Eigen::VectorXf>& sigma, int components) {
  // Four steps for each of the 256 colours.
  constexpr int stress_levels = 1023;
  const EncodedField stress = encode_field(sigma, components, predictions_, stress_levels);
  stress_components_ = components;
  stress_scales_.resize(scales_.size() - 1, 0.0);
  page_.add_block(fmt::format("{}/stress/{}", key_, stress_scales_.size()), "u2", stress.text);
  stress_scales_.push_back(stress.scale);
}

nlohmann::json SurfaceBlocks::header() const {
  nlohmann::json shapes = nlohmann::json::array();
  for (std::size_t j = 0; j < scales_.size(); ++j) {
    shapes.push_back({{"scale", scales_[j]}});
    if (j < stress_scales_.size()) shapes.back()["stress"] = stress_scales_[j];
  }
  return {{"key", key_},       {"vertices", predictions_.size()}, {"triangles", n_triangles_},
          {"edges", n_edges_}, {"stress", stress_components_},    {"levels", levels_},
          {"shapes", shapes}};
}

void require_pictures(const superelement::Superelement& se) {
  if (se.surface.vertices.rows() == 0) {
    throw std::invalid_argument(fmt::format(
        "superelement '{}' holds no surface to draw: reduce the part again, with shapes for pictures",
        se.name));
  }
  if (se.shapes.rows() != 3 * se.surface.vertices.rows() || se.shapes.cols() != se.n()) {
    throw std::invalid_argument(
        fmt::format("superelement '{}' has {} vertices and {} shape functions, so its shapes must be {} x "
                    "{}, but they are {} x {}",
                    se.name, se.surface.vertices.rows(), se.n(), 3 * se.surface.vertices.rows(), se.n(),
                    se.shapes.rows(), se.shapes.cols()));
  }
}

}  // namespace flexura::view
