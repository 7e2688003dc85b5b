// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/model/mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "mbs/base/files/plain_text.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import {

Surface box_surface(const Vector3d& h) {
  Surface box;
  for (int i = 0; i < 8; ++i)
    box.vertices.emplace_back((i & 1) ? h.x() : -h.x(), (i & 2) ? h.y() : -h.y(), (i & 4) ? h.z() : -h.z());
  const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : faces) {
    box.triangles.emplace_back(f[0], f[1], f[2]);
    box.triangles.emplace_back(f[0], f[2], f[3]);
  }
  for (int i = 0; i < 8; ++i)
    for (const int bit : {1, 2, 4})
      if ((i & bit) == 0) box.edges.emplace_back(i, i | bit);
  return box;
}

void Surface::append(const Surface& other, const Pose& X) {
  const int first = static_cast<int>(vertices.size());
  for (const Vector3d& v : other.vertices) vertices.push_back(X * v);
  for (const Eigen::Vector3i& t : other.triangles) triangles.push_back(t.array() + first);
  for (const auto& [a, b] : other.edges) edges.emplace_back(a + first, b + first);
}

std::string Names::add(const std::string& wanted) {
  constexpr std::size_t longest = 60;
  // What formulas and lists of results know by themselves.
  constexpr std::array reserved = {"ground", "origin", "t",   "pi",  "e",    "energy", "momentum", "power",
                                   "run",    "sin",    "cos", "tan", "sqrt", "exp",    "log",      "abs",
                                   "mod",    "min",    "max", "pow", "step", "sign"};
  std::string name;
  for (const char c : wanted) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain)
      name += c;
    else if (name.empty() || name.back() != '_')
      name += '_';
    if (name.size() == longest) break;
  }
  if (name.empty() || name == "_") name = "unnamed";
  if (name[0] >= '0' && name[0] <= '9') name = "_" + name;
  if (std::ranges::find(reserved, name) != reserved.end()) name += "_";
  std::string free = name;
  if (const auto before = taken_.find(name); before != taken_.end()) do
      free = fmt::format("{}_{}", name, ++before->second);
    while (taken_.contains(free));
  taken_.emplace(free, 1);
  return free;
}

namespace {

// Damaged UTF-8 is no TOML either: ASCII only.
std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    line += u < 0x20 || u >= 0x7F ? '?' : c;
  }
  return line;
}

}  // namespace

std::string shown(const std::string& text) {
  constexpr std::size_t longest = 120;
  return one_line(text.substr(0, longest)) + (text.size() > longest ? "..." : "");
}

std::string toml(double value) {
  if (!std::isfinite(value)) throw std::invalid_argument("a number of the mechanism is not finite");
  std::string text = fmt::format("{}", value == 0.0 ? 0.0 : value);  // no -0
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string toml(const Vector3d& v) {
  return fmt::format("[{}, {}, {}]", toml(v.x()), toml(v.y()), toml(v.z()));
}

std::string toml(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : files::plain_text(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::vector<Line> pose_lines(const Pose& X) {
  std::vector<Line> lines;
  if (!X.p.isZero(0.0)) lines.emplace_back("position", toml(X.p));
  if (!(X.R - Matrix3d::Identity()).isZero(0.0)) {
    const Eigen::Vector4d q = mbs::quaternion_of_rotation(X.R);
    lines.emplace_back("quaternion",
                       fmt::format("[{}, {}, {}, {}]", toml(q[0]), toml(q[1]), toml(q[2]), toml(q[3])));
  }
  return lines;
}

namespace {

void write_table(std::string& out, const std::string& header, const std::vector<std::string>& comments,
                 const std::vector<Line>& lines) {
  out += "\n";
  for (const std::string& comment : comments) out += "# " + one_line(comment) + "\n";
  out += header + "\n";
  for (const auto& [key, value] : lines) out += key + " = " + value + "\n";
}

void write_markers(std::string& out, const std::string& body, const std::vector<Marker>& markers) {
  for (const Marker& marker : markers) {
    std::vector<Line> lines = pose_lines(marker.X_BM);
    if (!marker.on.empty()) {
      lines.insert(lines.begin(), {"on", toml(marker.on)});
      // Without a position it would stand where the interface does.
      if (marker.X_BM.p.isZero(0.0)) lines.emplace_back("position", toml(marker.X_BM.p));
    }
    write_table(out, fmt::format("[{}.marker.{}]", body, marker.name), {}, lines);
  }
}

std::vector<Line> body_lines(const Body& body) {
  std::vector<Line> lines;
  if (!body.surface.empty()) {
    lines.emplace_back("superelement", toml("parts/" + body.file() + ".se.h5"));
    lines.emplace_back("fidelity", toml(std::string("rigid")));
  } else {
    lines.emplace_back("mass", toml(body.mass));
    if (!body.center.isZero(0.0)) lines.emplace_back("center", toml(body.center));
    const Matrix3d& I = body.inertia;
    if (!I.isZero(0.0))
      lines.emplace_back("inertia", fmt::format("[{}, {}, {}, {}, {}, {}]", toml(I(0, 0)), toml(I(1, 1)),
                                                toml(I(2, 2)), toml(I(0, 1)), toml(I(1, 2)), toml(I(2, 0))));
  }
  for (const Line& line : pose_lines(body.X_WB)) lines.push_back(line);
  return lines;
}

}  // namespace

std::string mechanism_text(const Mechanism& mechanism) {
  std::string out;
  for (const std::string& comment : mechanism.comments) out += "# " + one_line(comment) + "\n";
  out += "name = " + toml(shown(mechanism.name)) + "\n";
  for (const auto& [key, value] : mechanism.head) out += key + " = " + value + "\n";
  for (const std::vector<Line>& shape : mechanism.ground_shapes)
    write_table(out, "[[ground.shape]]", {}, shape);
  write_markers(out, "ground", mechanism.ground);
  for (const Body& body : mechanism.bodies) {
    write_table(out, "[body." + body.name + "]", body.comments, body_lines(body));
    for (const std::vector<Line>& shape : body.shapes)
      write_table(out, "[[body." + body.name + ".shape]]", {}, shape);
    write_markers(out, "body." + body.name, body.markers);
  }
  for (const Element& e : mechanism.elements)
    write_table(out, fmt::format("[{}.{}]", e.table, e.name), e.comments, e.lines);
  if (!mechanism.solver.empty()) write_table(out, "[solver]", {}, mechanism.solver);
  return out;
}

}  // namespace flexura::import
