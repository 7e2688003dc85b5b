// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/link_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>

#include "import/model/inertia.hpp"

namespace flexura::import::urdf {
namespace {

constexpr double kSame =
    1e-5;  // of the size: vertices nearer than this are one; triangles of pictures have 1e-3

bool is_one_piece(const Surface& surface) {
  std::vector<int> root(surface.vertices.size());
  std::iota(root.begin(), root.end(), 0);
  const auto top = [&](int v) {
    while (root[static_cast<std::size_t>(v)] != v)
      v = root[static_cast<std::size_t>(v)] =
          root[static_cast<std::size_t>(root[static_cast<std::size_t>(v)])];
    return v;
  };
  for (const Eigen::Vector3i& t : surface.triangles)
    for (int k = 0; k < 3; ++k) root[static_cast<std::size_t>(top(t(k)))] = top(t((k + 1) % 3));
  const int first = top(surface.triangles.front()(0));
  return std::ranges::all_of(surface.triangles, [&](const Eigen::Vector3i& t) { return top(t(0)) == first; });
}

std::string binary_stl(const Surface& surface) {
  std::string out(80, ' ');
  const auto add = [&](const void* data, std::size_t size) {
    out.append(static_cast<const char*>(data), size);
  };
  const auto n = static_cast<std::uint32_t>(surface.triangles.size());
  add(&n, sizeof n);
  for (const Eigen::Vector3i& t : surface.triangles) {
    float x[12] = {};
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i)
        x[3 + 3 * k + i] = static_cast<float>(surface.vertices[static_cast<std::size_t>(t(k))](i));
    add(x, sizeof x);
    out.append(2, '\0');
  }
  return out;
}

struct Material {
  const char *name, *says;
  double density, young_gpa, poisson;
};

// What links are made of; handbook values.
constexpr Material kMaterials[] = {{"steel", "steel", 7850.0, 210.0, 0.3},
                                   {"titanium", "titanium", 4430.0, 114.0, 0.34},
                                   {"aluminium", "aluminium", 2700.0, 70.0, 0.33},
                                   {"polymer", "a polymer like ABS", 1050.0, 2.3, 0.36}};

// The material whose density is nearest to that of the link, filled: modulus and density are of one.  Where it is the link's but for
// alloy and picture, 10 %, the part has the link's mass.
std::string part_text(const Body& body, double volume) {
  const double density = body.mass / volume;
  const auto off = [&](const Material& m) { return std::abs(std::log(density / m.density)); };
  const Material& material = *std::ranges::min_element(kMaterials, {}, off);
  const bool is_link = off(material) < 0.1;
  const std::string why = is_link ? std::string("with this density the part has the link's mass")
                                  : fmt::format(
                                        "filled, the picture would weigh {:.4g} kg/m^3 with the link's "
                                        "{:.6g} kg: the link is hollow, "
                                        "or made of several; the part weighs {:.4g} kg",
                                        density, body.mass, material.density * volume);
  return fmt::format(
      "# link \"{}\", imported by flexura import: for flexura reduce, which makes it flexible\n"
      "name = {}\n\n[geometry]\nfile = {}\nunit = \"m\"\n\n"
      "# The file gives no material; {} is the nearest by density: {}\n"
      "[material.{}]\nyoung = \"{} GPa\"\npoisson = {}\ndensity = {}\n",
      body.name, toml(body.file()), toml(body.file() + ".stl"), material.says, why, material.name,
      material.young_gpa, material.poisson,
      is_link ? fmt::format("{:.9g}", density) : fmt::format("{}", material.density));
}

}  // namespace

bool is_closed(const Surface& surface) {
  std::map<std::pair<int, int>, std::pair<int, int>> edges;  // how often along, how often against
  for (const Eigen::Vector3i& t : surface.triangles)
    for (int k = 0; k < 3; ++k) {
      const int a = t(k), b = t((k + 1) % 3);
      auto& [along, against] = edges[std::minmax(a, b)];
      ++(a < b ? along : against);
    }
  return !edges.empty() &&
         std::ranges::all_of(edges, [](const auto& edge) { return edge.second == std::pair(1, 1); });
}

void weld(Surface& surface) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& v : surface.vertices) box.extend(v);
  if (box.isEmpty()) return;
  const double cell = kSame * box.diagonal().norm();
  if (!(cell > 0.0)) return;
  using Cell = std::array<std::int64_t, 3>;
  std::map<Cell, std::vector<int>> cells;
  std::vector<Vector3d> kept;
  std::vector<int> number;
  for (const Vector3d& v : surface.vertices) {
    const Vector3d at = ((v - box.min()) / cell).array().floor();
    const Cell own = {static_cast<std::int64_t>(at.x()), static_cast<std::int64_t>(at.y()),
                      static_cast<std::int64_t>(at.z())};
    int same = -1;
    for (int k = 0; k < 27 && same < 0; ++k) {
      const auto found = cells.find({own[0] + k % 3 - 1, own[1] + k / 3 % 3 - 1, own[2] + k / 9 - 1});
      if (found == cells.end()) continue;
      for (const int other : found->second)
        if ((kept[static_cast<std::size_t>(other)] - v).norm() <= cell) same = other;
    }
    if (same < 0) {
      same = static_cast<int>(kept.size());
      kept.push_back(v);
      cells[own].push_back(same);
    }
    number.push_back(same);
  }
  surface.vertices = std::move(kept);
  std::vector<Eigen::Vector3i> triangles;
  for (const Eigen::Vector3i& t : surface.triangles) {
    const Eigen::Vector3i now(number[static_cast<std::size_t>(t(0))], number[static_cast<std::size_t>(t(1))],
                              number[static_cast<std::size_t>(t(2))]);
    if (now(0) != now(1) && now(1) != now(2) && now(2) != now(0)) triangles.push_back(now);
  }
  surface.triangles = std::move(triangles);
  for (auto& [a, b] : surface.edges) {
    a = number[static_cast<std::size_t>(a)];
    b = number[static_cast<std::size_t>(b)];
  }
}

std::vector<TextFile> link_parts(const Mechanism& mechanism, Findings& findings) {
  std::vector<TextFile> out;
  std::vector<std::string> others;
  for (const Body& body : mechanism.bodies) {
    if (body.surface.empty()) continue;
    const double volume = surface_properties(body.surface).mass;
    if (!is_closed(body.surface) || !is_one_piece(body.surface) || !(volume > 0.0)) {
      others.push_back(body.name);
      continue;
    }
    const std::string stem = "parts/" + body.file();
    out.push_back({stem + ".stl", binary_stl(body.surface)});
    out.push_back({stem + ".toml", part_text(body, volume)});
  }
  if (!others.empty())
    findings.note(
        "links that cannot be made flexible",
        fmt::format("{} cannot be made flexible by --reduce: {} no closed surface of one body",
                    fmt::join(others, ", "), others.size() == 1 ? "its picture is" : "their pictures are"));
  return out;
}

}  // namespace flexura::import::urdf
