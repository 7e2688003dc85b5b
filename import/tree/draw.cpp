// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/tree/draw.hpp"

#include <cmath>
#include <numbers>

namespace flexura::import::tree {
namespace {

using Kind = Solid::Kind;

bool is_plain_box(const Solid& solid) {
  // Quarter turns leave the axes; what stands off by round-off is drawn as if it did not.
  return solid.kind == Kind::box && (solid.X_LS.R.cwiseAbs().rowwise().maxCoeff().array() > 1.0 - 1e-9).all();
}

std::vector<Line> line_of(const char* type, std::vector<Line> lines, const std::string& color) {
  lines.insert(lines.begin(), {"type", toml(std::string(type))});
  if (!color.empty()) lines.emplace_back("color", toml(color));
  return lines;
}

std::vector<Line> ball(const Vector3d& center, double radius, const std::string& color) {
  return line_of("sphere", {{"center", toml(center)}, {"radius", toml(radius)}}, color);
}

// False where the mechanism file has no such shape.
bool add_shape(const Solid& solid, std::vector<std::vector<Line>>& shapes) {
  const Vector3d half = solid.X_LS.R.col(2) * solid.size.y();
  const Vector3d from = solid.X_LS.p - half, to = solid.X_LS.p + half;
  switch (solid.kind) {
    case Kind::sphere:
      shapes.push_back(ball(solid.X_LS.p, solid.size.x(), solid.color));
      return true;
    case Kind::capsule:
      shapes.push_back(ball(from, solid.size.x(), solid.color));
      shapes.push_back(ball(to, solid.size.x(), solid.color));
      [[fallthrough]];
    case Kind::cylinder:
      if (!(half.norm() > 0.0)) return true;
      shapes.push_back(line_of("cylinder",
                               {{"from", toml(from)}, {"to", toml(to)}, {"radius", toml(solid.size.x())}},
                               solid.color));
      return true;
    case Kind::box:
      if (!is_plain_box(solid)) return false;
      shapes.push_back(line_of("box",
                               {{"center", toml(solid.X_LS.p)},
                                {"size", toml(Vector3d(2.0 * (solid.X_LS.R.cwiseAbs() * solid.size)))}},
                               solid.color));
      return true;
    default:
      return false;
  }
}

Surface ellipsoid_surface(const Vector3d& a) {
  constexpr int around = 24, along = 12;
  Surface s;
  s.vertices.emplace_back(0.0, 0.0, a.z());
  for (int i = 1; i < along; ++i)
    for (int k = 0; k < around; ++k) {
      const double u = std::numbers::pi * i / along, v = 2.0 * std::numbers::pi * k / around;
      s.vertices.emplace_back(a.x() * std::sin(u) * std::cos(v), a.y() * std::sin(u) * std::sin(v),
                              a.z() * std::cos(u));
    }
  s.vertices.emplace_back(0.0, 0.0, -a.z());
  const int last = static_cast<int>(s.vertices.size()) - 1;
  const auto at = [&](int i, int k) { return 1 + (i - 1) * around + k % around; };
  for (int k = 0; k < around; ++k) {
    s.triangles.emplace_back(0, at(1, k), at(1, k + 1));
    s.triangles.emplace_back(last, at(along - 1, k + 1), at(along - 1, k));
    for (int i = 1; i + 1 < along; ++i) {
      s.triangles.emplace_back(at(i, k), at(i + 1, k), at(i + 1, k + 1));
      s.triangles.emplace_back(at(i, k), at(i + 1, k + 1), at(i, k + 1));
    }
  }
  return s;
}

}  // namespace

int draw(const std::vector<Solid>& solids, std::vector<std::vector<Line>>& shapes) {
  int left_out = 0;
  for (const Solid& solid : solids)
    if (!add_shape(solid, shapes)) ++left_out;
  return left_out;
}

int draw(const std::vector<Solid>& solids, Body& body) {
  int left_out = 0;
  for (const Solid& solid : solids) {
    if (add_shape(solid, body.shapes)) continue;
    if (!(body.mass > 0.0)) {
      ++left_out;
      continue;
    }
    body.surface.append(solid.kind == Kind::box         ? box_surface(solid.size)
                        : solid.kind == Kind::ellipsoid ? ellipsoid_surface(solid.size)
                                                        : solid.surface,
                        solid.X_LS);
  }
  return left_out;
}

}  // namespace flexura::import::tree
