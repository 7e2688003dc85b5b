// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/tessellate.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace flexura::view {

namespace {

using Eigen::Vector3d;

constexpr int sides = 32;

Vector3d vector_of(const nlohmann::json& list) {
  return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()};
}

/// A surface of revolution about `axis`: rings at (height, radius), from below to above; outside by the right
/// hand.
void revolve(const Vector3d& middle, const Vector3d& axis, const std::vector<std::array<double, 2>>& profile,
             Tessellation& out) {
  const Vector3d e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
  const auto first = static_cast<std::int32_t>(out.points.size());
  for (const auto& [height, radius] : profile) {
    for (int i = 0; i < sides; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / sides;
      out.points.push_back(middle + height * axis + radius * (std::cos(angle) * e1 + std::sin(angle) * e2));
    }
  }
  for (std::int32_t ring = 0; ring + 1 < static_cast<std::int32_t>(profile.size()); ++ring) {
    for (int i = 0; i < sides; ++i) {
      const std::int32_t a = first + ring * sides + i, b = first + ring * sides + (i + 1) % sides;
      // A ring of radius zero leaves one of the two triangles without area.
      if (profile[static_cast<std::size_t>(ring)][1] > 0.0) out.triangles.push_back({a, b, b + sides});
      if (profile[static_cast<std::size_t>(ring) + 1][1] > 0.0)
        out.triangles.push_back({a, b + sides, a + sides});
    }
  }
}

}  // namespace

void tessellate(const nlohmann::json& shape, Tessellation& out) {
  const std::string type = shape.at("type");
  if (type == "line") {
    for (std::size_t i = 0; i < shape["points"].size(); ++i) {
      const auto here = static_cast<std::int32_t>(out.points.size());
      out.points.push_back(vector_of(shape["points"][i]));
      if (i > 0) out.lines.push_back({here - 1, here});
    }
    return;
  }
  const Vector3d middle = vector_of(shape.at("position"));
  if (type == "box") {
    const Vector3d half = 0.5 * vector_of(shape["size"]);
    const auto& q = shape["rotation"];
    const Eigen::Quaterniond turn(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(),
                                  q[3].get<double>());
    const auto first = static_cast<std::int32_t>(out.points.size());
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      out.points.push_back(middle + turn * half.cwiseProduct(sign));
    }
    static constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& f : faces) {
      out.triangles.push_back({first + f[0], first + f[1], first + f[2]});
      out.triangles.push_back({first + f[0], first + f[2], first + f[3]});
    }
    return;
  }
  const double radius = shape.at("radius");
  std::vector<std::array<double, 2>> profile;
  Vector3d axis = Vector3d::UnitZ();
  if (type == "sphere") {
    constexpr int bands = sides / 2;
    for (int i = 0; i <= bands; ++i) {
      const double angle = std::numbers::pi * i / bands;
      profile.push_back({-radius * std::cos(angle), i == 0 || i == bands ? 0.0 : radius * std::sin(angle)});
    }
  } else {
    const double half = 0.5 * shape.at("length").get<double>();
    axis = vector_of(shape["axis"]);
    profile = {{-half, 0.0}, {-half, radius}};
    if (type == "cylinder") profile.push_back({half, radius});
    profile.push_back({half, 0.0});
  }
  revolve(middle, axis, profile, out);
}

}  // namespace flexura::view
