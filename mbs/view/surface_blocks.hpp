// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "mbs/view/html/page_file.hpp"

namespace flexura::view {

/// Writes a surface, then shapes on it one by one, as blocks KEY/vertices, KEY/triangles, ..., KEY/shape/0,
/// ...
class SurfaceBlocks {
 public:
  /// Throws std::invalid_argument, naming `what`, when the surface is empty or refers to vertices it does not
  /// have.
  SurfaceBlocks(PageFile& page, std::string key, const superelement::Surface& surface,
                const std::string& what, int shapes_expected);

  /// u: x, y, z of each vertex [m].
  void add_shape(const Eigen::Ref<const Eigen::VectorXf>& u);
  /// The stress of the shape added last, as block KEY/stress/J: `components` numbers for each vertex [Pa], 1
  /// (von Mises) or 6 (xx, yy, zz, xy, yz, zx), the same for all shapes.
  void add_stress(const Eigen::Ref<const Eigen::VectorXf>& sigma, int components);

  /// {"key", "vertices", "triangles", "edges", "stress": components or 0, "shapes": [{"scale", "stress"}]}
  nlohmann::json header() const;

 private:
  PageFile& page_;
  std::string key_;
  std::vector<Prediction> predictions_;
  Eigen::Index n_triangles_, n_edges_;
  int levels_, stress_components_ = 0;
  std::vector<double> scales_, stress_scales_;
};

/// Throws std::invalid_argument, naming the superelement, unless it holds a surface and shapes that fit.
void require_pictures(const superelement::Superelement& se);

}  // namespace flexura::view
