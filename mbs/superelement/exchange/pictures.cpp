// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/exchange/polydata.hpp"
#include "mbs/superelement/text_file.hpp"

// VTK XML PolyData (polydata.hpp) and gmsh's MSH 2.2 (gmsh.info).
namespace flexura::superelement {

using exchange::drawn_shape;
using exchange::mode_name;

void write_vtp(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes) {
  exchange::require_surface(se);
  const Surface& surface = se.surface;
  // Edges only where there are no faces (beams): ParaView finds the feature edges of a surface itself.
  exchange::PolyData data(surface.vertices, surface.triangles,
                          surface.triangles.rows() == 0 ? surface.edges : decltype(surface.edges){});
  for (auto j = static_cast<std::size_t>(modes.n_rigid); j < modes.modes.size(); ++j) {
    data.add_point_array(mode_name(modes, j), 3, drawn_shape(se, modes.modes[j]));
  }
  if (!surface.triangle_interface.empty()) {
    data.add_cell_array("interface", Eigen::Map<const Eigen::VectorXi>(
                                         surface.triangle_interface.data(),
                                         static_cast<Eigen::Index>(surface.triangle_interface.size())));
  }
  data.write(path);
}

void write_gmsh_views(const std::filesystem::path& path, const Superelement& se, const ModeAnalysis& modes) {
  exchange::require_surface(se);
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
    const Eigen::VectorXf shape = drawn_shape(se, modes.modes[j]);
    fmt::format_to(to, "$NodeData\n1\n\"{}\"\n1\n0.0\n3\n0\n3\n{}\n", mode_name(modes, j), s.vertices.rows());
    for (Eigen::Index v = 0; v < s.vertices.rows(); ++v) {
      fmt::format_to(to, "{} {} {} {}\n", v + 1, shape[3 * v], shape[3 * v + 1], shape[3 * v + 2]);
    }
    fmt::format_to(to, "$EndNodeData\n");
  }
  write_whole(path, {out.data(), out.size()});
}

}  // namespace flexura::superelement
