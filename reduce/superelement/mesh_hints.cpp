// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/superelement/mesh_hints.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "mesh/model/coincident.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

// Twice the volume over the surface, of the straight faces: the thickness of a plate, half the width of a square bar.
double mean_thickness(const mesh::Mesh& mesh) {
  double volume = 0.0, area = 0.0;
  if (mesh.n_nodes() == 0) return 0.0;
  const Vector3d origin = mesh.points.row(0);
  for (const mesh::CellBlock& block : mesh.boundary) {
    const int corners = mesh::shape_of(block.type).corners;
    for (Index row = 0; row < block.nodes.rows(); ++row)
      for (int c = 1; c + 1 < corners; ++c) {
        const auto at = [&](int a) -> Vector3d {
          return mesh.points.row(block.nodes(row, a)).transpose() - origin;
        };
        const Vector3d twice = (at(c) - at(0)).cross(at(c + 1) - at(0));
        area += 0.5 * twice.norm();
        volume += at(0).dot(twice) / 6.0;
      }
  }
  return area > 0.0 ? std::max(2.0 * volume / area, 0.0) : 0.0;
}

bool is_linear(const mesh::CellBlock& block) {
  return block.nodes.cols() == mesh::shape_of(block.type).corners;
}

// Bricks with bubbles bend as those of order 2 do.
bool locks_in_bending(const mesh::CellBlock& block, Formulation of_part) {
  const Formulation formulation = formulation_of(block, of_part);
  return is_linear(block) && !(block.type == mesh::CellType::hex8 && formulation == Formulation::enhanced);
}

// Cells all of whose corners lie on the surface, as a share.
double share_of_single_layers(const mesh::Mesh& mesh) {
  std::vector<char> outside(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (const mesh::CellBlock& block : mesh.boundary)
    for (const mesh::Index node : block.nodes.reshaped()) outside[static_cast<std::size_t>(node)] = 1;
  double single = 0.0, all = 0.0;
  for (const mesh::CellBlock& block : mesh.solids)
    for (Index row = 0; row < block.nodes.rows(); ++row) {
      bool on_surface = true;
      for (int a = 0; a < mesh::shape_of(block.type).corners; ++a)
        on_surface = on_surface && outside[static_cast<std::size_t>(block.nodes(row, a))];
      single += on_surface;
      all += 1.0;
    }
  return all > 0.0 ? single / all : 0.0;
}

double worst_of(const MeshShare& share) {
  double worst = share.modes.empty() ? 0.0 : share.modes.front().error;
  for (const MeshShare::Interface& interface : share.interfaces) worst = std::max(worst, interface.error);
  return worst;
}

// Nodes of cells beside others that nothing joins to them: seams that open.
std::string cracks(const Part& part) {
  std::vector<char> joined(static_cast<std::size_t>(part.mesh.n_nodes()), 0);
  const auto join = [&](mesh::Index node) { joined[static_cast<std::size_t>(node)] = 1; };
  for (const InterfaceSpec& interface : part.interfaces)
    for (const mesh::Index node : interface.set.nodes) join(node);
  for (const DependentDof& constraint : part.dependent) join(constraint.dof.node);
  for (const Follower& follower : part.followers) join(follower.point);
  for (const Link& link : part.links) join(link.from), join(link.to);
  for (const FrameElement& frame : part.frames)
    for (const mesh::Index node : frame.nodes) join(node);
  std::vector<mesh::Index> nodes;
  std::vector<char> seen(joined.size(), 0);
  for (const auto* blocks : {&part.mesh.boundary, &part.mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      for (const mesh::Index node : block.nodes.reshaped())
        if (!joined[static_cast<std::size_t>(node)] &&
            !std::exchange(seen[static_cast<std::size_t>(node)], 1))
          nodes.push_back(node);
  const auto pairs = mesh::coincident_nodes(part.mesh.points, std::move(nodes));
  if (pairs.empty()) return "";
  const auto [a, b] = pairs.front();
  const auto label = [&](mesh::Index node) {
    return part.mesh.node_label.empty() ? node : part.mesh.node_label[static_cast<std::size_t>(node)];
  };
  return fmt::format(
      "{} node{} of solids or shells lie{} where others do that nothing joins to them, the first {} and {} "
      "at "
      "({:.5g}, {:.5g}, {:.5g}) m: the part is open there; merge them unless it is meant to be",
      pairs.size(), pairs.size() == 1 ? "" : "s", pairs.size() == 1 ? "s" : "", label(a), label(b),
      part.mesh.points(a, 0), part.mesh.points(a, 1), part.mesh.points(a, 2));
}

}  // namespace

MeshHints mesh_hints(const Part& part, double size, const std::optional<MeshShare>& share) {
  constexpr double kWarn = 0.05, kNote = 0.01;
  MeshHints out;
  if (size == 0.0 && !part.matrices)
    if (std::string open = cracks(part); !open.empty()) out.warnings.push_back(std::move(open));
  if (part.matrices || part.mesh.solids.empty()) return out;
  const bool known = share && !(share->modes.empty() && share->interfaces.empty());
  const double worst = known ? worst_of(*share) : 0.0;
  // Whatever the estimate says: what it adds to the elements is held by the bulk modulus as they are.
  for (const Material& material : part.materials) {
    // nu of an isotropic material; beyond 0.495 the bulk modulus is a hundred times the shear modulus.
    const double poisson = material.D(0, 1) / (material.D(0, 0) + material.D(0, 1));
    if (poisson > 0.495)
      out.warnings.push_back(
          fmt::format("material \"{}\" is nearly incompressible (Poisson's ratio {:.7g}), where elements of "
                      "displacements are far too "
                      "stiff: take 0.49 unless its compressibility itself matters, and a finer mesh",
                      material.name, poisson));
  }
  if (known && !(worst > kNote)) return out;
  std::vector<std::string>& to = !known || !(worst <= kWarn) ? out.warnings : out.notes;

  if (const double thickness = mean_thickness(part.mesh); thickness > 0.0 && size > 2.0 * thickness)
    to.push_back(fmt::format(
        "the elements (mesh.size {:.3g} m) are larger than the part is thick (about {:.3g} m, twice "
        "its volume over its surface): choose a smaller mesh.size",
        size, thickness));
  double n_linear = 0.0, n_uniform = 0.0, n_all = 0.0;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const auto n = static_cast<double>(block.nodes.rows());
    n_all += n;
    const Formulation formulation = formulation_of(block, part.formulation);
    if (solid_element(block.type, formulation).strains == Strains::uniform)
      n_uniform += n;
    else if (locks_in_bending(block, part.formulation))
      n_linear += n;
  }
  if (n_linear > 0.1 * n_all)
    to.push_back(fmt::format(
        "{:.0f} of {:.0f} elements are of order 1, far too stiff in bending: use order 2", n_linear, n_all));
  const bool is_thin = share_of_single_layers(part.mesh) > 0.5;
  if (n_uniform > 0.1 * n_all)
    to.push_back(fmt::format(
        "{:.0f} of {:.0f} elements have uniform strains (reduced integration, order 1) and are too soft in "
        "bending{}: four through a thickness bend within a few per cent",
        n_uniform, n_all, is_thin ? ", a single one through the thickness by far" : ""));
  if (is_thin && n_uniform < n_all)
    to.push_back(
        "most of the part has a single element through its thickness: two or more bend as they should");
  return out;
}

}  // namespace flexura::reduce
