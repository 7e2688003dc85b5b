// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cstring>

#include "mbs/superelement/exchange/exchange.hpp"

// VTK XML PolyData (docs.vtk.org, "VTK XML file formats") with inline base64 data, and gmsh's MSH 2.2
// (gmsh.info).
namespace flexura::superelement {
namespace {

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

// The number of bytes as UInt64, then the bytes.
template <typename T>
std::string data_block(const T* values, std::size_t count) {
  const std::uint64_t size = count * sizeof(T);
  std::string bytes(sizeof size + size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  if (size > 0) std::memcpy(bytes.data() + sizeof size, values, size);
  return base64(bytes);
}

template <typename T>
void data_array(std::string& out, const char* type, const std::string& name, int components, const T* values,
                std::size_t count) {
  out += fmt::format(
      "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n{}\n</DataArray>\n",
      type, name, components, data_block(values, count));
}

void require_surface(const Superelement& se) {
  if (se.surface.vertices.rows() == 0 || se.shapes.rows() != 3 * se.surface.vertices.rows()) {
    throw std::invalid_argument(
        fmt::format("superelement \"{}\" holds no surface with shapes, so there is nothing to draw; reduce "
                    "the part again "
                    "with its surface",
                    se.name));
  }
}

std::string mode_name(const ModeAnalysis& modes, std::size_t j) {
  return fmt::format("mode {} ({:.2f} Hz)", j + 1, modes.modes[j].frequency_hz);
}

// One mode's displacement on the surface, at the size it is drawn.
Eigen::VectorXf drawn(const Superelement& se, const Mode& mode) {
  Eigen::VectorXf shape = se.shapes * mode.u_se.cast<float>();
  shape *= static_cast<float>(exchange::display_scale(se, shape));
  return shape;
}

}  // namespace

void write_vtp(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes) {
  require_surface(se);
  const Surface& s = se.surface;
  const auto n_v = static_cast<std::size_t>(s.vertices.rows()),
             n_t = static_cast<std::size_t>(s.triangles.rows());
  std::string out = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" "
      "NumberOfLines=\"0\" "
      "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n<PointData>\n",
      n_v, n_t);
  for (auto j = static_cast<std::size_t>(modes.n_rigid); j < modes.modes.size(); ++j) {
    const Eigen::VectorXf shape = drawn(se, modes.modes[j]);
    data_array(out, "Float32", mode_name(modes, j), 3, shape.data(), 3 * n_v);
  }
  out += "</PointData>\n<CellData>\n";
  if (!s.triangle_interface.empty())
    data_array(out, "Int32", "interface", 1, s.triangle_interface.data(), n_t);
  out += "</CellData>\n<Points>\n";
  data_array(out, "Float64", "Points", 3, s.vertices.data(), 3 * n_v);
  out += "</Points>\n<Polys>\n";
  data_array(out, "Int32", "connectivity", 1, s.triangles.data(), 3 * n_t);
  std::vector<std::int32_t> offsets(n_t);
  for (std::size_t t = 0; t < n_t; ++t) offsets[t] = static_cast<std::int32_t>(3 * (t + 1));
  data_array(out, "Int32", "offsets", 1, offsets.data(), n_t);
  out += "</Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
  exchange::write_whole(path, out);
}

void write_gmsh_views(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes) {
  require_surface(se);
  const Surface& s = se.surface;
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", s.vertices.rows());
  for (Eigen::Index v = 0; v < s.vertices.rows(); ++v) {
    fmt::format_to(to, "{} {} {} {}\n", v + 1, s.vertices(v, 0), s.vertices(v, 1), s.vertices(v, 2));
  }
  fmt::format_to(to, "$EndNodes\n$Elements\n{}\n", s.triangles.rows());
  for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
    // Physical tag 1 is the free surface, 2 and on the interfaces.
    const int tag = s.triangle_interface.empty() ? 1 : s.triangle_interface[static_cast<std::size_t>(t)] + 2;
    fmt::format_to(to, "{} 2 2 {} {} {} {} {}\n", t + 1, tag, tag, s.triangles(t, 0) + 1,
                   s.triangles(t, 1) + 1, s.triangles(t, 2) + 1);
  }
  fmt::format_to(to, "$EndElements\n");
  for (auto j = static_cast<std::size_t>(modes.n_rigid); j < modes.modes.size(); ++j) {
    const Eigen::VectorXf shape = drawn(se, modes.modes[j]);
    fmt::format_to(to, "$NodeData\n1\n\"{}\"\n1\n0.0\n3\n0\n3\n{}\n", mode_name(modes, j), s.vertices.rows());
    for (Eigen::Index v = 0; v < s.vertices.rows(); ++v) {
      fmt::format_to(to, "{} {} {} {}\n", v + 1, shape[3 * v], shape[3 * v + 1], shape[3 * v + 2]);
    }
    fmt::format_to(to, "$EndNodeData\n");
  }
  exchange::write_whole(path, {out.data(), out.size()});
}

}  // namespace flexura::superelement
