// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>

#include "import/model/mechanism.hpp"

namespace flexura::import::urdf {

/// Triangles as a file tells them; vertices that coincide are one.
class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(const std::filesystem::path& file) : file_(file) {}

  int vertex(const Vector3d& x) {
    if (!x.allFinite()) refuse("a vertex is not finite");
    const auto [at, is_new] =
        index_.emplace(std::array{x.x(), x.y(), x.z()}, static_cast<int>(surface.vertices.size()));
    if (is_new) surface.vertices.push_back(x);
    return at->second;
  }
  void triangle(int a, int b, int c) {
    if (a != b && b != c && c != a) surface.triangles.emplace_back(a, b, c);
  }
  /// Throws std::invalid_argument with the file in front.
  [[noreturn]] void refuse(const std::string& what) const {
    throw std::invalid_argument(file_.string() + ": " + what);
  }

  Surface surface;

 private:
  const std::filesystem::path& file_;
  std::map<std::array<double, 3>, int> index_;
};

}  // namespace flexura::import::urdf
