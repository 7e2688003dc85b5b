// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

namespace flexura::view {

/// Triangles and lines that stand for the primitive shapes of a body.
struct Tessellation {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<std::array<std::int32_t, 2>> lines;
};

/// Adds a shape as parse_body_shapes() returns it; round ones become prisms of 32 sides (a sphere 16 x 32
/// patches) with their corners on the true surface.
void tessellate(const nlohmann::json& shape, Tessellation& out);

}  // namespace flexura::view
